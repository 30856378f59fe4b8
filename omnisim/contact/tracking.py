"""Stage 1, where: the contact point of the roller that touches the floor, by either of the paper's algorithms.

Seen along the axle k, which points at the reader (h is forward and to the right, n up):

           O ------> h          d    unit vector from the wheel centre O to the roller centre O_B = O + R1 d
           |\\                   q    azimuth of the roller: d = -cos q n + sin q h
           | \\ R1               t    k x d = -cos q h - sin q n
         n ^  \\ d               a    roller axis = c t + s k          (c, s = cos psi, sin psi)
           |   O_B              P    contact point = O - R n + l k
        ---P---------- floor    arm  a x (P - O_B): a force F on the roller has the torque arm . F about its axis

Both algorithms give a `Contact`, and both are of an upright wheel on a flat floor. Formulas: explicit, section 4 of the
paper; implicit, its section 3 with the misprints mended: the contact point needs "- R j1" where the paper prints
"- R1 j1", and the contact test is |c_beta| < cos psi sin alpha, both of which the paper leaves open.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import combine, cross, dot
from omnisim.contact.frame import Axis, axes, axis_vector, rate_vector, tangential

EDGE = 1e-12  # rounding allowed when two rollers touch at once


class Contact(NamedTuple):
    """Where the roller touches: l (m) along the axle, and the components of arm (m) along h and k."""

    l: float
    arm_h: float
    arm_k: float


@kernel
def roller_axis(wheel, cos_q, sin_q):
    """Orientation of a roller at azimuth q."""
    return Axis(-wheel.cos_psi * cos_q, wheel.sin_psi, -wheel.cos_psi * sin_q)


@kernel
def explicit_contact(wheel, cos_q, sin_q):
    """Closed form: l = R1 tan q tan psi, arm = -h_q (s, c cos q)."""
    slant = wheel.roller_distance / cos_q
    h_q, l = wheel.radius - slant, slant * sin_q * wheel.tan_psi
    return Contact(l, -h_q * wheel.sin_psi, -h_q * wheel.cos_psi * cos_q)


@kernel
def implicit_contact(wheel, frame, axis, rho):
    """From rho, the integrated unit vector from O_B to O (Vec3, world).

    P - O_B = R1 rho - R n + l k1, where l follows from (P - O_B) . k2 = 0: the contact point lies in the vertical
    plane through the roller's axis, whose normal is k2 = i2 x n (not normalised: its length cancels).
    """
    _, k1, n = axes(frame)
    i2 = axis_vector(frame, axis)
    k2 = cross(i2, n)
    l = -wheel.roller_distance * dot(rho, k2) / dot(k1, k2)
    arm = tangential(frame, cross(i2, combine(wheel.roller_distance, rho, l, k1, -wheel.radius, n)))
    return Contact(l, arm.h, arm.k)


@kernel
def rho_rate(frame, axis, twist, rho):
    """rho' of a roller (Vec3) on a wheel with this WheelTwist, by the paper's orthogonality conditions derived in time:

        rho' . i2 = -rho . i2'        rho' . k1 = -rho . k1'        rho' . rho = 0

    Linear in rho', solved by Cramer's rule. The orientation of the roller (i2, and i2' = w x i2) is known; rho
    itself is only ever integrated.
    """
    w, i2 = rate_vector(frame, twist), axis_vector(frame, axis)
    _, k1, _ = axes(frame)
    k1_rho = cross(k1, rho)
    b1 = -dot(rho, cross(w, i2))
    b2 = -dot(rho, cross(w, k1))
    determinant = dot(i2, k1_rho)
    return combine(b1 / determinant, k1_rho, b2 / determinant, cross(rho, i2), 0.0, rho)


@kernel
def explicit_touches(wheel, cos_q):
    """Contact condition of the explicit tracking, |q| <= alpha: both neighbours touch at their common edge."""
    return cos_q >= wheel.cos_alpha - EDGE


@kernel
def implicit_touches(wheel, axis, rho):
    """Contact condition of the implicit tracking: |c_beta| <= c sin alpha, and O_B lower than the height R."""
    return abs(axis.n) <= wheel.cos_psi * wheel.sin_alpha + EDGE and rho.z > 0.0
