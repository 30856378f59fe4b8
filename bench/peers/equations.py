"""The equations of motion as an integrator from elsewhere takes them: y' = f(t, y) while the rollers in contact stay.

    y = [x y yaw, spin angles | their rates | rates of the rollers in contact | integrals of the drives]

These are the states of a march that its motion depends on, in its order: without the energy integrals, the odometry and
the second roller of a wheel. Three forms, for regularized friction: in NumPy, as one would write it, for a bare wheel
under constant drive and for a machine on parallel wheels whose contacts carry it; tuned by hand into Python scalars,
three times faster for nine states, for the bare wheel; `compiled`, the right-hand side of the march itself, for any.
"""

import math
from collections.abc import Callable
from functools import cache

import numba
import numpy as np
from numba.experimental import structref

from bench.common import March
from omnisim.dynamics.parameters import DRIVE_INPUT
from omnisim.dynamics.state import Stage, places, places_in
from omnisim.march.roller_exchange import release_rollers, take_rollers
from omnisim.march.runge_kutta import evaluate

YAW, SPIN, YAW_RATE, SPIN_RATE, ROLLER = 2, 3, 6, 7, 8  # places of a bare wheel; spin angles begin there in all
PASSED = 1e-12  # rad: so far beyond its end a roller is left, and the next one has surely begun
STEEP = 1e-3  # of the slip over which friction changes, by which states are shifted for the Jacobian


def numpy_form(march: March) -> Callable:
    """y' = f(t, y) of a bare wheel on the roller of its mode, in NumPy."""
    machine, wheel, mode = march.parameters.machine, march.parameters.wheels[0], march.run.mode[0]
    radius, r1, c, s = (float(wheel[name]) for name in ("radius", "roller_distance", "cos_psi", "sin_psi"))
    j_k, i_a, i_z, mass = wheel.axle_inertia, wheel.axial_inertia, machine.yaw_inertia, machine.mass
    limit, eps, air_cos, air_sin = machine.friction * mass * machine.gravity, machine.slip_speed, *air_sums(march)
    torque, q_0 = march.parameters.inputs[0, DRIVE_INPUT, 0], wheel.phase + 2.0 * wheel.alpha * mode.roller

    def f(_, y):
        velocity, yaw, yaw_rate, spin_rate, roller_rate = y[4:6], y[YAW], y[YAW_RATE], y[SPIN_RATE], y[ROLLER]
        q = q_0 - y[SPIN]
        h, k = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        axis_n, h_q, l = -c * np.sin(q), radius - r1 / np.cos(q), r1 * np.tan(q) * wheel.tan_psi
        arm = -h_q * np.array([s, c * np.cos(q)])
        joint = roller_rate - spin_rate * s - yaw_rate * axis_n
        slip = np.array([h @ velocity - spin_rate * radius - yaw_rate * l, k @ velocity]) + joint * arm
        force = -limit * slip / np.sqrt(slip @ slip + eps**2)
        roller_torque = arm @ force
        g_h = -c * i_a * (np.cos(q) * (air_cos + roller_rate) - np.sin(q) * air_sin)
        yaw_moment = spin_rate * g_h - roller_torque * axis_n - l * force[0]
        spin_moment = torque - radius * force[0] - roller_torque * s - yaw_rate * g_h
        acceleration = (force[0] * h + force[1] * k) / mass
        return np.concatenate([y[4:8], acceleration, [yaw_moment / i_z, spin_moment / j_k, roller_torque / i_a]])

    return f


def numpy_machine(march: March) -> Callable:
    """The same of a machine whose wheels head forward, by rate or torque drives below their limits."""
    machine, wheels, mode = march.parameters.machine, march.parameters.wheels, march.run.mode
    assert (wheels.cos_heading == 1.0).all(), "all wheels have to head forward"
    count, (x, aside), (moment_x, moment_y) = len(wheels), wheels.offset.T, machine.moment
    start, inputs = (table[march.run.clock.piece] for table in (march.parameters.starts, march.parameters.inputs))
    radius, c, s, i_a = wheels.radius, wheels.cos_psi, wheels.sin_psi, wheels.axial_inertia
    q_0, turn_mass = wheels.phase + 2.0 * wheels.alpha * mode.roller, 1.0 / machine.yaw_inertia

    def f(t, y):
        spin_angle, (v_x, v_y, yaw_rate), spin = (
            y[3 : 3 + count],
            y[3 + count : 6 + count],
            y[6 + count : 6 + 2 * count],
        )
        roller, integral = y[6 + 2 * count : 6 + 3 * count], y[6 + 3 * count :]
        cos_yaw, sin_yaw, cos_q, sin_q = (
            np.cos(y[YAW]),
            np.sin(y[YAW]),
            np.cos(q_0 - spin_angle),
            np.sin(q_0 - spin_angle),
        )
        v_h, v_k = v_x * cos_yaw + v_y * sin_yaw, v_y * cos_yaw - v_x * sin_yaw
        axis_h, axis_n, slant = -c * cos_q, -c * sin_q, wheels.roller_distance / cos_q
        arm_h, arm_k, side = -(radius - slant) * s, (radius - slant) * axis_h, aside + slant * sin_q * wheels.tan_psi
        joint = roller - spin * s - yaw_rate * axis_n
        slip_h = v_h - spin * radius - yaw_rate * side + joint * arm_h
        slip_k = v_k + yaw_rate * x + joint * arm_k
        factor = -machine.friction / np.sqrt(slip_h**2 + slip_k**2 + machine.slip_speed**2)
        force_h, force_k = factor * slip_h, factor * slip_k  # by the load, as all that follows from them
        rolling = arm_h * force_h + arm_k * force_k
        across = mode.air_cos + roller
        g_h, g_n = (
            -c * i_a * (cos_q * across - sin_q * mode.air_sin),
            -c * i_a * (sin_q * across + cos_q * mode.air_sin),
        )
        g_k, target = s * i_a * (mode.air_sum + roller), inputs[DRIVE_INPUT:, 0] + inputs[DRIVE_INPUT:, 1] * (t - start)
        torque = wheels.drive_gain * target - wheels.drive_damping * spin
        errors = np.zeros(0)
        if machine.integrals:
            torque, errors = torque + wheels.drive_integral * integral, target - spin
        gyro_yaw, gyro = spin @ g_h, (spin * (g_n - wheels.axle_inertia * yaw_rate) - yaw_rate * g_k).sum()
        places = np.array([np.ones(count), x, side])  # the load is b . (1, x, y)
        turning = places @ (x * force_k - side * force_h - rolling * axis_n)
        about_k = places @ (x + (machine.height - radius) * force_h) - moment_y * turn_mass * turning
        about_h = places @ (side + machine.height * force_k - rolling * axis_h) + moment_x * turn_mass * turning
        right_k = yaw_rate**2 * moment_x - torque.sum() + moment_y * turn_mass * gyro_yaw
        right_h = yaw_rate**2 * moment_y + gyro - moment_x * turn_mass * gyro_yaw
        weight = machine.mass * machine.gravity
        load = np.linalg.solve([places.sum(axis=1), about_k, about_h], [weight, right_k, right_h])
        yaw_acceleration, load = (load @ turning + gyro_yaw) * turn_mass, load @ places
        a_h, a_k = (load @ force_h) / machine.mass, (load @ force_k) / machine.mass
        acceleration = [a_h * cos_yaw - a_k * sin_yaw, a_h * sin_yaw + a_k * cos_yaw, yaw_acceleration]
        spin_moment = torque - yaw_rate * g_h - load * (radius * force_h + s * rolling)
        return np.concatenate(
            [
                y[3 + count : 6 + 2 * count],
                acceleration,
                spin_moment * wheels.spin_mobility,
                load * rolling / i_a,
                errors,
            ]
        )

    return f


def scalar_form(march: March) -> Callable:
    """The same in Python scalars."""
    machine, wheel, mode = march.parameters.machine, march.parameters.wheels[0], march.run.mode[0]
    radius, r1, c, s = (float(wheel[name]) for name in ("radius", "roller_distance", "cos_psi", "sin_psi"))
    j_k, i_a = float(wheel.axle_inertia), float(wheel.axial_inertia)
    mass, i_z, tan_psi = float(machine.mass), float(machine.yaw_inertia), float(wheel.tan_psi)
    limit, eps_square = float(machine.friction * mass * machine.gravity), float(machine.slip_speed) ** 2
    torque, q_0 = (
        float(march.parameters.inputs[0, DRIVE_INPUT, 0]),
        float(wheel.phase + 2.0 * wheel.alpha * mode.roller),
    )
    air_cos, air_sin, cos, sin, sqrt = *air_sums(march), math.cos, math.sin, math.sqrt

    def f(_, y):
        _, _, yaw, spin_angle, v_x, v_y, yaw_rate, spin_rate, roller_rate = y.tolist()
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
            spin_rate,
            (force_h * cos_yaw - force_k * sin_yaw) / mass,
            (force_h * sin_yaw + force_k * cos_yaw) / mass,
            (spin_rate * g_h - roller_torque * axis_n - l * force_h) / i_z,
            (torque - radius * force_h - roller_torque * s - yaw_rate * g_h) / j_k,
            roller_torque / i_a,
        ]

    return f


def air_sums(march: March) -> tuple[float, float]:
    """sum p_i cos D_i and sum p_i sin D_i over the rollers in the air, rad/s."""
    return float(march.run.mode[0].air_cos), float(march.run.mode[0].air_sin)


# --- the right-hand side of the march itself --------------------------------------------------------


@structref.register
class HeldType(numba.types.StructRef):
    """Numba's type of Held."""


class Held(structref.StructRefProxy):
    """Parameters, Run and the places of y in the state (n,) of a march.

    One object to hand over to compiled code instead of all their arrays: a call takes 2.5 microseconds instead of 15.
    """


structref.define_proxy(Held, HeldType, ["parameters", "run", "motion"])


def held(march: March) -> Held:
    """A march whose rollers in contact are found."""
    return Held(march.parameters, march.run, motion(march))


def motion(march: March) -> np.ndarray:
    """Where the states of the motion stand in the state of a march without bearing friction."""
    at, wheels = places_in(march.parameters), len(march.parameters.wheels)
    rollers = at.roller_rate + np.arange(wheels) * int(march.parameters.machine.slots)
    return np.concatenate([np.arange(at.roller_rate), rollers, np.arange(at.integral, at.friction_loss)])


@cache
def direct(function: Callable, held: numba.types.Type, dimensions: int) -> Callable:
    """A kernel (Held, t, y, out) for y of any strides, called without finding out the types each time."""
    y, out = numba.types.Array(numba.float64, 1, "A"), numba.types.Array(numba.float64, dimensions, "C")
    signature = held, numba.float64, y, out
    function.compile(signature)
    return function.get_overload(signature)


def bound(function: Callable, held: Held, *shape: int) -> Callable:
    """A kernel as a function of t and y, which returns an array (shape)."""
    call = direct(function, numba.typeof(held), len(shape))

    def f(t, y):
        out = np.empty(shape)
        call(held, t, y, out)
        return out

    return f


@numba.njit(error_model="numpy")
def rates(held, t, y, out):
    """y' (n,)."""
    evaluate_motion(held.parameters, held.run, held.motion, t, y, out)


@numba.njit(error_model="numpy", inline="always")
def evaluate_motion(parameters, run, motion, t, y, out):
    for m in range(len(motion)):
        run.y[motion[m]] = y[m]
    run.clock.rhs += 1
    evaluate(parameters, Stage(run.mode, run.clock.piece, t, run.y, run.slopes[0], run.monitors, False))
    for m in range(len(motion)):
        out[m] = run.slopes[0, motion[m]]


@numba.njit(error_model="numpy")
def jacobian(held, t, y, out):
    """Derivatives of y' by y (n, n): forward differences, far below the slip over which friction changes."""
    parameters, run, motion, speed = held.parameters, held.run, held.motion, 1.0
    here, there, shifted = np.empty(len(y)), np.empty(len(y)), y.copy()
    evaluate_motion(parameters, run, motion, t, y, here)
    for w in range(len(run.monitors)):
        speed = min(speed, math.sqrt(run.monitors[w].slip_square[0]) + parameters.machine.slip_floor)
    shift = min(max(STEEP * speed, 1e-11), 1e-7)
    for j in range(len(y)):
        shifted[j] = y[j] + shift
        evaluate_motion(parameters, run, motion, t, shifted, there)
        for i in range(len(y)):
            out[i, j] = (there[i] - here[i]) / (shifted[j] - y[j])
        shifted[j] = y[j]


@numba.njit(error_model="numpy")
def ahead(held, t, y, out):
    """Angles by which the wheels may spin on before they leave their rollers (W,), rad."""
    parameters, run = held.parameters, held.run
    at = places(parameters)
    for w in range(len(run.mode)):
        angle = past_middle(parameters, run.mode[w], w, y[at.spin_angle + w])
        sense = -1.0 if y[at.spin_rate + w] < 0.0 else 1.0
        out[w] = parameters.wheels[w].alpha + PASSED - sense * angle


@numba.njit(error_model="numpy", inline="always")
def past_middle(parameters, mode, w, spin_angle):
    """Spin angle of wheel w beyond that at which the middle of its roller is down, rad."""
    return spin_angle - parameters.wheels[w].phase - 2.0 * parameters.wheels[w].alpha * mode.roller


@numba.njit(error_model="numpy")
def exchange(held, t, y, out):
    """y after every wheel at the end of its roller has gone on to the next one: the rates of the rollers change."""
    parameters, run, motion = held.parameters, held.run, held.motion
    first = places(parameters).spin_angle
    for m in range(len(motion)):
        run.y[motion[m]] = y[m]
    for w in range(len(run.mode)):
        angle = past_middle(parameters, run.mode[w], w, y[first + w])
        if abs(angle) >= parameters.wheels[w].alpha:
            release_rollers(parameters, run, w)
            take_rollers(parameters, run, w, run.mode[w].roller + (1 if angle > 0.0 else -1), False)
    for m in range(len(motion)):
        out[m] = run.y[motion[m]]
