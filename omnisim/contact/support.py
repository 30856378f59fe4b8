"""The lowest point of a roller at any tilt: which point of a surface of revolution lies furthest along -nu.

    P = B + u a + r e        e = -unit(nu - (nu . a) a), across the axis        N  = nu . a, the tilt

               generatrix r(u)                        u, r   axial and radial coordinate of the surface, m
            .---------------.
         .-'        |        '-.  rim of the end      exact   sin q = -N / c, the envelope of roller_profile.py
        |           | r(0)      |                     arc     u = -rho N, r = r(0) - rho + rho sqrt(1 - N^2)
    ----+-----------+-----------+--> axis a
     -half_length             half_length

Beyond the end of the profile the rim is lowest, u = +-half_length with its own r. Which of the three, the rim behind,
the profile or the rim ahead, is the `region`: frozen within a step, so that a stage which looks a little further sees
the smooth continuation of its own region.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel

EXACT, ARC = 0, 1
PROFILES = {"exact": EXACT, "arc": ARC}
BEHIND, WITHIN, AHEAD = -1, 0, 1  # regions: the rim at u < 0, the profile, the rim at u > 0

SHAPE = np.dtype(
    [
        ("kind", np.int64),  # one of PROFILES
        ("radius", np.float64),  # exact: R of its wheel; arc: r(0), m
        ("distance", np.float64),  # exact: R1 of its wheel, m
        ("cos_psi", np.float64),  # exact: of its wheel
        ("curvature_radius", np.float64),  # arc: rho, m
        ("half_length", np.float64),  # m
        ("end_radius", np.float64),  # r there, m
        ("end_tilt", np.float64),  # |N| up to which the profile holds the lowest point
    ],
    align=True,
)


class Support(NamedTuple):
    """Axial and radial coordinate of the lowest point (m), and their rates by the tilt N."""

    u: float
    r: float
    u_rate: float
    r_rate: float


@kernel
def region_of(shape, tilt):
    """In which region the lowest point of a roller of this SHAPE lies, for nu . a = `tilt`."""
    if abs(tilt) <= shape.end_tilt:
        return WITHIN
    return BEHIND if tilt > 0.0 else AHEAD


@kernel
def region_guard(shape, region, tilt):
    """How far nu . a = `tilt` is inside its region, 1: >= 0 as long as the region holds."""
    if region == WITHIN:
        return shape.end_tilt - abs(tilt)
    return -region * tilt - shape.end_tilt


@kernel
def support(shape, region, tilt, across):
    """The Support of a roller of this SHAPE in this region; tilt: nu . a, across: sqrt(1 - tilt^2)."""
    if region != WITHIN:
        return Support(region * shape.half_length, shape.end_radius, 0.0, 0.0)
    if shape.kind == ARC:
        rho = shape.curvature_radius
        return Support(-rho * tilt, shape.radius - rho + rho * across, -rho, -rho * tilt / across)
    c = shape.cos_psi
    sin_q = -tilt / c
    cos_q = math.sqrt(1.0 - sin_q * sin_q)
    slant = shape.distance / cos_q
    drop = shape.radius - slant
    u = sin_q * (slant / c + drop * c)
    along = (slant / cos_q) * (1.0 / c - c * sin_q * sin_q) + drop * c * cos_q  # du / dq
    u_rate = -along / (c * cos_q)
    return Support(u, drop * across, u_rate, u_rate * tilt / across)
