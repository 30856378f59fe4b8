"""Contacts whose force must be sought: those that creep, and wheels that rest on two rollers.

Every other force is linear in the unknowns of normal_forces/rigid_plane.py; these are found by solving that system
again and again.

A creeping contact slips so slowly that friction turns its slip at once: it has the direction u = v / |v| in which

    v' = kappa u + omega |v| n        n = (-u_k, u_h), omega = u' . n        under F = -mu N u

omega, the rate at which u itself turns, comes with the mode (march/creeping.py); from rest it counts for nothing. The
force is linear like that of any sliding friction once u is known, and u is found by Newton's method.

A wheel at a common edge of two rollers rests on both if each of them alone would turn it back: phi' = 0, and the load
N is split into sigma N on the roller ahead (q = +alpha) and (1 - sigma) N on the one behind such that phi'' = 0. It is
the limit of ever shorter swings about the edge, sigma the part of the time that they spend on the roller ahead; so a
force that does not depend on N, viscous friction, is shared as well.

    turning(sigma) = tau - theta' G_h - sum (R F_h + s Ia p') = 0    turning(0) > 0 > turning(1)

With the loads given its forces at rest obey Gauss' principle, a convex problem: wheel by wheel they are taken from the
contact equations of the one wheel, while the body's acceleration follows at once, until nothing changes.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import angle_of
from omnisim.contact.frame import Axis, Slip
from omnisim.contact.kinematics import Jacobian
from omnisim.contact.mobility import Symmetric, across, yielding_along
from omnisim.contact.set_valued import CREEP, TINY, contact_forces, slip_direction, turned
from omnisim.dynamics.normal_forces.rigid_plane import carry
from omnisim.dynamics.normal_forces.solution import carried_at_once, solve
from omnisim.dynamics.normal_forces.tilt import TILT_X, TILT_Y, place_load
from omnisim.dynamics.planar_body import (
    free_rate,
    holding_force,
    holds,
    inverse,
    push_of,
    pushed_equations,
    set_holding,
    slip_by_rolling,
    yielding,
)
from omnisim.dynamics.state import TOUCHING
from omnisim.dynamics.twist import Acceleration

MOST_ITERATIONS = 100  # for a share
MOST_SWEEPS = 500  # over the wheels
MOST_ROUNDS = 100  # of loads
TOLERANCE = 1e-15  # change of forces and loads, relative to the largest, and of a share
STEADY = 1e-12  # correction of a direction by Newton's method: the next would be lost in rounding
LOST = 1e-12  # of the load times the radius, a torque that is lost in rounding
MOST_FIRM = 40  # rounds until spins that give no way are held
ROUNDING = 1e-11  # a change below which, if it no longer falls, is rounding


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
        carried, mobility = carried_at_once(machine, workspace, weighing), inverse(machine, equations)
        acceleration, regular = solve(machine, workspace, load, equations, mobility, carried, pushing)
    if workspace.resting is not None and machine.follows:
        found = equations, acceleration
        acceleration, regular = hold_firmly(machine, wheels, workspace, load, found, weighing, pushing)
    return acceleration, regular


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
            carried, mobility = carried_at_once(machine, workspace, weighing), inverse(machine, equations)
            acceleration, regular = solve(machine, workspace, load, equations, mobility, carried, pushing)
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
def converged(change, last):
    """Whether a change, relative to what changes, is none, or rounding."""
    return change <= TOLERANCE or (change <= ROUNDING and change >= last)


@kernel
def find_shared_forces(machine, wheels, workspace, mobility, acceleration):
    """Forces of all wheels on two rollers under the loads in the workspace: the largest change, relative, of the first
    sweep over them."""
    first, last = 0.0, math.inf
    for sweep in range(MOST_SWEEPS):
        change, size, count = 0.0, TINY, 0
        for w in range(len(wheels)):
            part = workspace.parts[w]
            ahead = workspace.contacts[part.first]
            behind = workspace.contacts[part.first + 1]
            if not (part.sought and part.contacts == 2):
                continue
            count += 1
            h_0, k_0, h_1, k_1 = ahead.force[0], ahead.force[1], behind.force[0], behind.force[1]
            acceleration = pushed(machine, acceleration, mobility, workspace, w, -1.0)
            if workspace.resting is not None:
                set_resting(machine, wheels[w], workspace, w, mobility, acceleration)
            share_load(machine, wheels[w], workspace, w)
            acceleration = pushed(machine, acceleration, mobility, workspace, w, 1.0)
            change = max(change, max(abs(ahead.force[0] - h_0), abs(ahead.force[1] - k_0)))
            change = max(change, max(abs(behind.force[0] - h_1), abs(behind.force[1] - k_1)))
            size = max(size, max(abs(ahead.force[0]), abs(ahead.force[1])))
            size = max(size, max(abs(behind.force[0]), abs(behind.force[1])))
        change /= size
        if sweep == 0:
            first = change
        if count < 2 or converged(change, last):
            break
        last = change
    return first


@kernel
def pushed(machine, acceleration, mobility, workspace, w, sign):
    """The Acceleration with the forces of wheel w added or, sign -1, taken away."""
    x, y, yaw = 0.0, 0.0, 0.0
    part = workspace.parts[w]
    for c in range(part.first, part.first + part.contacts):
        contact = workspace.contacts[c]
        force, torque, normal = contact.force, contact.torque, contact.pressed
        push_x, push_y, push_yaw = push_of(machine, contact, force[0], force[1], torque, normal)
        x, y, yaw = x + push_x, y + push_y, yaw + push_yaw
    more = yielding(mobility, x, y, yaw)
    return Acceleration(
        acceleration.x + sign * more.x, acceleration.y + sign * more.y, acceleration.yaw + sign * more.yaw
    )


@kernel
def set_resting(machine, wheel, workspace, w, mobility, acceleration):
    """The contact equations of wheel w on two rollers into `resting` and `mobility` of the workspace; its spin is
    held."""
    for side in range(TOUCHING):
        contact = workspace.contacts[wheel.contacts + side]
        resting = workspace.resting[side]
        resting.rest = contact.rest
        resting.force[0], resting.force[1] = contact.force[0], contact.force[1]  # where the search begins
        resting.bias[0], resting.bias[1] = free_rate(contact, acceleration)
        for other in range(TOUCHING):
            hh, hk, kh, kk = through_body(contact, workspace.contacts[wheel.contacts + other], mobility)
            if side == other:
                own = yielding_along(Symmetric(hh, hk, kk), wheel.axial_mobility, contact.arm[0], contact.arm[1])
                hh, hk, kh, kk = own.hh, own.hk, own.hk, own.kk
            a = workspace.loads.mobility[side, other]
            a[0, 0], a[0, 1], a[1, 0], a[1, 1] = hh, hk, kh, kk
        if machine.rolling:
            set_rolling(wheel, workspace, side, mobility)


@outlined
def set_rolling(wheel, workspace, side, mobility):
    """What rolling resistance of both contacts of a wheel on two rollers does to the slip of one of them, by the normal
    forces, into `resting`."""
    contact = workspace.contacts[wheel.contacts + side]
    resting, feel = workspace.resting[side], contact.lever
    resting.alone[0], resting.alone[1] = resting.bias[0], resting.bias[1]
    for other in range(TOUCHING):
        moved = yielding(mobility, 0.0, 0.0, workspace.contacts[wheel.contacts + other].resisting[2])
        h = feel[0, 0] * moved.x + feel[1, 0] * moved.y + feel[2, 0] * moved.yaw
        k = feel[0, 1] * moved.x + feel[1, 1] * moved.y + feel[2, 1] * moved.yaw
        if side == other:
            own_h, own_k = slip_by_rolling(wheel, contact, True)
            h, k = h + own_h, k + own_k
        resting.by_load[other, 0], resting.by_load[other, 1] = h, k


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


@kernel
def contact_mobility(wheel, contact, mobility):
    """Slip acceleration (Symmetric, 1/kg) by the force of a contact that carries its wheel alone."""
    hh, hk, _, kk = through_body(contact, contact, mobility)
    a = yielding_along(Symmetric(hh, hk, kk), wheel.spin_mobility, contact.spin[0], contact.spin[1])
    return yielding_along(a, wheel.axial_mobility, contact.arm[0], contact.arm[1])


@kernel
def through_body(contact, source, mobility):
    """Slip acceleration of a contact by the force of another through the body alone (hh, hk, kh, kk), 1/kg."""
    push, feel = source.lever, contact.lever
    h = yielding(mobility, push[0, 0], push[1, 0], push[2, 0])
    k = yielding(mobility, push[0, 1], push[1, 1], push[2, 1])
    return (
        feel[0, 0] * h.x + feel[1, 0] * h.y + feel[2, 0] * h.yaw,
        feel[0, 0] * k.x + feel[1, 0] * k.y + feel[2, 0] * k.yaw,
        feel[0, 1] * h.x + feel[1, 1] * h.y + feel[2, 1] * h.yaw,
        feel[0, 1] * k.x + feel[1, 1] * k.y + feel[2, 1] * k.yaw,
    )


@kernel
def share_load(machine, wheel, workspace, w):
    """Split the load of wheel w between its two rollers: their forces and shares, and how firmly it rests on both."""
    part = workspace.parts[w]
    t_low, t_high = turning(machine, workspace, w, 0.0), turning(machine, workspace, w, 1.0)
    low, high = 0.0, 1.0
    part.share_margin = min(t_low, -t_high)
    lost = LOST * abs(part.normal_force) * wheel.radius
    share = 0.5
    if t_low - t_high > lost:
        share = min(max(t_low / (t_low - t_high), 0.0), 1.0)
    elif min(t_low, t_high) > lost or max(t_low, t_high) < -lost:  # one of them will carry on, by the sense of both
        share = 1.0 if t_low > 0.0 else 0.0
    if (
        workspace.resting is not None
        and (workspace.resting[0].rest or workspace.resting[1].rest)
        and t_low > 0.0 > t_high
    ):
        side = 0
        for _ in range(MOST_ITERATIONS):  # regula falsi, Illinois variant
            t = turning(machine, workspace, w, share)
            if t > 0.0:
                low, t_low = share, t
                t_high *= 0.5 if side == 1 else 1.0
                side = 1
            else:
                high, t_high = share, t
                t_low *= 0.5 if side == -1 else 1.0
                side = -1
            last = share
            share = (low * t_high - high * t_low) / (t_high - t_low)
            if t == 0.0 or abs(share - last) <= TOLERANCE:
                break
    turning(machine, workspace, w, share)
    place_load(wheel, workspace, w)


@kernel
def turning(machine, workspace, w, share):
    """J_k phi'' of wheel w, N m, if its rollers carry `share` and the rest; leaves their forces in the workspace."""
    part = workspace.parts[w]
    normal, total = max(part.normal_force, 0.0), part.free_spin
    for side in range(TOUCHING):
        contact = workspace.contacts[part.first + side]
        contact.share = share if side == 0 else 1.0 - share
        contact.torque = contact.share * normal * contact.unit_torque
        if workspace.resting is None or not workspace.resting[side].rest:
            for i in range(2):
                contact.force[i] = contact.share * (contact.constant[i] + contact.unit[i] * normal)
        total -= contact.axis[1] * contact.axis[2] * contact.torque
        contact.pressed = contact.share * normal
        if machine.rolling:
            total += contact.pressed * contact.turning
    if workspace.resting is not None:
        find_resting_forces(machine, workspace, part, normal)
    for side in range(TOUCHING):
        contact = workspace.contacts[part.first + side]
        for i in range(2):
            total += contact.spin[i] * contact.force[i]
    return total


@outlined
def add_rolling(workspace, part, resting):
    """What rolling resistance does to a contact at rest on a wheel on two rollers, into its bias."""
    for i in range(2):
        resting.bias[i] = resting.alone[i]
        for other in range(TOUCHING):
            resting.bias[i] += workspace.contacts[part.first + other].pressed * resting.by_load[other, i]


@kernel
def find_resting_forces(machine, workspace, part, normal):
    """Forces of the contacts of a wheel that rest, beside those that slip."""
    for side in range(TOUCHING):
        contact = workspace.contacts[part.first + side]
        resting = workspace.resting[side]
        resting.limit = contact.share * machine.friction * normal
        if machine.rolling:
            add_rolling(workspace, part, resting)
        if not resting.rest:
            resting.force[0], resting.force[1] = contact.force[0], contact.force[1]
    contact_forces(workspace.resting, workspace.loads.mobility)
    for side in range(TOUCHING):
        contact = workspace.contacts[part.first + side]
        resting = workspace.resting[side]
        contact.force[0], contact.force[1] = resting.force[0], resting.force[1]
