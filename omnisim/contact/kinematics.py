"""Stage 2, how fast: the slip velocity at the contact point, and its rate of change."""

from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Slip, rate_along, touching_acceleration, turning_velocity


class Jacobian(NamedTuple):
    """Slip velocity by the speeds that it shares with other contacts, (h, k) for each: spin, yaw; and its roller's."""

    spin_h: float
    spin_k: float
    yaw_h: float
    yaw_k: float
    roller_h: float
    roller_k: float


@kernel
def joint_rate(axis, roller_rate, twist):
    """chi' = p - w . a, rad/s: rate of a roller relative to its wheel, which has this WheelTwist, from its absolute
    axial rate p."""
    return roller_rate - rate_along(twist, axis)


@kernel
def slip_velocity(wheel, contact, twist, joint):
    """Slip from the WheelTwist and chi' = `joint` (rad/s): v = V_w + w x (P - O) + chi' a x (P - O_B).

    V_w is added last: it comes last, from the rotation of the chassis, and the forces wait for the slip.
    """
    turned = turning_velocity(wheel, twist, contact.l)
    return Slip(twist.h + (joint * contact.arm_h + turned.h), twist.k + (joint * contact.arm_k + turned.k))


@kernel
def shift(wheel, cos_q, spin_rate):
    """l' (m/s): how fast the contact point runs along the axle, as q' = -phi'."""
    return -wheel.roller_distance * wheel.tan_psi / (cos_q * cos_q) * spin_rate


@outlined
def streaming(wheel, state):
    """Velocity (Slip, m/s) with which the contact runs over the surface of its roller, at a ContactState: that of the
    contact point over the floor, (V_h - theta' l) h + (V_k + l') k, less the slip."""
    contact, joint, spin_rate = state.contact, state.joint, state.twist.spin
    along = shift(wheel, state.cos_q, spin_rate)
    return Slip(spin_rate * wheel.radius - joint * contact.arm_h, along - joint * contact.arm_k)


@kernel
def slip_acceleration(wheel, state, motion):
    """v' (Slip, m/s^2) at a ContactState, from the accelerations `motion`; without friction in them it is b.

    The contact moves through the wheel with q' = -phi', so l, arm and axis have rates of their own, with either
    tracking taken from the closed forms; h and k turn with the yaw.
    """
    axis, contact, cos_q, sin_q, joint = state.axis, state.contact, state.cos_q, state.sin_q, state.joint
    spin_rate, yaw_rate = state.twist.spin, state.twist.yaw
    h_q = wheel.radius - wheel.roller_distance / cos_q
    h_rate = wheel.roller_distance * sin_q / (cos_q * cos_q) * spin_rate
    l_rate = shift(wheel, cos_q, spin_rate)
    arm_h_rate = -h_rate * wheel.sin_psi
    arm_k_rate = -wheel.cos_psi * (h_rate * cos_q + h_q * sin_q * spin_rate)
    axis_n_rate = wheel.cos_psi * cos_q * spin_rate
    joint_acceleration = motion.roller - motion.spin * axis.k - motion.yaw * axis.n - yaw_rate * axis_n_rate
    disk = touching_acceleration(wheel, state.twist, motion, contact.l)
    return Slip(
        disk.h - yaw_rate * l_rate + joint_acceleration * contact.arm_h + joint * arm_h_rate,
        disk.k + joint_acceleration * contact.arm_k + joint * arm_k_rate,
    )


@kernel
def slip_jacobian(wheel, axis, contact):
    """Of a contact; by the velocity of C it is the identity. Yaw is about C."""
    return Jacobian(
        -wheel.radius - axis.k * contact.arm_h,
        -axis.k * contact.arm_k,
        -wheel.offset[1] - contact.l - axis.n * contact.arm_h,
        wheel.offset[0] - axis.n * contact.arm_k,
        contact.arm_h,
        contact.arm_k,
    )
