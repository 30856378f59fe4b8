"""The rollers of a wheel type as a workshop sees them, whatever their profile: without kernels.

The exact profile has closed forms of its own, in solids.py; all others are chains of arcs, see generatrix.py.
"""

import math
from itertools import permutations
from typing import NamedTuple

import numpy as np

from omnisim.base.keeping import kept
from omnisim.scene import solids
from omnisim.scene.generatrix import Arc, Generatrix, both, edge, ends, generatrix
from omnisim.scene.generatrix import thickest as thickest_of
from omnisim.scene.solids import Solid
from omnisim.scene.wheel_schema import WheelType

Points = tuple[np.ndarray, np.ndarray]
AZIMUTHS = 1001  # of a pitch, for heights
REFINED = 40  # halvings of what is around the lowest and the highest of them


# --- one roller -----------------------------------------------------------------------------------


def drawn(kind: WheelType, count: int) -> Points:
    """u and r along the generatrix, m, (K,): about `count` of them, all its corners among them."""
    if kind.profile.kind == "exact":
        return solids.profile(solids.outline(kind), np.linspace(-kind.covered, kind.covered, count))
    arcs = generatrix(kind.profile)
    round_ = [arc for arc in arcs if arc.radius > 0.0]
    turned = math.fsum(swept(arc) for arc in round_)
    points: list[Points] = []
    for arc in arcs:
        pieces = max(2, math.ceil((count - 1) * swept(arc) / turned)) if arc.radius > 0.0 else 0
        points.append(along(arc, np.linspace(math.asin(arc.start), math.asin(arc.end), pieces + 1)))
    u, r = np.concatenate([each[0] for each in points]), np.concatenate([each[1] for each in points])
    new = np.append(True, np.hypot(np.diff(u), np.diff(r)) > 1e-12 * thickest(kind))
    return u[new], np.maximum(r[new], 0.0)


def swept(arc: Arc) -> float:
    return math.asin(arc.start) - math.asin(arc.end)


def along(arc: Arc, angles: np.ndarray) -> Points:
    """u and r of an arc where its normal leans by these angles towards -u (rad), m."""
    return arc.u - arc.radius * np.sin(angles), arc.r + arc.radius * np.cos(angles)


def farthest(kind: WheelType, sine: np.ndarray) -> list[Points]:
    """u and r of the points that reach farthest in directions whose components along the axis are `sine`, m.

    One for each convex solid that makes a roller up: of a stepped one these are cylinders, each from end to end.
    """
    profile = kind.profile
    if profile.kind == "exact":
        return [solids.farthest(solids.outline(kind), sine)]
    if profile.kind != "stepped":
        return [farthest_of(generatrix(profile), sine)]
    ends = np.cumsum(profile.lengths).tolist()
    cylinders = [both([edge(-end, radius, 1.0, 0.0)]) for end, radius in zip(ends, profile.radii, strict=True)]
    return [farthest_of(arcs, sine) for arcs in cylinders]


def farthest_of(arcs: Generatrix, sine: np.ndarray) -> Points:
    across = np.sqrt(1.0 - sine * sine)
    tilts = [np.clip(-sine, arc.end, arc.start) for arc in arcs]
    u = np.array([arc.u - arc.radius * tilt for arc, tilt in zip(arcs, tilts, strict=True)])
    r = np.array([arc.r + arc.radius * np.sqrt(1.0 - tilt**2) for arc, tilt in zip(arcs, tilts, strict=True)])
    best = (u * sine + r * across).argmax(axis=0)[None]
    return np.take_along_axis(u, best, 0)[0], np.take_along_axis(r, best, 0)[0]


def reaches(kind: WheelType, sine: np.ndarray) -> list[np.ndarray]:
    """How far each of these solids reaches from the roller's centre, m."""
    across = np.sqrt(1.0 - sine * sine)
    return [u * sine + r * across for u, r in farthest(kind, sine)]


def reach(kind: WheelType, sine: np.ndarray) -> np.ndarray:
    """How far a roller does."""
    return np.max(reaches(kind, sine), axis=0)


def thickest(kind: WheelType) -> float:
    """Radius of a roller where it is largest, m."""
    if kind.profile.kind == "exact":
        return kind.radius - kind.roller_distance
    return thickest_of(generatrix(kind.profile))


def bending(kind: WheelType) -> float:
    """The largest radius of curvature of the generatrix where it touches, m: what hollow ground should not have."""
    if kind.profile.kind == "exact":
        cos = math.cos(math.radians(kind.roller_angle_deg))
        return kind.radius - kind.roller_distance + kind.roller_distance / cos**2
    return max(arc.radius for arc in generatrix(kind.profile))


def roller_solid(kind: WheelType) -> Solid:
    """Of a roller with its bore, a cylinder from end to end. Where r is less than that of the bore nothing is left.

    The integrals of solids.solid, along every arc and every line.
    """
    bore = kind.roller.bore_radius
    if kind.profile.kind == "exact":
        return solids.solid(solids.outline(kind), bore)
    nodes, weights = np.polynomial.legendre.leggauss(solids.NODES)
    whole = np.zeros(3)
    for u, r, slope in pieces_of(generatrix(kind.profile), bore, nodes):
        du = np.pi * weights * slope
        ring, fourth = r**2 - bore**2, r**4 - bore**4
        whole += ring @ du, 0.5 * fourth @ du, (0.25 * fourth + ring * u**2) @ du
    return Solid(*map(float, whole))


def pieces_of(arcs: Generatrix, bore: float, nodes: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """u, r and du by node, of every arc and line as far as r is above the bore, where nodes are from -1 to 1."""
    found = []
    last: tuple[float, float] | None = None
    for arc in arcs:
        here = arc.at(arc.start)
        if last is not None and here[0] > last[0]:
            first, end = (bored(*pair, bore) for pair in ((last, here), (here, last)))
            half = 0.5 * (end[0] - first[0])
            if half > 0.0:
                part = 0.5 * (1.0 + nodes)
                u, r = (a + part * (b - a) for a, b in zip(first, end, strict=True))
                found.append((u, r, np.full_like(nodes, half)))
        if arc.radius > 0.0:
            most = math.acos(min(1.0, max(-1.0, (bore - arc.r) / arc.radius)))
            start, stop = min(math.asin(arc.start), most), max(math.asin(arc.end), -most)
            if start > stop:
                angles = 0.5 * (start + stop) - 0.5 * (start - stop) * nodes
                u, r = along(arc, angles)
                found.append((u, r, 0.5 * (start - stop) * arc.radius * np.cos(angles)))
        last = arc.at(arc.end)
    return found


def bored(end: tuple[float, float], other: tuple[float, float], bore: float) -> tuple[float, float]:
    """The end of a line, or where it comes out of the bore."""
    if end[1] >= bore or other[1] <= bore:
        return end if end[1] >= bore else other
    part = (bore - end[1]) / (other[1] - end[1])
    return end[0] + part * (other[0] - end[0]), bore


# --- rollers on their wheel -----------------------------------------------------------------------


def gap(kind: WheelType, turn: float, aside: float = 0.0) -> float:
    """Distance between the surfaces of two rollers a turn (rad) apart, m, of which the one behind stands `aside` (m)
    of the one ahead along the axle; below 0 they overlap: see solids.gap.

    Turned by half a turn one is the other with its ends swapped: what counts of it is its reach the other way.
    """
    psi = math.radians(kind.roller_angle_deg)
    b = np.linspace(-0.5 * np.pi, 0.5 * np.pi, solids.DIRECTIONS)
    along = np.clip(np.cos(b) * math.cos(psi) * math.cos(0.5 * turn) + np.sin(b) * math.sin(psi), -1.0, 1.0)
    room = 2.0 * np.cos(b) * kind.roller_distance * math.sin(0.5 * turn) + np.sin(b) * aside
    return min(float((room - one - other).max()) for one in reaches(kind, along) for other in reaches(kind, -along))


def gap_in_row(kind: WheelType) -> float:
    """The gap between neighbours of a row."""
    return gap(kind, 2.0 * math.pi / kind.roller_count)


def gap_between_rows(kind: WheelType) -> float:
    """The least gap between rollers of different rows, m; infinite of one row."""
    rings, found = kind.rings, [math.inf]
    for behind, ahead in permutations(range(len(rings)), 2):
        turn = (rings[ahead].phase_deg - rings[behind].phase_deg) % (360.0 / kind.roller_count)
        found.append(gap(kind, math.radians(turn), rings[behind].offset - rings[ahead].offset))
    return min(found)


def hub_radius(kind: WheelType) -> float:
    """Of the largest cylinder about the axle that no roller enters, m; 0 if rollers reach the axle."""
    return max(kind.roller_distance - thickest(kind), 0.0)


def half_length(kind: WheelType) -> float:
    """Of a roller, m: the longer half if it is not symmetric."""
    if kind.profile.kind == "exact":
        return float(solids.profile(solids.outline(kind), np.array(kind.covered))[0])
    return max(map(abs, ends(generatrix(kind.profile))))


def end_radius(kind: WheelType) -> float:
    """Of a roller at its end, m: that of its end disc."""
    return float(drawn(kind, 2)[1][-1])


def half_width(kind: WheelType) -> float:
    """Of a wheel, m: rollers are thick amid, and their axes long across the wheel."""
    across = half_length(kind) * abs(math.sin(math.radians(kind.roller_angle_deg)))
    return max(thickest(kind), across) + max(abs(row.offset) for row in kind.rows)


class Rolling(NamedTuple):
    """Of an upright wheel rolling straight ahead on rigid ground: lowest, mean and highest height of its centre, m.

    That is its rolling radius: rollers turn freely about their axes, which lie in the vertical plane of the contact
    normal, so that along the axis V_h - phi' H = 0.
    """

    lowest: float
    mean: float
    highest: float


def azimuths(kind: WheelType) -> np.ndarray:
    """Of all rollers at spin angle 0, rad from straight down."""
    turns = 2.0 * np.pi * np.arange(kind.roller_count) / kind.roller_count
    return np.add.outer(turns, np.radians([row.phase_deg for row in kind.rings])).ravel()


def heights(kind: WheelType, angles: np.ndarray) -> np.ndarray:
    """Of the centre of an upright wheel at these spin angles (rad), m: max of R1 cos q + reach(c sin q)."""
    cos, near = math.cos(math.radians(kind.roller_angle_deg)), math.cos(2.0 * math.pi / kind.roller_count)
    found = np.full(np.shape(angles), -np.inf)
    for first in azimuths(kind):
        q = first - angles
        if np.cos(q).max() < near:
            continue  # one of its row is lower
        found = np.maximum(found, kind.roller_distance * np.cos(q) + reach(kind, cos * np.sin(q)))
    return found


@kept
def rolling(kind: WheelType) -> Rolling:
    """Over a pitch, after which every height comes again."""
    pitch = 2.0 * math.pi / kind.roller_count
    angles = np.linspace(0.0, pitch, AZIMUTHS)
    found = heights(kind, angles)
    mean = 0.5 * (found[:-1] + found[1:]).mean()
    low, high = (refined(kind, angles[at], pitch / (AZIMUTHS - 1), sign) for at, sign in
                 ((found.argmin(), -1.0), (found.argmax(), 1.0)))  # fmt: skip
    return Rolling(low, float(mean), high)


def refined(kind: WheelType, angle: float, step: float, sign: float) -> float:
    """The lowest (sign -1) or highest height around an angle."""
    best = angle
    for _ in range(REFINED):
        around = best + step * np.linspace(-1.0, 1.0, 5)
        found = heights(kind, around)
        best, step = float(around[(sign * found).argmax()]), 0.5 * step
    return float(heights(kind, np.array([best]))[0])
