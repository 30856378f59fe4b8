"""The generatrix of a roller that is not the exact one: arcs of circles, joined by straight lines.

    r    lobe    line     lobe              u, r     axial and radial coordinate, m
      .-'---------------------'-.           tilt     nu . a where the point is lowest: of its normal, towards -u
     |                           |          arc      u = u_c - radius tilt, r = r_c + radius sqrt(1 - tilt^2)
    -+------------- 0 -----------+--> u     edge     an arc of radius 0

Along u the tilt falls from 1 to -1 as long as the generatrix bulges; at the foot of a step it rises again.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from omnisim.scene.ground_schema import Profile

Point = tuple[float, float]


class Arc(NamedTuple):
    """Its centre (u, r) and radius, m, and the tilt where it starts and ends."""

    u: float
    r: float
    radius: float
    start: float
    end: float

    def at(self, tilt: float) -> tuple[float, float]:
        """u and r where the tilt is this, m."""
        return self.u - self.radius * tilt, self.r + self.radius * math.sqrt(1.0 - tilt * tilt)

    @property
    def bulges(self) -> bool:
        return self.start >= self.end


Generatrix = tuple[Arc, ...]


def thickest(arcs: Generatrix) -> float:
    """r where it is largest, m."""
    return max(arc.at(min(max(0.0, arc.end), arc.start))[1] for arc in arcs if arc.bulges)


def ends(arcs: Generatrix) -> tuple[float, float]:
    """u where a generatrix begins and ends, m."""
    return arcs[0].at(arcs[0].start)[0], arcs[-1].at(arcs[-1].end)[0]


def edge(u: float, r: float, start: float, end: float) -> Arc:
    return Arc(u, r, 0.0, start, end)


def generatrix(profile: Profile) -> Generatrix:
    """Of a profile that is not the exact one, along u."""
    return KINDS[profile.kind](profile)


def number(value: float | tuple[float, ...]) -> float:
    """The radius of a profile that has one."""
    assert isinstance(value, float)
    return value


def numbers(value: float | tuple[float, ...]) -> tuple[float, ...]:
    """Those of a profile by points."""
    assert isinstance(value, tuple)
    return value


def mirrored(arcs: Sequence[Arc]) -> list[Arc]:
    """The same seen from the other end."""
    return [Arc(-arc.u, arc.r, arc.radius, -arc.end, -arc.start) for arc in reversed(arcs)]


def both(half: Sequence[Arc]) -> Generatrix:
    """The half at u < 0, and its mirror image."""
    return (*half, *mirrored(half))


def barrel(profile: Profile) -> Generatrix:
    rho, half, middle = profile.curvature_radius, profile.half_length, number(profile.radius)
    end, tilt = middle - rho + math.sqrt(rho**2 - half**2), half / rho
    return edge(-half, end, 1.0, tilt), Arc(0.0, middle - rho, rho, tilt, -tilt), edge(half, end, -tilt, -1.0)


def cylinder(profile: Profile) -> Generatrix:
    e = profile.edge_radius
    return both([Arc(e - profile.half_length, number(profile.radius) - e, e, 1.0, 0.0)])


def capsule(profile: Profile) -> Generatrix:
    radius = number(profile.radius)
    return both([Arc(radius - profile.half_length, 0.0, radius, 1.0, 0.0)])


def sphere(profile: Profile) -> Generatrix:
    return (Arc(0.0, 0.0, number(profile.radius), 1.0, -1.0),)


def cone(profile: Profile) -> Generatrix:
    middle, end, half = number(profile.radius), profile.end_radius, profile.half_length
    tilt = (middle - end) / math.hypot(middle - end, half)
    return edge(-half, end, 1.0, tilt), edge(0.0, middle, tilt, -tilt), edge(half, end, -tilt, -1.0)


def stepped(profile: Profile) -> Generatrix:
    """Each cylinder with its outer edge; between two of them the foot of the step."""
    half: list[Arc] = []
    ends = [math.fsum(profile.lengths[: i + 1]) for i in range(len(profile.lengths))]
    for i in reversed(range(len(ends))):
        if half:
            half.append(edge(-ends[i], profile.radii[i + 1], 0.0, 1.0))
        half.append(edge(-ends[i], profile.radii[i], 1.0, 0.0))
    return both(half)


def through_points(profile: Profile) -> Generatrix:
    """Two arcs between each two points, with one tangent where they meet; in a point it is that of the circle through
    it and its neighbours. All of them bulge if the points do."""
    points = list(zip(profile.axial, numbers(profile.radius), strict=True))
    befores = [max(0, min(i - 1, len(points) - 3)) for i in range(len(points))]
    angles = [tangent(points[k], points[k + 1], points[k + 2], at) for k, at in zip(befores, points, strict=True)]
    arcs: list[Arc] = []
    for a, b, start, end in zip(points, points[1:], angles, angles[1:], strict=False):
        arcs += two_arcs(a, b, start, end)
    return edge(*points[0], 1.0, arcs[0].start), *arcs, edge(*points[-1], arcs[-1].end, -1.0)


def tangent(a: Point, b: Point, c: Point, at: Point) -> float:
    """Angle of the circle through three points at one of them, rad, > 0 where r grows: chord and tangent enclose the
    angle that the chord is seen under. At the end of a generatrix it is at most upright."""
    first, last, whole = rise(a, b), rise(b, c), rise(a, c)
    if at == a:
        return min(first - last + whole, 0.5 * math.pi)
    if at == c:
        return max(last - first + whole, -0.5 * math.pi)
    return first + last - whole


def rise(a: Point, b: Point) -> float:
    return math.atan2(b[1] - a[1], b[0] - a[0])


def two_arcs(a: Point, b: Point, start: float, end: float) -> list[Arc]:
    """From a to b, tangents at these angles: the tangent where they meet is along the chord.

    They turn by f and l and rise over the chord by h:  h (cot(f / 2) + cot(l / 2)) = |b - a|,  radius = h / (1 - cos f)
    """
    chord = rise(a, b)
    first, last = start - chord, chord - end
    h = math.dist(a, b) / (1.0 / math.tan(0.5 * first) + 1.0 / math.tan(0.5 * last))
    found = []
    for point, angle, by, span in ((a, start, first, (start, chord)), (b, end, last, (chord, end))):
        radius = 0.5 * h / math.sin(0.5 * by) ** 2
        u, r = point[0] + radius * math.sin(angle), point[1] - radius * math.cos(angle)
        found.append(Arc(u, r, radius, math.sin(span[0]), math.sin(span[1])))
    return found


KINDS: dict[str, Callable[[Profile], Generatrix]] = {
    "arc": barrel,
    "cylinder": cylinder,
    "capsule": capsule,
    "sphere": sphere,
    "cone": cone,
    "stepped": stepped,
    "points": through_points,
}
