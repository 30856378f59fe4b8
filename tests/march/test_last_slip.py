"""How long slip lasts while what accelerates it and friction's strength stay, and what the march makes of it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import omnisim
from bench.machine_scenes import platform
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric
from omnisim.march.last_slip import PRECISE, time_to_rest
from omnisim.results.comparison import distance


@pytest.mark.short
def test_time_to_rest_where_friction_resists_alike_in_all_directions():
    """(s |v| + b . v)' = b^2 - s^2 for v' = b - s v / |v|: so T = (s |v| + b . v) / (s^2 - b^2)."""
    rng = np.random.default_rng(3)
    worst = 0.0
    for _ in range(300):
        s, angle = 10.0 ** rng.uniform(-1, 3), rng.uniform(0, 2 * np.pi)
        b = s * rng.uniform(0, 0.8) * np.array([np.cos(angle), np.sin(angle)])
        v = 10.0 ** rng.uniform(-6, 0) * rng.normal(size=2)
        exact = (s * np.hypot(*v) + b @ v) / (s * s - b @ b)
        worst = max(worst, abs(time_to_rest(Slip(*b), Symmetric(1.0, 0.0, 1.0), s, Slip(*v))[0] / exact - 1.0))
    assert worst < 2.0 * PRECISE  # measured 1.5e-3


@pytest.mark.short
@pytest.mark.parametrize("ratio", [3.0, 20.0, 200.0])
def test_time_to_rest_where_a_roller_gives_way_more_than_the_machine(ratio):
    """Against LSODA, which follows slip until a millionth of it is left and goes straight on from there."""
    rng = np.random.default_rng(4)
    errors = []
    for _ in range(15):
        turn = rng.uniform(0, np.pi)
        axes = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        s = axes @ np.diag([ratio, 1.0]) @ axes.T
        b, v = s @ (rng.uniform(0, 0.8) * axes @ [np.cos(turn), np.sin(turn)]), rng.normal(size=2)

        def rate(_, v, s=s, b=b):
            return b - s @ v / np.hypot(*v)

        def nearly(_, now, v=v):
            return np.hypot(*now) - 1e-6 * np.hypot(*v)

        nearly.terminal = True
        run = solve_ivp(rate, (0.0, 1e3), v, "LSODA", events=nearly, rtol=1e-10, atol=1e-14)
        end = run.y[:, -1]
        exact = run.t[-1] - end @ end / (end @ rate(0.0, end))
        found, turned = time_to_rest(Slip(*b), Symmetric(s[0, 0], s[0, 1], s[1, 1]), 1.0, Slip(*v))
        assert 0.0 <= turned <= found
        errors.append(abs(found / exact - 1.0))
    # measured, by ratio: 1.1e-3, 2.3e-4, 2.0e-4 at most; 1.9e-4, 4.9e-5, 2.3e-5 mostly
    assert max(errors) < 2.0 * PRECISE and np.median(errors) < 0.4 * PRECISE


@pytest.mark.short
def test_slip_that_nothing_stops_takes_for_ever():
    """b beyond the cone: slip turns into its direction and grows."""
    assert time_to_rest(Slip(3.0, 1.0), Symmetric(2.0, 0.0, 1.0), 1.0, Slip(-1e-3, 1e-3))[0] == math.inf


@pytest.mark.parametrize(
    ("method", "step", "bound", "work"),
    [
        ("rk4", 1e-2, 1.2e-5, 1120),  # measured 1.06e-5 and 1082, by sub-steps to the end 1.05e-5 and 1776
        ("dopri5", 1e-2, 3e-7, 1750),  # 2.4e-7 and 1698, 2.8e-7 and 2600
        ("dopri5", 5e-3, 3e-8, 3600),  # 1.12e-8 and 3516, by the derivative at its start alone 4.2e-7
    ],
)
def test_a_stop_costs_two_sub_steps(method, step, bound, work):
    """26 stops of a wheel, 200 steps or 400 and 25 exchanges: errors of no more than by 7 sub-steps a stop."""
    exact, found = (
        omnisim.simulate(omnisim.load("coulomb_wheel", [f"solver.method={by}", f"time.step={length}"]))
        for by, length in (("dopri5", 1e-4), (method, step))
    )
    assert distance(found, exact) < bound
    assert found.attributes["rhs_evaluations"] < work


def test_creeping_slip_ends_with_the_step_that_is_aimed_at_its_end():
    """A platform whose wheels come to rest 88 times: one step less for most of them, at the same error."""
    exact, found = (
        omnisim.simulate(platform("diagonal with yaw", "rate", *setting))
        for setting in (("dopri5", 1e-4), ("rk4", 1e-2))
    )
    assert distance(found, exact) < 2.5e-5  # measured 1.9e-5, as before
    assert found.attributes["rhs_evaluations"] < 2200  # measured 2074, before 2811


def test_slip_that_stops_knows_how_its_direction_turns():
    """The same platform by a method that errs less: what is left is not what a stop begins with."""
    exact, found = (omnisim.simulate(platform("diagonal with yaw", "rate", "bs5", step)) for step in (1e-4, 0.1 / 75))
    assert distance(found, exact) < 5e-11  # measured 2.0e-11; with a direction that turns from rest 1.0e-9
