"""How friction turns slip while nothing else changes, by its direction, and what the march makes of it."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import omnisim
from bench.machine_scenes import platform
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric
from omnisim.march.turning_slip import Friction, go_straight, one_friction, turn_in, two_frictions
from omnisim.results.comparison import distance
from omnisim.scene.scene import parse


@pytest.mark.short
@pytest.mark.parametrize("axis", [(1.0, 0.0), (0.0, 1.0)])
def test_slip_that_goes_straight_on_takes_the_time_that_it_does(axis):
    """Along an axis of A, b = 0: |v| / (mu N A), even where friction would push any other slip away from it."""
    a, limit, v = Symmetric(30.0, 0.0, 1.0), 2.0, Slip(0.3 * axis[0], 0.3 * axis[1])
    found = turn_in(Slip(0.0, 0.0), a, one_friction(limit), v)
    rest = math.hypot(found.h, found.k) / (limit * (a.hh * axis[0] + a.kk * axis[1]))
    exact = 0.3 / (limit * (a.hh * axis[0] + a.kk * axis[1]))
    assert abs((found.time + (0.0 if found.gone else rest)) / exact - 1.0) < 1e-12  # measured 4e-16, rounding


@pytest.mark.short
@pytest.mark.parametrize("answer", [0.0, 0.1])
def test_slip_turns_as_its_equation_says(answer):
    """Against DOP853 at tight tolerances: slip, and its way, when a roller's has become the machine's; part of the load
    that answers to the direction of friction."""
    rng = np.random.default_rng(5)
    worst, furthest = 0.0, 0.0
    for _ in range(30):
        b, v = rng.uniform(-0.3, 0.3, 2), rng.uniform(-1.0, 1.0, 2) * [1.0, 0.2]
        m = np.array([1.0, *rng.uniform(-answer, answer, 2)])
        a = np.diag([30.0, 1.0])
        found = turn_in(Slip(*b), Symmetric(30.0, 0.0, 1.0), Friction(*m), Slip(*v))

        def rates(_, y, b=b, m=m, a=a):
            u = y[:2] / np.hypot(*y[:2])
            return np.concatenate([b - a @ u / (m[0] + m[1:] @ u), y[:2]])

        exact = solve_ivp(rates, (0.0, found.time), [*v, 0.0, 0.0], "DOP853", rtol=1e-11, atol=1e-14).y[:, -1]
        speed = np.hypot(*v)
        worst = max(worst, np.hypot(*(exact[:2] - [found.h, found.k])) / speed)
        furthest = max(furthest, np.hypot(*(exact[2:] - [found.way_h, found.way_k])) / (speed * found.time))
    assert worst < 1e-5 and furthest < 5e-5  # measured 2.9e-6 and 1.8e-5


@pytest.mark.short
def test_friction_between_two_directions():
    """1 / mu N is what it is at both, and that of the first across them as well."""
    v, u = Slip(0.3, 0.1), Slip(0.0, 1.0)
    found = two_frictions(v, 5.0, u, 4.0)

    def limit(h, k):
        size = math.hypot(h, k)
        return 1.0 / (found.mean + found.h * h / size + found.k * k / size)

    assert abs(limit(v.h, v.k) - 5.0) < 1e-14 and abs(limit(u.h, u.k) - 4.0) < 1e-14


@pytest.mark.parametrize(
    ("drive", "method", "step", "bound", "work"),
    [
        ("rate", "rk4", 1e-2, 2.5e-5, 2200),  # measured 1.9e-5 and 2062, by sub-steps 1.8e-5 and 2475
        # 6.4e-6 and 3381, 1.3e-5 and 3972; without the centre of the impulse 9.3e-6
        ("torque", "dopri5", 1e-2, 8e-6, 3500),
        ("torque", "dopri5", 5e-3, 1e-6, 6750),  # 5.3e-7 and 6556, 6.0e-6 and 6849
        ("rate", "bs5", 5e-3, 2e-8, 6500),  # 1.2e-8 and 6261
    ],
)
def test_slip_of_a_roller_that_has_come_down_turns_at_once(drive, method, step, bound, work):
    """A platform whose wheels come to rest 88 times by rate drives, and 94 times by torques, where nothing takes an
    error back."""
    exact, found = (
        omnisim.simulate(platform("diagonal with yaw", drive, *setting))
        for setting in (("dopri5", 1e-4), (method, step))
    )
    assert distance(found, exact) < bound
    assert found.attributes["rhs_evaluations"] < work


@pytest.mark.short
@pytest.mark.parametrize("beside", [1e-3, 1e-6])
def test_slip_goes_straight_on_while_little_of_it_is_beside(beside):
    """In one step, with all that b and the load do to it: against DOP853 at tight tolerances."""
    b, a, m = np.array([3.0, -0.02]), np.diag([30.0, 1.0]), np.array([1.0, 0.1, -0.05])
    v = np.array([-1.0, beside])
    time, *straight = go_straight(v[0], v[1], (30.0, 1.0), tuple(b), tuple(m))

    def rates(_, y):
        u = y[:2] / np.hypot(*y[:2])
        return np.concatenate([b - a @ u / (m[0] + m[1:] @ u), y[:2]])

    exact = solve_ivp(rates, (0.0, time), [*v, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
    assert time > 0.0 and abs(straight[1] / straight[0]) < 0.02
    assert np.abs(exact - straight).max() < 3e-5  # measured 9.0e-6 and 2.6e-6


# measured 1.7e-3 and 8.6e-4, as by sub-steps; of slip that has its end's direction too early 5.9e-3 and 1.9e-3
@pytest.mark.parametrize(("after", "bound"), [(3e-6, 3e-3), (1e-5, 1.5e-3)])
def test_a_row_within_a_turn_sees_slip_turn(after, bound):
    """So many seconds after a roller of the platform has come down: slip is what it is, not what it will end as."""
    text, wheel = platform("diagonal with yaw", "rate", "rk4", 0.1).text, "front_right"
    run = omnisim.simulate(platform("diagonal with yaw", "rate", "dopri5", 1e-4))
    downs = run["events/time"][(run["events/kind"] == "exchange") & (run["events/wheel"] == wheel)]
    end = float(downs[downs > 1.6][0]) + after

    def slip(method, steps):
        times = [f"time.end={end!r}", f"time.output_interval={end!r}", f"time.step={end / steps!r}"]
        found = omnisim.simulate(parse(text, "platform", [f'solver.method="{method}"', *times]))
        return found[f"wheels/{wheel}/slip_velocity"][-1]

    # what is left is the microsecond that the exchange is off: slip changes by 1700 m/s^2
    assert np.abs(slip("rk4", 130) - slip("dopri5", 8320)).max() < bound
