"""What a scene asks of its machine: the path of its command, and target rates of its drives."""

import math

import numpy as np
import pytest
from machines import machine, scene
from synthetic import synthetic_trajectory

from omnisim.results.commanded import Table, integral, path, target_rates
from omnisim.scene.ideal_kinematics import wheel_rows

pytestmark = pytest.mark.short
START = (0.3, -0.2, 0.7)
TIMES = np.linspace(0.0, 4.0, 41)
FOLLOW = {"kind": "rate", "proportional": 0.1}


def commanded(times, twist, **changed):
    drives = [FOLLOW] * 4
    initial = {"position": [0.3, -0.2], "yaw_deg": math.degrees(0.7)}
    return machine("mecanum", drives=drives, command={"times": times, "twist": twist}, initial=initial, **changed)


@pytest.mark.parametrize("yaw_rate", [0.5, -3.0, 40.0])
def test_a_constant_twist_leads_along_an_arc(yaw_rate):
    """x + v / w (sin yaw - sin yaw_0), ...; forward and sideways at once."""
    vx, vy = 0.4, -0.3
    found = integral(Table(np.array([0.0]), np.array([[vx, vy, yaw_rate]])), START, TIMES)
    yaw = START[2] + yaw_rate * TIMES
    sines, cosines = np.sin(yaw) - math.sin(START[2]), np.cos(yaw) - math.cos(START[2])
    expected = np.column_stack([
        START[0] + (vx * sines + vy * cosines) / yaw_rate,
        START[1] + (vy * sines - vx * cosines) / yaw_rate,
        yaw,
    ])  # fmt: skip
    assert np.abs(found - expected).max() < 2e-13  # 7e-16, 5e-15, of 25 turns 6e-14


def test_a_yaw_rate_that_rises_leads_along_a_clothoid():
    """x = int cos(w' t^2 / 2) dt, Fresnel's integrals, v = 1 m/s; with two rows only, too: six turns in a piece."""
    special = pytest.importorskip("scipy.special")
    bend = 5.0  # rad/s^2
    twists = Table(np.array([0.0, 4.0]), np.array([[1.0, 0.0, 0.0], [1.0, 0.0, 4.0 * bend]]))
    scale = math.sqrt(math.pi / bend)
    for times in (TIMES, TIMES[[0, -1]]):
        y, x = special.fresnel(times / scale)
        found = integral(twists, (0.0, 0.0, 0.0), times)
        assert np.abs(found[:, :2] - scale * np.column_stack([x, y])).max() < 1e-13  # 6e-16


def test_a_jump_of_the_command_is_a_corner_and_knots_between_rows_count():
    """Forward 1 m/s until 0.55 s, then to the left 2 m/s; held beyond the last knot."""
    config = scene(commanded([0.55, 0.55], [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])).config
    found = path(config, TIMES)
    forward, left = np.minimum(TIMES, 0.55), 2.0 * np.maximum(TIMES - 0.55, 0.0)
    cos, sin = math.cos(0.7), math.sin(0.7)
    assert np.abs(found[:, 0] - (0.3 + cos * forward - sin * left)).max() < 1e-14
    assert np.abs(found[:, 1] - (-0.2 + sin * forward + cos * left)).max() < 1e-14
    assert found[:, 2] == pytest.approx(0.7, abs=1e-15)


def test_rates_that_ideal_wheels_have_together_tell_the_path_as_the_command_does():
    """So do the tables that a Loop leaves behind."""
    times, twist = [0.0, 1.0, 1.0, 3.0], [[0.0, 0.0, 0.0], [0.4, 0.1, 0.0], [0.2, 0.0, 1.0], [0.0, 0.3, -1.0]]
    data = commanded(times, twist)
    config = scene(data).config
    rates = np.array(twist) @ wheel_rows(config).T
    del data["command"]
    for wheel, column in zip(data["wheels"], rates.T, strict=True):
        wheel["drive"] = FOLLOW | {"times": times, "rate": column.tolist()}
    assert np.abs(path(scene(data).config, TIMES) - path(config, TIMES)).max() < 1e-13  # 1e-15
    data["wheels"][0]["drive"]["rate"][1] += 0.1
    assert path(scene(data).config, TIMES) is None  # no ideal machine has these rates
    data["wheels"][0]["drive"] = {"kind": "free"}
    assert path(scene(data).config, TIMES) is None


def test_target_rates_are_those_recorded_or_else_those_of_the_scene():
    data = commanded([0.0, 1.0, 1.0], [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.0]])
    data["wheels"][1]["drive"] = FOLLOW | {"rate": 2.5}
    config = scene(data).config
    run = synthetic_trajectory(rows=21, wheels=("w0", "w1", "w2", "w3"))
    run.data["wheels/w3/target_rate"] = np.arange(21.0)
    found = target_rates(run, config)
    rows = wheel_rows(config)
    expected = np.where(run.time < 1.0, 0.5 * run.time, 0.0) * rows[0, 0]  # after the jump in its own row
    assert found["w0"] == pytest.approx(expected, abs=1e-14)
    assert set(found["w1"]) == {2.5}
    assert found["w3"].tolist() == list(range(21))
    torque = scene(machine("mecanum", drives=[{"kind": "torque", "torque": 0.1}] * 4)).config
    assert list(target_rates(run, torque)) == ["w3"] and path(torque, run.time) is None
