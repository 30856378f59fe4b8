"""The right-hand side against identities that do not use its formulas."""

import numpy as np
import pytest
from scenes import packed, reference_scene, standing

from omnisim.dynamics.state import YAW, Contents, Stage, places_of
from omnisim.march.initial_state import blank_rows
from omnisim.march.march import write_row
from omnisim.march.runge_kutta import evaluate
from omnisim.results.observables import Observables

pytestmark = pytest.mark.short

AT = places_of(Contents(wheels=1))
PUSHED = (
    "wheels.wheel.drive={kind='torque', torque=0.7}",
    "wrench.frame='body'",
    "wrench.times=[0.0]",
    "wrench.force=[[0.4, -0.3, 2.0]]",
    "wrench.yaw_torque=[0.06]",
)


def random_runs(psi, law, tracking="explicit", count=10):
    """Runs settled at random states of the four-roller wheel."""
    rng = np.random.default_rng(4)
    for _ in range(count):
        vx, vy, yaw_rate, spin_rate, spin, yaw = rng.normal(size=6).round(6)
        overrides = [
            f"wheel_types.omni.roller_angle_deg={psi}", f"friction.law={law}", "friction.viscosity=3.0",
            f"initial.velocity=[{vx}, {vy}]", f"initial.yaw_rate={yaw_rate}", f"initial.yaw_deg={100 * yaw}",
            f"wheels.wheel.spin_angle_deg={100 * spin}", f"wheels.wheel.spin_rate={5 * spin_rate}",
            f"wheels.wheel.roller_rates={(5 * rng.normal(size=4)).round(3).tolist()}", f"solver.tracking={tracking}",
        ]  # fmt: skip
        parameters, run = standing(reference_scene("testbench_psi30", *overrides, *PUSHED))
        yield parameters, run


def kinetic(parameters, y, rates, roller):
    """Energy of all bodies at a state, with the contacting roller's rate from the state."""
    wheel, machine = parameters.wheels[0], parameters.machine
    rates = rates[0].copy()
    rates[roller] = y[AT.roller_rate]
    speeds = machine.mass * (y[AT.velocity] ** 2 + y[AT.velocity + 1] ** 2) + machine.yaw_inertia * y[AT.yaw_rate] ** 2
    return 0.5 * (speeds + wheel.axle_inertia * y[AT.spin_rate] ** 2 + wheel.axial_inertia * np.sum(rates**2))


@pytest.mark.parametrize("law", ["regularized", "saturated", "viscous", "none"])
@pytest.mark.parametrize("psi", [0.0, 30.0, -45.0])
def test_the_power_of_all_forces_is_the_rate_of_kinetic_energy(psi, law):
    """T is quadratic in the speeds, so a central difference along y' is its rate to rounding."""
    for parameters, run in random_runs(psi, law):
        slope, roller = run.slopes[0], int(run.mode[0].roller % 4)
        ahead, back = (kinetic(parameters, run.y + h * slope, run.rates, roller) for h in (1e-3, -1e-3))
        power = slope[AT.drive_work] + slope[AT.wrench_work] - slope[AT.friction_loss]
        scale = abs(slope[AT.drive_work]) + abs(slope[AT.wrench_work]) + slope[AT.friction_loss] + 1.0
        assert abs((ahead - back) / 2e-3 - power) < 1e-10 * scale  # measured 1.1e-13


def test_both_trackings_have_the_same_right_hand_side():
    for explicit, implicit in zip(
        random_runs(30.0, "regularized"), random_runs(30.0, "regularized", "implicit"), strict=True
    ):
        n = AT.rho
        np.testing.assert_allclose(implicit[1].slopes[0, :n], explicit[1].slopes[0, :n], rtol=1e-11, atol=1e-11)


def test_rho_turns_with_the_wheel():
    for parameters, run in random_runs(-45.0, "none", "implicit"):
        y, slope = run.y, run.slopes[0]
        rho, rate = y[AT.rho :].reshape(-1, 3), slope[AT.rho :].reshape(-1, 3)
        axle = np.array([-np.sin(y[YAW]), np.cos(y[YAW]), 0.0])
        w = y[AT.spin_rate] * axle + y[AT.yaw_rate] * np.array([0.0, 0.0, 1.0])
        np.testing.assert_allclose(rate, np.cross(w, rho), rtol=0, atol=1e-12)
        assert parameters.machine.implicit_tracking


def test_a_roller_in_the_air_costs_no_state():
    sizes = []
    for rollers in (4, 40):
        _, run = packed(reference_scene("testbench_psi30", f"wheel_types.omni.roller_count={rollers}"))
        sizes.append(len(run.y))
    assert sizes == [13, 13]


def test_the_servo_torque_balances_the_moment_of_momentum_about_the_heading():
    """lambda from the balance of moments about h, with the momentum of every body summed one by one.

    d/dt (L . h) for L = J_t theta' n + J_k phi' k + G by differences along the motion, against lambda and the load.
    """
    config = reference_scene("testbench_psi30").config
    for parameters, run in random_runs(30.0, "regularized"):
        wheel, y = parameters.wheels[0], run.y
        rows = blank_rows(run, 1)
        write_row(parameters, run, rows)
        data = Observables(parameters, rows, 1.0, config)
        roller, rates = int(run.mode[0].roller % 4), run.rates[0].copy()

        def momentum(y, wheel=wheel, parameters=parameters, roller=roller, rates=rates):
            yaw, phi = y[YAW], y[AT.spin_angle]
            h, k, n = (
                np.array([np.cos(yaw), np.sin(yaw), 0]),
                np.array([-np.sin(yaw), np.cos(yaw), 0]),
                np.array([0, 0, 1.0]),
            )
            p = rates.copy()
            p[roller] = y[AT.roller_rate]
            q = wheel.phase + 2 * wheel.alpha * np.arange(4) - phi
            axes = -wheel.cos_psi * (np.outer(np.cos(q), h) + np.outer(np.sin(q), n)) + wheel.sin_psi * k
            return (
                parameters.machine.yaw_inertia * y[AT.yaw_rate] * n
                + wheel.axle_inertia * y[AT.spin_rate] * k
                + wheel.axial_inertia * p @ axes
            )

        step = 1e-5
        rate = (momentum(y + step * run.slopes[0]) - momentum(y - step * run.slopes[0])) / (2 * step)
        h = np.array([np.cos(y[YAW]), np.sin(y[YAW]), 0.0])
        force_h, force_k = data["wheels/wheel/friction_force"][0]
        point = data["wheels/wheel/contact_point"][0] - data["body/position"][0]
        k = np.array([-h[1], h[0], 0.0])
        force = force_h * h + force_k * k + data["wheels/wheel/normal_force"][0] * np.array([0.0, 0.0, 1.0])
        expected = (rate - np.cross(point, force)) @ h
        assert abs(data["wheels/wheel/servo_torque"][0] - expected) < 1e-8  # measured 4.2e-10, the differences


def test_the_right_hand_side_does_not_change_the_state():
    for parameters, run in random_runs(30.0, "saturated", count=2):
        before = run.y.copy()
        evaluate(parameters, Stage(run.mode, run.clock.piece, 0.1, run.y, run.slopes[1], run.monitors_end, True))
        assert np.array_equal(before, run.y)
