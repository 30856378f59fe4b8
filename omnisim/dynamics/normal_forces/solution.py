"""Loads and the acceleration of the body together: the questions that forces along the floor ask of normal forces."""

from omnisim.base.kernel import kernel
from omnisim.contact.set_valued import STICK
from omnisim.dynamics.normal_forces.rigid_plane import carry, nothing_carried, share_out
from omnisim.dynamics.normal_forces.servo import equal_load
from omnisim.dynamics.normal_forces.tilt import TILT_X, TILT_Y, tilt_holding
from omnisim.dynamics.parameters import SERVO
from omnisim.dynamics.planar_body import BodyEquations, held_equations, holds, push_of, yielding


@kernel
def loads_known(machine):
    """Whether normal forces are known before the forces along the floor, or else by unknowns found with them."""
    return machine.upright == SERVO


@kernel
def given_load(machine, load, wheels):
    """The load by which forces at a wheel are found, N: its own where it is known, else 1 N.

    load: of all `wheels` of them, N.
    """
    return equal_load(load, wheels) if loads_known(machine) else 1.0


@kernel
def loads_sought(parameters, stage):
    """Whether normal forces are unknowns that something of a Stage depends on: not inside a step while all wheels
    stick, each on one roller that turns without resistance."""
    machine, mode = parameters.machine, stage.mode
    if loads_known(machine):
        return False
    sought = stage.monitoring or machine.rolling or parameters.workspace.resting is None
    for w in range(len(mode)):
        sought = sought or mode[w].grip[0] != STICK or mode[w].shared == 1
    return sought


@kernel
def held_body(loads, contact, equations, weighing):
    """BodyEquations with a sticking contact, which goes into the rows of tilt as well if loads follow from them."""
    if weighing:
        tilt_holding(loads.tilt[0], contact, TILT_Y)
        tilt_holding(loads.tilt[1], contact, TILT_X)
    return held_equations(contact, equations)


@kernel
def carried_at_once(machine, workspace, weighing):
    """What is Carried by all wheels but those whose forces are sought; nothing where loads are not."""
    carried = nothing_carried(workspace)
    return carry(machine, workspace, carried, 0) if weighing else carried


@kernel
def solve(machine, workspace, load, equations, mobility, carried, pushing):
    """The Acceleration of the body, and how regular the loads are; normal forces into the workspace if they are sought.

    load: M g - f_z, N; equations, mobility: what is known at once, and the inverse of that; carried: at once as well;
    pushing: whether some contact pushes by a load that is known, or without. Regular: the determinant of the equations
    of the loads over that without friction.
    """
    if pushing:
        equations = balanced_equations(machine, workspace, equations)
    motion = yielding(mobility, equations.x, equations.y, equations.yaw)
    if carried.places.count == 0.0:
        return motion, 1.0
    return share_out(workspace, load, mobility, motion, carried)


@kernel
def balanced_equations(machine, workspace, equations):
    """BodyEquations with what contacts push that do not stick, by their loads where they are known."""
    known = loads_known(machine)
    x = equations.x
    y = equations.y
    yaw = equations.yaw
    for w in range(len(workspace.parts)):
        part = workspace.parts[w]
        if part.slides or not part.loaded:
            continue
        for c in range(part.first, part.first + part.contacts):
            contact = workspace.contacts[c]
            if workspace.resting is not None and holds(part, contact) and not machine.rolling:
                continue
            if part.contacts == 2:
                force_h = contact.force[0]
                force_k = contact.force[1]
                torque = contact.torque
                pressed = contact.pressed
            else:
                normal = part.normal_force if known else 0.0
                force_h = contact.constant[0] + contact.unit[0] * normal
                force_k = contact.constant[1] + contact.unit[1] * normal
                torque = contact.unit_torque * normal
                pressed = normal
            push_x, push_y, push_yaw = push_of(machine, contact, force_h, force_k, torque, pressed)
            x, y, yaw = x + push_x, y + push_y, yaw + push_yaw
    return BodyEquations(equations.xx, equations.xy, equations.xw, equations.yy, equations.yw, equations.ww, x, y, yaw)
