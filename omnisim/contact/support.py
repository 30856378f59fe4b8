"""The lowest point of a roller at any tilt: which point of a surface of revolution lies furthest along -nu.

    P = B + u a + r e        e = -unit(nu - (nu . a) a), across the axis        N  = nu . a, the tilt

               generatrix r(u)                        u, r   axial and radial coordinate of the surface, m
            .---------------.
         .-'        |        '-.  edge of the end     exact  sin q = -N / c, the envelope of roller_profile.py
        |           | r(0)      |                     arc    u = u_c - rho N, r = r_c + rho sqrt(1 - N^2)
    ----+-----------+-----------+--> axis a
     -half_length             half_length

A generatrix is a chain of arcs of circles, of which edges have no radius; of the exact one all but its two edges is the
envelope. Which of them holds the lowest point is the `region`, counted along u: frozen within a step, so that a stage
which looks a little further sees the smooth continuation of its own region. From each to the next P goes on, but not
its rate.

A SHAPE is convex. A roller has several where its generatrix has straight lines: see lobes.py of scenes.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel

MOST_ARCS = 40  # of a SHAPE
NO_ENVELOPE = -1

SHAPE = np.dtype(
    [
        ("envelope", np.int64),  # which region is the exact profile; or NO_ENVELOPE
        ("regions", np.int64),
        ("radius", np.float64),  # exact: R of its wheel; else of the roller in its middle, m
        ("distance", np.float64),  # exact: R1 of its wheel, m
        ("cos_psi", np.float64),  # exact: of its wheel
        ("sec_psi", np.float64),  # 1 / cos_psi
        ("tilts", np.float64, (MOST_ARCS + 1,)),  # region k holds the lowest point from tilts[k + 1] to tilts[k]
        ("arcs", np.float64, (MOST_ARCS, 3)),  # u_c, r_c and rho of each region, m
        ("half_length", np.float64),  # of the roller, m
        ("thickest", np.float64),  # r where it is largest, m
        ("reach", np.float64),  # of a sphere about the centre that holds it, m
        ("longest", np.float64),  # radius of curvature of the generatrix, about the largest, m
    ],
    align=True,
)


class Support(NamedTuple):
    """Axial and radial coordinate u and r of the lowest point (m), r / sqrt(1 - N^2) (m), and the rates of u and r by
    the tilt N."""

    u: float
    r: float
    over_across: float
    u_rate: float
    r_rate: float


@kernel
def region_of(shape, tilt):
    """In which region the lowest point of this SHAPE lies, for nu . a = `tilt`."""
    if tilt >= 0.0:
        region = 0
        while tilt <= shape.tilts[region + 1]:
            region += 1
        return region
    region = shape.regions - 1
    while tilt >= shape.tilts[region]:
        region -= 1
    return region


@kernel
def region_guard(shape, region, tilt):
    """How far nu . a = `tilt` is inside its region, 1: >= 0 as long as the region holds."""
    return min(shape.tilts[region] - tilt, tilt - shape.tilts[region + 1])


@kernel
def next_region(shape, region, tilt):
    """The region on the side where nu . a = `tilt` leaves this one."""
    before, beyond = shape.tilts[region] - tilt, tilt - shape.tilts[region + 1]
    return region - 1 if before < beyond else region + 1


@kernel
def support(shape, region, tilt, across):
    """The Support of this SHAPE in this region; tilt: nu . a, across: sqrt(1 - tilt^2)."""
    if region != shape.envelope:
        rho = shape.arcs[region, 2]
        u, over_across = shape.arcs[region, 0] - rho * tilt, shape.arcs[region, 1] / across + rho
        return Support(u, shape.arcs[region, 1] + rho * across, over_across, -rho, -rho * tilt / across)
    c, sec = shape.cos_psi, shape.sec_psi
    sin_q = -tilt * sec
    cos_q = math.sqrt(1.0 - sin_q * sin_q)
    slant = shape.distance / cos_q
    drop = shape.radius - slant
    u = sin_q * (slant * sec + drop * c)
    along = (slant / cos_q) * (sec - c * sin_q * sin_q) + drop * c * cos_q  # du / dq
    u_rate = -along / (c * cos_q)
    return Support(u, drop * across, drop, u_rate, u_rate * tilt / across)
