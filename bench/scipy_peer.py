"""The march against SciPy's LSODA on the same equations, at equal error: times read off work-precision curves.

Compared are the position, the yaw and the spin angle at the end. Four peers: the right-hand side in NumPy, as one
would write it, or tuned by hand into Python scalars (for nine states three times faster); through `solve_ivp` with a
terminal event, the usual way, or through the leaner `odeint`, driven from exchange to exchange by Newton's method.
All get what is fair: a closure with the constants of one roller, and the nine states of the motion without the three
energy integrals. For spin > 0, constant drive and no wrench.
"""

import math
import statistics
from collections.abc import Callable
from functools import partial

import numpy as np
from common import Claim, March, bare_wheel, interleaved, ready, table
from scipy.integrate import odeint, solve_ivp

from omnisim.parameters import DRIVE
from omnisim.state import YAW, X, Y, places_of

TARGET, ALARM = 100.0, 30.0  # times faster than LSODA in NumPy
AT = places_of(1, 2, 0, 0, 0)
MOTION = [X, Y, YAW, AT.velocity, AT.velocity + 1, AT.yaw_rate, AT.spin_angle, AT.spin_rate, AT.roller_rate]
PLACES = [0, 1, 2, 6]  # of x, y, yaw and spin angle in MOTION
SPIN, RATE, ROLLER = 6, 7, 8
TOLERANCES = [10.0**-k for k in range(4, 13)]
STEPS = [2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5]
ERRORS = [1e-5, 1e-6, 1e-7, 1e-8]
METHODS = ("rk4", "dopri5")


def numpy_right_hand_side(march: March, roller: int, air: complex) -> Callable:
    """y' = f(t, y) while `roller` is in contact, in NumPy; air = sum p_i exp(i D_i) over the others."""
    machine, wheel = march.parameters.machine, march.parameters.wheels[0]
    radius, r1, c, s = (float(wheel[name]) for name in ("radius", "roller_distance", "cos_psi", "sin_psi"))
    j_k, i_a, i_z, mass = wheel.axle_inertia, wheel.axial_inertia, machine.yaw_inertia, machine.mass
    limit, eps = machine.friction * mass * machine.gravity, machine.slip_speed
    torque, q_0 = march.parameters.inputs[0, DRIVE, 0], wheel.phase + 2.0 * wheel.alpha * roller

    def f(_, y):
        yaw, yaw_rate, spin_rate, roller_rate = y[2], y[5], y[RATE], y[ROLLER]
        q = q_0 - y[SPIN]
        h, k = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        axis_n, h_q, l = -c * np.sin(q), radius - r1 / np.cos(q), r1 * np.tan(q) * wheel.tan_psi
        arm = -h_q * np.array([s, c * np.cos(q)])
        joint = roller_rate - spin_rate * s - yaw_rate * axis_n
        slip = np.array([h @ y[3:5] - spin_rate * radius - yaw_rate * l, k @ y[3:5]]) + joint * arm
        force = -limit * slip / np.sqrt(slip @ slip + eps**2)
        roller_torque = arm @ force
        g_h = -c * i_a * (np.cos(q) * (air.real + roller_rate) - np.sin(q) * air.imag)
        yaw_moment = spin_rate * g_h - roller_torque * axis_n - l * force[0]
        spin_moment = torque - radius * force[0] - roller_torque * s - yaw_rate * g_h
        acceleration = (force[0] * h + force[1] * k) / mass
        rates = [yaw_moment / i_z, spin_rate, spin_moment / j_k, roller_torque / i_a]
        return np.concatenate([y[3:6], acceleration, rates])

    return f


def scalar_right_hand_side(march: March, roller: int, air: complex) -> Callable:
    """The same in Python scalars."""
    machine, wheel = march.parameters.machine, march.parameters.wheels[0]
    radius, r1, c, s = (float(wheel[name]) for name in ("radius", "roller_distance", "cos_psi", "sin_psi"))
    j_k, i_a = float(wheel.axle_inertia), float(wheel.axial_inertia)
    mass, i_z, tan_psi = float(machine.mass), float(machine.yaw_inertia), float(wheel.tan_psi)
    limit, eps_square = float(machine.friction * mass * machine.gravity), float(machine.slip_speed) ** 2
    torque, q_0 = float(march.parameters.inputs[0, DRIVE, 0]), float(wheel.phase + 2.0 * wheel.alpha * roller)
    air_cos, air_sin, cos, sin, sqrt = air.real, air.imag, math.cos, math.sin, math.sqrt

    def f(_, y):
        _, _, yaw, v_x, v_y, yaw_rate, spin_angle, spin_rate, roller_rate = y.tolist()
        cos_yaw, sin_yaw, cos_q, sin_q = cos(yaw), sin(yaw), cos(q_0 - spin_angle), sin(q_0 - spin_angle)
        axis_n, h_q, l = -c * sin_q, radius - r1 / cos_q, r1 * sin_q / cos_q * tan_psi
        arm_h, arm_k = -h_q * s, -h_q * c * cos_q
        joint = roller_rate - spin_rate * s - yaw_rate * axis_n
        slip_h = v_x * cos_yaw + v_y * sin_yaw - spin_rate * radius - yaw_rate * l + joint * arm_h
        slip_k = v_y * cos_yaw - v_x * sin_yaw + joint * arm_k
        factor = -limit / sqrt(slip_h * slip_h + slip_k * slip_k + eps_square)
        force_h, force_k = factor * slip_h, factor * slip_k
        roller_torque = arm_h * force_h + arm_k * force_k
        g_h = -c * i_a * (cos_q * (air_cos + roller_rate) - sin_q * air_sin)
        return [
            v_x,
            v_y,
            yaw_rate,
            (force_h * cos_yaw - force_k * sin_yaw) / mass,
            (force_h * sin_yaw + force_k * cos_yaw) / mass,
            (spin_rate * g_h - roller_torque * axis_n - l * force_h) / i_z,
            spin_rate,
            (torque - radius * force_h - roller_torque * s - yaw_rate * g_h) / j_k,
            roller_torque / i_a,
        ]

    return f


def until_exit_odeint(f, t, y, end, exit_angle, tolerance):
    """Integrate to the exit angle, where Newton's method leads, or to the end: t, y, whether the roller is left."""
    step = min((exit_angle - y[SPIN]) / y[RATE], end - t)
    while abs(step) > 1e-14 * end:
        y = odeint(f, y, (t, t + step), rtol=tolerance, atol=tolerance, tfirst=True, mxstep=10**6)[1]
        t, step = t + step, (exit_angle - y[SPIN]) / y[RATE]
        if t >= end and step > 0.0:
            return t, y, False
    return t, y, True


def until_exit_solve_ivp(f, t, y, end, exit_angle, tolerance):
    """The same with a terminal event."""

    def leaves(_, y):
        return y[SPIN] - exit_angle

    leaves.terminal, leaves.direction = True, 1
    found = solve_ivp(f, (t, end), y, method="LSODA", rtol=tolerance, atol=tolerance, events=leaves)
    return found.t[-1], found.y[:, -1], found.status == 1


NUMPY = "LSODA, NumPy, solve_ivp"  # the usual way
PEERS = {
    NUMPY: (numpy_right_hand_side, until_exit_solve_ivp),
    "LSODA, NumPy, odeint": (numpy_right_hand_side, until_exit_odeint),
    "LSODA, scalars, solve_ivp": (scalar_right_hand_side, until_exit_solve_ivp),
    "LSODA, scalars, odeint": (scalar_right_hand_side, until_exit_odeint),
}


def integrate(march: March, tolerance: float, peer: str = NUMPY) -> np.ndarray:
    """The nine states of the motion at the end of the scene of a fresh march."""
    right_hand_side, until_exit = PEERS[peer]
    wheel, rates, end = march.parameters.wheels[0], march.run.rates[0].copy(), march.steps * march.run.clock.dt
    alpha, count, number = float(wheel.alpha), int(wheel.rollers), np.arange(wheel.rollers)
    t, y, on = 0.0, march.run.y[MOTION], True
    roller = round((y[SPIN] - float(wheel.phase)) / (2.0 * alpha))
    while on:
        here = roller % count
        y[ROLLER] = rates[here]
        air = (rates * np.exp(2j * alpha * (number - here)))[number != here].sum()
        f = right_hand_side(march, roller, complex(air))
        exit_angle = float(wheel.phase + alpha * (2 * roller + 1))
        t, y, on = until_exit(f, t, y, end, exit_angle, tolerance)
        rates[here], roller = y[ROLLER], roller + 1
    return y


def measure(rounds: int) -> dict:
    """Error and median milliseconds along every ladder, and the times at equal error."""
    reference = ready(bare_wheel(1e-5, method="dopri5")).go().run.y[MOTION]
    finals: dict[tuple[str, float], np.ndarray] = {}
    contestants = {}
    for name in PEERS:
        for tolerance in TOLERANCES:
            contestants[name, tolerance] = partial(solving, finals, name, tolerance)
    for method in METHODS:
        for step in STEPS:
            contestants[f"omnisim, {method}", step] = partial(marching, finals, method, step)
    curves: dict[str, list] = {}
    for (name, knob), values in interleaved(contestants, rounds).items():
        error = float(np.abs(finals[name, knob] - reference)[PLACES].max())
        curves.setdefault(name, []).append((knob, error, statistics.median(values) * 1e3))
    at_error = {f"{error:.0e}": {name: time_at(error, points) for name, points in curves.items()} for error in ERRORS}
    return {"curves": curves, "ms_at_error": at_error, "ratios": ratios(at_error)}


def solving(finals: dict, name: str, tolerance: float) -> Callable:
    """Prepare an integration with LSODA, which leaves its final state in `finals`."""
    fresh = ready(bare_wheel(1e-3))

    def go():
        finals[name, tolerance] = integrate(fresh, tolerance, name)

    return go


def marching(finals: dict, method: str, step: float) -> Callable:
    """Prepare a march, which leaves its final state in `finals`."""
    fresh = ready(bare_wheel(step, method=method))

    def go():
        finals[f"omnisim, {method}", step] = fresh.go().run.y[MOTION]

    return go


def time_at(error: float, points: list[tuple[float, float, float]]) -> float | None:
    """Milliseconds for an error, between two points of a curve linear in the logarithms.

    Where the first, cheapest point is already better, its time; None beyond the last point.
    """
    (_, rough, fast), rest = points[0], points[1:]
    if rough <= error:
        return fast
    for _, fine, slow in rest:
        if fine <= error <= rough:
            return fast * (slow / fast) ** (math.log(rough / error) / math.log(rough / fine))
        rough, fast = fine, slow
    return None


def ratios(at_error: dict[str, dict[str, float | None]]) -> dict[str, dict[str, float]]:
    """Time of each LSODA over that of the fastest march, at each error that both reach."""
    found: dict[str, dict[str, float]] = {}
    for error, times in at_error.items():
        ours = [time for name, time in times.items() if time and name.startswith("omnisim")]
        theirs = {name: time for name, time in times.items() if time and name.startswith("LSODA")}
        if ours and theirs:
            found[error] = {name: time / min(ours) for name, time in theirs.items()}
    return found


def report(result: dict) -> str:
    names = list(result["curves"])
    peers = [name for name in names if name.startswith("LSODA")]
    equal = [
        [error]
        + [f"{times[name]:.2f}" if times[name] else "-" for name in names]
        + [f"{result['ratios'][error][name]:.0f}" if times[name] else "-" for name in peers]
        for error, times in result["ms_at_error"].items()
        if error in result["ratios"]
    ]
    points = [
        [name, f"{knob:.0e}", f"{error:.1e}", f"{time:.2f}"]
        for name, curve in result["curves"].items()
        for knob, error, time in curve
    ]
    return (
        table(
            ["error", *(f"{name}, ms" for name in names), *(f"{name[7:]} / fastest omnisim" for name in peers)], equal
        )
        + "\n\n"
        + table(["solver", "step or tolerance", "error", "ms"], points)
    )


def claims(result: dict) -> list[Claim]:
    in_numpy = [ratio for row in result["ratios"].values() for name, ratio in row.items() if "NumPy" in name]
    text = "LSODA with the right-hand side in NumPy, by the fastest march at equal error"
    return [Claim(text, min(in_numpy), "at least", TARGET, ALARM)]
