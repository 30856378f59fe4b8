"""What drives feel: the energy of rolling without slip; and how much estimates matter to it."""

import math

import numpy as np
import pytest
from scene_text import replaced
from vehicles import VEHICLE

import omnisim
from omnisim.dynamics.felt_inertia import felt_inertia, influence
from omnisim.dynamics.packing import bodies
from omnisim.scene.estimates import varied
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.scene import parse


def rolling(name, motion):
    """Overrides that start a scene rolling without slip in a unit motion of its common centre, rollers in the air at
    rest."""
    config = omnisim.load(name).config
    x_centre, y_centre, _ = bodies(config).centre
    twist = np.eye(3)[motion] + (motion == 2) * np.array([y_centre, -x_centre, 0.0])
    changes = {"initial": {"velocity": twist[:2].tolist(), "yaw_rate": float(twist[2]), "yaw_deg": 0.0}}
    for wheel, spin in zip(config.wheels, wheel_rows(config) @ twist, strict=True):
        kind = config.type_of(wheel)
        psi, heading = math.radians((1 - 2 * wheel.mirrored) * kind.roller_angle_deg), math.radians(wheel.heading_deg)
        x, y = wheel.position
        across = (twist[1] + twist[2] * x) * math.cos(heading) - (twist[0] - twist[2] * y) * math.sin(heading)
        azimuths = 2.0 * np.pi * np.arange(kind.rollers) / kind.rollers
        still = -(spin * math.sin(psi) - twist[2] * math.cos(psi) * np.sin(azimuths))  # joint rates of p = 0
        still[0] = across / ((kind.radius - kind.roller_distance) * math.cos(psi))  # the one on the floor rolls
        changes[f"wheels.{wheel.name}"] = {"spin_rate": float(spin), "roller_rates": still.tolist()}
    return changes


@pytest.mark.parametrize("motion", [0, 1, 2])
@pytest.mark.parametrize("name", ["youbot", "mixed", "soccer_robot"])
def test_the_felt_inertia_is_twice_the_energy_of_a_machine_that_rolls_at_unit_speed(name, motion):
    time = {"end": 1e-3, "step": 1e-3, "output_interval": 1e-3}
    run = omnisim.simulate(omnisim.load(name, rolling(name, motion) | {"time": time}))
    for wheel in run.wheels:
        assert np.hypot(*run[f"wheels/{wheel}/slip_velocity"][0]) < 1e-15
    kinetic = run["energy/kinetic"][0]
    assert felt_inertia(omnisim.load(name).config)[motion] == pytest.approx(2.0 * kinetic, rel=1e-13)


SHAPES = replaced(
    VEHICLE,
    "disk = { mass = 0.4, inertia_axle = 4e-4, inertia_diameter = 2.2e-4 }",
    "disk = { mass = 0.4, hub_radius = 0.03, width = 0.05 }",
    "roller = { mass = 0.1, inertia_axial = 6e-6, inertia_transverse = 9e-6 }",
    "roller = { density = 1100, bore_radius = 0.002 }",
    "center_of_mass = [0.02, 0.0, 0.1]\ninertia = [0.1, 0.2, 0.25]",
    "size = [0.5, 0.3, 0.1]",
)


def test_what_follows_from_an_estimate_follows_its_variation():
    config = parse(SHAPES).config
    roller = config.wheel_types["mecanum"].roller
    other = varied(config, ("wheel_types", "mecanum", "roller", "mass"), 1.1).wheel_types["mecanum"].roller
    for key in ("mass", "inertia_axial", "inertia_transverse"):
        assert getattr(other, key) == pytest.approx(1.1 * getattr(roller, key), rel=1e-15)
    disk = config.wheel_types["mecanum"].disk
    other = varied(config, ("wheel_types", "mecanum", "disk", "inertia_axle"), 1.1).wheel_types["mecanum"].disk
    assert other.inertia_diameter - disk.inertia_diameter == pytest.approx(0.05 * disk.inertia_axle, rel=1e-12)


def test_the_influence_of_an_estimate_is_that_of_a_scene_which_gives_a_tenth_more():
    config = parse(SHAPES).config
    inertia = 1.1 * config.wheel_types["mecanum"].disk.inertia_axle
    more = parse(SHAPES, overrides=[f"wheel_types.mecanum.disk.inertia_axle={inertia!r}"]).config
    found = influence(config, ("wheel_types", "mecanum", "disk", "inertia_axle"))
    assert found[:3] == pytest.approx(felt_inertia(more) / felt_inertia(config) - 1.0, rel=1e-12)
    assert found[0] > 0.0 and found[3] == 0.0


def test_a_higher_centre_of_mass_shifts_loads_in_proportion_and_is_not_felt():
    """Of a symmetric machine: M a dz / (2 wheelbase), here to the left / (2 track), is shifted; the mean is M g / 4."""
    config = parse(SHAPES).config
    *felt, shifted = influence(config, ("chassis", "center_of_mass"))
    places = [wheel.position for wheel in config.wheels]
    track = 2.0 * max(y for _, y in places)
    rise = 0.1 * config.chassis.center_of_mass[2] * config.chassis.mass
    assert felt == [0.0, 0.0, 0.0]
    assert shifted == pytest.approx(rise / (2.0 * track) / (bodies(config).mass * 9.81 / 4.0), rel=1e-12)
