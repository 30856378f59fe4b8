"""What a workshop asks of a wheel: the roller's profile and volume, room between rollers, ripple of other shapes.

Solids, gaps and the hub stand in solids.py, which needs no kernels.

Vectors are in the frame of the wheel at spin angle 0: x along h (heading), y along k (axle, left), z up; m.
`wheel` is a row of `Parameters.wheels`.
"""

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from omnisim.base.records import records
from omnisim.contact.roller_profile import length, profile_radius
from omnisim.dynamics.parameters import WHEEL
from omnisim.dynamics.wheel_values import heading_values, placed_values, shared_values
from omnisim.scene import rollers
from omnisim.scene.drives import drive_law
from omnisim.scene.schema import Wheel
from omnisim.scene.solids import Shape, Solid, gap, hub_radius, outline, profile, solid, support
from omnisim.scene.wheel_schema import WheelType

__all__ = [
    "Ripple",
    "Solid",
    "gap",
    "hub_radius",
    "of_type",
    "profile",
    "ripple",
    "roller_frames",
    "shapes",
    "solid",
    "spheres_within",
    "support",
]
AZIMUTHS = 1001  # of half a pitch, for the ripple
MOST_SPHERES = 9  # of a roller that is not the exact one
SPHERES = 3  # of a roller that is a row of them, to compare
SHORTFALL = 2.5e-3  # of the wheel radius: how much lower a row of spheres may carry the wheel


def of_type(kind: WheelType) -> np.record:
    """The record of a wheel of this type, not mirrored."""
    wheel = Wheel(name="wheel", type="wheel")
    values = shared_values(kind, drive_law(wheel.drive), False, None) | heading_values(wheel)
    own = placed_values(kind, wheel, values, (0.0, 0.0))
    return records(WHEEL, [values | own | {"rates": 0, "contacts": 0, "row": 0, "rows": 1}])[0]


# --- rollers on their wheel -----------------------------------------------------------------------


def roller_frames(kind: WheelType, mirrored: bool = False, phase: float = 0.0) -> list[tuple[np.ndarray, np.ndarray]]:
    """Centre R1 d + offset k and axis a = c t + s k of every roller, rows in turn; phase: azimuth of roller 0, rad."""
    turns = phase + 2.0 * np.pi * np.arange(kind.roller_count) / kind.roller_count
    azimuths = np.add.outer(turns, np.radians([row.phase_deg for row in kind.rings])).ravel()
    offsets = np.tile([row.offset for row in kind.rings], kind.roller_count)
    psi = math.radians(-kind.roller_angle_deg if mirrored else kind.roller_angle_deg)
    sine = np.sin(azimuths)
    cosine = np.cos(azimuths)
    zero = np.zeros(kind.rollers)
    centres = kind.roller_distance * np.column_stack([sine, zero, -cosine]) + np.outer(offsets, [0.0, 1.0, 0.0])
    axes = np.column_stack([-math.cos(psi) * cosine, zero + math.sin(psi), -math.cos(psi) * sine])
    return list(zip(centres, axes, strict=True))


# --- rollers of another shape ---------------------------------------------------------------------


class Spheres(NamedTuple):
    """A row of spheres along a roller's axis, m: places from its middle, radii."""

    places: np.ndarray
    radii: np.ndarray


def row_of_spheres(wheel: Shape, count: int) -> Spheres:
    """`count` spheres that touch the profile from within, at parameters spread evenly.

    The profile is the envelope of spheres about the point of the axis above the contact, R1 tan q / c from the middle,
    with radius h_q: where the wheel stands on the one of q_i, its centre is low by R1 (1 - cos(q - q_i)) / cos q_i.
    """
    at = wheel.alpha * (2.0 * np.arange(count) + 1.0 - count) / count
    return Spheres(
        wheel.roller_distance * np.tan(at) / wheel.cos_psi, wheel.radius - wheel.roller_distance / np.cos(at)
    )


def shortfall(wheel: Shape, count: int) -> float:
    """How much lower than R a row of spheres carries the wheel, at most, m: at the edge of two rollers."""
    half = wheel.alpha / count
    return wheel.roller_distance * (1.0 - math.cos(half)) / math.cos(wheel.alpha - half)


def few_spheres(wheel: Shape) -> Spheres:
    """As few as fall short of the wheel's radius by SHORTFALL of it at most."""
    counts = itertools.count(1)
    return row_of_spheres(wheel, next(n for n in counts if shortfall(wheel, n) <= SHORTFALL * wheel.radius))


def spheres_within(kind: WheelType) -> Spheres:
    """As few spheres along a roller's axis as carry the wheel but for SHORTFALL of its radius, MOST_SPHERES at most.

    Each is as large as it may be without reaching farther than the roller where an upright wheel touches: beyond that
    it may bulge out. The outermost touch where the roller does that takes over. Of a sharp edge they fall short by
    r (1 - cos a) for directions that an upright wheel turns by a.
    """
    if kind.profile.kind == "exact":
        return few_spheres(outline(kind))
    end = math.cos(math.radians(kind.roller_angle_deg)) * math.sin(math.pi / kind.rollers)
    sines = np.linspace(-end, end, AZIMUTHS)
    whole = rollers.reach(kind, sines)
    u, r = max(rollers.farthest(kind, sines[[0, -1]]), key=lambda point: point[0][-1] * end + point[1][-1])
    first, last = u - sines[[0, -1]] * r / math.sqrt(1.0 - end * end)
    for count in range(1, MOST_SPHERES + 1):
        places = np.linspace(first, last, count) if count > 1 else np.array([0.5 * (first + last)])
        spheres = Spheres(places, (whole - np.multiply.outer(places, sines)).min(axis=1))
        found = (np.multiply.outer(sines, spheres.places) + spheres.radii).max(axis=-1)
        if (whole - found).max() <= SHORTFALL * kind.radius:
            break
    return spheres


def shapes(wheel: np.record) -> dict[str, Callable[[np.ndarray], np.ndarray]]:
    """Shapes that stand for the exact roller, by how far they reach, m, in a direction: see `support`.

    Ellipse, capsule and cylinder are as long and, amid, as thick as the roller; spheres touch its profile from within.
    """
    half = 0.5 * length(wheel)
    middle = profile_radius(wheel, 0.0)
    straight = max(half - middle, 0.0)
    places, radii = row_of_spheres(wheel, SPHERES)
    return {
        "exact": lambda s: support(wheel, s),
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
