"""Drives against closed forms: wheels without friction of the floor spin by their drives alone, J_k phi'' = tau."""

import numpy as np
import pytest
from free_machines import free
from machines import axle_inertia, machine, run
from scipy.optimize import brentq

J = axle_inertia("mecanum")
KP, KI, LIMIT = 0.02, 0.1, 0.05  # N m s, N m, N m


def spin_of(drive, *overrides, **wheel):
    """Trajectory of a machine on four wheels of which the first has this drive."""
    data = machine("mecanum", drives=[drive])
    data["wheels"][0] |= wheel
    trajectory = run(data, *overrides)
    assert not trajectory["body/velocity"].any(), "the others do not notice"
    return trajectory, trajectory["wheels/w0/spin_rate"]


def damped(t, e, rate, kp=KP, ki=KI):
    """Error of a controlled rate, J e'' + kp e' + ki e = 0, from its value and rate of change at t = 0."""
    roots = np.roots([J, kp, ki]).astype(complex)
    shares = np.linalg.solve([[1.0, 1.0], roots], [e, rate])
    return np.real(np.exp(np.outer(t, roots)) @ shares)


@pytest.mark.parametrize(("kp", "ki"), [(0.02, 0.0), (0.02, 0.1), (0.02, 1.0)])
def test_a_controlled_rate_approaches_its_target_as_a_damped_oscillator(kp, ki):
    """Roots of J s^2 + kp s + ki: one, two real ones, two complex ones. The target is a ramp up to 0.5 s."""
    drive = {"kind": "rate", "times": [0.0, 0.5], "rate": [3.0, 8.0], "proportional": kp, "integral": ki}
    trajectory, rate = spin_of(drive, "time.end=0.5", "time.step=2.5e-4", spin_rate=1.0)
    t, slope, first = trajectory.time, 10.0, 3.0 - 1.0
    error = damped(t, first, slope - kp * first / J, kp, ki)
    assert np.abs(3.0 + slope * t - rate - error).max() < 1e-9  # rad/s; measured 6e-12, 2e-12, 1e-10
    assert np.abs(trajectory["energy/balance"]).max() < 1e-12  # J, of 0.02; measured 8e-14


def saturated(t, target, kp, ki):
    """Rate of a drive that starts at its limit, from rest: the time at which it leaves the limit, and the rate.

    While it is there, J phi'' = limit and z' = (limit - ki z) / kp.
    """

    def integral(t):
        return LIMIT / ki * -np.expm1(-ki / kp * t) if ki else LIMIT / kp * t

    def excess(t):
        return kp * (target - LIMIT / J * t) + ki * integral(t) - LIMIT

    leaves = brentq(excess, 0.0, 10.0, xtol=1e-15)
    error = target - LIMIT / J * leaves
    after = damped(np.maximum(t - leaves, 0.0), error, -(kp * error + ki * integral(leaves)) / J, kp, ki)
    return leaves, np.where(t < leaves, LIMIT / J * t, target - after)


@pytest.mark.parametrize("ki", [0.0, 0.1, 1.0])
def test_a_drive_leaves_its_limit_at_the_right_time_with_an_integral_that_has_not_wound_up(ki):
    target, errors = 20.0, []
    drive = {"kind": "rate", "rate": target, "proportional": KP, "integral": ki, "torque_limit": LIMIT}
    for step in (5e-3, 2.5e-3, 1.25e-3):
        trajectory, rate = spin_of(drive, f"time.step={step}", "time.output_interval=0.005")
        leaves, expected = saturated(trajectory.time, target, KP, ki)
        errors.append(np.abs(rate - expected).max())
        torque = trajectory["wheels/w0/drive_torque"]
        assert np.all(torque[trajectory.time < leaves] == LIMIT)
        assert np.all(torque[trajectory.time > leaves + 1e-3] < LIMIT)
        assert (
            np.abs(trajectory["energy/balance"]).max() < 1e-7 * trajectory["energy/drive_work"].max()
        )  # 5e-8 to 2e-10
    assert errors[-1] < 1e-7, errors  # rad/s, of 20; measured 6e-9, 3e-9, 5e-8
    assert np.log2(errors[0] / errors[-1]) / 2 >= 3.8, errors  # measured 4.00, 4.00, 3.97


def test_a_drive_at_its_limit_in_either_sense_gives_that_much_and_no_more():
    drive = {"kind": "rate", "times": [0.0, 0.4, 0.4, 1.0], "rate": [30.0, 30.0, -30.0, -30.0],
             "proportional": 0.05, "integral": 0.5, "torque_limit": LIMIT}  # fmt: skip
    trajectory, rate = spin_of(drive)
    torque, early = trajectory["wheels/w0/drive_torque"], trajectory.time < 0.4
    assert np.abs(torque).max() == LIMIT and torque[early][0] == LIMIT and torque[~early][0] == -LIMIT
    assert abs(rate[-1] + 30.0) < 0.5 * abs(rate[early][-1] + 30.0)
    np.testing.assert_allclose(trajectory["wheels/w0/drive_power"], torque * rate, rtol=1e-15)


MOTOR = {"resistance": 1.2, "torque_constant": 0.015, "gear_ratio": 14.0, "rotor_inertia": 3e-6, "viscosity": 2e-3}
GEARED = 14.0 * 0.015
WHOLE = J + 14.0**2 * 3e-6  # the rotor turns 14 times as fast
DAMPING = GEARED**2 / 1.2 + 2e-3


def test_drives_of_a_machine_free_in_space_begin_at_their_limits():
    """In the first row already, and beyond them never."""
    rate = {"kind": "rate", "rate": 30.0, "proportional": 0.05, "torque_limit": LIMIT}
    motor = {"kind": "dc_motor", "rate": -30.0, "proportional": 1.0, "voltage_limit": 6.0} | MOTOR
    motion = run(free(machine("mecanum", drives=[rate, motor])), "time={end=0.01, step=1e-4, output_interval=1e-3}")
    for path, most in (("wheels/w0/drive_torque", LIMIT), ("wheels/w1/voltage", -6.0)):
        assert motion[path][0] == most and np.abs(motion[f"interval_max/{path}"]).max() == abs(most), path


def test_a_motor_approaches_its_no_load_rate_through_jumps_of_its_voltage():
    jump = 0.1237  # s: inside of a step
    drive = {"kind": "dc_motor", "times": [0.0, jump, jump, 1.0], "voltage": [6.0, 6.0, -3.0, -3.0]} | MOTOR
    trajectory, rate = spin_of(drive, "time.step=2.5e-4", spin_rate=2.0)
    t, pace = trajectory.time, DAMPING / WHOLE
    no_load, reverse = (GEARED / 1.2 * voltage / DAMPING for voltage in (6.0, -3.0))
    at_jump = no_load + (2.0 - no_load) * np.exp(-pace * jump)
    first = no_load + (2.0 - no_load) * np.exp(-pace * t)
    second = reverse + (at_jump - reverse) * np.exp(-pace * np.maximum(t - jump, 0.0))
    assert np.abs(rate - np.where(t < jump, first, second)).max() < 1e-9  # rad/s, of 24; measured 2.3e-10
    energy = 0.5 * WHOLE * (rate**2 - rate[0] ** 2)
    assert (
        np.abs(trajectory["energy/kinetic"] - trajectory["energy/kinetic"][0] - energy).max() < 1e-15
    )  # the rotor's; 6e-17
    assert np.abs(trajectory["energy/balance"]).max() < 1e-9  # J, of 1; measured 7e-11


def test_friction_in_a_motor_stops_it():
    """J w' = -T w / sqrt(w^2 + r^2), so that sqrt(w^2 + r^2) + r log(w / (r + sqrt(w^2 + r^2))) falls evenly."""
    friction, smooth = 0.01, 0.5
    drive = {"kind": "dc_motor", "voltage": 0.0, "resistance": 1e12, "torque_constant": 1.0,
             "friction_torque": friction, "friction_rate": smooth}  # fmt: skip
    trajectory, rate = spin_of(drive, spin_rate=4.0)
    root = np.sqrt(rate**2 + smooth**2)
    falling = root + smooth * np.log(rate / (smooth + root))
    moving = rate > 1e-3
    assert rate[-1] < 1e-6 and moving.sum() > 30
    expected = falling[0] - friction / J * trajectory.time
    assert np.abs(falling - expected)[moving].max() < 2e-8  # rad/s; measured 6e-9
    loss = trajectory["energy/kinetic"][0] - trajectory["energy/kinetic"]
    assert np.abs(loss + trajectory["energy/drive_work"]).max() < 1e-11  # J; measured 2e-13


def test_the_reaction_of_the_drives_tilts_the_chassis():
    """Torque on a wheel about its axle comes off the load in front and goes onto the rear."""
    torque = 0.3
    still = run(machine("mecanum"))
    driven = run(machine("mecanum", drives=[{"kind": "torque", "torque": torque}] * 4))
    shift = 4 * torque / (4 * 0.2)  # of one wheel: four of them on levers of 0.2 m
    change = [driven[f"wheels/w{w}/normal_force"][0] - still[f"wheels/w{w}/normal_force"][0] for w in range(4)]
    assert change == pytest.approx([-shift, -shift, shift, shift], rel=1e-12)
