"""Rigid bodies in space: place and motion of each are 13 states, r Q v w, in world axes.

Body 0 is the chassis; then come the wheels, each its disk and its rollers. Body axes:

    chassis    its own                          disk    h, k, n at spin angle 0
    roller     z along its axis a; x and y turn with it

Without a chassis body 0 has no mass: it stands at the wheel centre, and what keeps the wheel upright acts on it.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, cross, dot, plus, times


class Quaternion(NamedTuple):
    """Rotation from body to world axes; inside a step its norm is not quite 1."""

    w: float
    x: float
    y: float
    z: float


class RigidBody(NamedTuple):
    """Centre of mass (m), rotation, and their rates (m/s, rad/s) in world axes."""

    position: Vec3
    rotation: Quaternion
    velocity: Vec3
    rate: Vec3


@kernel
def rigid_body(y, first):
    """The RigidBody whose states begin at `first`."""
    return RigidBody(
        vector_at(y, first),
        Quaternion(y[first + 3], y[first + 4], y[first + 5], y[first + 6]),
        vector_at(y, first + 7),
        vector_at(y, first + 10),
    )


@kernel
def against_gravity(machine):
    """Acceleration that it takes to stay at rest in gravity (Vec3, m/s^2): with it the weight is one more inertial
    force."""
    return Vec3(-machine.downhill[0], -machine.downhill[1], machine.gravity)


@kernel
def vector_at(y, first):
    return Vec3(y[first], y[first + 1], y[first + 2])


@kernel
def store_vector(y, first, vector):
    y[first], y[first + 1], y[first + 2] = vector.x, vector.y, vector.z


@kernel
def store_quaternion(y, first, rotation):
    y[first + 3], y[first + 4], y[first + 5], y[first + 6] = rotation.w, rotation.x, rotation.y, rotation.z


@kernel
def rate_states(dy, first, body, acceleration, angular):
    """Rates of the states of a body: its own, and its accelerations (Vec3, m/s^2 and rad/s^2)."""
    store_vector(dy, first, body.velocity)
    spun = product(Quaternion(0.0, body.rate.x, body.rate.y, body.rate.z), body.rotation)
    store_quaternion(dy, first, Quaternion(0.5 * spun.w, 0.5 * spun.x, 0.5 * spun.y, 0.5 * spun.z))
    store_vector(dy, first + 7, acceleration)
    store_vector(dy, first + 10, angular)


@kernel
def product(a, b):
    """Rotation b, then a."""
    return Quaternion(
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
    )


@kernel
def square(q):
    return q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z


@kernel
def first_axis(q):
    """Unit vector along the body's x axis (Vec3, world), whatever the norm of q."""
    scale = 1.0 / square(q)
    return Vec3(
        (q.w * q.w + q.x * q.x - q.y * q.y - q.z * q.z) * scale,
        2.0 * (q.x * q.y + q.w * q.z) * scale,
        2.0 * (q.x * q.z - q.w * q.y) * scale,
    )


@kernel
def second_axis(q):
    """The same along y."""
    scale = 1.0 / square(q)
    return Vec3(
        2.0 * (q.x * q.y - q.w * q.z) * scale,
        (q.w * q.w - q.x * q.x + q.y * q.y - q.z * q.z) * scale,
        2.0 * (q.y * q.z + q.w * q.x) * scale,
    )


@kernel
def third_axis(q):
    """The same along z."""
    scale = 1.0 / square(q)
    return Vec3(
        2.0 * (q.x * q.z + q.w * q.y) * scale,
        2.0 * (q.y * q.z - q.w * q.x) * scale,
        (q.w * q.w - q.x * q.x - q.y * q.y + q.z * q.z) * scale,
    )


@kernel
def turned_to(q, axis):
    """Rotation q after the shortest turn that brings its z axis to the unit vector `axis`; of norm 1."""
    now = third_axis(q)
    turn = cross(now, axis)
    turned = product(Quaternion(1.0 + dot(now, axis), turn.x, turn.y, turn.z), q)
    scale = 1.0 / math.sqrt(square(turned))
    return Quaternion(turned.w * scale, turned.x * scale, turned.y * scale, turned.z * scale)


@kernel
def gyroscopic(across, along, axis, rate):
    """w x J w (Vec3, N m) of a body of revolution with J = `across` its unit axis and `along` it, turning at `rate`."""
    return times((along - across) * dot(rate, axis), cross(rate, axis))


@kernel
def needed_wrench(mass, across, along, axis, rate, acceleration, angular):
    """Newton and Euler for a body of revolution: the force (Vec3, N) and the moment about its centre of mass (N m) that
    give it these accelerations, m/s^2 and rad/s^2."""
    more = (along - across) * dot(angular, axis)
    moment = plus(plus(times(across, angular), times(more, axis)), gyroscopic(across, along, axis, rate))
    return times(mass, acceleration), moment
