"""Stage 2, how fast: the slip velocity at the contact point, and how easily a contact force changes it."""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel


class Slip(NamedTuple):
    """Velocity of the roller's material point at the contact, relative to the floor, along h and k, m/s."""

    h: float
    k: float


LIGHT = 1e8


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
def largest(a):
    """The larger eigenvalue of a symmetric matrix a (hh, hk, kk)."""
    hh, hk, kk = a
    return 0.5 * (hh + kk) + math.sqrt(0.25 * (hh - kk) ** 2 + hk * hk)


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


@kernel
def inverse_mass(machine, wheel, axis, contact, spin_held=False):
    """A (hh, hk, kk), 1/kg: slip acceleration caused by a contact force, v' = A F + (what F does not change).

    A = J diag(1/M, 1/M, 1/J_k, 1/I_z, 1/Ia) J^T, with J the Jacobian of the slip velocity in the speeds
    (V_h, V_k, phi', theta', p), in which the mass matrix is diagonal; without 1/J_k if the spin is held.
    """
    j = slip_jacobian(wheel, axis, contact)
    translation, yaw, roller = machine.mobility, machine.yaw_mobility, wheel.axial_mobility
    spin = 0.0 if spin_held else wheel.spin_mobility
    return (
        translation + spin * j.spin_h * j.spin_h + yaw * j.yaw_h * j.yaw_h + roller * j.roller_h * j.roller_h,
        spin * j.spin_h * j.spin_k + yaw * j.yaw_h * j.yaw_k + roller * j.roller_h * j.roller_k,
        translation + spin * j.spin_k * j.spin_k + yaw * j.yaw_k * j.yaw_k + roller * j.roller_k * j.roller_k,
    )


@kernel
def holding_mass(machine, wheel, axis, j):
    """E (hh, hk, kk), kg: F = -E v' is the force that takes the slip acceleration v' away by spin and roller alone.

    The inverse of what they give way, spin spin^T / J + arm arm^T / Ia. A pointed tip has no arm, and its force along
    the roller's path is the body's to choose; an arm is taken as at least that at which the roller's inertia
    appears LIGHT times the body's mass: less is passed within nanoseconds.
    """
    arm_h, arm_k = j.roller_h, j.roller_k
    shortest = wheel.axial_inertia / (LIGHT * machine.mass)
    if arm_h * arm_h + arm_k * arm_k < shortest:
        length = math.sqrt(shortest / (axis.h * axis.h + axis.k * axis.k))
        arm_h, arm_k = length * axis.k, -length * axis.h
    spin, roller = wheel.spin_mobility, wheel.axial_mobility
    cross = j.spin_h * arm_k - j.spin_k * arm_h
    inverse = 1.0 / (spin * roller * cross * cross)
    return (
        (spin * j.spin_k * j.spin_k + roller * arm_k * arm_k) * inverse,
        -(spin * j.spin_h * j.spin_k + roller * arm_h * arm_k) * inverse,
        (spin * j.spin_h * j.spin_h + roller * arm_h * arm_h) * inverse,
    )
