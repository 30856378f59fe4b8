"""Where a roller touches the ground, and what rubber and friction do there.

    P      the roller's lowest point along -nu                  X   the point of the ground with P - X along nu
    delta  = -(P - X) . nu: how far the rubber is pressed in, > 0 in contact
    V      velocity of the roller's material at X, of the body  delta' = -V . nu
    N      = max(0, stiffness delta + damping delta')            v = V - (V . nu) nu, friction by the scene's law

All along hub axes, from the wheel centre O. B: centre of the roller.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, combine, cross, dot, plus, times
from omnisim.contact.common_normal import ANY, touch
from omnisim.contact.frame import Slip
from omnisim.contact.friction import friction
from omnisim.contact.support import Support, region_of, support
from omnisim.dynamics.spatial.pose import inward, mounted, outward, tangent_of

STANDING = 1e-9  # of a roller on end: its rim is lowest all around, and any point of it will do


class Roller(NamedTuple):
    """A roller on its wheel: cosine and sine of its azimuth, its axis and B from O along hub axes (m)."""

    cos_q: float
    sin_q: float
    axis: Vec3
    centre: Vec3


class Touching(NamedTuple):
    """Where a roller would touch: normal of the ground along hub axes, delta (m), tilt nu . a, X - B (m), and how far X
    is inside the piece of the ground, m."""

    normal: Vec3
    depth: float
    tilt: float
    lever: Vec3
    within: float


class Reaction(NamedTuple):
    """What the ground does at a contact: delta' (m/s), stiffness delta + damping delta' and N (N), slip (m/s) and
    friction (N) in the tangent plane, factor of the law (N s/m), force (N) and moment about the normal (N m)."""

    closing: float
    press: float
    normal_force: float
    slip: Slip
    friction: Slip
    factor: float
    force: Vec3
    torque: float
    heat: float


@kernel
def roller_on(parameters, w, i, cos, sin):
    """The Roller i of wheel w whose spin angle has this cosine and sine."""
    wheel, place = parameters.wheels[w], parameters.space.disk[w, i]
    cos_q = place[0] * cos + place[1] * sin
    sin_q = place[1] * cos - place[0] * sin
    axis = Vec3(-wheel.cos_psi * cos_q, wheel.sin_psi, -wheel.cos_psi * sin_q)
    centre = Vec3(wheel.roller_distance * sin_q, place[2], -wheel.roller_distance * cos_q)
    return Roller(cos_q, sin_q, axis, centre)


@kernel
def ground_normal(body, hub):
    """Normal of the base plane along hub axes."""
    rotation = body.rotation
    return inward(mounted(hub), Vec3(rotation.x.z, rotation.y.z, rotation.z.z))


@kernel
def height_of(body, hub):
    """Height of O over the base plane, m."""
    return body.position.z + dot(Vec3(body.rotation.x.z, body.rotation.y.z, body.rotation.z.z), hub.centre)


@kernel
def touch_plane(shape, region, roller, normal, height):
    """The Touching of a Roller on the base plane, in a frozen region; normal: along hub axes, height: of O, m."""
    tilt = dot(roller.axis, normal)
    across = max(math.sqrt(max(1.0 - tilt * tilt, 0.0)), STANDING)
    found = support(shape, region, tilt, across)
    depth = found.r * across - found.u * tilt - height - dot(roller.centre, normal)
    return Touching(normal, depth, tilt, lever_of(roller, normal, found, tilt, across, depth), math.inf)


@kernel
def lever_of(roller, normal, found, tilt, across, depth):
    """X - B: u a + r e + delta nu."""
    radial = found.r / across
    return combine(found.u + radial * tilt, roller.axis, depth - radial, normal, 0.0, normal)


@kernel
def in_world(body, hub, roller):
    """Centre (m) and axis of a Roller, world axes."""
    axes = mounted(hub)
    centre = plus(body.position, outward(body.rotation, plus(hub.centre, outward(axes, roller.centre))))
    return centre, outward(body.rotation, outward(axes, roller.axis))


@outlined
def touch_ground(parameters, body, hub, w, piece, region, roller):
    """The same on a piece of uneven ground."""
    space = parameters.space
    centre, axis = in_world(body, hub, roller)
    found = touch(space.floor, piece, space.shapes[w], region, centre, axis)
    normal = inward(mounted(hub), inward(body.rotation, found.nu))
    shape = Support(found.support.u, found.support.r, 0.0, 0.0)
    lever = lever_of(roller, normal, shape, found.tilt, max(found.across, STANDING), found.depth)
    return Touching(normal, found.depth, found.tilt, lever, found.inside if found.converged else -math.inf)


@kernel
def touching(parameters, body, hub, w, piece, region, roller, normal, height):
    """The Touching of a Roller of wheel w in a frozen region; normal and height as `touch_plane` wants them."""
    if parameters.space.floor is None:
        return touch_plane(parameters.space.shapes[w], region, roller, normal, height)
    return touch_ground(parameters, body, hub, w, piece, region, roller)


@kernel
def touching_now(parameters, body, hub, w, piece, roller, normal, height):
    """The same in whatever region the lowest point is."""
    if parameters.space.floor is None:
        shape = parameters.space.shapes[w]
        return touch_plane(shape, region_of(shape, dot(roller.axis, normal)), roller, normal, height)
    return touch_ground(parameters, body, hub, w, piece, ANY, roller)


@kernel
def react(parameters, hub, w, touched, pressed, saturated, roller, spin_rate, joint):
    """The Reaction at a contact of wheel w.

    pressed, saturated: of its mode. joint: chi', rate of the roller in its wheel, rad/s.
    """
    machine = parameters.machine
    own = parameters.space.hubs[w]
    normal = touched.normal
    rate = Vec3(hub.rate.x, hub.rate.y + spin_rate, hub.rate.z)
    carried = plus(hub.velocity, cross(rate, plus(roller.centre, touched.lever)))
    velocity = plus(carried, times(joint, cross(roller.axis, touched.lever)))
    closing = -dot(velocity, normal)
    press = own.stiffness * touched.depth + own.damping * closing
    load = press if pressed else 0.0
    h, k = tangent_of(normal)
    slip = Slip(dot(velocity, h), dot(velocity, k))
    turn = dot(rate, normal) + joint * touched.tilt
    factor, torque = friction(machine, saturated, load, slip, turn)
    held = Slip(-factor * slip.h, -factor * slip.k)
    heat = factor * (slip.h * slip.h + slip.k * slip.k) - torque * turn
    return Reaction(closing, press, load, slip, held, factor, combine(load, normal, held.h, h, held.k, k), torque, heat)


@kernel
def joint_rate(roller, rate, hub, spin_rate):
    """chi' of a roller with the absolute axial rate `rate`, rad/s."""
    return rate - dot(roller.axis, hub.rate) - spin_rate * roller.axis.y
