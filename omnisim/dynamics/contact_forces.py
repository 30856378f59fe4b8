"""Contacts whose force must be sought: those that creep, and wheels that rest on two rollers.

Every other force is linear in the unknowns of normal_forces/rigid_plane.py; these are found by solving that system
again and again.

A creeping contact slips so slowly that friction turns its slip at once: it has the direction u = v / |v| in which

    v' = kappa u + omega |v| n        n = (-u_k, u_h), omega = u' . n        under F = -mu N u

omega, the rate at which u itself turns, comes with the mode (march/creeping.py); from rest it counts for nothing. The
force is linear like that of any sliding friction once u is known, and u is found by Newton's method.

Wheels that rest on two rollers: shared_forces.py.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import angle_of
from omnisim.contact.frame import Axis, Slip
from omnisim.contact.kinematics import Jacobian
from omnisim.contact.mobility import across
from omnisim.contact.set_valued import CREEP, TINY, slip_direction, turned
from omnisim.dynamics.normal_forces.rigid_plane import carry
from omnisim.dynamics.normal_forces.solution import carried_at_once, solve
from omnisim.dynamics.normal_forces.tilt import TILT_X, TILT_Y
from omnisim.dynamics.planar_body import (
    contact_mobility,
    free_rate,
    holding_force,
    holds,
    inverse,
    push_of,
    pushed_equations,
    set_holding,
    slip_by_rolling,
)
from omnisim.dynamics.shared_forces import converged, find_shared_forces
from omnisim.dynamics.twist import Acceleration

MOST_ROUNDS = 100  # of loads
STEADY = 1e-12  # correction of a direction by Newton's method: the next would be lost in rounding
MOST_FIRM = 40  # rounds until spins that give no way are held


@kernel
def seek(workspace, part, mode):
    """Whether the forces of a wheel are sought, into its part of the workspace; the direction in which it creeps turns
    as its mode says."""
    part.sought = mode.loaded and (mode.shared or mode.grip[0] == CREEP)
    if part.sought:
        contact, begun, veer = workspace.contacts[part.first], mode.creep[0], mode.veer[0]
        contact.begun[0], contact.begun[1] = begun[0], begun[1]
        contact.veer[0], contact.veer[1] = veer[0], veer[1]


@kernel
def find_forces(parameters, load, equations, weighing, pushing, sought):
    """All loads if they are sought (`weighing`), and forces that are: the Acceleration of the body, and how regular
    the loads are."""
    machine, wheels, workspace = parameters.machine, parameters.wheels, parameters.workspace
    if sought:
        acceleration, regular = find_contact_forces(machine, wheels, workspace, load, equations, weighing, pushing)
    else:
        acceleration, regular = find_at_once(machine, workspace, load, equations, weighing, pushing)
    if workspace.resting is not None and machine.follows:
        found = equations, acceleration
        acceleration, regular = hold_firmly(machine, wheels, workspace, load, found, weighing, pushing)
    return acceleration, regular


@kernel
def find_at_once(machine, workspace, load, equations, weighing, pushing):
    """The same where no force is sought."""
    carried, mobility = carried_at_once(machine, workspace, weighing), inverse(machine, equations)
    return solve(machine, workspace, load, equations, mobility, carried, pushing)


@outlined
def hold_firmly(machine, wheels, workspace, load, found, weighing, pushing):
    """The same where sticking contacts hold wheels that follow angles: a spin gives no way, and they have been taken
    to turn as easily as HEAVY says. What they would turn is taken off the slip acceleration that the contacts hold.

    found: the BodyEquations, and the Acceleration by them. Each round leaves about 1 / HEAVY of the error before it.
    """
    equations, acceleration = found
    regular = 1.0
    last = math.inf
    for _ in range(MOST_FIRM):
        change, size = 0.0, TINY
        for w in range(len(wheels)):
            part, wheel = workspace.parts[w], wheels[w]
            contact = workspace.contacts[part.first]
            if wheel.follows and not part.slides and holds(part, contact):
                force_h, force_k = holding_force(contact, acceleration)
                if machine.rolling:
                    normal = max(part.normal_force, 0.0)
                    force_h, force_k = force_h + contact.unit[0] * normal, force_k + contact.unit[1] * normal
                more_h, more_k = hold_more(machine, wheel, contact, force_h, force_k)
                push_x, push_y, push_yaw = push_of(machine, contact, more_h, more_k, 0.0, 0.0)
                equations = pushed_equations(equations, push_x, push_y, push_yaw)
                if weighing:
                    push_tilt(workspace.loads.tilt[0], contact, TILT_Y, more_h, more_k)
                    push_tilt(workspace.loads.tilt[1], contact, TILT_X, more_h, more_k)
                change = max(change, max(abs(more_h), abs(more_k)))
                size = max(size, max(abs(force_h), abs(force_k)))
        if converged(change / size, last):
            break
        last = change / size
        if any_sought(workspace):
            acceleration, regular = find_contact_forces(machine, wheels, workspace, load, equations, weighing, pushing)
        else:
            acceleration, regular = find_at_once(machine, workspace, load, equations, weighing, pushing)
    return acceleration, regular


@kernel
def hold_more(machine, wheel, contact, force_h, force_k):
    """Let a sticking contact hold a spin that gives no way, where this force (N) would turn it: how much more force."""
    turned = wheel.holding_mobility * (contact.spin[0] * force_h + contact.spin[1] * force_k)
    held_h, held_k = contact.holding[0, 3], contact.holding[1, 3]
    axis = Axis(contact.axis[0], contact.axis[1], contact.axis[2])
    j = Jacobian(contact.spin[0], contact.spin[1], 0.0, 0.0, contact.arm[0], contact.arm[1])
    rate = Slip(contact.bias[0] - turned * contact.spin[0], contact.bias[1] - turned * contact.spin[1])
    set_holding(machine, wheel, contact, axis, j, rate)
    return contact.holding[0, 3] - held_h, contact.holding[1, 3] - held_k


@kernel
def push_tilt(row, contact, i, force_h, force_k):
    """A row of tilt with one more force of a contact; i: its row of the levers."""
    row[3] -= contact.lever[i, 0] * force_h + contact.lever[i, 1] * force_k


@kernel
def any_sought(workspace):
    """Whether the force of some contact is sought."""
    found = False
    for w in range(len(workspace.parts)):
        found = found or workspace.parts[w].sought == 1
    return found


@outlined
def find_contact_forces(machine, wheels, workspace, load, equations, weighing, pushing):
    """Find the sought forces of an instant and all loads; returns what `solve` does."""
    acceleration = Acceleration(0.0, 0.0, 0.0)
    regular = 1.0
    last = math.inf
    known, mobility = carried_at_once(machine, workspace, weighing), inverse(machine, equations)
    for _ in range(MOST_ROUNDS):
        carried = carry(machine, workspace, known, 1) if weighing else known
        acceleration, regular = solve(machine, workspace, load, equations, mobility, carried, pushing)
        change = find_shared_forces(machine, wheels, workspace, mobility, acceleration)
        for w in range(len(wheels)):
            part = workspace.parts[w]
            if workspace.resting is not None and part.sought and part.contacts == 1:
                correction = turn_creep(machine, wheels[w], workspace, w, mobility, acceleration)
                change = max(change, correction if correction > STEADY else 0.0)
        if converged(change, last):
            break
        last = change
    return acceleration, regular


@kernel
def turn_creep(machine, wheel, workspace, w, mobility, acceleration):
    """Turn the direction of a creeping contact by one Newton correction: its size, rad."""
    contact = workspace.contacts[wheel.contacts]
    limit = machine.friction * max(workspace.parts[w].normal_force, 0.0)
    a = contact_mobility(wheel, contact, mobility)
    rate_h, rate_k = free_rate(contact, acceleration)
    if machine.rolling:
        normal = max(workspace.parts[w].normal_force, 0.0)
        more_h, more_k = slip_by_rolling(wheel, contact)
        rate_h, rate_k = rate_h + normal * more_h, rate_k + normal * more_k
    if contact.creep[0] == 0.0 and contact.creep[1] == 0.0:
        u = slip_direction(a, Slip(rate_h, rate_k), limit)  # no force was in the balance yet
        u_h = u.h
        u_k = u.k
        correction = 1.0
    else:
        u_h, u_k = contact.creep[0], contact.creep[1]
        spin = (contact.spin[0] * u_h + contact.spin[1] * u_k) * limit * wheel.spin_mobility
        roller = (contact.arm[0] * u_h + contact.arm[1] * u_k) * limit * wheel.axial_mobility
        rate_h -= contact.spin[0] * spin + contact.arm[0] * roller
        rate_k -= contact.spin[1] * spin + contact.arm[1] * roller
        resisting = limit * across(a, u_h, u_k)
        along = rate_h * u_h + rate_k * u_k
        begun, speed = contact.begun, contact.slip[0] * u_h + contact.slip[1] * u_k
        angle = angle_of(begun[0] * u_h + begun[1] * u_k, begun[0] * u_k - begun[1] * u_h)
        turning = speed * (contact.veer[0] + contact.veer[1] * angle)  # omega |v|
        rate_h, rate_k, resisting = rate_h + turning * u_k, rate_k - turning * u_h, resisting + speed * contact.veer[1]
        u_h, u_k, correction = turned(u_h, u_k, rate_h, rate_k, resisting, along, contact.turned)
        contact.turned = correction
    contact.creep[0], contact.creep[1] = u_h, u_k
    contact.unit[0], contact.unit[1] = -machine.friction * u_h, -machine.friction * u_k
    return abs(correction)
