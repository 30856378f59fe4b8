"""Motion of a machine free in space whose parts are all free bodies: start, energy, and a march by DOP853.

Nothing is located: the march has the tolerance of its steps, which shorten where a contact begins or ends.
"""

from itertools import pairwise
from math import radians
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from oracle.spatial.bodies import Coordinates, X, Y, Z, placed, turned
from oracle.spatial.machine import Machine, Reactions, rotor_inertia
from oracle.vectors import cross


def start(machine: Machine) -> Coordinates:
    """The initial state of a scene that gives a height; yaw, then pitch, then roll, and their rates."""
    initial = machine.initial
    yaw, pitch, roll = (radians(initial.get(f"{key}_deg", 0.0)) for key in ("yaw", "pitch", "roll"))
    rates = [initial.get(f"{key}_rate", 0.0) for key in ("yaw", "pitch", "roll")]
    quaternion = multiplied(half(Z, yaw), multiplied(half(Y, pitch), half(X, roll)))
    axes = Z, turned(Z, yaw) @ Y, turned(Z, yaw) @ turned(Y, pitch) @ X
    omega = sum(rate * axis for rate, axis in zip(rates, axes, strict=True))
    position = np.array([*initial.get("position", [0.0, 0.0]), initial["height"]])
    velocity = np.array([*initial.get("velocity", [0.0, 0.0]), initial.get("vertical_velocity", 0.0)])
    entries = [wheel.entry for wheel in machine.wheels]
    angle = np.radians([entry.get("spin_angle_deg", 0.0) for entry in entries])
    spin = np.array([entry.get("spin_rate", 0.0) for entry in entries])
    none, rockers = np.zeros(len(entries)), np.zeros(len(machine.layout.carriers))
    rest = [np.zeros(wheel.count) for wheel in machine.wheels]
    now = Coordinates(position, quaternion, velocity, omega, angle, spin, none, none, rockers, rockers, rest)
    bodies, axial = placed(machine.layout, now), []
    for w, of in enumerate(machine.layout.rollers):
        axial.append(bodies.axis[of] @ bodies.w[machine.layout.disk[w]] + np.array(entries[w].get("roller_rates", 0.0)))
    return now._replace(axial_rates=axial)


def half(axis: np.ndarray, angle: float) -> np.ndarray:
    return np.array([np.cos(0.5 * angle), *(np.sin(0.5 * angle) * axis)])


def multiplied(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Product of two quaternions (w, x, y, z)."""
    (a, u), (b, v) = (left[0], left[1:]), (right[0], right[1:])
    return np.array([a * b - u @ v, *(a * v + b * u + cross(u, v))])


class Energy(NamedTuple):
    """Energies (J) of a state, and the rates (W) at which it gains what its drives do and loses the rest.

    kinetic_rate + gravity_rate + elastic_rate = drive + wrench - friction - contact - damper - bearing
    """

    kinetic: float
    gravity: float
    elastic: float
    kinetic_rate: float
    gravity_rate: float
    elastic_rate: float
    drive: float
    wrench: float
    friction: float
    contact: float
    damper: float
    bearing: float
    rolling: float

    @property
    def imbalance(self) -> float:
        gained = self.kinetic_rate + self.gravity_rate + self.elastic_rate
        lost = self.friction + self.contact + self.damper + self.bearing + self.rolling
        return gained - self.drive - self.wrench + lost


def energy(machine: Machine, time: float, now: Coordinates, found: Reactions) -> Energy:
    bodies, mass = placed(machine.layout, now), machine.layout.mass
    linear, turning = found.bodies[:, :3], found.bodies[:, 3:]
    momentum = (bodies.inertia @ bodies.w[:, :, None])[..., 0]
    change = (bodies.inertia @ turning[:, :, None])[..., 0]
    rotors = np.array([rotor_inertia(wheel.entry) for wheel in machine.wheels])
    kinetic = 0.5 * (mass @ np.sum(bodies.v**2, axis=1) + np.sum(bodies.w * momentum) + rotors @ now.spin_rate**2)
    kinetic_rate = mass @ np.sum(bodies.v * linear, axis=1) + np.sum(bodies.w * change)
    kinetic_rate += rotors @ (now.spin_rate * found.spin)
    loads = machine.loads(time, bodies)
    elastic = elastic_rate = contact = friction = damper = bearing = rolling = 0.0
    for touch in found.touches:
        pressed = machine.wheels[touch.wheel].kind["contact"]["stiffness"] * touch.depth
        elastic, elastic_rate = elastic + 0.5 * pressed * touch.depth, elastic_rate + pressed * touch.depth_rate
        contact += (touch.load - pressed) * touch.depth_rate
        friction -= touch.friction @ touch.slip
        rolling -= touch.resisting @ touch.turning
    for w, wheel in enumerate(machine.wheels):
        chi, torque = machine.bearings(w, bodies)
        bearing -= chi @ torque
        if w in machine.layout.hub:
            spring, s, rate = wheel.entry["suspension"], now.travel[w], now.travel_rate[w]
            preload = spring.get("preload", 0.0)
            elastic += (preload + 0.5 * spring["stiffness"] * s) * s
            elastic_rate += (preload + spring["stiffness"] * s) * rate
            damper += spring.get("damping", 0.0) * rate**2
    wrench = loads.force @ bodies.v[0] + loads.torque @ bodies.w[0]
    gravity, gravity_rate = -mass @ bodies.x @ machine.gravity, -mass @ bodies.v @ machine.gravity
    return Energy(kinetic, gravity, elastic, kinetic_rate, gravity_rate, elastic_rate, loads.drives @ now.spin_rate,
                  wrench, friction, contact, damper, bearing, rolling)  # fmt: skip


def packed(now: Coordinates) -> np.ndarray:
    return np.concatenate([*now[:-1], *now.axial_rates])


def unpacked(machine: Machine, state: np.ndarray) -> Coordinates:
    wheels, rockers = len(machine.wheels), len(machine.layout.carriers)
    sizes = [3, 4, 3, 3, *(4 * [wheels]), *(2 * [rockers]), *(wheel.count for wheel in machine.wheels)]
    parts = np.split(state, np.cumsum(sizes)[:-1])
    return Coordinates(*parts[:10], parts[10:])


def rates(now: Coordinates, found: Reactions) -> Coordinates:
    """Of the coordinates; a quaternion turns by half of (0, w) q."""
    turning = 0.5 * multiplied(np.array([0.0, *now.angular_velocity]), now.quaternion)
    return Coordinates(now.velocity, turning, found.acceleration, found.angular_acceleration, now.spin_rate, found.spin,
                       now.travel_rate, found.travel, now.axle_rate, found.axle, found.rollers)  # fmt: skip


def march(machine: Machine, times: list[float], rtol: float) -> list[Coordinates]:
    """States at these times, the first of which is that of the start."""
    settings = {"method": "DOP853", "rtol": rtol, "atol": 1e-2 * rtol}
    states = [packed(start(machine))]

    def derivative(time: float, state: np.ndarray) -> np.ndarray:
        now = unpacked(machine, state)
        return packed(rates(now, machine.solve(time, now)))

    for begin, end in pairwise(times):
        solved = solve_ivp(derivative, (begin, end), states[-1], **settings)
        if solved.status < 0:
            raise RuntimeError(solved.message)
        states.append(solved.y[:, -1])
    return [unpacked(machine, state) for state in states]
