"""Energy of machines free in space, and rockers, which are pendulums and levers. Measured values beside the bounds."""

import copy

import numpy as np
import pytest
from free_machines import free, whole_mass
from machines import CHASSIS, TYPES, diameter_inertia, machine, run, scene, tables, wheel_mass
from scenes import reference_scene

from omnisim.dynamics.packing import pack
from omnisim.march.spatial_start import standing_pose

G = 9.81
OMNI = TYPES["omni"]
FRICTION = {"law": "regularized", "coefficient": 0.5, "slip_speed": 0.1}
MOTOR = {"kind": "dc_motor", "voltage": 9.0, "resistance": 1.5, "torque_constant": 0.3, "rotor_inertia": 2e-4,
         "inductance": 1e-3}  # fmt: skip


def turned_over(motion) -> float:
    """What there is of energy, and what comes and goes, J."""
    works = sum(np.abs(motion[f"energy/{key}_work"]).max() for key in ("drive", "wrench"))
    return motion["energy/kinetic"].max() + works


def everything() -> dict:
    """Bumps, springs, dampers, two rows of rollers with bearing friction, motors, a wrench, and a slope."""
    data = tables(reference_scene("spatial_mecanum_springs"))
    kind = data["wheel_types"]["type0"]
    kind["rows"] = [{"offset": -0.012}, {"offset": 0.012, "phase_deg": 30.0}]
    kind["roller"] |= {"bearing_viscosity": 1e-5, "bearing_torque": 1e-3, "bearing_rate": 1.0}
    for wheel in data["wheels"]:
        wheel["drive"] = MOTOR
    data["wrench"] = {"times": [0.0, 0.5], "force": [[3.0, -2.0, 5.0], [-2.0, 4.0, 0.0]], "yaw_torque": [0.5, -0.5]}
    return data


def test_energy_is_balanced_with_everything_at_once():
    data = everything() | {"time": {"end": 0.5, "step": 1e-5, "output_interval": 0.02}}
    motion = run(data)
    for loss in ("friction_loss", "bearing_loss", "contact_loss", "damper_loss"):
        assert motion[f"energy/{loss}"][-1] > 1e-3, loss  # J: each has its share
    assert np.abs(motion["energy/balance"]).max() < 1e-9 * turned_over(motion)  # measured 2.1e-11


@pytest.mark.long
@pytest.mark.parametrize("name", ["kiwi_slope", "double_row", "mecanum_bump", "mecanum_springs"])
def test_energy_of_the_reference_cases_is_balanced(name):
    motion = run(tables(reference_scene(f"spatial_{name}", "time.step=1e-5")))
    # measured 4.3e-11, 1.1e-11, 7.8e-12, 5.2e-11
    assert np.abs(motion["energy/balance"]).max() < 1e-9 * turned_over(motion)


def test_without_friction_and_damping_nothing_is_lost():
    """A machine that bounces and tumbles over a bump: kinetic, elastic and weight's energy stay together."""
    data = tables(reference_scene("spatial_mecanum_springs")) | {"friction": {"law": "none"}}
    data["wheel_types"]["type0"]["contact"]["damping"] = 0.0
    for wheel in data["wheels"]:
        wheel["drive"] = {"kind": "free"}
        wheel["suspension"]["damping"] = 0.0
    data |= {"time": {"end": 0.6, "step": 1e-5, "output_interval": 0.02}}
    data["initial"] |= {"height": 0.005, "velocity": [0.3, 1.2]}
    motion = run(data)
    assert {"lift_off", "touch_down"} <= set(motion["events/kind"])
    whole = motion["energy/kinetic"] + motion["energy/elastic"] + motion["energy/gravity"]
    assert np.abs(whole - whole[0]).max() < 1e-10 * motion["energy/kinetic"].max()  # measured 3e-13
    assert np.abs(motion["energy/balance"]).max() < 1e-10 * motion["energy/kinetic"].max()


def on_rockers(data: dict, *rockers) -> dict:
    """The machine with the wheels of these numbers on rockers: (wheels, about, point)."""
    data = copy.deepcopy(data)
    data["axles"] = [
        {"name": f"axle{j}", "wheels": [f"w{i}" for i in wheels], "about": about, "point": list(point)}
        for j, (wheels, about, point) in enumerate(rockers)
    ]
    return data


def angle(motion, wheels, arm) -> np.ndarray:
    """By which a rocker whose wheels are 2 arm (m) apart is inclined to the ground, rad."""
    first, second = (motion[f"wheels/w{i}/rollers/center_position"].mean(axis=1)[:, 2] for i in wheels)
    return np.arcsin((first - second) / (2.0 * arm))


@pytest.mark.parametrize("about", ["x", "y"])
def test_a_rocker_in_the_air_swings_as_a_pendulum(about):
    """A heavy chassis that a force of (m + M) a lifts: the rocker swings about the way of the force, tilted by f / F,
    as 1 - cos(w t) with w^2 = m a l / (I + m l^2 M / (m + M)), l from the line to the centre of its wheels."""
    mass, pull, push = 1e4, 12.0, 5.0
    axis, wheels, places = (
        "xy".index(about),
        (0, 1) if about == "x" else (0, 2),
        ((0.2, 0.15), (0.2, -0.15), (-0.2, 0.15)),
    )
    chassis = {"mass": mass, "center_of_mass": [0.0, 0.0, 0.2], "inertia": [1e8, 1e8, 1e8]}
    line = [0.2, 0.0, 0.2] if about == "x" else [0.0, 0.15, 0.2]
    time = {"end": 3.0, "step": 1e-3, "output_interval": 0.01}
    data = on_rockers(free(machine("omni", places, chassis=chassis, time=time)), (wheels, about, line))
    data["scene"] |= {"gravity": 0.0}
    pair, whole = 2.0 * wheel_mass("omni"), mass + 3.0 * wheel_mass("omni")
    sideways = [0.0, push, 0.0] if about == "x" else [push, 0.0, 0.0]
    data["wrench"] = {"times": [0.0], "force": [[*sideways[:2], whole * pull]]}
    data["initial"] = {"height": 1.0}
    motion = run(data)
    arm = 0.15 if about == "x" else 0.2
    own = pair * arm**2 + (2.0 * diameter_inertia("omni") if about == "x" else 0.0)
    length = 0.2 - OMNI["radius"]
    rate = np.sqrt(pair * pull * length / (own + length**2 * pair * (whole - pair) / whole))
    tilt = push / (whole * pull) * (1.0 if axis else -1.0)
    swing = angle(motion, wheels, arm) * (1.0 if about == "x" else -1.0)
    expected = tilt * (1.0 - np.cos(rate * motion.time))
    assert np.abs(swing - expected).max() < 1e-7 * abs(tilt)  # measured 6e-9


def test_a_rocker_loads_its_wheels_alike():
    """Front wheels on a rocker across: they carry the same, and those behind the moment of a centre of mass beside."""
    chassis = CHASSIS | {"center_of_mass": [0.03, 0.04, 0.1]}
    plain = free(machine("omni", chassis=chassis), 1e7)
    data = on_rockers(plain, ((0, 1), "x", (0.2, 0.0, 0.08)))
    loads = rest_loads(data)
    mass = whole_mass(data)
    front = mass * G * 0.5 + CHASSIS["mass"] * G * 0.03 / 0.4
    behind = mass * G - front
    moment = CHASSIS["mass"] * G * 0.04 / 0.3
    expected = [front / 2.0, front / 2.0, behind / 2.0 + moment, behind / 2.0 - moment]
    assert np.abs(loads / expected - 1.0).max() < 1e-5  # measured 6.6e-6; rubber of 1e8 N/m: ten times less
    assert np.ptp(rest_loads(plain)[:2]) > 1.0  # N: without a rocker they do not
    aside = on_rockers(plain, ((0, 2), "y", (0.0, 0.15, 0.15)), ((1, 3), "y", (0.0, -0.15, 0.15)))
    aside["chassis"]["center_of_mass"] = [0.0, 0.04, 0.1]
    loads = rest_loads(aside)
    assert np.abs(loads[[0, 1]] / loads[[2, 3]] - 1.0).max() < 1e-5  # along the machine two rockers do so


def rest_loads(data: dict) -> np.ndarray:
    """Loads of the wheels in static equilibrium (W,), N."""
    config = scene(data).config
    return standing_pose(config, pack(config))[1]


def test_a_rocker_over_a_bump_keeps_its_wheels_loaded_and_the_energy_balanced():
    data = free(machine("omni", friction=FRICTION), damping=100.0)
    data = on_rockers(data, ((0, 1), "x", (0.2, 0.0, 0.08)))
    data |= {
        "floor": {"bumps": [[0.45, 0.15, 0.015, 0.1]]},
        "time": {"end": 0.8, "step": 2e-5, "output_interval": 0.02},
    }
    data["initial"] = {"velocity": [0.5, 0.0]}
    for wheel in data["wheels"]:
        wheel["spin_rate"] = 0.5 / OMNI["radius"]
    motion = run(data)
    assert np.abs(angle(motion, (0, 1), 0.15)).max() > 0.02  # rad
    assert np.abs(motion["energy/balance"]).max() < 1e-9 * turned_over(motion)  # measured 4e-12
