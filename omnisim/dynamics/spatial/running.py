"""How the point X where a roller touches the ground runs over both.

    X - B = g a + f nu     g = u + r N / across     f = delta - r / across     N = nu . a

While the machine moves, N changes as a turns with its disk and nu with the ground below X; nu' = K X' with the
curvature K of the ground there, a symmetric map of tangents. X' has g' a, of which N' takes its part of nu': so, in
the tangent plane, with b = V_B + g a' + (dg / dN) (nu . a') a

    nu' - f K nu' - (dg / dN) (a . nu') K a = K b

All along hub axes; X, nu, delta and B as in touching.py.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, combine, cross, dot, plus, times
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric, applied
from omnisim.contact.patch import coordinates_of, patch, turning_of_normal
from omnisim.contact.support import support
from omnisim.dynamics.spatial.pose import mounted, outward, tangent_of
from omnisim.dynamics.spatial.touching import STANDING, disk_turning, piece_of, shape_of


class Running(NamedTuple):
    """Of X - B = g a + f nu: g, f (m), g' and the rate of f - delta (m/s), and nu' (Vec3, rad/s)."""

    along: float
    deep: float
    along_rate: float
    deep_rate: float
    swing: Vec3


@kernel
def running(parameters, mode, w, c, place):
    """The Running of contact c of wheel w; place: its Standing and Touching."""
    stand, touched = place
    tilt, axis = touched.tilt, touched.roller.axis
    across = max(math.sqrt(max(1.0 - tilt * tilt, 0.0)), STANDING)
    found = support(shape_of(parameters.space, w, mode.meeting[c]), mode.region[c], tilt, across)
    radial = found.over_across
    radial_by_tilt = (found.r_rate + radial * tilt / across) / across
    along, along_by_tilt = found.u + radial * tilt, found.u_rate + radial_by_tilt * tilt + radial
    swing = Vec3(0.0, 0.0, 0.0)
    if parameters.space.body.uneven:
        swing = swinging(parameters, mode.meeting[c], place, along, along_by_tilt)
    tilt_rate = dot(cross(disk_turning(stand), axis), touched.normal) + dot(swing, axis)
    return Running(along, touched.depth - radial, along_by_tilt * tilt_rate, -radial_by_tilt * tilt_rate, swing)


@outlined
def swinging(parameters, meeting, place, along, along_by_tilt):
    """nu' (Vec3, rad/s) of uneven ground at this meeting and place; along: g, along_by_tilt: dg / dN (m)."""
    stand, touched = place
    axis, normal, f = touched.roller.axis, touched.normal, touched.deep
    h, k = tangent_of(normal)
    curved = curvature(parameters, meeting, place, h, k)
    turning = disk_turning(stand)
    axis_rate = cross(turning, axis)
    centre = plus(stand.hub.velocity, cross(turning, touched.roller.centre))
    b = plus(centre, combine(along, axis_rate, along_by_tilt * dot(normal, axis_rate), axis, 0.0, axis))
    right_h, right_k = applied(curved, dot(b, h), dot(b, k))
    a_h, a_k = dot(axis, h), dot(axis, k)
    bent_h, bent_k = applied(curved, a_h, a_k)
    tip_h, tip_k = along_by_tilt * bent_h, along_by_tilt * bent_k
    hh, hk = 1.0 - f * curved.hh - tip_h * a_h, -f * curved.hk - tip_h * a_k
    kh, kk = -f * curved.hk - tip_k * a_h, 1.0 - f * curved.kk - tip_k * a_k
    scale = 1.0 / (hh * kk - hk * kh)
    return combine(scale * (kk * right_h - hk * right_k), h, scale * (hh * right_k - kh * right_h), k, 0.0, normal)


@kernel
def curvature(parameters, meeting, place, h, k):
    """K of the ground along its tangents h and k (Symmetric, 1/m), > 0 where it is convex; a vertical face has none."""
    stand, touched = place
    floor, piece = parameters.space.floor, piece_of(parameters.space, meeting)
    rotation, axes = stand.body.rotation, mounted(stand.hub)
    point = plus(stand.body.position, outward(rotation, plus(stand.hub.centre, outward(axes, touched.arm))))
    at = coordinates_of(floor, piece, point)
    if piece and at.first > 0.5 * math.pi:
        return Symmetric(0.0, 0.0, 0.0)
    ground = patch(floor, piece, at)
    h, k = outward(rotation, outward(axes, h)), outward(rotation, outward(axes, k))
    by_h, by_k = turning_of_normal(ground, h), turning_of_normal(ground, k)
    return Symmetric(dot(by_h, h), dot(by_h, k), dot(by_k, k))


@outlined
def streaming(parameters, mode, w, c, place, joint):
    """Velocity (Slip, m/s) with which a contact runs over the surface of its roller, which turns on its axle with the
    rate `joint`, rad/s: that of X less that of the material there; place: its Standing and Touching.

    Of X - B = g a + f nu it is what the turning w of the roller does not make: g' a + f (nu' - w x nu).
    """
    stand, touched = place
    run = running(parameters, mode, w, c, place)
    turning = plus(disk_turning(stand), times(joint, touched.roller.axis))
    slid = plus(times(run.along_rate, touched.roller.axis), times(run.deep, run.swing))
    velocity = plus(slid, times(-run.deep, cross(turning, touched.normal)))
    h, k = tangent_of(touched.normal)
    return Slip(dot(velocity, h), dot(velocity, k))
