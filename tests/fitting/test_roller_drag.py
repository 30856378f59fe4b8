"""What rolling resistance and creep do to a mecanum machine whose wheels follow angles: the page on measured robots."""

import copy
import math

import numpy as np
import pytest

import omnisim
from docs.measured_drag import BRUSH
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.scene import parse
from omnisim.scene.toml_text import rewrite

RADIUS, DISTANCE, ROLLERS = 0.03, 0.0235, 8  # of omni4
SINE = math.sqrt(0.5)  # of 45 deg, and its cosine
RESISTANCE, STIFFNESS = 8e-4, BRUSH["creep_stiffness"]
BEARING, LOAD = 2e-3, 9.81 * (3.0 + 4 * (0.12 + 8 * 0.008)) / 4.0  # N m, N
BEGIN, END = 2.0, 6.0  # s, at constant speed
AHEAD, ASIDE, IN_PLACE = (0.08, 0.0, 0.0), (0.0, 0.08, 0.0), (0.0, 0.0, 0.4)


def gain(twist, resistance: float = 0.0, bearing: float = 0.0) -> float:
    """Distance along a twist by that which the wheels' turning makes of ideal ones."""
    base = omnisim.load("omni4")
    data = {key: value for key, value in copy.deepcopy(base.document.data).items() if key != "command"}
    data |= {"time": {"end": END, "step": 0.05, "output_interval": 0.05}, "friction": BRUSH}
    time = np.linspace(0.0, END, 121)
    seconds = np.where(time < 1.0, 0.5 * time**2, time - 0.5)
    for wheel, rate in zip(data["wheels"], wheel_rows(base.config) @ twist, strict=True):
        wheel["drive"] = {"kind": "follow", "times": time.tolist(), "angle": (rate * seconds).tolist()}
    for kind in data["wheel_types"].values():
        kind["roller"] |= {"rolling_resistance": resistance, "bearing_torque": bearing}
    run = omnisim.simulate(parse(rewrite("", [], data)))
    assert run.complete, run.attributes["status"]
    first = np.searchsorted(run.time, BEGIN)
    pose = np.column_stack([run["body/position"][:, :2], run["body/yaw"]])
    moved = (pose[-1] - pose[first]) / (run.time[-1] - run.time[first])
    return float(moved @ twist) / float(np.dot(twist, twist))


def slip(twist, bearing: float = 0.0) -> float:
    """The share of the speed that creeps: sqrt(2) F V / (c N), F = |M a| / h_q across a roller, as much along it, of
    rolling resistance; or F = T / h_q of a bearing.

    The mean over the way on a roller."""
    speed_h, speed_k, _ = np.asarray(twist) / np.linalg.norm(twist)
    q = np.linspace(-1.0, 1.0, 401) * math.pi / ROLLERS
    h_q = RADIUS - DISTANCE / np.cos(q)
    joint = speed_k / (h_q * SINE * np.cos(q))
    spin = (speed_h - joint * h_q * SINE) / RADIUS
    turning = np.array([-joint * SINE * np.cos(q), spin + joint * SINE])  # w_t
    about_axis = np.abs(-turning[0] * SINE * np.cos(q) + turning[1] * SINE) / np.hypot(*turning)
    along = -spin * DISTANCE / np.cos(q) ** 2 + joint * h_q * SINE * np.cos(q)  # of the contact, over the roller
    rolling = np.hypot(spin * RADIUS + joint * h_q * SINE, along)
    arm = bearing / LOAD if bearing else RESISTANCE * about_axis
    found = math.sqrt(2.0) * arm / h_q * rolling / STIFFNESS
    return float(np.average(found, weights=1.0 / np.cos(q) ** 2))


@pytest.mark.long
@pytest.mark.parametrize(("twist", "wanted"), [(AHEAD, slip(AHEAD)), (ASIDE, slip(ASIDE)), (IN_PLACE, 0.0)])
def test_drag_of_rollers_costs_speed_ahead_and_twice_as_much_aside_and_none_in_place(twist, wanted):
    """Simulated 1.58 % ahead, 3.28 % of 0.974 aside, -0.05 % in place; closed form 1.50, 2.97, 0."""
    free, slowed = (gain(twist, resistance) for resistance in (0.0, RESISTANCE))
    assert (free - slowed) / free == pytest.approx(wanted, rel=0.15, abs=1e-3)


@pytest.mark.long
@pytest.mark.parametrize(("twist", "wanted"), [(AHEAD, 0.0), (ASIDE, slip(ASIDE, BEARING))])
def test_bearings_of_rollers_cost_speed_aside_alone(twist, wanted):
    """2 mN m: simulated 0.831 % of the speed aside and -8e-7 of that ahead; closed form 0.828 % and 0."""
    free, slowed = gain(twist), gain(twist, bearing=BEARING)
    assert (free - slowed) / free == pytest.approx(wanted, rel=0.15, abs=1e-3)
