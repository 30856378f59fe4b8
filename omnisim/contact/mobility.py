"""Stage 2, how easily: the slip acceleration that a contact force causes, and the force that takes one away.

Both are symmetric matrices over h and k, sums of terms m v v^T: what moves at a speed of the mobility m gives way to a
force along v, the row of that speed in the Jacobian of the slip velocity.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.contact.frame import Slip
from omnisim.contact.kinematics import slip_jacobian

LIGHT = 1e8  # masses of the body, that an arm too short for its own inertia stands for: passed within nanoseconds

HEAVY = 1e2  # masses of the body, that a spin which gives no way stands for until its contact holds firmly


class Symmetric(NamedTuple):
    """A symmetric matrix over h and k."""

    hh: float
    hk: float
    kk: float


@kernel
def isotropic(value):
    """The Symmetric that is the same in every direction."""
    return Symmetric(value, 0.0, value)


@kernel
def yielding_along(a, mobility, h, k):
    """A Symmetric with one more speed that gives way: a + m v v^T."""
    return Symmetric(a.hh + mobility * h * h, a.hk + mobility * h * k, a.kk + mobility * k * k)


@kernel
def inverse(a, determinant):
    """a^-1; determinant: of a, for callers who know it without cancellation."""
    scale = 1.0 / determinant
    return Symmetric(a.kk * scale, -a.hk * scale, a.hh * scale)


@kernel
def applied(a, h, k):
    """Components of a (h, k)."""
    return a.hh * h + a.hk * k, a.hk * h + a.kk * k


@kernel
def solution(a, b):
    """x in a x = b, both Slip."""
    determinant = a.hh * a.kk - a.hk * a.hk
    return Slip((a.kk * b.h - a.hk * b.k) / determinant, (a.hh * b.k - a.hk * b.h) / determinant)


@kernel
def across(a, h, k):
    """(u x) . a (u x): a Symmetric across the vector u = (h, k)."""
    return a.hh * k * k - 2.0 * a.hk * h * k + a.kk * h * h


@kernel
def largest(a):
    """The larger eigenvalue of a Symmetric."""
    return 0.5 * (a.hh + a.kk) + math.sqrt(0.25 * (a.hh - a.kk) ** 2 + a.hk * a.hk)


@kernel
def inverse_mass(machine, wheel, axis, contact, spin_held=False):
    """A (Symmetric, 1/kg): slip acceleration caused by a contact force, v' = A F + (what F does not change).

    A = J diag(1/M, 1/M, 1/J_k, 1/I_z, 1/Ia) J^T, with J the Jacobian of the slip velocity in the speeds
    (V_h, V_k, phi', theta', p), in which the mass matrix is diagonal; without 1/J_k if the spin is held.
    """
    j = slip_jacobian(wheel, axis, contact)
    a = yielding_along(isotropic(machine.mobility), 0.0 if spin_held else wheel.spin_mobility, j.spin_h, j.spin_k)
    a = yielding_along(a, machine.yaw_mobility, j.yaw_h, j.yaw_k)
    return yielding_along(a, wheel.axial_mobility, j.roller_h, j.roller_k)


@kernel
def holding_mass(machine, wheel, axis, j):
    """E (Symmetric, kg): F = -E v' is the force that takes the slip acceleration v' away by spin and roller alone."""
    given, determinant = own_mobility(machine, wheel, axis, j)
    return inverse(given, determinant)


@kernel
def turning_mass(machine, wheel, axis, j, u_h, u_k):
    """The same of a force that takes away what is across the unit vector u, and is across it."""
    given, _ = own_mobility(machine, wheel, axis, j)
    e = 1.0 / across(given, u_h, u_k)
    return Symmetric(e * u_k * u_k, -e * u_h * u_k, e * u_h * u_h)


@kernel
def own_mobility(machine, wheel, axis, j):
    """How a contact gives way by spin and roller, spin spin^T / J + arm arm^T / Ia (Symmetric, 1/kg), and the
    determinant of that.

    A pointed tip has no arm, and its force along the roller's path is the body's to choose; an arm is taken as at
    least that at which the roller's inertia appears LIGHT times the body's mass. A spin that follows angles gives no
    way, and is taken as HEAVY times it.
    """
    arm_h, arm_k = j.roller_h, j.roller_k
    shortest = wheel.axial_inertia / (LIGHT * machine.mass)
    if arm_h * arm_h + arm_k * arm_k < shortest:
        length = math.sqrt(shortest / (axis.h * axis.h + axis.k * axis.k))
        arm_h, arm_k = length * axis.k, -length * axis.h
    spin, roller = wheel.holding_mobility, wheel.axial_mobility
    cross = j.spin_h * arm_k - j.spin_k * arm_h
    given = yielding_along(yielding_along(isotropic(0.0), spin, j.spin_h, j.spin_k), roller, arm_h, arm_k)
    return given, spin * roller * cross * cross
