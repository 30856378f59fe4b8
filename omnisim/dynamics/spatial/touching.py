"""Where a roller touches the ground.

    P      the roller's lowest point along -nu      X   the point of the ground with P - X along nu
    delta  = -(P - X) . nu: how far the rubber is pressed in, > 0 in contact

All along hub axes, from the wheel centre O. B: centre of the roller. What it does there: reaction.py.

Every lobe of a roller may touch every piece of the floor: `meeting` counts the pieces for the first lobe, then for the
next. On a plane it is the lobe.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, dot, plus, times
from omnisim.contact.common_normal import ANY, touch
from omnisim.contact.floor import pieces
from omnisim.contact.support import region_of, support
from omnisim.dynamics.spatial.pose import Body, Hub, hub_of, inward, mounted, outward, stretch_of
from omnisim.dynamics.state import places

STANDING = 1e-9  # of a roller on end: its rim is lowest all around, and any point of it will do


class Standing(NamedTuple):
    """A wheel at an instant: the Body, its Hub, cosine and sine of its spin angle, its spin rate (rad/s), normal nu of
    the base plane along hub axes, 1 / |k x nu|, and height of O over that plane (m)."""

    body: Body
    hub: Hub
    cos: float
    sin: float
    spin_rate: float
    normal: Vec3
    stretch: float
    height: float


class Roller(NamedTuple):
    """A roller on its wheel: cosine and sine of its azimuth, its axis and B from O along hub axes (m)."""

    cos_q: float
    sin_q: float
    axis: Vec3
    centre: Vec3


class Touching(NamedTuple):
    """Where a roller would touch: the Roller, normal nu of the ground along hub axes, 1 / |k x nu|, delta (m), tilt
    nu . a, f (m) and X - B = g a + f nu (m), X from O (m), and how far X is inside the piece of the ground, m."""

    roller: Roller
    normal: Vec3
    stretch: float
    depth: float
    tilt: float
    deep: float
    lever: Vec3
    arm: Vec3
    within: float


@kernel
def standing(parameters, w, body, y):
    """The Standing of wheel w."""
    at = places(parameters)
    hub = hub_of(parameters, body, w, y)
    cos, sin = cos_sin(y[at.spin_angle + w])
    rotation = body.rotation
    up = Vec3(rotation.x.z, rotation.y.z, rotation.z.z)
    height = body.position.z + dot(up, hub.centre)
    normal = inward(mounted(hub), up)
    return Standing(body, hub, cos, sin, y[at.spin_rate + w], normal, stretch_of(normal), height)


@kernel
def roller_on(parameters, w, i, stand):
    """The Roller i of wheel w."""
    wheel, disk, i = parameters.wheels[w], parameters.space.disk, np.uint32(i)
    cos_q = disk[w, 0, i] * stand.cos + disk[w, 1, i] * stand.sin
    sin_q = disk[w, 1, i] * stand.cos - disk[w, 0, i] * stand.sin
    axis = Vec3(-wheel.cos_psi * cos_q, wheel.sin_psi, -wheel.cos_psi * sin_q)
    centre = Vec3(wheel.roller_distance * sin_q, disk[w, 2, i], -wheel.roller_distance * cos_q)
    return Roller(cos_q, sin_q, axis, centre)


@kernel
def meetings(space, w):
    """Of a roller of wheel w: lobes times pieces of the floor."""
    if not space.body.uneven:
        return space.hubs[w].lobes
    return space.hubs[w].lobes * pieces(space.floor)


@kernel
def piece_of(space, meeting):
    """The piece of uneven ground of a meeting."""
    return meeting % pieces(space.floor)


@kernel
def shape_of(space, w, meeting):
    """The SHAPE of the lobe of a meeting."""
    lobe = meeting
    if space.body.uneven:
        lobe = meeting // pieces(space.floor)
    return space.shapes[np.uint32(space.hubs[w].first_lobe + lobe)]


@kernel
def touching(parameters, w, stand, meeting, region, i):
    """The Touching of roller i of wheel w at a meeting, in a frozen region or ANY."""
    roller = roller_on(parameters, w, i, stand)
    shape = shape_of(parameters.space, w, meeting)
    if not parameters.space.body.uneven:
        return touch_plane(shape, region, roller, stand)
    return touch_ground(parameters, shape, stand, piece_of(parameters.space, meeting), region, roller)


@kernel
def touching_at(parameters, mode, w, c, stand):
    """The same of contact c of wheel w."""
    return touching(parameters, w, stand, mode.meeting[c], mode.region[c], roller_at(mode, c))


@kernel
def rate_of_roller(parameters, mode, w, c):
    """Where the rate of the roller of contact c stands in the state."""
    slot = roller_at(mode, c) if parameters.machine.every_rate else mode.slot[c]
    return np.uint32(parameters.wheels[w].rates + slot)


@kernel
def roller_at(mode, c):
    """Which roller of its wheel touches at contact c."""
    return mode.roller[np.uint32(mode.slot[c])]  # unsigned, as all places here: nobody tests if it counts from the end


@kernel
def touch_plane(shape, region, roller, stand):
    """The same on the base plane, of a roller of the wheel of a Standing."""
    normal = stand.normal
    tilt = dot(roller.axis, normal)
    if region == ANY:
        region = region_of(shape, tilt)
    square = max(1.0 - tilt * tilt, STANDING * STANDING)
    found = support(shape, region, tilt, math.sqrt(square))
    depth = found.over_across * square - found.u * tilt - stand.height - dot(roller.centre, normal)
    deep = depth - found.over_across
    lever = lever_of(roller, normal, found, tilt, deep)
    return Touching(roller, normal, stand.stretch, depth, tilt, deep, lever, plus(roller.centre, lever), math.inf)


@kernel
def lever_of(roller, normal, found, tilt, deep):
    """X - B: u a + r e + delta nu, with a Support and f."""
    return plus(times(found.u + found.over_across * tilt, roller.axis), times(deep, normal))


@kernel
def in_world(stand, roller):
    """Centre (m) and axis of a Roller, world axes."""
    body = stand.body
    axes = mounted(stand.hub)
    centre = plus(body.position, outward(body.rotation, plus(stand.hub.centre, outward(axes, roller.centre))))
    return centre, outward(body.rotation, outward(axes, roller.axis))


@outlined
def touch_ground(parameters, shape, stand, piece, region, roller):
    """The same on a piece of uneven ground."""
    space = parameters.space
    centre, axis = in_world(stand, roller)
    found = touch(space.floor, piece, shape, region, centre, axis)
    normal = inward(mounted(stand.hub), inward(stand.body.rotation, found.nu))
    deep = found.depth - found.support.over_across
    lever = lever_of(roller, normal, found.support, found.tilt, deep)
    within = found.inside if found.converged else -math.inf
    arm = plus(roller.centre, lever)
    return Touching(roller, normal, stretch_of(normal), found.depth, found.tilt, deep, lever, arm, within)


@kernel
def disk_turning(stand):
    """Rate at which the disk of a Standing turns (Vec3, rad/s)."""
    rate = stand.hub.rate
    return Vec3(rate.x, rate.y + stand.spin_rate, rate.z)


@kernel
def joint_rate(stand, roller, rate):
    """chi' of a Roller with the absolute axial rate `rate`, rad/s."""
    return rate - dot(roller.axis, stand.hub.rate) - stand.spin_rate * roller.axis.y
