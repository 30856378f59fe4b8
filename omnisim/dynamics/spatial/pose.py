"""Where the chassis is and how it moves, and the same of its wheels: frames, positions, velocities.

    chassis axes    x forward, y left, z up, at C            hub axes    h heading, k axle, z up, at the wheel centre O

World axes belong to the base plane, z its normal. The orientation (w, x, y, z) is a quaternion of any length: only its
direction counts, so no step need put it back to 1.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, combine, cross, dot, minus, plus, times
from omnisim.dynamics.spatial.records import ORIENTATION, POSITION
from omnisim.dynamics.state import places


class Rotation(NamedTuple):
    """World components of the chassis axes."""

    x: Vec3
    y: Vec3
    z: Vec3


class Body(NamedTuple):
    """The chassis at an instant: its axes, C (world, m), and velocity of C (m/s) and rate (rad/s) along its axes."""

    rotation: Rotation
    position: Vec3
    velocity: Vec3
    rate: Vec3


class Hub(NamedTuple):
    """What a wheel is mounted on: its axes and O from C along chassis axes (m), velocity of O (m/s) and rate (rad/s)
    along its own."""

    h: Vec3
    k: Vec3
    up: Vec3
    centre: Vec3
    velocity: Vec3
    rate: Vec3


@kernel
def vector(array, place):
    """Three numbers of an array as a Vec3."""
    return Vec3(array[place], array[place + 1], array[place + 2])


@kernel
def rotation_of(w, x, y, z):
    """The Rotation of a quaternion of any length."""
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return Rotation(
        Vec3(1.0 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)),
        Vec3(s * (x * y - w * z), 1.0 - s * (x * x + z * z), s * (y * z + w * x)),
        Vec3(s * (x * z + w * y), s * (y * z - w * x), 1.0 - s * (x * x + y * y)),
    )


@kernel
def outward(axes, v):
    """A vector with these components along `axes`, a Rotation, in the frame in which they are given."""
    return combine(v.x, axes.x, v.y, axes.y, v.z, axes.z)


@kernel
def inward(axes, v):
    """The components of v along `axes`, a Rotation."""
    return Vec3(dot(axes.x, v), dot(axes.y, v), dot(axes.z, v))


@kernel
def body_of(parameters, y):
    """The Body in state y."""
    at = places(parameters)
    rotation = rotation_of(y[ORIENTATION], y[ORIENTATION + 1], y[ORIENTATION + 2], y[ORIENTATION + 3])
    return Body(rotation, vector(y, POSITION), inward(rotation, vector(y, at.velocity)), vector(y, at.rate))


@kernel
def orientation_rate(y, rate, dy):
    """Rate of the quaternion in y, q' = q w / 2, into dy; rate: along chassis axes, rad/s."""
    w, x, y_, z = y[ORIENTATION], y[ORIENTATION + 1], y[ORIENTATION + 2], y[ORIENTATION + 3]
    dy[ORIENTATION] = -0.5 * (x * rate.x + y_ * rate.y + z * rate.z)
    dy[ORIENTATION + 1] = 0.5 * (w * rate.x + y_ * rate.z - z * rate.y)
    dy[ORIENTATION + 2] = 0.5 * (w * rate.y + z * rate.x - x * rate.z)
    dy[ORIENTATION + 3] = 0.5 * (w * rate.z + x * rate.y - y_ * rate.x)


@kernel
def hub_of(parameters, body, w, y):
    """The Hub of wheel w in state y."""
    space = parameters.space
    hub = space.hubs[w]
    if hub.carrier >= 0:
        j = hub.carrier
        s, s_rate = y[places(parameters).joint + j], y[places(parameters).joint_rate + j]
        return carried_hub(hub, space.carriers[j], body, s, s_rate)
    h, k, centre = vector(hub.h, 0), vector(hub.k, 0), vector(hub.centre, 0)
    velocity = level(h, k, plus(body.velocity, cross(body.rate, centre)))
    return Hub(h, k, Vec3(0.0, 0.0, 1.0), centre, velocity, level(h, k, body.rate))


@kernel
def level(h, k, v):
    """The components of v along axes of which h and k have no z and the third is z: `inward`, in half the products."""
    return Vec3(h.x * v.x + h.y * v.y, k.x * v.x + k.y * v.y, v.z)


@outlined
def carried_hub(hub, carrier, body, s, s_rate):
    """The same of one on a carrier that stands at s: called, so that its branch costs others no registers."""
    h, k, up = vector(hub.h, 0), vector(hub.k, 0), Vec3(0.0, 0.0, 1.0)
    centre = vector(hub.centre, 0)
    axis, point = vector(carrier.axis, 0), vector(carrier.point, 0)
    if not carrier.turns:
        velocity = plus(body.velocity, times(s_rate, axis))
        return mounted_at(Rotation(h, k, up), plus(centre, times(s, axis)), body, velocity, body.rate)
    cos, sin = cos_sin(s)
    axes = Rotation(turned(h, axis, cos, sin), turned(k, axis, cos, sin), turned(up, axis, cos, sin))
    arm = turned(minus(centre, point), axis, cos, sin)
    velocity = plus(body.velocity, times(s_rate, cross(axis, arm)))
    return mounted_at(axes, plus(point, arm), body, velocity, plus(body.rate, times(s_rate, axis)))


@kernel
def mounted_at(axes, centre, body, velocity, rate):
    """The Hub with these axes and O, and this velocity without that by the turning of the Body, all along its axes."""
    velocity = plus(velocity, cross(body.rate, centre))
    return Hub(axes.x, axes.y, axes.z, centre, inward(axes, velocity), inward(axes, rate))


@kernel
def turned(v, axis, cos, sin):
    """v turned about a unit axis by an angle of this cosine and sine."""
    return combine(cos, v, sin, cross(axis, v), (1.0 - cos) * dot(axis, v), axis)


@kernel
def mounted(hub):
    """The axes of a Hub along those of the chassis, a Rotation."""
    return Rotation(hub.h, hub.k, hub.up)


@kernel
def tangent_of(normal):
    """Unit vectors h = unit(k x nu) and k = nu x h in the tangent plane of the ground, along hub axes, in which nu is
    given."""
    stretch = stretch_of(normal)
    h = Vec3(normal.z * stretch, 0.0, -normal.x * stretch)
    return h, cross(normal, h)


@kernel
def stretch_of(normal):
    """1 / |k x nu|, of a normal along hub axes."""
    return 1.0 / math.sqrt(normal.x * normal.x + normal.z * normal.z)


@kernel
def product(matrix, v):
    """A 3 x 3 array times a Vec3."""
    return Vec3(
        matrix[0, 0] * v.x + matrix[0, 1] * v.y + matrix[0, 2] * v.z,
        matrix[1, 0] * v.x + matrix[1, 1] * v.y + matrix[1, 2] * v.z,
        matrix[2, 0] * v.x + matrix[2, 1] * v.y + matrix[2, 2] * v.z,
    )


@kernel
def put(target, v):
    """A Vec3 into the first three numbers of an array."""
    target[0], target[1], target[2] = v.x, v.y, v.z


@kernel
def put_at(array, place, v):
    array[place], array[place + 1], array[place + 2] = v.x, v.y, v.z


@kernel
def add_push(push, moment, force):
    """Add a moment and a force (Vec3) to six numbers."""
    push[0] += moment.x
    push[1] += moment.y
    push[2] += moment.z
    push[3] += force.x
    push[4] += force.y
    push[5] += force.z
