r"""Convex parts of rollers that are neither exact nor barrels, for the spatial oracle. SI units, radians.

A part is a hull of circles in the half-plane (u, r), each seen under normals that lean by `low` to `high` towards -u:

    lowest point where the axis rises by s = sin f:   (u - rho sin g, r + rho cos g),  g = f kept within low and high,
    of the circle where -u s + r cos f is largest

Straight lines of a generatrix part a roller: at each end of a line the part goes on inside the roller. BEND after the
line's direction a circle follows that turns by BEND over its share of the line, then its end is a corner.
"""

from itertools import pairwise
from math import asin, atan2, cos, hypot, inf, pi, sin, sqrt
from typing import NamedTuple

import numpy as np

BEND = 5e-3
LEVEL = 0.5 * pi


class Circle(NamedTuple):
    u: float
    r: float
    rho: float
    low: float
    high: float

    def at(self, lean: float) -> tuple[float, float]:
        return self.u - self.rho * sin(lean), self.r + self.rho * cos(lean)

    @property
    def mirrored(self) -> "Circle":
        return Circle(-self.u, self.r, self.rho, -self.high, -self.low)


class Hull(NamedTuple):
    circles: list[Circle]
    reach: float

    def lowest(self, s: float) -> tuple[float, float]:
        lean, best, found = asin(min(max(s, -1.0), 1.0)), -inf, (0.0, 0.0)
        for circle in self.circles:
            u, r = circle.at(min(max(lean, circle.low), circle.high))
            if -u * s + r * sqrt(1.0 - s**2) > best:
                best, found = -u * s + r * sqrt(1.0 - s**2), (u, r)
        return found


def inner(circle: Circle, line: float) -> list[Circle]:
    """A circle with a line of this length towards -u, in what it has of it."""
    lean = circle.high + BEND
    u, r = circle.at(lean)
    rho = line / BEND
    turned = Circle(u + rho * sin(lean), r - rho * cos(lean), rho, lean, lean + BEND)
    return [Circle(*turned.at(lean + BEND), 0.0, lean + BEND, LEVEL), turned, circle._replace(high=lean)]


def sides(circles: list[Circle]) -> list[list[Circle]]:
    """Parts at u < 0, and their mirror images."""
    return [circles, [circle.mirrored for circle in circles]]


def parts_of(profile: dict) -> list[Hull]:
    kind, radius, half = profile["kind"], profile.get("radius"), profile.get("half_length")
    if kind == "sphere":
        found = [[Circle(0.0, 0.0, radius, -LEVEL, LEVEL)]]
    elif kind in ("cylinder", "capsule"):
        e = radius if kind == "capsule" else profile.get("edge_radius", 0.0)
        # the left one, whose line is towards +u
        right = inner(Circle(half - e, radius - e, e, -LEVEL, 0.0), half - e)
        found = sides([circle.mirrored for circle in right])
    elif kind == "cone":
        slope, line = atan2(radius - profile["end_radius"], half), 0.5 * hypot(radius - profile["end_radius"], half)
        crest = inner(Circle(0.0, radius, 0.0, -slope, slope), line)
        crest = [*crest[:2], *(c.mirrored for c in crest[:2]), crest[2]._replace(low=-slope - BEND)]
        end = inner(Circle(half, profile["end_radius"], 0.0, -LEVEL, -slope), line)
        left, right = sides([circle.mirrored for circle in end])
        found = [left, crest, right]
    elif kind == "stepped":
        ends = np.cumsum(profile["lengths"]).tolist()
        right = [
            inner(Circle(end, r, 0.0, -LEVEL, 0.0), length)
            for end, r, length in zip(ends, profile["radii"], profile["lengths"], strict=True)
        ]
        left = [[circle.mirrored for circle in one] for one in right]
        found = [*reversed(left), *right]
    elif kind == "points":
        found = [through(list(zip(profile["axial"], profile["radius"], strict=True)))]
    else:
        raise ValueError(f"the oracle has no profile {kind!r}")
    corners = [circle.at(lean) for one in found for circle in one for lean in (circle.low, circle.high)]
    return [Hull(one, max(hypot(*corner) for corner in corners) + 1e-3) for one in found]


def through(points: list[tuple[float, float]]) -> list[Circle]:
    """Two circles between each two points: they meet in the incentre of the points and of where their tangents meet."""
    leans = [lean_at(points, i) for i in range(len(points))]
    circles = []
    for (a, b), (start, end) in zip(pairwise(points), pairwise(leans), strict=True):
        # where a + x (cos start, sin start) meets b - y (cos end, sin end)
        system = np.array([[cos(start), cos(end)], [sin(start), sin(end)]])
        x, _ = np.linalg.solve(system, np.subtract(b, a))
        tip = np.array([a[0] + x * cos(start), a[1] + x * sin(start)])
        sizes = np.array([np.linalg.norm(tip - b), np.linalg.norm(tip - a), np.linalg.norm(np.subtract(b, a))])
        middle = (sizes[0] * np.array(a) + sizes[1] * np.array(b) + sizes[2] * tip) / sizes.sum()
        chord = atan2(b[1] - a[1], b[0] - a[0])
        for point, lean, (low, high) in ((a, start, (chord, start)), (b, end, (end, chord))):
            way = np.array(point) - middle
            inwards = np.array([sin(lean), -cos(lean)])
            rho = -(way @ way) / (2.0 * way @ inwards)
            circles.append(Circle(*(np.array(point) + rho * inwards), rho, low, high))
    first = Circle(*points[0], 0.0, leans[0], LEVEL)
    return [first, *circles, Circle(*points[-1], 0.0, -LEVEL, leans[-1])]


def lean_at(points: list[tuple[float, float]], i: int) -> float:
    """Of the tangent of the circle through a point and its neighbours."""
    k = min(max(i - 1, 0), len(points) - 3)
    a, b, c = (np.array(point) for point in points[k : k + 3])
    centre = np.linalg.solve(2.0 * np.array([b - a, c - a]), np.array([b @ b - a @ a, c @ c - a @ a]))
    u, r = np.array(points[i]) - centre
    return atan2(-u, r)
