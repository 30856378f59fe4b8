"""Stage 2, how fast: the slip velocity at the contact point, and its rate of change."""

from typing import NamedTuple

from omnisim.base.kernel import kernel


class Slip(NamedTuple):
    """Velocity of the roller's material point at the contact, relative to the floor, along h and k, m/s."""

    h: float
    k: float


class Motion(NamedTuple):
    """Accelerations of the wheel centre along h and k (m/s^2), of spin, yaw and the roller's axial rate (rad/s^2)."""

    h: float
    k: float
    spin: float
    yaw: float
    roller: float


class Jacobian(NamedTuple):
    """Slip velocity by the speeds that it shares with other contacts, (h, k) for each: spin, yaw; and its roller's."""

    spin_h: float
    spin_k: float
    yaw_h: float
    yaw_k: float
    roller_h: float
    roller_k: float


@kernel
def joint_rate(axis, roller_rate, spin_rate, yaw_rate):
    """chi' = p - w . a, rad/s: rate of the roller relative to the wheel, from its absolute axial rate p."""
    return roller_rate - (spin_rate * axis.k + yaw_rate * axis.n)


@kernel
def slip_velocity(wheel, contact, velocity_h, velocity_k, spin_rate, yaw_rate, joint):
    """Slip from the velocity of the wheel centre (m/s), the spin and yaw rate and chi' = `joint` (rad/s).

    v = V_w + w x (P - O) + chi' a x (P - O_B)
    """
    return Slip(
        velocity_h - spin_rate * wheel.radius - yaw_rate * contact.l + joint * contact.arm_h,
        velocity_k + joint * contact.arm_k,
    )


@kernel
def slip_acceleration(wheel, state, motion):
    """v' (Slip, m/s^2) at a ContactState, from the accelerations `motion`; without friction in them it is b.

    The contact moves through the wheel with q' = -phi', so l, arm and axis have rates of their own, with either
    tracking taken from the closed forms; h and k turn with the yaw.
    """
    axis, contact, cos_q, sin_q, joint = state.axis, state.contact, state.cos_q, state.sin_q, state.joint
    spin_rate, yaw_rate = state.spin_rate, state.yaw_rate
    h_q = wheel.radius - wheel.roller_distance / cos_q
    h_rate = wheel.roller_distance * sin_q / (cos_q * cos_q) * spin_rate
    l_rate = -wheel.roller_distance * wheel.tan_psi / (cos_q * cos_q) * spin_rate
    arm_h_rate = -h_rate * wheel.sin_psi
    arm_k_rate = -wheel.cos_psi * (h_rate * cos_q + h_q * sin_q * spin_rate)
    axis_n_rate = wheel.cos_psi * cos_q * spin_rate
    joint_acceleration = motion.roller - motion.spin * axis.k - motion.yaw * axis.n - yaw_rate * axis_n_rate
    along_h = motion.h + yaw_rate * state.velocity.k - motion.spin * wheel.radius - motion.yaw * contact.l
    along_k = motion.k - yaw_rate * state.velocity.h
    return Slip(
        along_h - yaw_rate * l_rate + joint_acceleration * contact.arm_h + joint * arm_h_rate,
        along_k + joint_acceleration * contact.arm_k + joint * arm_k_rate,
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
