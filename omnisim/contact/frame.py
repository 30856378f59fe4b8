"""The frame of a contact, and the motion of its wheel in it: velocity of points, and components along h, k and n.

         n   k            h    where the wheel heads, in the plane that touches the floor
         |  /             k    along its axle
         | /              n    normal of the floor
         P -----> h       P    contact point, O - R n + l k

Wheels stand upright on a flat floor: k lies in that plane, n is the same everywhere, and all frames differ by a turn
about n alone, from each other, from the chassis and from the world. So the cosine and the sine of that turn are a
whole Frame, and a wheel that is not tilted has no rate about h. This file knows it, dynamics/twist.py does for the
machine, and the closed forms do that hold for such wheels alone: where they touch (tracking.py), and the equations of a
body in the plane (planar_body.py, normal_forces/). The others speak of h, k and n: a wheel that leans, or stands on
ground that is not flat, has another Frame and another twist behind the same functions.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec2, Vec3, combine


class Frame(NamedTuple):
    """Unit vectors h = (cos, sin, 0), k = (-sin, cos, 0) and n = (0, 0, 1), along axes x, y and z."""

    cos: float
    sin: float


class Slip(NamedTuple):
    """Components along h and k of a velocity (m/s), above all of the roller's material at the contact relative to the
    floor, or of what goes with it: an acceleration (m/s^2), an impulse (N s), a force (N)."""

    h: float
    k: float


class Axis(NamedTuple):
    """Components of a roller's unit axis a along h, k and n."""

    h: float
    k: float
    n: float


class WheelTwist(NamedTuple):
    """Velocity of a wheel's centre along h and k (m/s), and rates of its disk about k and n (rad/s)."""

    h: float
    k: float
    spin: float
    yaw: float


class Motion(NamedTuple):
    """Accelerations of the wheel centre along h and k (m/s^2), of spin, yaw and the roller's axial rate (rad/s^2)."""

    h: float
    k: float
    spin: float
    yaw: float
    roller: float


@kernel
def frame_on_chassis(wheel):
    """The Frame of a wheel along the axes of its chassis."""
    return Frame(wheel.cos_heading, wheel.sin_heading)


@kernel
def frame_along(h):
    """The Frame whose h (Vec3) is given, along the same axes."""
    return Frame(h.x, h.y)


@kernel
def frame_by(carrier, frame):
    """A Frame along the axes of a carrier, along those of which the carrier is a Frame."""
    return Frame(
        carrier.cos * frame.cos - carrier.sin * frame.sin,
        carrier.sin * frame.cos + carrier.cos * frame.sin,
    )


@kernel
def turn_of(frame):
    """The angle by which a Frame is turned about n, rad."""
    return math.atan2(frame.sin, frame.cos)


@kernel
def axes(frame):
    """h, k and n (Vec3)."""
    return Vec3(frame.cos, frame.sin, 0.0), Vec3(-frame.sin, frame.cos, 0.0), Vec3(0.0, 0.0, 1.0)


@kernel
def tangential(frame, vector):
    """What a vector with components x, y has along h and k (Slip)."""
    return Slip(vector.x * frame.cos + vector.y * frame.sin, vector.y * frame.cos - vector.x * frame.sin)


@kernel
def outward(frame, slip):
    """Components x, y (Vec2) of what is given along h and k."""
    return Vec2(slip.h * frame.cos - slip.k * frame.sin, slip.h * frame.sin + slip.k * frame.cos)


@kernel
def axis_vector(frame, axis):
    """An Axis as a Vec3."""
    return Vec3(axis.h * frame.cos - axis.k * frame.sin, axis.h * frame.sin + axis.k * frame.cos, axis.n)


@kernel
def spoke(frame, cos_q, sin_q):
    """d = -cos q n + sin q h (Vec3): from the wheel centre to that of the roller at azimuth q."""
    return Vec3(sin_q * frame.cos, sin_q * frame.sin, -cos_q)


@kernel
def rate_vector(frame, twist):
    """Angular velocity of a disk with this WheelTwist (Vec3, rad/s)."""
    return Vec3(-twist.spin * frame.sin, twist.spin * frame.cos, twist.yaw)


@kernel
def rate_change(frame, twist, motion):
    """Its rate (Vec3, rad/s^2), from the accelerations `motion`: k turns with the yaw, k' = -theta' h."""
    h, k, n = axes(frame)
    return combine(motion.spin, k, motion.yaw, n, -twist.yaw * twist.spin, h)


@kernel
def rate_along(twist, axis):
    """w . a: of the rate of a disk what is along an Axis, rad/s."""
    return twist.spin * axis.k + twist.yaw * axis.n


@kernel
def turn_rate(axis, twist, joint):
    """Angular velocity of a roller about the normal, rad/s; joint: its rate relative to the disk."""
    return twist.yaw + joint * axis.n


@kernel
def turning_velocity(wheel, twist, l):
    """w x (P - O) with P = O - R n + l k: what turning adds to the velocity of the disk where it would touch (Slip,
    m/s)."""
    return Slip(-(twist.spin * wheel.radius + twist.yaw * l), 0.0)


@kernel
def touching_acceleration(wheel, twist, motion, l):
    """Rates of the components of that velocity at constant l (Slip, m/s^2), by the accelerations `motion`: h and k turn
    with the yaw."""
    along_h = motion.h + twist.yaw * twist.k - motion.spin * wheel.radius - motion.yaw * l
    return Slip(along_h, motion.k - twist.yaw * twist.h)
