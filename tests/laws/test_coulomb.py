"""Set-valued Coulomb friction: fourth order through stops and exchanges, and closed forms where there are any."""

import numpy as np
import pytest
from scenes import final_reference, final_state, packed, reference_data, reference_scene, simulate

import omnisim
from omnisim.base.methods import METHODS
from omnisim.base.status import COMPLETE, RUNNING
from omnisim.contact.set_valued import SLIP, STICK
from omnisim.dynamics.state import Stage, places
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state
from omnisim.march.event_log import EVENT
from omnisim.march.initial_state import blank_rows
from omnisim.march.march import march
from omnisim.march.runge_kutta import evaluate
from omnisim.march.slip import slip_rate
from omnisim.results.comparison import distance

CASE = "coulomb_wheel"
STILL = ("initial.velocity=[0, 0]", "wheels.wheel.spin_rate=0")
MASS, RADIUS, AXIAL = 0.5 + 8 * 0.02, 0.05, 8.245564409760374e-07
LIMIT = 0.5 * MASS * 9.81  # mu N
AXLE = 0.0004 + 8 * (0.02 * 0.04**2 + 2.3234831200535613e-06)  # J_k
ROLLING = 1 / MASS + RADIUS**2 / AXLE  # inverse mass of the contact along h


def test_the_reference_is_reached_at_order_four_through_25_exchanges_and_26_stops():
    reference = reference_data(CASE)
    exact = final_reference(CASE)
    steps, bounds = (1e-2, 5e-3, 2e-3, 1e-3), (2e-5, 1e-6, 5e-8, 5e-9)
    errors = []
    for step, bound in zip(steps, bounds, strict=True):
        run = simulate(CASE, f"time.step={step}")
        kinds = list(run["events/kind"])
        assert (kinds.count("exchange"), kinds.count("stick"), kinds.count("slip")) == (25, 26, 25)
        errors.append(np.abs(final_state(run) - exact).max())
        assert errors[-1] < bound  # measured 1.0e-5, 9.4e-7, 3.0e-8, 2.1e-9
        assert np.abs(run["body/position"][:, :2] - reference["position"]).max() < bound
    assert np.log2(errors[2] / errors[3]) >= 3.8  # measured 3.86; from 1e-2 on it is 3.68, as the first error is small


@pytest.mark.parametrize(
    "overrides", [(), ("wheel_types.omni.roller_angle_deg=30", "initial.yaw_rate=1.0"), ("solver.tracking=implicit",)]
)
def test_every_row_obeys_the_law(overrides):
    run = simulate(CASE, "time.step=2e-5", "time.output_interval=2e-5", "time.end=0.2", *overrides)
    slip, force = run["wheels/wheel/slip_velocity"], run["wheels/wheel/friction_force"]
    speed, size = np.linalg.norm(slip, axis=1), np.linalg.norm(force, axis=1)
    limit = 0.5 * run["wheels/wheel/normal_force"]
    sticks = speed < 1e-10
    assert 100 < np.count_nonzero(sticks) < len(sticks) - 100
    assert np.all(size <= limit * (1 + 1e-12))
    assert np.abs(size - limit)[~sticks].max() < 1e-12 * LIMIT
    along = np.sum(force * slip, axis=1)[~sticks]
    assert np.abs(along / (speed * size)[~sticks] + 1.0).max() < 1e-12, "friction opposes the slip"
    assert speed[sticks].max() < 1e-11  # m/s; measured 3.8e-16


def test_the_energy_balance_holds_through_stick_and_slip():
    run = simulate(CASE, "time.step=5e-4")
    assert np.abs(run["energy/balance"]).max() < 1e-9 * run["energy/kinetic"][0]  # measured 8e-12
    assert np.all(np.diff(run["energy/friction_loss"]) >= -1e-15)


def test_a_wheel_pushed_sideways_spins_its_roller_up_in_the_time_of_pure_sliding():
    run = simulate(
        CASE, "initial.velocity=[0, 0.3]", "wheels.wheel.spin_rate=0", "time.end=0.1", "time.output_interval=0.1"
    )
    sideways = 1 / MASS + (0.05 - 0.04) ** 2 / AXIAL
    stop = 0.3 / (LIMIT * sideways)
    assert list(run["events/kind"]) == ["stick"]
    assert abs(run["events/time"][0] - stop) < 1e-12  # s, of 7.5e-4
    assert abs(run["body/velocity"][-1, 1] - (0.3 - LIMIT / MASS * stop)) < 1e-11


def test_a_wheel_spun_up_on_the_spot_rolls_after_the_time_of_pure_sliding():
    run = simulate(CASE, "initial.velocity=[0, 0]", "wheels.wheel.spin_rate=30", "time.step=1e-3", "time.end=0.5")
    stop = RADIUS * 30.0 / (LIMIT * ROLLING)
    sticks = run["events/time"][run["events/kind"] == "stick"]
    assert len(sticks) == 1
    assert abs(sticks[0] - stop) < 1e-9  # s; measured 5e-13
    speed = LIMIT / MASS * stop
    assert abs(run["body/velocity"][-1, 0] - speed) < 1e-10
    assert abs(run["wheels/wheel/spin_rate"][-1] - speed / RADIUS) < 1e-8


@pytest.mark.parametrize("step", [1e-2, 1e-3])
def test_a_torque_ramp_lets_the_wheel_slip_when_the_rolling_force_reaches_the_cone(step):
    ramp = 0.4  # N m/s
    run = simulate(
        CASE,
        *STILL,
        f"wheels.wheel.drive={{kind='torque', times=[0, 1], torque=[0, {ramp}]}}",
        "time.end=1.0",
        f"time.step={step}",
    )
    release = LIMIT * ROLLING * AXLE / (ramp * RADIUS)
    slips = run["events/time"][run["events/kind"] == "slip"]
    assert len(slips) == 1
    assert abs(slips[0] - release) < 1e-8  # s; measured 6e-13
    after = 1.0 - release  # then F_h = mu N, whatever the slip
    assert (
        abs(
            run["body/velocity"][-1, 0]
            - (LIMIT / MASS * after + ramp * release**2 / 2 * RADIUS / AXLE / ROLLING / MASS)
        )
        < 1e-7
    )


@pytest.mark.parametrize(("share", "slips"), [(0.999999, False), (1.0, False), (1.01, True)])
def test_a_constant_torque_slips_above_the_limit_and_not_at_it(share, slips):
    torque = share * LIMIT * ROLLING * AXLE / RADIUS
    run = simulate(
        CASE, *STILL, f"wheels.wheel.drive={{kind='torque', torque={torque!r}}}", "time.end=0.2", "time.step=1e-3"
    )
    moved = np.abs(run["wheels/wheel/slip_velocity"][-1, 0])
    if slips:
        expected = (share - 1.0) * LIMIT * ROLLING * 0.2
        assert moved == pytest.approx(expected, rel=1e-4)
    else:
        assert moved < 1e-11


def test_a_wheel_stuck_for_a_long_time_does_not_drift():
    pushed = ("wheels.wheel.drive={kind='torque', torque=0.01}", "wrench.times=[0]", "wrench.force=[[-0.19, 0, 0]]")
    run = simulate(CASE, *STILL, *pushed, "time.end=100.0", "time.step=1e-2", "time.output_interval=1.0")
    assert np.abs(run["wheels/wheel/slip_velocity"]).max() < 1e-10
    assert np.abs(run["body/velocity"][:, 0] - RADIUS * run["wheels/wheel/spin_rate"]).max() < 1e-10


def test_without_friction_or_load_the_law_does_nothing():
    for override in ("friction.coefficient=0", "scene.gravity=0"):
        run = simulate(CASE, override)
        assert np.all(run["body/velocity"] == run["body/velocity"][0])
        assert set(run["events/kind"]) == {"exchange"}


@pytest.mark.parametrize("psi", [0.0, 45.0, -30.0])
def test_both_trackings_stick_and_slip_alike(psi):
    runs = [
        omnisim.simulate(
            reference_scene(
                CASE,
                f"wheel_types.omni.roller_angle_deg={psi}",
                "time.step=5e-4",
                "initial.yaw_rate=0.5",
                f"solver.tracking={name}",
            )
        )
        for name in ("explicit", "implicit")
    ]
    assert list(runs[0]["events/kind"]) == list(runs[1]["events/kind"])
    assert np.abs(runs[0]["body/position"] - runs[1]["body/position"]).max() < 1e-8


@pytest.mark.parametrize(
    ("step", "overrides"),
    [
        (1e-3, ()),
        (1e-2, ()),
        (1e-3, ("solver.method=radau5",)),
        (1e-3, ("solver.method=auto", "wheel_types.omni.roller_angle_deg=45", "initial.yaw_rate=2.0",
                "wheels.wheel.drive={kind='torque', times=[0.0, 0.5, 1.5], torque=[0.0, 0.12, 0.11]}")),
    ],
)  # fmt: skip
def test_the_multipliers_hold_at_every_accepted_step(step, overrides):
    """Sticking: no slip acceleration, force inside the cone, no slip. Slipping: the whole force, against the slip. The
    next step may begin with the derivative before drift was taken away, which differs with the error of the last."""
    parameters, run = packed(reference_scene(CASE, f"time.step={step}", *overrides))
    rows, log = blank_rows(run, 10**5), np.zeros(10**5, EVENT).view(np.recarray)
    stages, at, seen, largest = METHODS["rk4"].stages, places(parameters), {SLIP: 0, STICK: 0}, 0.0
    while run.clock.step < run.clock.steps and run.clock.status == RUNNING:
        run.clock.pause = run.clock.rhs + 1  # one step
        march(parameters, stages, run, rows, log)
        grip, limit = run.mode[0].grip[0], parameters.machine.friction * run.monitors[0].normal_force
        body = body_motion(parameters, run.y)
        state = contact_state(parameters, run.mode[0], 0, 0, body, run.y)
        derivative, monitors, clock = np.empty_like(run.y), run.monitors.copy().view(np.recarray), run.clock
        evaluate(parameters, Stage(run.mode, clock.piece, clock.step * clock.dt, run.y, derivative, monitors, True))
        largest = max(largest, np.max(np.abs(derivative - run.slopes[0])))
        acceleration = np.hypot(*slip_rate(parameters, run.mode[0], 0, 0, run.y, derivative)[0])
        slope = derivative[[at.velocity, at.velocity + 1]] * parameters.machine.mass
        cos, sin = body.frame
        force = np.array([cos * slope[0] + sin * slope[1], cos * slope[1] - sin * slope[0]])
        size, slip = np.hypot(*force), np.hypot(*state.slip)
        if grip == STICK:
            assert acceleration < 1e-10  # m/s^2, of hundreds; measured up to 2.0e-13
            assert size <= limit * (1 + 1e-12) and slip < 1e-11  # m/s; measured up to 2.3e-12
        elif grip == SLIP:
            assert abs(size - limit) < 1e-12 * limit
            assert force @ np.array(state.slip) + size * slip < 1e-9 * size * slip + 1e-15
        seen[grip] = seen.get(grip, 0) + 1
    assert run.clock.status in (RUNNING, COMPLETE)
    assert largest < 2e-2 * (step / 1e-2) ** 4  # SI, of hundreds; measured 1.5e-2 with 1e-2 s and 4.2e-7 with 1e-3 s
    assert seen[STICK] > 10 and (seen[SLIP] > 10 or step > 5e-3)


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("testbench_psi30", ("wrench.times=[0.0]", "wrench.force=[[0.5, 1.0, 0.0]]", "time.step=0.2", "time.end=100",
                             "time.output_interval=1.0", "initial.velocity=[0, 0]", "initial.yaw_rate=0",
                             "wheels.wheel.spin_rate=0", "wheels.wheel.roller_rates=0")),
        (CASE, ("time.step=2.0", "time.output_interval=2.0", "initial.yaw_rate=5")),
    ],
)  # fmt: skip
def test_steps_far_too_long_for_coulomb_friction_are_found_out_by_their_energy(name, overrides):
    """What such steps make is no motion: the run ends early, and names a shorter step."""
    run = omnisim.simulate(reference_scene(name, "friction.law=coulomb", *overrides))
    assert "came from nowhere" in run.attributes["status"] and "use time.step <" in run.attributes["status"]
    assert run["events/kind"][-1] == "stop" and run.time[-1] == run.attributes["stop_time"]
    finer = ("time.step=0.001", "solver.method=radau5", "time.end=2.0")
    assert omnisim.simulate(reference_scene(name, "friction.law=coulomb", *overrides, *finer)).complete


@pytest.mark.parametrize(
    ("method", "order", "bounds"),  # measured, by steps of 1e-3 and 1e-4 s
    [
        ("rk4", 3.6, (1e-3, 1e-6)),  # 4.38: 3.8e-4, 1.5e-8
        ("dopri5", 3.0, (2e-6, 1e-9)),  # 3.34: 6.1e-7, 2.8e-10
        ("auto", 2.8, (2e-4, 1e-6)),  # 3.05: 9.9e-5, 8.9e-8
        ("radau5", 4.0, (2e-6, 1e-9)),  # 4.14: 7.8e-7, 5.6e-11
    ],
)
@pytest.mark.long
def test_the_order_holds_through_releases_and_slow_slip_of_a_driven_wheel(method, order, bounds):
    """A mecanum wheel from rest under a torque that rises beyond its limit and falls back, against radau5 at 2e-5."""
    driven = (
        "wheel_types.omni.roller_angle_deg=45", *STILL,
        "wheels.wheel.drive={kind='torque', times=[0.0, 1.0, 2.0], torque=[0.0, 0.25, 0.0]}",
    )  # fmt: skip
    exact = final_state(simulate(CASE, *driven, "solver.method=radau5", "time.step=2e-5"))
    runs = [simulate(CASE, *driven, f"solver.method={method}", f"time.step={step}") for step in (1e-3, 1e-4)]
    assert list(runs[0]["events/kind"]).count("slip") >= 10
    errors = [np.abs(final_state(run) - exact).max() for run in runs]
    assert np.log10(errors[0] / errors[1]) > order, errors
    assert errors[0] < bounds[0] and errors[1] < bounds[1]


@pytest.mark.parametrize("scene", ["coulomb_wheel", "kiwi"])
def test_sub_steps_of_slip_keep_the_order_of_dopri5(scene):
    changes = {"solver.method": "dopri5", "time.output_interval": 0.01}
    steps = (1e-4, 2e-3, 1e-3)
    exact, coarse, fine = (omnisim.simulate(omnisim.load(scene, changes | {"time.step": step})) for step in steps)
    assert np.log2(distance(coarse, exact) / distance(fine, exact)) > 4.7  # measured 5.1, 5.2
    assert distance(fine, exact) < 2e-11  # measured 5.1e-12, 6.0e-13
