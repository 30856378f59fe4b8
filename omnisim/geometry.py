"""What a workshop asks of a wheel: the roller's profile and volume, room between rollers, ripple of other shapes.

Vectors are in the frame of the wheel at spin angle 0: x along h (heading), y along k (axle, left), z up; m.
`wheel` is a row of `Parameters.wheels`.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from omnisim.config import Wheel, WheelType
from omnisim.packing import wheel_values
from omnisim.parameters import WHEEL
from omnisim.records import records
from omnisim.roller import axial_coordinate, drop, length, profile_radius, support_parameter

NODES = 40  # of Gauss and Legendre: integrals of a profile are exact to rounding
DIRECTIONS = 2001  # tried for the gap: none of them can make it too large
AZIMUTHS = 1001  # of half a pitch, for the ripple
SPHERES = 3  # of a roller that is a row of them


def of_type(kind: WheelType) -> np.record:
    """The record of a wheel of this type, not mirrored."""
    values = wheel_values(kind, Wheel(name="wheel", type="wheel"), np.zeros(2))
    return records(WHEEL, [values | {"rates": 0}])[0]


# --- the roller -----------------------------------------------------------------------------------


def profile(wheel: np.record, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(q) and r(q), m, of roller.py at every profile parameter q (rad)."""
    return np.array([axial_coordinate(wheel, x) for x in q]), np.array([profile_radius(wheel, x) for x in q])


class Solid(NamedTuple):
    """A solid of revolution at density 1: volume (m^3), moments of inertia about and across its axis (m^5)."""

    volume: float
    axial: float
    transverse: float


def solid(wheel: np.record) -> Solid:
    """V = int pi r^2 du, axial int pi/2 r^4 du, transverse int pi (r^4 / 4 + r^2 u^2) du.

    du/dq = R1 (1 / c - c sin^2 q) / cos^2 q + h_q c cos q.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    q, c = wheel.alpha * nodes, wheel.cos_psi
    u, r = profile(wheel, q)
    h = np.array([drop(wheel, x) for x in q])
    slope = wheel.roller_distance * (1.0 / c - c * np.sin(q) ** 2) / np.cos(q) ** 2 + h * c * np.cos(q)
    du = np.pi * wheel.alpha * weights * slope
    return Solid(r**2 @ du, 0.5 * r**4 @ du, (0.25 * r**4 + (r * u) ** 2) @ du)


def support(wheel: np.record, sine: float) -> float:
    """How far the roller reaches from its centre in a direction whose component along its axis is `sine`, m."""
    q = support_parameter(wheel, -sine)
    return axial_coordinate(wheel, q) * sine + profile_radius(wheel, q) * math.sqrt(1.0 - sine * sine)


# --- rollers on their wheel -----------------------------------------------------------------------


def roller_frames(kind: WheelType, mirrored: bool = False, phase: float = 0.0) -> list[tuple[np.ndarray, np.ndarray]]:
    """Centre R1 d and axis a = c t + s k of every roller; phase: azimuth of roller 0, rad."""
    azimuths = phase + 2.0 * np.pi * np.arange(kind.roller_count) / kind.roller_count
    psi = math.radians(-kind.roller_angle_deg if mirrored else kind.roller_angle_deg)
    sine, cosine, zero = np.sin(azimuths), np.cos(azimuths), np.zeros(kind.roller_count)
    centres = kind.roller_distance * np.column_stack([sine, zero, -cosine])
    axes = np.column_stack([-math.cos(psi) * cosine, zero + math.sin(psi), -math.cos(psi) * sine])
    return list(zip(centres, axes, strict=True))


def gap(wheel: np.record, pitches: int = 1) -> float:
    """Distance between the surfaces of two rollers `pitches` apart, m; below 0 they overlap.

    Between convex bodies A and B every unit vector n has n . (B - A) - reach of A along n - reach of B along -n, and
    the largest of these is the distance: a finite number of n never makes it too large. Half a turn about the radius
    midway swaps the rollers, so the best n is at right angles to it: n = cos b along the rim + sin b along the axle,

        distance = 2 max_b [cos b R1 sin g - reach(cos b c cos g + sin b s)],    g = pitches * alpha
    """
    g, best = pitches * wheel.alpha, -math.inf
    for b in np.linspace(-0.5 * np.pi, 0.5 * np.pi, DIRECTIONS):
        along = math.cos(b) * wheel.cos_psi * math.cos(g) + math.sin(b) * wheel.sin_psi
        best = max(best, math.cos(b) * wheel.roller_distance * math.sin(g) - support(wheel, min(1.0, max(-1.0, along))))
    return 2.0 * best


def hub_radius(wheel: np.record) -> float:
    """Of the largest cylinder about the axle that no roller enters, m; 0 if rollers reach the axle."""
    return max(2.0 * wheel.roller_distance - wheel.radius, 0.0)


# --- rollers of another shape ---------------------------------------------------------------------


def shapes(wheel: np.record) -> dict[str, Callable[[np.ndarray], np.ndarray]]:
    """Shapes that stand for the exact roller, by how far they reach, m, in a direction: see `support`.

    Ellipse, capsule and cylinder are as long and, amid, as thick as the roller. A sphere about the point of the axis
    above the contact, R1 tan q / c from the middle, with radius h_q touches the profile from within at q.
    """
    half, middle = 0.5 * length(wheel), profile_radius(wheel, 0.0)
    straight = max(half - middle, 0.0)
    at = wheel.alpha * (2.0 * np.arange(SPHERES) + 1.0 - SPHERES) / SPHERES
    places = wheel.roller_distance * np.tan(at) / wheel.cos_psi
    radii = np.array([drop(wheel, q) for q in at])
    return {
        "exact": lambda s: np.array([support(wheel, x) for x in s]),
        "ellipse": lambda s: np.hypot(half * s, middle * np.sqrt(1.0 - s**2)),
        "capsule": lambda s: straight * np.abs(s) + middle,
        "cylinder": lambda s: half * np.abs(s) + middle * np.sqrt(1.0 - s**2),
        f"{SPHERES} spheres": lambda s: (np.multiply.outer(s, places) + radii).max(axis=-1),
    }


class Ripple(NamedTuple):
    """Of a wheel rolling straight ahead: lowest, mean and highest rolling radius, m.

    It is the height of the wheel's centre: the roller turns freely about its axis, which lies in the vertical plane of
    the contact normal, so along the axis V_h - phi' H = 0.
    """

    lowest: float
    mean: float
    highest: float


def ripple(wheel: np.record, reach: Callable[[np.ndarray], np.ndarray]) -> Ripple:
    """Centre height H = max over rollers of R1 cos q + reach(c sin q), over half a pitch: it is even about a roller."""
    q = np.linspace(0.0, wheel.alpha, AZIMUTHS)
    azimuths = [q + 2.0 * wheel.alpha * other for other in (-1, 0, 1)]
    heights = np.max([wheel.roller_distance * np.cos(x) + reach(wheel.cos_psi * np.sin(x)) for x in azimuths], axis=0)
    mean = 0.5 * (heights[:-1] + heights[1:]).mean()
    return Ripple(float(heights.min()), float(mean), float(heights.max()))
