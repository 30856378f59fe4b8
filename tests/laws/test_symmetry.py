"""Symmetries of space and of the description: what must not change the motion of a machine changes only rounding."""

import copy

import numpy as np
import pytest
from machines import mirrored, rotated, rotation, run, tables
from scenes import of_wheels, reference_scene

PUSH = {
    "times": [0.0, 1.0, 1.0, 2.0],  # a jump at 1 s
    "force": [[1.0, 2.0, 0.0], [-2.0, 1.0, 3.0], [0.0, -2.0, 0.0], [1.0, 1.0, -1.0]],
    "yaw_torque": [0.1, -0.2, 0.3, 0.0],
}
TURN_DEG = 73.0
CREEP = ("friction.law=brush", "friction.creep_stiffness=4.0")
ROLLING = ("wheel_types.omni.roller.rolling_resistance=1e-3", "wheel_types.omni.roller.rolling_rate=2.0")

# Scenes whose friction is smooth, and the largest share of rounding that their motion may show: they amplify little.
SMOOTH = {
    "kiwi": tables(reference_scene("kiwi", "time.step=2e-4")),
    "pushed kiwi": tables(reference_scene("kiwi", "time.step=2e-4")) | {"wrench": PUSH},
    "kiwi pushed in its own axes": tables(reference_scene("kiwi", "time.step=2e-4"))
    | {"wrench": PUSH | {"frame": "body"}},
    "mecanum": tables(reference_scene("mecanum", "time.step=4e-5")),
    "creeping kiwi": tables(reference_scene("kiwi", "time.step=2e-5", *CREEP)) | {"wrench": PUSH},
    "kiwi that resists rolling": tables(reference_scene("kiwi", "time.step=2e-5", *ROLLING)) | {"wrench": PUSH},
    "kiwi on a slope": tables(reference_scene("kiwi", "time.step=2e-4"))
    | {"floor": {"slope_deg": 9.0, "uphill_deg": 50.0}},
}
# Coulomb friction: fewer digits are left of forces and of the times at which it sticks.
COULOMB = {
    "youbot on a curve": tables("youbot") | {"command": {"times": [0.0, 0.5], "twist": [[0, 0, 0], [0.3, 0.2, 0.5]]}},
    "mixed wheels": tables("mixed"),
}
ALL = SMOOTH | COULOMB


def same_motion(one, other, matrix, sense, digits):
    """Whether the plane motion of `other` is that of `one` through `matrix` (2, 2), spins and loads the same.

    digits: bounds, relative, of positions and angles; of spin rates and forces.
    """
    motion, forces = digits
    turn = other["body/yaw"][0] - sense * one["body/yaw"][0]
    wheels = [[run[f"wheels/{name}/{path}"] for name in one.wheels] for run in (one, other) for path in COMPARED]
    own, others = wheels[: len(COMPARED)], wheels[len(COMPARED) :]
    pairs = [
        (one["body/position"][:, :2] @ matrix.T, other["body/position"][:, :2], motion),
        (sense * one["body/yaw"] + turn, other["body/yaw"], motion),
        (np.array(own[0]), np.array(others[0]), motion),
        (np.array(own[1]), np.array(others[1]), forces),
        (np.array(own[2]), np.array(others[2]), forces),
        (np.array(own[3]) * [1, sense], np.array(others[3]), forces),
    ]
    for expected, found, bound in pairs:
        assert np.abs(found - expected).max() <= bound * np.abs(expected).max()
    assert list(one["events/kind"]) == list(other["events/kind"])


COMPARED = ("spin_angle", "spin_rate", "normal_force", "friction_force")
DIGITS = dict.fromkeys(SMOOTH, (1e-14, 1e-13)) | dict.fromkeys(COULOMB, (1e-13, 2e-10))
DIGITS["kiwi on a slope"] = (1e-14, 1e-12)  # what is turned is rounded once more: forces to 1e-13


@pytest.mark.parametrize("name", ALL)
def test_a_machine_in_a_mirror_moves_as_its_mirror_image(name):
    """Measured: motion to 9e-16, forces to 2e-14; with coulomb friction to the last bit."""
    same_motion(run(ALL[name]), run(mirrored(ALL[name])), np.diag([1.0, -1.0]), -1, DIGITS[name])


@pytest.mark.parametrize("name", ALL)
def test_a_turn_of_the_world_turns_the_motion(name):
    """Measured: motion to 4e-16, forces to 1e-14; with coulomb friction to 4e-15 and 1e-11."""
    turned = run(rotated(ALL[name], TURN_DEG))
    same_motion(run(ALL[name]), turned, rotation(np.radians(TURN_DEG)), 1, DIGITS[name])


@pytest.mark.parametrize("name", ALL)
def test_the_order_of_the_wheels_does_not_matter(name):
    """Measured: motion to 2e-16, forces to 2e-15; with coulomb friction to 2e-16 and 3e-13."""
    data = copy.deepcopy(ALL[name])
    data["wheels"] = data["wheels"][1:][::-1] + data["wheels"][:1]
    same_motion(run(ALL[name]), run(data), np.eye(2), 1, DIGITS[name])


def test_a_symmetric_machine_goes_straight_though_its_four_wheels_change_rollers_at_once():
    straight = run(tables("youbot"))
    assert np.abs(straight["body/position"][:, 1]).max() < 1e-14  # m, of 1.37; measured 1.9e-15
    assert np.abs(straight["body/yaw"]).max() < 1e-14  # rad; 6.6e-15
    exchanges = straight["events/kind"] == "exchange"
    front, right, rear, other = (
        straight["events/time"][exchanges & (straight["events/wheel"] == name)] for name in straight.wheels
    )
    assert len(front) == 28 and front[0] == rear[0]  # all four at once, until the load shifts between front and rear
    # s, of 3: measured 3e-15 and 1.4e-14, the rounding of yaw by the speed of the wheels
    assert np.abs(front - right).max() < 3e-14 and np.abs(rear - other).max() < 3e-14


def test_a_kiwi_turns_on_the_spot_when_told():
    data = tables("kiwi")
    data["command"] = {"times": [0.0, 0.5], "twist": [[0, 0, 0], [0, 0, 1.0]]}
    for wheel, angle in zip(data["wheels"], np.radians([60.0, 180.0, -60.0]), strict=True):  # exact to the last digit
        wheel["position"] = [0.125 * np.cos(angle), 0.125 * np.sin(angle)]
    turning = run(data)
    assert np.abs(turning["body/position"]).max() < 1e-12  # m
    assert turning["body/yaw"][-1] > 3.0
    spins = of_wheels(turning, "spin_angle")
    assert np.abs(spins - spins[:, :1]).max() < 1e-11 * spins[-1, 0]
