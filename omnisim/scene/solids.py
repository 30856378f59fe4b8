"""Solids of known shape, without kernels: the roller by its profile, with a bore; the disk of a wheel.

Vectors are in the frame of the wheel at spin angle 0: x along h (heading), y along k (axle, left), z up; m.
`wheel` is an Outline, or a row of `Parameters.wheels`, which has the same names.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.scene.wheel_schema import Disk, WheelType

NODES = 40  # of Gauss and Legendre: integrals of a profile are exact to rounding
HALVINGS = 60  # of the interval that holds the end of a bore: to rounding
DIRECTIONS = 2001  # tried for the gap: none of them can make it too large


class Outline(NamedTuple):
    """What the shape of a wheel's rollers follows from: R and R1 (m), the angle alpha of its end (rad), and psi."""

    radius: float
    roller_distance: float
    alpha: float
    cos_psi: float
    sin_psi: float


Shape = Outline | np.record  # a wheel's record has these fields as well


def outline(kind: WheelType) -> Outline:
    psi = math.radians(kind.roller_angle_deg)
    return Outline(kind.radius, kind.roller_distance, kind.covered, math.cos(psi), math.sin(psi))


# --- the roller -----------------------------------------------------------------------------------


def profile(wheel: Shape, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u(q) and r(q), m, of roller_profile.py at every profile parameter q (rad)."""
    h = wheel.radius - wheel.roller_distance / np.cos(q)
    c = wheel.cos_psi
    u = wheel.roller_distance * np.tan(q) / c + h * c * np.sin(q)
    return u, np.maximum(h, 0.0) * np.sqrt(1.0 - (c * np.sin(q)) ** 2)


class Solid(NamedTuple):
    """A solid of revolution at density 1: volume (m^3), moments of inertia about and across its axis (m^5)."""

    volume: float
    axial: float
    transverse: float


def solid(wheel: Shape, bore: float = 0.0) -> Solid:
    """The exact profile less a cylindrical bore of radius b (m) from end to end. Where r < b nothing is left.

        V = int pi (r^2 - b^2) du                         axial = int pi/2 (r^4 - b^4) du
        transverse = int pi ((r^4 - b^4) / 4 + (r^2 - b^2) u^2) du

    du/dq = R1 (1 / c - c sin^2 q) / cos^2 q + h_q c cos q.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    end = bored_end(wheel, bore)
    c = wheel.cos_psi
    q = end * nodes
    u, r = profile(wheel, q)
    h = wheel.radius - wheel.roller_distance / np.cos(q)
    slope = wheel.roller_distance * (1.0 / c - c * np.sin(q) ** 2) / np.cos(q) ** 2 + h * c * np.cos(q)
    du = np.pi * end * weights * slope
    ring, fourth = r**2 - bore**2, r**4 - bore**4
    return Solid(float(ring @ du), float(0.5 * fourth @ du), float((0.25 * fourth + ring * u**2) @ du))


def bored_end(wheel: Shape, bore: float) -> float:
    """The profile parameter where r = b, rad; alpha if the tips are thicker than the bore. r falls with q."""
    if profile(wheel, np.array(wheel.alpha))[1] >= bore:
        return wheel.alpha
    low, high = 0.0, wheel.alpha
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if profile(wheel, np.array(middle))[1] > bore else (low, middle)
    return low


def farthest(wheel: Shape, sine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """u and r of the point that reaches farthest in directions whose components along the axis are `sine`, m."""
    return profile(wheel, np.clip(np.arcsin(np.clip(sine / wheel.cos_psi, -1.0, 1.0)), -wheel.alpha, wheel.alpha))


def support(wheel: Shape, sine: np.ndarray) -> np.ndarray:
    """How far the roller reaches from its centre in these directions, m."""
    u, r = farthest(wheel, sine)
    return u * sine + r * np.sqrt(1.0 - sine * sine)


# --- the disk -------------------------------------------------------------------------------------


def disk_solid(disk: Disk) -> Solid:
    """The hub, a cylinder with a bore, and a plate around each of its ends: rings of radii b < a, length l, middle z.

    V = sum pi (a^2 - b^2) l                          axle = sum pi/2 (a^4 - b^4) l
    diameter = axle / 2 + sum pi (a^2 - b^2) l (l^2 / 12 + z^2)
    """
    aside = 0.5 * (disk.width - disk.plate_thickness)
    rings = [(disk.hub_radius, disk.bore_radius, disk.width, 0.0)]
    rings += [(disk.plate_radius, disk.hub_radius, disk.plate_thickness, z) for z in (-aside, aside)]
    volumes = [math.pi * (a * a - b * b) * l for a, b, l, _ in rings]
    axle = sum(0.5 * volume * (a * a + b * b) for volume, (a, b, _, _) in zip(volumes, rings, strict=True))
    spread = sum(volume * (l * l / 12.0 + z * z) for volume, (_, _, l, z) in zip(volumes, rings, strict=True))
    return Solid(sum(volumes), axle, 0.5 * axle + spread)


# --- rollers on their wheel -----------------------------------------------------------------------


def gap(wheel: Shape, pitches: float = 1) -> float:
    """Distance between the surfaces of two rollers `pitches` apart, m; below 0 they overlap.

    Between convex bodies A and B every unit vector n has n . (B - A) - reach of A along n - reach of B along -n, and
    the largest of these is the distance: a finite number of n never makes it too large. Half a turn about the radius
    midway swaps the rollers, so the best n is at right angles to it: n = cos b along the rim + sin b along the axle,

        distance = 2 max_b [cos b R1 sin g - reach(cos b c cos g + sin b s)],    g = pitches * alpha
    """
    g = pitches * wheel.alpha
    b = np.linspace(-0.5 * np.pi, 0.5 * np.pi, DIRECTIONS)
    along = np.cos(b) * wheel.cos_psi * math.cos(g) + np.sin(b) * wheel.sin_psi
    room = np.cos(b) * wheel.roller_distance * math.sin(g) - support(wheel, np.clip(along, -1.0, 1.0))
    return 2.0 * float(room.max())


def pitches(kind: WheelType, turn_deg: float) -> float:
    """An angle by that over which the profile of a roller is cut."""
    return math.radians(turn_deg) / (2.0 * kind.covered)


def hub_radius(wheel: Shape) -> float:
    """Of the largest cylinder about the axle that no roller enters, m; 0 if rollers reach the axle."""
    return max(2.0 * wheel.roller_distance - wheel.radius, 0.0)


def ring_half_width(wheel: Shape) -> float:
    """Of a ring of rollers, m: they are thick amid, and their axes long across the wheel."""
    across = float(profile(wheel, np.array(wheel.alpha))[0]) * abs(wheel.sin_psi)
    return max(wheel.radius - wheel.roller_distance, across)
