"""Stage 3, what force: friction laws, each a number and a branch in `friction_factor`.

What else knows of laws: docs/pages/extend.md. Every law is isotropic: F = -g v with a scalar g >= 0, so friction never
does positive work. g is also the largest eigenvalue of -dF/dv, so g times the largest eigenvalue of the contact's
inverse mass is the rate at which slip relaxes.
"""

import math

from omnisim.base.kernel import kernel
from omnisim.contact.contensou import patch_factors

NONE, VISCOUS, REGULARIZED, SATURATED, COULOMB = range(5)
LAWS = {
    "none": NONE,
    "viscous": VISCOUS,
    "regularized": REGULARIZED,
    "saturated": SATURATED,
    "coulomb": COULOMB,  # while slipping; at zero slip see set_valued.py
}
TINY_SPEED = 1e-300  # never divide by zero: a stage far off the step's end may hit v = 0 exactly


@kernel
def friction(machine, saturated, normal_force, slip, turn):
    """g in F = -g v (N s/m) and the contact torque about the normal (N m); `turn` (rad/s): the roller's rate about it.

    Only a patch with a radius has a torque: then the regularized slip speed and the speed of its rim enter
    Contensou's integrals.
    """
    if machine.patch_radius == 0.0:
        return friction_factor(machine, saturated, normal_force, slip), 0.0
    limit = machine.friction * normal_force
    speed = math.sqrt(slip.h * slip.h + slip.k * slip.k + machine.slip_speed * machine.slip_speed)
    force, torque = patch_factors(speed, machine.patch_radius * abs(turn))
    return limit * force / speed, -math.copysign(limit * machine.patch_radius * torque, turn)


@kernel
def friction_factor(machine, saturated, normal_force, slip):
    """g in F = -g v, N s/m, from the normal force (N) and the slip velocity (m/s).

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
    if machine.law == VISCOUS:
        return machine.viscosity
    return 0.0
