"""The oracle of a vehicle against reference trajectories, and against laws that hold whatever it assumes.

Measured values stand beside the bounds.
"""

import tomllib
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

from oracle.cases import agree, kinetic_rate, load
from oracle.machine import Machine, Reactions
from oracle.multibody import simulate, start
from oracle.vectors import OMEGA, POSITION, ROTATION, UP, VELOCITY, cross

UPRIGHT = ("contacts", "servo")


def skew(upright: str = "contacts", **friction) -> dict:
    """Three unlike wheels, nothing symmetric; drives and a wrench that change."""
    scene = tomllib.loads((Path(__file__).parent / "skew.toml").read_text())
    scene["friction"] |= friction
    return scene | {"scene": {"upright": upright}}


def begin(scene: dict) -> tuple[Machine, np.ndarray, Reactions]:
    """The machine, its bodies and what acts on them at the start."""
    machine = Machine(scene)
    state, contacts = start(machine)
    bodies = machine.bodies(state)
    return machine, bodies, machine.solve(0.0, bodies, machine.mode(0.0, contacts))


@pytest.mark.long
def test_three_omni_wheels_follow_the_reference():
    agree("kiwi", 0.2)  # one exchange; N 7e-14, positions 3e-16, angles 2e-15, velocities 3e-15, spin rates 3e-14


@pytest.mark.long
def test_three_omni_wheels_follow_a_third_of_the_reference():
    agree("kiwi", 0.7)  # five exchanges; positions 2e-15, angles 6e-14, velocities 6e-14, spin rates 2e-12


@pytest.mark.long
def test_four_mecanum_wheels_follow_the_reference():
    agree("mecanum", 0.2)  # one exchange; N 7e-14, positions 1e-16, angles 2e-14, velocities 2e-14, spin rates 2e-13


@pytest.mark.parametrize("upright", UPRIGHT)
@pytest.mark.long
def test_constraints_survive_exchanges_under_load(upright: str):
    motion = simulate(skew(upright, law="viscous"), [0.0, 0.12])
    assert {name for _, name in motion["exchange_times"]} == {"front", "left", "right"}
    assert motion["constraint_residual"].max() < 1e-12  # measured: 2e-14


@pytest.mark.long
def test_results_do_not_depend_on_the_tolerance():
    fine, coarse = (simulate(skew(), [0.0, 0.03], rtol) for rtol in (1e-13, 1e-11))
    for key in ("position", "velocity", "yaw", "yaw_rate", "kinetic"):
        np.testing.assert_allclose(coarse[key], fine[key], rtol=1e-9, atol=1e-10, err_msg=key)


@pytest.mark.parametrize("upright", UPRIGHT)
def test_joints_floor_and_servo_do_no_work(upright: str):
    """The kinetic energy changes by the power of drives, wrench and friction alone."""
    scene = skew(upright)
    machine, bodies, reactions = begin(scene)
    drives = [-0.2, 0.1, 0.15]
    power = sum(tau * entry["spin_rate"] for tau, entry in zip(drives, scene["wheels"], strict=True))
    power += bodies[0, ROTATION].reshape(3, 3) @ [2.0, -1.0, 3.0] @ bodies[0, VELOCITY] + 0.1 * bodies[0, OMEGA][2]
    power += sum(force @ touch.slip for force, touch in zip(reactions.friction, reactions.touches, strict=True))
    assert abs(kinetic_rate(machine, bodies, reactions) - power) < 1e-11  # of -6 W; measured: 3e-14


@pytest.mark.parametrize("upright", UPRIGHT)
def test_momenta_change_by_what_acts_from_outside(upright: str):
    """Floor, weight, wrench and servo: what acts between bodies, drives among it, drops out of the sums.

    About a point of the floor, sum of x x m v' + d(I w)/dt = sum of P x (F + N n) + x_0 x f + weights + torques.
    """
    machine, bodies, reactions = begin(skew(upright))
    x, w, turned = bodies[:, POSITION], bodies[:, OMEGA], bodies[:, ROTATION].reshape(-1, 3, 3)
    inertia = (turned * machine.inertia[:, None]) @ turned.transpose(0, 2, 1)
    gained = machine.mass[:, None] * reactions.acceleration[:, :3]
    turning = (inertia @ reactions.acceleration[:, 3:, None])[..., 0] + cross(w, (inertia @ w[..., None])[..., 0])
    weights = -9.81 * machine.mass[:, None] * UP
    floor = reactions.friction + reactions.normal_force[:, None] * UP
    points = np.array([touch.point for touch in reactions.touches])
    force, servo = turned[0] @ [2.0, -1.0, 3.0], 0.1 * UP
    if upright == "servo":
        servo = servo + turned[0, :, :2] @ reactions.servo_torque
    change, impulse = gained.sum(axis=0), weights.sum(axis=0) + floor.sum(axis=0) + force
    np.testing.assert_allclose(change, impulse, rtol=0, atol=1e-11)  # of 40 N; measured: 1e-14
    moment = cross(x, weights).sum(axis=0) + cross(points, floor).sum(axis=0) + cross(x[0], force) + servo
    spun = cross(x, gained).sum(axis=0) + turning.sum(axis=0)
    np.testing.assert_allclose(spun, moment, rtol=0, atol=1e-11)  # of 13 N m; measured: 2e-14


@pytest.mark.long
def test_without_friction_the_centre_of_mass_moves_straight():
    """Drives and gyroscopic torques turn the chassis about it, through five exchanges."""
    scene = skew(law="none")
    del scene["wrench"]
    machine, bodies, _ = begin(scene)
    centre = machine.mass @ (bodies[:, POSITION] - [0.3, -0.2, 0.0]) / machine.mass.sum()
    motion = simulate(scene, [0.0, 0.06, 0.12])
    turned = motion["yaw"] - motion["yaw"][0]
    arm = np.stack([np.cos(turned) * centre[0] - np.sin(turned) * centre[1],
                    np.sin(turned) * centre[0] + np.cos(turned) * centre[1]], axis=1)  # fmt: skip
    velocity = motion["velocity"] + motion["yaw_rate"][:, None] * arm @ [[0.0, 1.0], [-1.0, 0.0]]
    np.testing.assert_allclose(velocity, velocity[:1].repeat(3, axis=0), rtol=0, atol=1e-12)  # measured: 2e-15
    path = motion["position"] + arm
    np.testing.assert_allclose(path - path[0], motion["time"][:, None] * velocity[0], rtol=0, atol=1e-13)
    assert abs(motion["yaw_rate"][-1] - 1.3) > 1e-3


def test_three_normal_forces_are_their_own_multipliers():
    """An affine N is no assumption for three wheels: one multiplier for each gives the same motion."""
    machine, bodies, reactions = begin(skew())
    machine.shares = lambda bodies, touches: np.eye(3)
    mode = machine.mode(0.0, start(machine)[1])
    alone = machine.solve(0.0, bodies, mode)
    np.testing.assert_allclose(alone.normal_force, reactions.normal_force, rtol=1e-12)  # measured: 1e-15
    np.testing.assert_allclose(alone.acceleration, reactions.acceleration, rtol=1e-9, atol=1e-8)


def test_three_rows_keep_four_wheels_on_the_floor():
    """g'' = 0 at every wheel, though only three sums of the four are imposed; N is affine in the contact's place."""
    scene, _ = load("mecanum")
    for wheel, phi in zip(scene["wheels"], (10.0, -25.0, 15.0, 5.0), strict=True):
        wheel["spin_angle_deg"] = phi
    _, _, reactions = begin(scene)
    acceleration = reactions.acceleration.ravel()
    for touch in reactions.touches:
        lift = touch.push(UP) @ acceleration[touch.columns] - touch.bias
        assert abs(lift) < 1e-10  # of 10 m/s^2; measured: 2e-13
    places = np.array([[1.0, *touch.point[:2]] for touch in reactions.touches])
    affine = places @ np.linalg.lstsq(places, reactions.normal_force, rcond=None)[0]
    np.testing.assert_allclose(reactions.normal_force, affine, rtol=1e-12)


@pytest.mark.parametrize("upright", UPRIGHT)
@pytest.mark.long
def test_mirrored_vehicle_moves_as_the_mirror_image(upright: str):
    """Reflection in the plane of x and z: psi, roller rates, y, headings, yaw and F_k change sign."""
    scene = skew(upright)
    image = deepcopy(scene)
    flip = np.array([1.0, -1.0])
    for wheel in image["wheels"]:
        wheel |= {"mirrored": not wheel.get("mirrored", False), "heading_deg": -wheel["heading_deg"]}
        wheel |= {"position": flip * wheel["position"], "roller_rates": [-rate for rate in wheel["roller_rates"]]}
    image["chassis"]["center_of_mass"] = np.array([1.0, -1.0, 1.0]) * scene["chassis"]["center_of_mass"]
    image["wrench"]["force"] = np.array([1.0, -1.0, 1.0]) * scene["wrench"]["force"]
    image["wrench"]["yaw_torque"] = [-torque for torque in scene["wrench"]["yaw_torque"]]
    for key in ("position", "velocity"):
        image["initial"][key] = flip * scene["initial"][key]
    for key in ("yaw_deg", "yaw_rate"):
        image["initial"][key] = -scene["initial"][key]
    one, other = simulate(scene, [0.0, 0.02]), simulate(image, [0.0, 0.02])
    signs = {"position": flip, "acceleration": flip, "yaw": -1.0, "yaw_acceleration": -1.0, "servo_torque": -flip}
    for key, sign in signs.items():
        np.testing.assert_allclose(other[key], sign * one[key], rtol=1e-9, atol=1e-10, err_msg=key)
    signs = {"spin_angle": 1.0, "normal_force": 1.0, "friction_force": flip, "roller_axial_rate": -1.0}
    for name, wheel in one["wheels"].items():
        for key, sign in signs.items():
            found = other["wheels"][name][key]
            np.testing.assert_allclose(found, sign * wheel[key], rtol=1e-9, atol=1e-10, err_msg=f"{key} {name}")


@pytest.mark.long
def test_wheels_that_turn_alike_exchange_rollers_together():
    scene, _ = load("mecanum")
    scene["friction"] = {"law": "viscous", "viscosity": 2.0}
    scene["chassis"]["center_of_mass"] = [0.0, 0.0, 0.1]
    scene["initial"] = {"velocity": [0.1, 0.0]}
    for wheel in scene["wheels"]:
        wheel |= {"spin_rate": 8.0, "drive": {"kind": "free"}}
    times, names = zip(*simulate(scene, [0.0, 0.1])["exchange_times"], strict=True)
    assert set(names) == {wheel["name"] for wheel in scene["wheels"]} and len(names) == 4
    assert np.ptp(times) < 1e-12


@pytest.mark.long
def test_a_lifted_wheel_is_refused():
    scene = skew()
    scene["wrench"] = {"times": [0.0, 0.1], "yaw_torque": [0.0, 0.0], "force": [[0.0, 0.0, 0.0], [0.0, 0.0, 40.0]]}
    with pytest.raises(ValueError, match="front lifts off"):
        simulate(scene, [0.0, 0.1])
