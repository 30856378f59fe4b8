"""Stage 2, how fast: the slip velocity at the contact point, and how easily a contact force changes it."""

from typing import NamedTuple

from omnisim.kernel import kernel


class Slip(NamedTuple):
    """Velocity of the roller's material point at the contact, relative to the floor, along h and k, m/s."""

    h: float
    k: float


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
def inverse_mass(machine, wheel, axis, contact):
    """A (hh, hk, kk), 1/kg: slip acceleration caused by a contact force, v' = A F + (what F does not change).

    A = J diag(1/M, 1/M, 1/J_k, 1/I_z, 1/Ia) J^T, with J the Jacobian of the slip velocity in the speeds
    (V_h, V_k, phi', theta', p), in which the mass matrix is diagonal.
    """
    spin_h, spin_k = -wheel.radius - axis.k * contact.arm_h, -axis.k * contact.arm_k
    yaw_h, yaw_k = -contact.l - axis.n * contact.arm_h, -axis.n * contact.arm_k
    translation, spin, yaw = 1.0 / machine.mass, 1.0 / wheel.axle_inertia, 1.0 / machine.yaw_inertia
    roller = 1.0 / wheel.axial_inertia
    return (
        translation + spin * spin_h * spin_h + yaw * yaw_h * yaw_h + roller * contact.arm_h * contact.arm_h,
        spin * spin_h * spin_k + yaw * yaw_h * yaw_k + roller * contact.arm_h * contact.arm_k,
        translation + spin * spin_k * spin_k + yaw * yaw_k * yaw_k + roller * contact.arm_k * contact.arm_k,
    )
