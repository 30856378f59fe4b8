"""Where a roller meets ground that is no plane: by the common normal of both.

               a                      nu   unit normal of the floor at X, upwards
          .---/--.                    P    the roller's lowest point along -nu
         |   B    |                   X    the point of the floor with P - X parallel to nu
          '--\\---'                    depth = -(P - X) . nu, > 0 where they overlap
       ____ P \\ ____ X __
           '-__      __-'             (P - X) . p = (P - X) . q = 0 for two tangents p, q of the floor at X

Two equations for two coordinates of X, solved by Newton's method with the exact Jacobian; no step makes the residual
larger. It is a function of the state alone: it starts below the roller each time. On ground as hollow as the roller is
curved there may be several common normals, of which the deepest is found from a few starts.

Each piece of a floor is asked for its own: see floor.py. `Touch.inside` tells whether X is there.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, combine, cross, dot, minus, plus, times
from omnisim.contact.floor import GROUND, beyond, highest_around, inside_piece, smooth_ground
from omnisim.contact.patch import Coordinates, edge_patch, patch
from omnisim.contact.support import Support, region_of, support

ANY = -1  # in the place of a region: whichever holds the lowest point
MOST_STEPS = 40  # of Newton, of which four are usual
MOST_HALVINGS = 12  # of one of them
NEAR = 0.02  # rad, from where Newton alone finds the angle of an edge
FIRST, LAST = -0.3, 0.5 * math.pi + 0.3  # rad, between which that angle is looked for: a little beyond the arc
SMALL = 1e-8  # of the roller's radius: after a step so short the next would change nothing
ROUNDED = 1e-13  # of the same: residuals that are zero but for rounding
TINY = 1e-12  # sine of the angle below which a roller stands on end


class Roller(NamedTuple):
    """The SHAPE record of a roller or of a lobe, its centre B (Vec3, m) and its unit axis a (Vec3), world axes."""

    shape: object
    centre: Vec3
    axis: Vec3


class Touch(NamedTuple):
    """Common normal of a roller and a floor, world axes.

    nu         unit normal of the floor at X (Vec3)
    point      X (Vec3), m
    depth      -(P - X) . nu, m; > 0: they overlap
    tilt       nu . a
    across     sqrt(1 - tilt^2)
    support    the Support of P in its region
    region     of the roller: see support.py
    inside     how far X is inside the piece of the floor, m; < 0: there is no contact on this piece
    converged  False: no common normal was found, and nothing else of this holds
    """

    nu: Vec3
    point: Vec3
    depth: float
    tilt: float
    across: float
    support: Support
    region: int
    inside: float
    converged: bool


class Low(NamedTuple):
    """The point P of a roller that is lowest along -nu (Vec3, m), with e and what Touch tells of it."""

    nu: Vec3
    point: Vec3
    e: Vec3
    tilt: float
    across: float
    support: Support
    region: int


class Look(NamedTuple):
    """The roller seen from a place X on the floor, P - X, and residual and Jacobian of Newton."""

    at: Coordinates
    point: Vec3
    low: Low
    gap: Vec3
    first: float  # residuals along p and q
    last: float
    first_first: float  # their derivatives by the coordinates
    first_last: float
    last_first: float
    last_last: float
    reach: float  # m along p for one of the first coordinate


@kernel
def room(floor, piece, roller):
    """How far above or beside this piece a Roller is that cannot touch it, m; 0 where it may: cheap, and not told of
    all that cannot. Over a level top it ends where the roller touches: a root for that event to find."""
    centre, reach = roller.centre, roller.shape.reach
    bottom = lowest(roller, ANY, Vec3(0.0, 0.0, 1.0)).point.z
    if bottom > floor.highest:
        return bottom - floor.highest
    if piece:
        step = floor.steps[piece - 1]
        s = beyond(step, centre.x, centre.y)
        return max(-reach - s, s - step[6] - reach, 0.0)
    over = highest_around(floor, centre.x, centre.y, reach)
    if bottom > over:
        return bottom - over
    ground = smooth_ground(floor, centre.x, centre.y)
    nu = unit(Vec3(-ground.slope_x, -ground.slope_y, 1.0))
    below = minus(lowest(roller, ANY, nu).point, Vec3(centre.x, centre.y, ground.height + floor.stairs))
    return max(dot(below, nu) - 0.5 * floor.bend * reach * reach, 0.0)


@kernel
def unit(a):
    return times(1.0 / math.sqrt(dot(a, a)), a)


@kernel
def touch(floor, piece, shape, region, centre, axis):
    """The Touch of a roller, in this region of its own or in ANY, with this piece of the floor."""
    roller = Roller(shape, centre, axis)
    found, converged = around_edge(floor, piece, roller) if piece else deepest(floor, roller)
    if region != ANY and found.low.region != region:
        found, converged = newton(floor, piece, roller, region, found.at)
    low, point = found.low, found.point
    if piece and found.at.first > 0.5 * math.pi:
        low, point = on_face(floor.steps[piece - 1], roller, region, low, point)
    return Touch(
        low.nu,
        point,
        dot(minus(point, low.point), low.nu),
        low.tilt,
        low.across,
        low.support,
        low.region,
        inside_piece(floor, piece, point.x, point.y),
        converged,
    )


@kernel
def deepest(floor, roller):
    """The Look along the deepest common normal with the GROUND, in any region, and whether there is one.

    One start finds it unless the ground may be as hollow as the roller is curved.
    """
    shape = roller.shape
    best, known = newton(floor, GROUND, roller, ANY, below(roller, 0.0))
    if known and floor.hollow * shape.longest < 1.0:
        return best, known
    for part in (-1.0, -0.5, 0.5, 1.0):
        other, converged = newton(floor, GROUND, roller, ANY, below(roller, part * shape.half_length))
        if converged and (not known or dot(other.gap, other.low.nu) < dot(best.gap, best.low.nu)):
            best, known = other, True
    return best, known


@kernel
def below(roller, along):
    """Coordinates below the roller's lowest point for the vertical, or below the point of its axis at `along` (m) if
    that is not 0."""
    if along == 0.0:
        place = lowest(roller, ANY, Vec3(0.0, 0.0, 1.0)).point
    else:
        place = combine(1.0, roller.centre, along, roller.axis, 0.0, roller.axis)
    return Coordinates(place.x, place.y)


@kernel
def facing(floor, piece, roller):
    """Coordinates where the edge looks from its own axis to the roller's centre."""
    step, centre = floor.steps[piece - 1], roller.centre
    way = (centre.y - step[1]) * step[2] - (centre.x - step[0]) * step[3]
    top = edge_patch(floor, piece - 1, Coordinates(0.0, way)).point
    angle = math.atan2(step[6] - beyond(step, centre.x, centre.y), centre.z - top.z + step[5])
    return Coordinates(min(max(angle, 0.0), 0.5 * math.pi), way)


@kernel
def around_edge(floor, piece, roller):
    """The Look along the common normal with an edge, in any region, and whether there is one.

    Of the angles of the arc it is the one with the least depth: two convex bodies are apart along it, or overlap least.
    The residual along the arc is the rate of the depth, so its sign tells on which side that is: Newton between bounds,
    which are halved where it is slow, until it gets there alone. Where it is beyond the arc, the Look is from there.
    """
    least, most, before = -math.inf, math.inf, math.inf
    here = look(floor, piece, roller, ANY, facing(floor, piece, roller))
    for _ in range(MOST_STEPS):
        slope = here.first_first - here.first_last * here.last_first / here.last_last
        rate = here.first - here.first_last * here.last / here.last_last
        if abs(rate) < NEAR * slope:
            found, known = newton(floor, piece, roller, ANY, here.at)
            if known:
                return found, known
        turn = here.at.first
        if (rate < 0.0 and turn >= LAST) or (rate > 0.0 and turn <= FIRST):
            return here, True
        if rate < 0.0:
            least = turn
        else:
            most = turn
        target = turn - rate / slope
        if not least < target < most or abs(rate) > 0.5 * before:
            target = 0.5 * (least + most)
        before = abs(rate)
        target = min(max(target, FIRST), LAST)
        last = -(here.last + here.last_first * (target - turn)) / here.last_last
        here = look(floor, piece, roller, ANY, Coordinates(target, here.at.last + last))
    return here, False


@outlined
def newton(floor, piece, roller, region, at):
    """The Look at the common normal to which these Coordinates lead, and whether they do."""
    here = look(floor, piece, roller, region, at)
    scale = roller.shape.radius
    for _ in range(MOST_STEPS):
        miss = here.first * here.first + here.last * here.last
        if miss == 0.0:
            return here, True
        first, last = newton_step(here)
        if abs(here.reach * first) + abs(last) < SMALL * scale:
            return look(floor, piece, roller, region, Coordinates(here.at.first + first, here.at.last + last)), True
        part = 1.0
        there = look(floor, piece, roller, region, Coordinates(here.at.first + first, here.at.last + last))
        for _ in range(MOST_HALVINGS):
            if there.first * there.first + there.last * there.last < miss:
                break
            part *= 0.5
            at = Coordinates(here.at.first + part * first, here.at.last + part * last)
            there = look(floor, piece, roller, region, at)
        if not there.first * there.first + there.last * there.last < miss:
            return here, miss < (ROUNDED * scale) ** 2
        here = there
    return here, False


@kernel
def newton_step(here):
    """What Newton adds to the two coordinates of a Look."""
    scarce = here.first_first * here.last_last - here.first_last * here.last_first
    first = (here.first_last * here.last - here.last_last * here.first) / scarce
    last = (here.last_first * here.first - here.first_first * here.last) / scarce
    return first, last


@kernel
def lowest(roller, region, nu):
    """The Low of a roller, in this region or ANY."""
    axis = roller.axis
    tilt = dot(nu, axis)
    up = combine(1.0, nu, -tilt, axis, 0.0, axis)
    across = max(math.sqrt(dot(up, up)), TINY)
    e = times(-1.0 / across, up)
    if region == ANY:
        region = region_of(roller.shape, tilt)
    found = support(roller.shape, region, tilt, across)
    return Low(nu, combine(1.0, roller.centre, found.u, axis, found.r, e), e, tilt, across, found, region)


@kernel
def look(floor, piece, roller, region, at):
    """The Look from these Coordinates of a piece."""
    here = patch(floor, piece, at)
    p, q, normal = here.p, here.q, here.normal
    size = math.sqrt(dot(normal, normal))
    low = lowest(roller, region, times(1.0 / size, normal))
    gap = minus(low.point, here.point)
    b, found = cross(roller.axis, low.e), low.support
    # P moves by `tipping` (a . dnu) - `swinging` (b . dnu), and dnu by that of the normal over its size, but along nu
    tipping = plus(times(found.u_rate / size, roller.axis), times(found.r_rate / size, low.e))
    swinging = times(found.r / (low.across * size), b)
    return Look(
        at,
        here.point,
        low,
        gap,
        dot(gap, p),
        dot(gap, q),
        moving(low, roller.axis, b, here.normal_first, dot(tipping, p), dot(swinging, p))
        + (dot(gap, here.p_first) - here.reach * dot(p, p)),
        moving(low, roller.axis, b, here.normal_last, dot(tipping, p), dot(swinging, p))
        + (dot(gap, here.p_last) - dot(p, q)),
        moving(low, roller.axis, b, here.normal_first, dot(tipping, q), dot(swinging, q))
        + (dot(gap, here.q_first) - here.reach * dot(p, q)),
        moving(low, roller.axis, b, here.normal_last, dot(tipping, q), dot(swinging, q))
        + (dot(gap, here.q_last) - dot(q, q)),
        here.reach,
    )


@kernel
def moving(low, axis, b, change, tipping, swinging):
    """How fast P moves along a tangent with the normal, which changes by `change` (Vec3): of it the part along nu does
    not turn nu, and none of that is along b."""
    return tipping * (dot(axis, change) - low.tilt * dot(low.nu, change)) - swinging * dot(b, change)


@kernel
def on_face(step, roller, region, low, point):
    """Low and X of a roller that the vertical face below an arc meets; what it is given if there is no face."""
    if step[4] <= step[5]:
        return low, point
    low = lowest(roller, region, Vec3(-step[2], -step[3], 0.0))
    s = beyond(step, low.point.x, low.point.y)
    return low, combine(1.0, low.point, s, low.nu, 0.0, low.nu)
