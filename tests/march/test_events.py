"""Events: exchanges, turns and edges. No roller ever carries the wheel beyond its end."""

import itertools
import math

import numpy as np
import pytest
from scenes import reference_scene, simulate, standing

import omnisim
from omnisim.march.roller_exchange import touching

STILL = ("initial.velocity=[0, 0]", "initial.yaw_rate=0", "wheels.wheel.roller_rates=0")
EDGE = "wheels.wheel.spin_angle_deg=45"  # the common edge of rollers 0 and 1 of the four-roller wheel


def torque(times, values):
    return f"wheels.wheel.drive={{kind='torque', times={times}, torque={values}}}"


def assert_no_roller_overruns(run, alpha):
    assert np.abs(run["wheels/wheel/contact_angle"]).max() <= alpha + 1e-12
    exchanges = run["events/kind"] == "exchange"
    pairs = list(zip(run["events/roller_from"][exchanges], run["events/roller_to"][exchanges], strict=True))
    for (_, to), (back, _) in itertools.pairwise(pairs):
        assert to == back, "an exchange starts from the roller that the last one left in contact"


def test_exchanges_hand_the_contact_to_the_neighbour_ahead_at_the_common_edge():
    run = simulate("testbench_psi30", "friction.law=none", "initial.yaw_rate=0.0")
    spin = np.radians(0.0) + 9.0 * run["events/time"]
    edges = math.pi / 4 * (2 * np.arange(len(spin)) + 1)
    assert np.abs(spin - edges).max() < 1e-11  # a free spin at constant rate; measured 3.6e-14
    assert np.array_equal(run["events/roller_to"], (run["events/roller_from"] + 1) % 4)


@pytest.mark.parametrize("step", [1e-3, 1e-4])
def test_an_exchange_costs_one_step_more_and_the_derivative_behind_it(step):
    """It is aimed at: nothing is searched, and no step is taken twice."""
    run = omnisim.simulate(omnisim.load("six_rollers", [f"time.step={step}"]))
    exchanges = np.count_nonzero(run["events/kind"] == "exchange")
    assert exchanges == 15
    beside = run.attributes["rhs_evaluations"] - 4 * run.attributes["steps"]
    assert beside == 5 * exchanges + 2  # the two at the start find the rollers and the derivative


def test_a_wheel_that_runs_backwards_exchanges_backwards():
    run = simulate("testbench_psi30", "friction.law=none", "initial.yaw_rate=0.0", "wheels.wheel.spin_rate=-9.0")
    assert np.array_equal(run["events/roller_to"], (run["events/roller_from"] - 1) % 4)
    edges = math.pi / 4 * (2 * np.arange(len(run["events/time"])) + 1)
    assert np.abs(9.0 * run["events/time"] - edges).max() < 1e-11  # measured 3.6e-14


@pytest.mark.short
def test_several_exchanges_in_one_step_are_all_found_in_order():
    """500 rad/s at a step of 1e-2: about three exchanges in every step; without friction the times are known."""
    run = simulate(
        "testbench_psi30", "friction.law=none", "initial.yaw_rate=0.0", "wheels.wheel.spin_rate=500.0",
        "time.step=1e-2", "time.end=1.0",
    )  # fmt: skip
    expected = (math.pi / 4 * (2 * np.arange(len(run["events/time"])) + 1)) / 500.0
    assert len(expected) == int(500.0 / (math.pi / 2) + 0.5)
    assert np.abs(run["events/time"] - expected).max() < 1e-12  # measured 4.4e-16


@pytest.mark.short
def test_the_implicit_tracking_stops_when_the_step_is_too_large_to_integrate_rho():
    run = omnisim.simulate(
        reference_scene("testbench_psi30", "wheels.wheel.spin_rate=500.0", "time.step=1e-2", "solver.tracking=implicit")
    )
    assert "lost track" in run.attributes["status"]
    assert run.attributes["stop_wheel"] == "wheel"


@pytest.mark.short
def test_a_wheel_that_leaves_the_edge_and_returns_within_a_step_is_caught_at_the_return():
    """Started on an edge with a small spin against a constant torque: it leaves, turns, and is back at 2 phi'/|phi''|.

    With one step over the whole swing, the root at 0 is not the event; the later one is.
    """
    spin, pull = 0.02, -0.5
    inertia = 0.008 + 4 * (0.15 * 0.068**2 + 0.00012 * 0.75)
    back = -2.0 * spin * inertia / pull
    step = 2.5 * back
    run = simulate(
        "testbench_psi30", *STILL, EDGE, "friction.law=none", f"wheels.wheel.spin_rate={spin}",
        torque([0.0], [pull]), f"time.step={step!r}", f"time.end={10 * step!r}", f"time.output_interval={step!r}",
    )  # fmt: skip
    first = [run[f"events/{name}"][0] for name in ("time", "roller_from", "roller_to")]
    assert first[0] == pytest.approx(back, rel=1e-12)
    assert first[1:] == [1, 0]
    assert_no_roller_overruns(run, math.pi / 4)


@pytest.mark.short
def test_a_wheel_that_goes_over_the_edge_and_comes_back_within_a_step_exchanges_twice():
    inertia = 0.008 + 4 * (0.15 * 0.068**2 + 0.00012 * 0.75)
    gap, spin, pull = 1e-5, 0.05, -0.5  # rad before the edge, rad/s, N m
    decel = -pull / inertia
    root = math.sqrt(spin**2 - 2.0 * decel * gap)
    times = [(spin - root) / decel, (spin + root) / decel]
    step = 2.0 * times[1]
    run = simulate(
        "testbench_psi30", *STILL, "friction.law=none",
        f"wheels.wheel.spin_angle_deg={math.degrees(math.pi / 4 - gap)}",
        f"wheels.wheel.spin_rate={spin}", torque([0.0], [pull]),
        f"time.step={step!r}", f"time.end={step!r}", f"time.output_interval={step!r}",
    )  # fmt: skip
    assert run["events/time"] == pytest.approx(times, rel=1e-9)
    assert list(run["events/roller_to"]) == [1, 0]
    assert run["wheels/wheel/contact_roller"][-1] == 0


@pytest.mark.short
@pytest.mark.parametrize(("spin", "roller", "angle"), [(3.0, 1, 45.0), (-3.0, 0, -45.0)])
def test_on_an_edge_at_the_start_the_sense_of_spin_tells_the_roller(spin, roller, angle):
    run = simulate("testbench_psi30", *STILL, EDGE, f"wheels.wheel.spin_rate={spin}", "time.end=0.1")
    assert run["wheels/wheel/contact_roller"][0] == roller
    assert math.degrees(run["wheels/wheel/contact_angle"][0]) == pytest.approx(angle, abs=1e-10)
    assert len(run["events/time"]) == 0 or run["events/time"][0] > 0.0


@pytest.mark.short
@pytest.mark.parametrize(("pull", "roller"), [(0.5, 1), (-0.5, 0)])
def test_on_an_edge_at_rest_the_spin_acceleration_tells_the_roller(pull, roller):
    run = simulate(
        "testbench_psi30",
        *STILL,
        EDGE,
        "friction.law=none",
        "wheels.wheel.spin_rate=0",
        torque([0.0], [pull]),
        "time.end=0.1",
    )
    assert run["wheels/wheel/contact_roller"][0] == roller
    assert len(run["events/time"]) == 0


def test_a_torque_that_rises_from_zero_takes_the_wheel_off_an_edge_to_either_side():
    for pull, roller in ((0.5, 1), (-0.5, 0)):
        run = simulate(
            "testbench_psi30",
            *STILL,
            EDGE,
            "friction.law=none",
            "wheels.wheel.spin_rate=0",
            torque([0.0, 1.0], [0.0, pull]),
            "time.end=0.1",
        )
        assert run["wheels/wheel/contact_roller"][-1] == roller
        assert_no_roller_overruns(run, math.pi / 4)


def test_a_wheel_at_rest_on_an_edge_stays_there_quietly():
    run = simulate("testbench_psi30", *STILL, EDGE, "wheels.wheel.spin_rate=0", "time.end=1.0")
    assert np.all(run["wheels/wheel/spin_angle"] == run["wheels/wheel/spin_angle"][0])
    assert len(run["events/time"]) == 0


def test_an_oscillating_wheel_never_overruns_a_roller():
    swing = torque([0.0, 0.3, 0.3, 0.9, 0.9, 1.5, 1.5, 2.1], [0.4, 0.4, -0.4, -0.4, 0.4, 0.4, -0.4, -0.4])
    run = simulate(
        "testbench_psi30", *STILL, swing, "wheels.wheel.spin_rate=0", "time.end=2.0", "time.output_interval=0.002"
    )
    assert_no_roller_overruns(run, math.pi / 4)
    turns = np.diff(np.sign(run["wheels/wheel/spin_rate"][1:]))
    assert np.count_nonzero(turns) >= 3


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
def test_the_rollers_that_touch_are_found_by_either_contact_condition(tracking):
    for degrees, expected in (
        (0.0, (0, 0)),
        (45.0, (1, 0)),
        (44.0, (0, 0)),
        (46.0, (1, 1)),
        (720.0, (8, 8)),
        (-45.0, (0, -1)),
    ):
        parameters, run = standing(
            reference_scene("testbench_psi30", f"wheels.wheel.spin_angle_deg={degrees}", f"solver.tracking={tracking}")
        )
        assert touching(parameters, 0, run.y) == expected
        assert run.mode[0].roller == expected[0]  # positive spin


def test_an_exchange_on_an_output_time_is_in_that_row_already():
    """The authors' testbench rolls at pi / 2 rad/s: exchanges fall on 0.5, 1.5, ... s, after 80000 steps and more."""
    run = omnisim.simulate(omnisim.load("authors_testbench", ["time.step=6.25e-6", "time.output_interval=0.5"]))
    assert np.abs(run["events/time"] - np.arange(10) - 0.5).max() < 1e-13  # s; measured 5e-15
    assert list(run["wheels/wheel/contact_roller"][1::2]) == [1, 2, 3, 0, 1, 2, 3, 0, 1, 2]
    assert np.degrees(run["wheels/wheel/contact_angle"][1::2]) == pytest.approx(45.0, abs=1e-10)


def test_energy_does_not_change_at_an_exchange():
    """There is no impact: the contact point jumps along the axle, no velocity does."""
    run = simulate("testbench_psi30", "time.step=1e-5", "time.end=1.0")
    assert len(run["events/time"]) > 3
    assert np.abs(run["energy/balance"]).max() < 1e-12  # J; measured 1.4e-15
