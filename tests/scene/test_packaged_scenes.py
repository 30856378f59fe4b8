"""The packaged scenes: each says where it comes from, and its numbers are what it says."""

import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss

from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows
from omnisim.scene.scene import load, packaged_scenes
from omnisim.scene.schema import unused_keys

pytestmark = pytest.mark.short

WHEELS = {
    "authors_sliding": 1,
    "authors_testbench": 1,
    "authors_vehicle": 3,
    "cable_duct": 4,
    "coulomb_wheel": 1,
    "fm202": 1,
    "kiwi": 3,
    "kiwi_ramp": 3,
    "mixed": 4,
    "omni3": 3,
    "omni4": 4,
    "platform24v": 4,
    "rocker": 4,
    "six_rollers": 1,
    "soccer_kit": 3,
    "soccer_robot": 4,
    "thirty_two_rollers": 1,
    "wheel_bench": 1,
    "youbot": 4,
}
FREE = ("cable_duct", "kiwi_ramp", "rocker")
VEHICLES = [name for name, count in WHEELS.items() if count > 1]
REVOLVED = [name for name in packaged_scenes() if "solids of" in load(name).text]


def test_the_packaged_scenes_are_known():
    assert {name: len(load(name).config.wheels) for name in packaged_scenes()} == WHEELS


def test_they_are_found_by_a_python_that_begins_in_a_clone():
    """Its folder hides an installed package."""
    alone = "import sys; sys.meta_path[:] = [each for each in sys.meta_path if 'editable' not in repr(each)]"
    code = f"{alone}; import omnisim; print(omnisim.__file__, omnisim.load('six_rollers').config.title)"
    root = Path(__file__).parents[2]
    told = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True).stdout
    assert told == f"{root}/omnisim/__init__.py {load('six_rollers').config.title}\n"


@pytest.mark.parametrize("name", packaged_scenes())
def test_a_packaged_scene_says_its_source_and_uses_all_its_keys(name):
    scene = load(name)
    assert "\n# Source: " in scene.text
    assert scene.config.title and unused_keys(scene.config) == ()


def test_the_scenes_of_the_readme_and_the_pages_can_be_run(tmp_path):
    root = Path(__file__).parents[2]
    pages = [root / "README.md", *(root / f"docs/pages/{name}.md" for name in ("machines", "scene", "tutorial"))]
    wheels = []
    for page in pages:
        for text in re.findall(r"```toml\n(schema.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            (tmp_path / "scene.toml").write_text(text)
            config = load(tmp_path / "scene.toml").config
            assert unused_keys(config) == ()
            wheels.append(len(config.wheels))
    readme = pages[0].read_text(encoding="utf-8")
    assert wheels == [1, 3, 1, 1]
    assert all(f"`{name}`" in readme or f"run {name}" in readme for name in packaged_scenes())


@pytest.mark.parametrize("name", VEHICLES)
def test_a_vehicle_stands_on_its_wheels_and_its_rates_give_its_motion(name):
    config = load(name).config
    assert config.upright == ("free" if name in FREE else "contacts")
    assert inverse(wheel_rows(config), rms_distance(config)) is not None


def solid_of_revolution(kind):
    """Moments of inertia of 1 kg of the exact profile (axial, transverse), m^2, by Gauss quadrature over q."""
    c, alpha = math.cos(math.radians(kind.roller_angle_deg)), math.pi / kind.roller_count
    nodes, weights = leggauss(60)
    q = alpha * nodes
    h, dh = kind.radius - kind.roller_distance / np.cos(q), -kind.roller_distance * np.sin(q) / np.cos(q) ** 2
    u = kind.roller_distance * np.tan(q) / c + h * c * np.sin(q)
    du = kind.roller_distance / (c * np.cos(q) ** 2) + dh * c * np.sin(q) + h * c * np.cos(q)
    r = h * np.sqrt(1.0 - (c * np.sin(q)) ** 2)
    volume, axial, across = (np.sum(weights * du * r**2 * part) for part in (1.0, r**2 / 2, r**2 / 4 + u**2))
    return axial / volume, across / volume


@pytest.mark.parametrize("name", REVOLVED)
def test_rollers_said_to_be_solids_of_revolution_have_their_inertia(name):
    for kind in load(name).config.wheel_types.values():
        axial, transverse = solid_of_revolution(kind)
        assert kind.roller.inertia_axial == pytest.approx(kind.roller.mass * axial, rel=1e-4)
        assert kind.roller.inertia_transverse == pytest.approx(kind.roller.mass * transverse, rel=1e-4)


def test_solids_of_revolution_are_found_by_their_words():
    assert REVOLVED == ["fm202", "kiwi", "mixed", "soccer_robot", "youbot"]


def test_the_authors_vehicle_starts_without_slip():
    config = load("authors_vehicle").config
    rates = wheel_rows(config) @ (*config.initial.velocity, config.initial.yaw_rate)
    assert [wheel.spin_rate for wheel in config.wheels] == pytest.approx(rates)


@pytest.mark.parametrize("name", ["authors_vehicle", "kiwi", "soccer_kit", "soccer_robot"])
def test_axles_of_a_round_machine_point_at_its_middle(name):
    for wheel in load(name).config.wheels:
        heading = math.radians(wheel.heading_deg)
        along = wheel.position[0] * math.cos(heading) + wheel.position[1] * math.sin(heading)
        assert along == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("start", ["initial.yaw_rate=0", "friction={law='viscous', viscosity=8.5e5}"])
def test_the_other_starts_of_the_authors_vehicle_load(start):
    spins = [f"wheels.{name}.spin_rate=0" for name in "abc"]
    assert load("authors_vehicle", [start, "initial.velocity=[1,0]", *spins]).config.initial.velocity == (1.0, 0.0)
