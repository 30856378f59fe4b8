"""Wheels that are sold: each number has its source or says how it is estimated, and every one of them runs."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scene_text import message

import omnisim
from omnisim.scene.masses import point_masses
from omnisim.scene.packaged import packaged_scenes, packaged_text, packaged_wheels
from omnisim.scene.rollers import roller_solid, rolling
from omnisim.scene.scene import load, load_text
from omnisim.scene.schema import unused_keys

WHEELS = (
    "andymark_mecanum_203", "gobilda_mecanum_104", "kornylak_omni_38", "lekiwi_omni_102", "mecanum_60", "omni_100",
    "omni_125", "omni_48", "omni_58", "robocin_omni_50", "robomaster_mecanum_152", "robomaster_omni_152", "xrp_omni_70",
)  # fmt: skip
FREE = [name for name in WHEELS if load(name).config.upright == "free"]
RIGID = [name for name in WHEELS if name not in FREE]


@pytest.mark.short
def test_the_packaged_wheels_are_known_and_have_names_of_their_own():
    assert tuple(packaged_wheels()) == WHEELS
    assert not set(WHEELS) & set(packaged_scenes())
    page = (Path(__file__).parents[2] / "docs/pages/wheels.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| `(\w+)` \|", page, re.MULTILINE)) == list(WHEELS)


@pytest.mark.short
@pytest.mark.parametrize("name", WHEELS)
def test_a_packaged_wheel_is_one_type_of_its_name_without_doubts_or_unused_keys(name):
    scene = load(name)
    assert list(scene.config.wheel_types) == [name] and {wheel.type for wheel in scene.config.wheels} == {name}
    assert scene.warnings == () and unused_keys(scene.config) == ()


@pytest.mark.short
@pytest.mark.parametrize("name", WHEELS)
def test_every_number_of_a_packaged_wheel_has_a_source_or_is_marked_as_estimated(name):
    """A mark stands in the comment of its line, or in those just above."""
    text = packaged_text(name)
    head = text[: text.index("schema = 1")]
    sources = set(re.findall(r"^#(?: Source:|        ) (\[\d\])", head, re.MULTILINE))
    assert sources == {f"[{i + 1}]" for i in range(len(sources))} and sources
    body = text[text.index("[wheel_types") :].split("\n\n")[0].splitlines()[1:]
    above = ""
    for line in body:
        told = above + line.partition("#")[2]
        if not line.startswith("#"):
            assert re.search(r"\[\d\]|estimated", told), line
        assert set(re.findall(r"\[\d\]", told)) <= sources, line
        above = above + line if line.startswith("#") else ""


MINE = """schema = 1
time = { end = 0.1, step = 1e-3 }
friction = { law = "coulomb", coefficient = 0.6 }
wheels = [{ name = "wheel", type = "mine" }]

[wheel_types.mine] # a comment of mine
from = "lekiwi_omni_102"
disk = { mass = 0.08 }
"""


@pytest.mark.short
def test_a_wheel_type_takes_over_what_it_leaves_out_and_what_it_gives_wins():
    scene, sold = load_text(MINE), load("lekiwi_omni_102").config.wheel_types["lekiwi_omni_102"]
    mine = scene.config.wheel_types["mine"]
    assert (mine.radius, mine.rows, mine.roller) == (sold.radius, sold.rows, sold.roller)
    assert (mine.disk.mass, mine.disk.hub_radius) == (0.08, sold.disk.hub_radius)
    assert mine.disk.inertia_axle == pytest.approx(0.5 * 0.08 * sold.disk.hub_radius**2)


@pytest.mark.short
def test_what_is_loaded_has_the_keys_of_the_wheel_and_not_its_name():
    scene = load_text(MINE, ["wheel_types.mine.roller.density=1300"])
    assert "from" not in scene.text and "# a comment of mine" in scene.text and "radius = 0.0508" in scene.text
    assert load_text(scene.text).config == scene.config
    assert scene.config.wheel_types["mine"].roller.density == 1300.0


@pytest.mark.short
@pytest.mark.parametrize(
    ("wheel", "said"),
    [
        ('"lekiwi_omni_10"', "'lekiwi_omni_10': no packaged wheel has this name; did you mean 'lekiwi_omni_102'?"),
        ('"x"', "'x': no packaged wheel has this name; must be one of andymark_mecanum_203, "),
    ],
)
def test_the_name_of_no_wheel_is_one_line(wheel, said):
    text = message(MINE.replace('"lekiwi_omni_102"', wheel))
    assert text.startswith(f"s.toml:7: wheel_types.mine.from = {said}") and "\n" not in text


@pytest.mark.parametrize("name", RIGID)
def test_a_packaged_wheel_rolls_on_and_its_energy_is_balanced(name):
    run = omnisim.simulate(load(name))
    assert run.attributes["status"] == "complete"
    kinetic = run["energy/kinetic"][0]
    assert np.abs(run["energy/balance"]).max() < 1e-6 * kinetic  # measured up to 9.1e-8
    start = run["body/velocity"][0, 0]
    assert run["body/velocity"][-1, 0] == pytest.approx(start, rel=0.03)  # measured 0.018; it was thrown almost rolling


@pytest.mark.parametrize("name", FREE)
def test_packaged_wheels_on_rubber_carry_a_robot(name):
    run = omnisim.simulate(load(name, {"time.end": 0.05}))
    assert run.attributes["status"] == "complete"
    scale = np.abs(run["energy/elastic"]).max()
    assert np.abs(run["energy/balance"]).max() < 1e-6 * scale  # measured up to 2e-9
    share = sum(run[f"wheels/{wheel}/normal_force"][0] for wheel in run.wheels)
    assert share == pytest.approx(9.81 * sum(point_masses(load(name).config)[0]), rel=1e-9)


@pytest.mark.short
def test_the_estimate_of_a_roller_is_near_the_inertias_of_a_maker_s_model():
    """Kornylak's roller in its CAD model: about its axis 1.007 of it, across 0.970."""
    roller = load("kornylak_omni_38").config.wheel_types["kornylak_omni_38"].roller
    volume, axial, across = roller_solid(load("kornylak_omni_38").config.wheel_types["kornylak_omni_38"])
    assert roller.mass * axial / volume == pytest.approx(roller.inertia_axial, rel=0.01)
    assert roller.mass * across / volume == pytest.approx(roller.inertia_transverse, rel=0.035)


@pytest.mark.short
def test_the_rubber_ring_of_the_soccer_wheel_is_the_torus_of_its_moments_of_inertia():
    """m = 7.2860775354e-5 kg, 1.0045224022e-9 and 5.2234345231e-10 kg m^2 in the CAD model."""
    kind = load("robocin_omni_50").config.wheel_types["robocin_omni_50"]
    tube = kind.profile.curvature_radius
    ring, mass = kind.profile.radius - tube, 7.2860775354338029e-05
    assert mass * (ring**2 + 0.75 * tube**2) == pytest.approx(1.0045224022133389e-09, rel=1e-9)
    assert mass * (0.5 * ring**2 + 0.625 * tube**2) == pytest.approx(5.2234345231370893e-10, rel=1e-9)
    assert kind.radius == pytest.approx(kind.roller_distance + ring + tube, abs=1e-6)


@pytest.mark.short
def test_the_wheels_that_are_not_round_go_up_and_down_as_the_page_says():
    """(R - rho) (1 - cos 10 deg) between two rings; a step of a roller stands out of the wheel's circle."""
    lowest, _, highest = rolling(load("robocin_omni_50").config.wheel_types["robocin_omni_50"])
    assert highest - lowest == pytest.approx((0.024993 - 0.00105) * (1.0 - math.cos(math.radians(10.0))), abs=1e-7)
    lowest, _, highest = rolling(load("andymark_mecanum_203").config.wheel_types["andymark_mecanum_203"])
    assert (lowest, highest) == pytest.approx((0.09996, 0.10179), abs=5e-6)
