"""Each piece of a floor by two coordinates that are regular all over it: what a common normal is solved in."""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, combine, cross, dot, plus
from omnisim.contact.floor import around, beyond, flattened


class Coordinates(NamedTuple):
    """Where on a piece. Ground: x, y (m). Edge: the angle of the arc from its top (rad), the way along it (m)."""

    first: float
    last: float


class Patch(NamedTuple):
    """A place on a piece: the point X (Vec3, m), tangents p and q with p x q upwards, their derivatives by the two
    coordinates (Vec3 each), p x q and its derivatives, and how far X goes along p for one of the first; along q it is
    1."""

    point: Vec3
    p: Vec3
    q: Vec3
    p_first: Vec3
    p_last: Vec3
    q_first: Vec3
    q_last: Vec3
    normal: Vec3
    normal_first: Vec3
    normal_last: Vec3
    reach: float


@kernel
def patch(floor, piece, at):
    """The Patch at these Coordinates, which may lie beyond the piece: it goes on smoothly there."""
    return edge_patch(floor, piece - 1, at) if piece else ground_patch(floor, at)


@kernel
def ground_patch(floor, at):
    ground = flattened(floor, at.first, at.last)
    across = Vec3(0.0, 0.0, ground.xy)
    return Patch(
        Vec3(at.first, at.last, ground.height),
        Vec3(1.0, 0.0, ground.slope_x),
        Vec3(0.0, 1.0, ground.slope_y),
        Vec3(0.0, 0.0, ground.xx),
        across,
        across,
        Vec3(0.0, 0.0, ground.yy),
        Vec3(-ground.slope_x, -ground.slope_y, 1.0),
        Vec3(-ground.xx, -ground.xy, 0.0),
        Vec3(-ground.xy, -ground.yy, 0.0),
        1.0,
    )


@kernel
def edge_patch(floor, k, at):
    """s = w - e sin(angle), z = height - e + e cos(angle) above the ground without this step; p is X by s on level
    ground turned up to where the arc is vertical, so that nothing is singular there."""
    step = floor.steps[k]
    edge, x_up, y_up = step[5], step[2], step[3]
    cos, sin = math.cos(at.first), math.sin(at.first)
    s = step[6] - edge * sin
    x, y = step[0] + s * x_up - at.last * y_up, step[1] + s * y_up + at.last * x_up
    rest = around(floor, k, x, y)
    up, along = rest.slope_x * x_up + rest.slope_y * y_up, rest.slope_y * x_up - rest.slope_x * y_up
    twice_up = rest.xx * x_up * x_up + 2.0 * rest.xy * x_up * y_up + rest.yy * y_up * y_up
    both = (rest.yy - rest.xx) * x_up * y_up + rest.xy * (x_up * x_up - y_up * y_up)
    twice_along = rest.xx * y_up * y_up - 2.0 * rest.xy * x_up * y_up + rest.yy * x_up * x_up
    p, q = Vec3(cos * x_up, cos * y_up, up * cos + sin), Vec3(-y_up, x_up, along)
    p_first = Vec3(-sin * x_up, -sin * y_up, cos - up * sin - edge * cos * cos * twice_up)
    p_last, q_first = Vec3(0.0, 0.0, cos * both), Vec3(0.0, 0.0, -edge * cos * both)
    q_last = Vec3(0.0, 0.0, twice_along)
    return Patch(
        Vec3(x, y, rest.height + step[4] - edge + edge * cos),
        p,
        q,
        p_first,
        p_last,
        q_first,
        q_last,
        cross(p, q),
        plus(cross(p_first, q), cross(p, q_first)),
        plus(cross(p_last, q), cross(p, q_last)),
        -edge,
    )


@kernel
def coordinates_of(floor, piece, point):
    """The Coordinates of a point X (Vec3, m) of a piece; angle more than a right one on the face below an arc."""
    if not piece:
        return Coordinates(point.x, point.y)
    step = floor.steps[piece - 1]
    rest = around(floor, piece - 1, point.x, point.y)
    rise = point.z - rest.height - step[4] + step[5]
    way = (point.y - step[1]) * step[2] - (point.x - step[0]) * step[3]
    return Coordinates(math.atan2(step[6] - beyond(step, point.x, point.y), rise), way)


@kernel
def turning_of_normal(here, motion):
    """How the unit normal at a Patch changes (Vec3) as X moves by a tangent `motion` (Vec3, m)."""
    square = dot(here.normal, here.normal)
    first = dot(cross(motion, here.q), here.normal) / (square * here.reach)
    last = dot(cross(here.p, motion), here.normal) / square
    change = combine(first, here.normal_first, last, here.normal_last, 0.0, here.normal)
    scale = 1.0 / math.sqrt(square)
    return combine(scale, change, -scale * dot(change, here.normal) / square, here.normal, 0.0, here.normal)
