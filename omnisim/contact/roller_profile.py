"""The ideal roller: its exact profile, and the lowest point of it at any tilt.

The profile is the envelope that keeps the contact point exactly R below the centre of an upright wheel:

              generatrix r(q)           u, r   axial and radial coordinate of the surface, m
            .---------------.           q      profile parameter, rad: the roller touches the floor there
         .-'        |        '-.               when it stands at azimuth q from straight down
        |           | r(0)      |       c      cos psi
    ----+-----------+-----------+--> axis a
                  u = 0      u(alpha)

    h_q = R - R1 / cos q        u(q) = R1 tan q / c + h_q c sin q        r(q) = h_q sqrt(1 - c^2 sin^2 q)

`wheel` is a row of `Parameters.wheels`.
"""

import math

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, combine, dot


@kernel
def drop(wheel, q):
    """h_q: height of the roller's axis above the floor, straight above the contact point, m.

    Not clamped at a pointed tip: a Runge-Kutta stage may look a little beyond the roller's end, and must see the
    smooth continuation there.
    """
    return wheel.radius - wheel.roller_distance / math.cos(q)


@kernel
def axial_coordinate(wheel, q):
    """u(q), m: odd in q."""
    return wheel.roller_distance * math.tan(q) / wheel.cos_psi + drop(wheel, q) * wheel.cos_psi * math.sin(q)


@kernel
def profile_radius(wheel, q):
    """r(q) >= 0, m: even in q. At a pointed tip typed in decimals h_q may be a rounding error below 0."""
    return max(drop(wheel, q), 0.0) * math.sqrt(1.0 - (wheel.cos_psi * math.sin(q)) ** 2)


@kernel
def length(wheel):
    """2 u(alpha), m.

    The paper's L = 2 R sin(alpha) / cos(psi) holds for psi = 0 or a pointed tip (R1 = R cos alpha) only.
    """
    return 2.0 * axial_coordinate(wheel, wheel.alpha)


@kernel
def tip_radius(wheel):
    """r(alpha), m: zero for a pointed tip."""
    return profile_radius(wheel, wheel.alpha)


@kernel
def support_parameter(wheel, axis_n):
    """Profile parameter of the lowest point, rad, for a roller whose unit axis has the upward component `axis_n`.

    The normal of the surface of revolution is known in closed form, so no iteration is needed at any tilt; beyond
    the ends the rim of the end disc is lowest.
    """
    sine = min(1.0, max(-1.0, -axis_n / wheel.cos_psi))
    return min(wheel.alpha, max(-wheel.alpha, math.asin(sine)))


@kernel
def support_point(wheel, axis):
    """The roller's lowest point relative to its centre, m (Vec3), for the unit axis `axis` (Vec3), z up.

    Of a roller standing on end, whose whole rim is lowest, one point of the rim.
    """
    q = support_parameter(wheel, axis.z)
    up = Vec3(-axis.z * axis.x, -axis.z * axis.y, 1.0 - axis.z * axis.z)
    norm = math.sqrt(dot(up, up))
    if norm == 0.0:
        up = Vec3(1.0, 0.0, 0.0)
        norm = 1.0
    return combine(axial_coordinate(wheel, q), axis, -profile_radius(wheel, q) / norm, up, 0.0, up)
