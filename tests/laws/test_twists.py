"""The youBot and the kiwi follow twists: where odometry is right, and by how much it is wrong; bench/twists.py."""

from functools import cache

import numpy as np
import pytest

from bench import twists
from bench.twists import TWISTS, follow, rolled

RADIUS, ALPHA = 0.0475, np.pi / 6  # of the youBot's wheels, six rollers


@cache
def row(machine, name):
    return twists.row(machine, name, 4.0)


def test_a_machine_driven_forward_stays_on_its_line():
    for machine in TWISTS:
        found = row(machine, "forward")
        assert abs(found["y"]) < 1e-12 and abs(found["yaw"]) < 1e-12  # m, rad; measured 6e-15, 5e-15
        assert found["position_error"] < 1e-5  # m; measured 2.8e-6 and 1.2e-8


@pytest.mark.parametrize("name", TWISTS["kiwi"])
def test_odometry_of_straight_rollers_is_right_but_for_skids(name):
    found = row("kiwi", name)
    assert found["position_error"] < 2e-7 and abs(found["yaw_error"]) < 1e-6  # m, rad; measured 3.8e-8, 2.0e-7


@pytest.mark.parametrize(("speed", "skids"), [(0.05, 2e-5), (0.02, 4e-6)])
def test_a_mecanum_machine_goes_sideways_by_the_integral_of_the_cosine(speed, skids):
    """y = R (2 n sin(alpha) + sin(q)): sin(alpha) / alpha = 0.955 of the odometry, but for skids."""
    found = follow("youbot", (0.0, speed, 0.0), 20.0)
    distance = found["body/position"][:, 1]
    for wheel in found.wheels:
        assert np.abs(distance - np.abs(rolled(found, wheel, RADIUS, ALPHA))).max() < skids  # m; measured 5.5e-6, 9e-7
    pitches = np.abs(found["wheels/front_right/spin_angle"]) / (2.0 * ALPHA)
    ends = [0.5, np.floor(pitches[-1] - 0.5) + 0.5]
    true, told = (np.diff(np.interp(ends, pitches, y)) for y in (distance, found["odometry/position"][:, 1]))
    assert abs(true / told - np.sin(ALPHA) / ALPHA) < 2e-5  # measured 4.6e-6, 1.9e-6


def test_a_mecanum_machine_goes_diagonally_by_another_mean():
    assert (
        abs(1.0 + row("youbot", "diagonal")["lost"] - (2.0 - 2.0 * np.tan(ALPHA / 2) / ALPHA)) < 1e-4
    )  # measured 8e-6


def test_a_mecanum_machine_that_turns_slips_all_the_time_and_turns_less():
    found = row("youbot", "rotation")
    assert -0.04 < found["lost"] < -0.02  # measured -0.028
    assert found["steady_slip"] > 0.01  # m/s; measured 0.019: the contact points move along the axles
    assert max(row("youbot", name)["steady_slip"] for name in ("forward", "sideways", "diagonal")) < 1e-10
