"""Masses and inertias that a scene leaves out: those of its shapes, and what is said where a shape is missing."""

import math
import re

import numpy as np
import pytest
from commands import command
from scene_text import message, replaced
from vehicles import VEHICLE

import omnisim
from omnisim.contact.roller_profile import axial_coordinate, profile_radius
from omnisim.dynamics.packing import pack
from omnisim.scene.estimates import estimates
from omnisim.scene.scene import parse
from omnisim.scene.solids import Outline, bored_end, outline, profile, solid
from omnisim.scene.toml_text import show_path

pytestmark = pytest.mark.short

SHAPES = replaced(
    VEHICLE,
    "disk = { mass = 0.4, inertia_axle = 4e-4, inertia_diameter = 2.2e-4 }",
    "disk = { mass = 0.4, hub_radius = 0.03, width = 0.05 }",
    "roller = { mass = 0.1, inertia_axial = 6e-6, inertia_transverse = 9e-6 }",
    "roller = { density = 1100, bore_radius = 0.002 }",
    "center_of_mass = [0.02, 0.0, 0.1]\ninertia = [0.1, 0.2, 0.25]",
    "size = [0.5, 0.3, 0.1]",
)


def envelope(wheel: Outline, u: np.ndarray) -> np.ndarray:
    """r(u), m, another way: the roller stays above the floor of every azimuth q, a half space in its own frame,

    u c sin q + r sqrt(1 - c^2 sin^2 q) <= R - R1 cos q
    """
    q = np.linspace(-wheel.alpha, wheel.alpha, 4001)
    sine = wheel.cos_psi * np.sin(q)
    limits = (wheel.radius - wheel.roller_distance * np.cos(q) - np.outer(u, sine)) / np.sqrt(1.0 - sine**2)
    return limits.min(axis=1)


@pytest.mark.parametrize("psi", [0.0, 45.0, 60.0])
@pytest.mark.parametrize("bore", [0.0, 0.002, 0.006])
def test_a_roller_with_a_bore_is_the_solid_between_the_envelope_of_floors_and_the_bore(psi, bore):
    """The widest bore is wider than the tips, of 3 to 5 mm, so that the ends are gone."""
    c, s = math.cos(math.radians(psi)), math.sin(math.radians(psi))
    wheel = Outline(0.05, 0.04, math.pi / 6, c, s)
    length = float(profile(wheel, np.array(bored_end(wheel, bore)))[0])
    u = np.linspace(-length, length, 4001)
    r, weight = envelope(wheel, u), np.full(4001, u[1] - u[0])
    weight[1:-1:2] *= 4.0 / 3.0
    weight[2:-1:2] *= 2.0 / 3.0
    weight[[0, -1]] /= 3.0  # Simpson's rule
    assert r.min() >= bore - 1e-7 and (bore <= 0.005 or r[[0, -1]] == pytest.approx(bore, abs=1e-7))
    ring, fourth = np.pi * (r**2 - bore**2), np.pi * (r**4 - bore**4)
    found = ring @ weight, 0.5 * fourth @ weight, (0.25 * fourth + ring * u**2) @ weight
    assert solid(wheel, bore) == pytest.approx(found, rel=1e-6)  # measured up to 9.3e-8, of the grid of q


def test_the_profile_without_kernels_is_that_of_the_kernels():
    wheel = pack(omnisim.load("youbot").config).wheels[0]
    q = np.linspace(-wheel.alpha, wheel.alpha, 7)
    kernels = [[axial_coordinate(wheel, x) for x in q], [profile_radius(wheel, x) for x in q]]
    np.testing.assert_allclose(profile(wheel, q), kernels, rtol=1e-15)  # measured 0


@pytest.mark.parametrize(
    ("name", "overrides", "digits"),
    [
        ("youbot", ["wheel_types.mecanum.roller={mass=0.05}"], 1e-4),  # measured 4.2e-5
        ("youbot", ["wheel_types.mecanum.disk={mass=0.4, hub_radius=0.036, width=0.05}"], 3e-4),  # measured 1.6e-4
        ("mixed", ["chassis={mass=8.0, size=[0.4, 0.3, 0.1], ground_clearance=0.04}"], 1e-4),  # measured 5.0e-5
    ],
)
def test_packaged_scenes_that_say_their_shapes_have_the_estimated_inertias(name, overrides, digits):
    """Their numbers were found elsewhere and typed with four or five digits."""
    given, estimated = pack(omnisim.load(name).config), pack(omnisim.load(name, overrides).config)
    for field in ("axle_inertia", "transverse_inertia", "axial_inertia", "disk_inertia"):
        np.testing.assert_allclose(estimated.wheels[field], given.wheels[field], rtol=digits)
    for field in ("yaw_inertia", "chassis_inertia", "height", "mass"):
        np.testing.assert_allclose(estimated.machine[field], given.machine[field], rtol=digits)


def test_the_mass_of_a_roller_is_its_density_by_its_volume():
    kind = parse(SHAPES).config.wheel_types["mecanum"]
    volume = solid(outline(kind), 0.002).volume
    assert kind.roller.mass == pytest.approx(1100 * volume, rel=1e-15)


def test_a_box_stands_half_a_wheel_radius_above_the_floor_unless_the_scene_says_how_high():
    assert parse(SHAPES).config.chassis.center_of_mass == pytest.approx((0.0, 0.0, 0.025 + 0.05))
    lower = parse(SHAPES, overrides=["chassis.ground_clearance=0"]).config.chassis
    assert lower.center_of_mass == pytest.approx((0.0, 0.0, 0.05))


def test_given_numbers_win():
    """One of each; the disk's inertia about a diameter follows the given one about the axle."""
    overrides = ["wheel_types.mecanum.roller.mass=0.1", "wheel_types.mecanum.roller.inertia_transverse=9e-6",
                 "wheel_types.mecanum.disk.inertia_axle=4e-4", "chassis.center_of_mass=[0.02, 0, 0.1]"]  # fmt: skip
    scene = parse(SHAPES, overrides=overrides)
    kind, chassis = scene.config.wheel_types["mecanum"], scene.config.chassis
    assert (kind.roller.mass, kind.roller.inertia_transverse, kind.disk.inertia_axle) == (0.1, 9e-6, 4e-4)
    assert kind.disk.inertia_diameter == pytest.approx(2e-4 + 0.4 * 0.05**2 / 12)
    assert chassis.center_of_mass == (0.02, 0.0, 0.1)
    assert chassis.inertia == pytest.approx((6 * 0.1 / 12, 6 * 0.26 / 12, 6 * 0.34 / 12))
    assert {show_path(found.path) for found in estimates(scene.config)} == {
        "wheel_types.mecanum.roller.inertia_axial", "wheel_types.mecanum.disk.inertia_diameter", "chassis.inertia"
    }  # fmt: skip


def test_a_scene_that_gives_all_its_numbers_keeps_them_and_has_no_estimates():
    config = parse(VEHICLE).config
    assert not list(estimates(config))
    assert config.chassis.inertia == (0.1, 0.2, 0.25) and config.wheel_types["mecanum"].roller.inertia_axial == 6e-6


def test_the_text_of_a_scene_stays_what_its_user_wrote_and_loads_again():
    scene = parse(SHAPES)
    assert scene.text == SHAPES
    assert parse(scene.text).config == scene.config


@pytest.mark.parametrize(
    ("old", "new", "key", "instead"),
    [
        ("density = 1100, ", "", "wheel_types.mecanum.roller.mass", "left out beside density (a finite number > 0)"),
        ("hub_radius = 0.03, ", "", "wheel_types.mecanum.disk.inertia_axle", "left out beside hub_radius"),
        (", width = 0.05", "", "wheel_types.mecanum.disk.inertia_diameter", "left out beside width"),
        ("size = [0.5, 0.3, 0.1]", "inertia = [1, 1, 1]", "chassis.center_of_mass", "three finite numbers > 0 [le"),
        ("size = [0.5, 0.3, 0.1]", "center_of_mass = [0, 0, 1]", "chassis.inertia", "left out beside size"),
        ("bore_radius = 0.002", "bore_radius = 0.01", "wheel_types.mecanum.roller.bore_radius = 0.01",
         "must be less than radius - roller_distance = 0.01"),
        ("density = 1100", "density = 1100, inertia_transverse = 1e-9",
         "wheel_types.mecanum.roller.inertia_transverse = 1e-09", "at least half of the inertia_axial that"),
    ],
)  # fmt: skip
def test_what_is_missing_and_what_could_be_given_instead_is_one_line(old, new, key, instead):
    text = message(replaced(SHAPES, old, new))
    assert "\n" not in text
    assert text.split(": ")[1] == key and instead in text


def test_shapes_beside_the_numbers_that_they_would_give_are_said_to_be_unused(folder):
    from omnisim.scene.schema import unused_keys

    overrides = [
        "wheel_types.mecanum.roller.mass=0.1",
        "chassis.ground_clearance=0.1",
        "chassis.center_of_mass=[0,0,1]",
    ]
    assert unused_keys(parse(SHAPES).config) == ()
    unused = unused_keys(parse(SHAPES, overrides=overrides).config)
    assert unused == ("wheel_types.mecanum.roller.density", "chassis.ground_clearance")


def test_info_lists_every_estimate_with_its_unit_and_what_it_is_of(folder):
    (folder / "shapes.toml").write_text(SHAPES)
    shown = command("info", "shapes.toml").stdout
    block = shown.partition("estimated from shapes")[2].partition("\n\n")[0]
    lines = [re.split(" {2,}", line.strip()) for line in block.splitlines()[1:] if re.match(r" {2}\S", line)]
    assert [line[0] for line in lines] == [
        *(f"wheel_types.mecanum.roller.{key}" for key in ("mass", "inertia_axial", "inertia_transverse")),
        *(f"wheel_types.mecanum.disk.{key}" for key in ("inertia_axle", "inertia_diameter")),
        "chassis.center_of_mass", "chassis.inertia",
    ]  # fmt: skip
    chassis = parse(SHAPES).config.chassis
    assert [float(part) for part in re.findall(r"[\d.e-]+", lines[-1][1].split("]")[0])] == pytest.approx(
        chassis.inertia
    )
    assert (
        "a box of 0.5 x 0.3 x 0.1 m" in lines[-1][2] and "estimated from shapes" not in command("info", "youbot").stdout
    )
