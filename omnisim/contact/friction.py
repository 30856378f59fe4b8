"""Stage 3, what force: friction laws, each a number and a branch in `friction_factor`.

What else knows of laws: docs/pages/extend.md. Every law is isotropic: F = -g v with a scalar g >= 0, so friction never
does positive work. g is also the largest eigenvalue of -dF/dv, so g times the largest eigenvalue of the contact's
inverse mass is the rate at which slip relaxes.

brush: rubber that rolls under a force creeps. Bristles of rubber enter the contact upright, are bent by the slip on
their way through it, and slide where that takes more than mu times the pressure, a parabola along the contact
(Pacejka, Tire and Vehicle Dynamics, 2012, section 3.2, of isotropic bristles and theoretical slip):

    F = -mu N (1 - (1 - theta)^3) v / |v|       theta = c |v| / (3 mu V) < 1, beyond it F = -mu N v / |v|

    c    creep_stiffness: force by load, by ratio of slip       V    sqrt(|v_r|^2 + slip_speed^2)

v_r is the velocity with which the contact runs over the roller's surface, that of the geometric point of contact over
the floor less v (`streaming`). Pacejka's V is |v_r|; with slip_speed a roller at rest has a law as well, smooth like
the regularized one. F has two continuous derivatives where all of the contact slides, so no event is needed there.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.contensou import patch_factors

NONE, VISCOUS, REGULARIZED, SATURATED, COULOMB, BRUSH = range(6)
LAWS = {
    "none": NONE,
    "viscous": VISCOUS,
    "regularized": REGULARIZED,
    "saturated": SATURATED,
    "coulomb": COULOMB,  # while slipping; at zero slip see set_valued.py
    "brush": BRUSH,
}
TINY_SPEED = 1e-300  # never divide by zero: a stage far off the step's end may hit v = 0 exactly


@kernel
def friction(machine, saturated, normal_force, slip, turn, stream):
    """g in F = -g v (N s/m) and the contact torque about the normal (N m); `turn` (rad/s): the roller's rate about it.

    Only a patch with a radius has a torque: then the regularized slip speed and the speed of its rim enter
    Contensou's integrals.
    """
    if machine.patch_radius == 0.0:
        return friction_factor(machine, saturated, normal_force, slip, stream), 0.0
    limit = machine.friction * normal_force
    speed = math.sqrt(slip.h * slip.h + slip.k * slip.k + machine.slip_speed * machine.slip_speed)
    force, torque = patch_factors(speed, machine.patch_radius * abs(turn))
    return limit * force / speed, -math.copysign(limit * machine.patch_radius * torque, turn)


@kernel
def friction_factor(machine, saturated, normal_force, slip, stream):
    """g in F = -g v, N s/m, from the normal force (N), the slip velocity and, for brush, v_r (both Slip, m/s).

    `saturated` is the branch of the saturated law, frozen throughout a step: |v| > slip_speed or not.
    """
    if machine.law == REGULARIZED:
        square = slip.h * slip.h + (slip.k * slip.k + machine.slip_speed * machine.slip_speed)
        return machine.friction * normal_force / math.sqrt(square)
    if machine.law == SATURATED:
        speed = machine.slip_speed
        if saturated:
            speed = max(math.sqrt(slip.h * slip.h + slip.k * slip.k), TINY_SPEED)
        return machine.friction * normal_force / speed
    if machine.law == COULOMB:
        return machine.friction * normal_force / max(math.sqrt(slip.h * slip.h + slip.k * slip.k), TINY_SPEED)
    if machine.viscous:
        return machine.viscosity
    if machine.brush:
        return brush_factor(machine, normal_force, slip, stream)
    return 0.0


@outlined
def brush_factor(machine, normal_force, slip, stream):
    """The same for brush: N c (1 - theta + theta^2 / 3) / V up to theta = 1, where all of the contact slides."""
    speed = math.sqrt(slip.h * slip.h + slip.k * slip.k)
    passing = passing_speed(machine, stream)
    sliding = 3.0 * machine.friction * passing / machine.creep_stiffness
    if speed < sliding:
        theta = speed / sliding
        return normal_force * machine.creep_stiffness * (1.0 - theta * (1.0 - theta / 3.0)) / passing
    return machine.friction * normal_force / max(speed, TINY_SPEED)


@kernel
def passing_speed(machine, stream):
    """V of the brush law, m/s; stream: v_r (Slip, m/s)."""
    return math.sqrt(stream.h * stream.h + stream.k * stream.k + machine.slip_speed * machine.slip_speed)
