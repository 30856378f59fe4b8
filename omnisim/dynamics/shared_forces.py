"""Wheels that rest on two rollers, and how their load is shared.

A wheel at a common edge of two rollers rests on both if each of them alone would turn it back: phi' = 0, and the load
N is split into sigma N on the roller ahead (q = +alpha) and (1 - sigma) N on the one behind such that phi'' = 0. It is
the limit of ever shorter swings about the edge, sigma the part of the time that they spend on the roller ahead; so a
force that does not depend on N, viscous friction, is shared as well.

    turning(sigma) = tau - theta' G_h - sum (R F_h + s Ia p') = 0    turning(0) > 0 > turning(1)

With the loads given its forces at rest obey Gauss' principle, a convex problem: wheel by wheel they are taken from the
contact equations of the one wheel, while the body's acceleration follows at once, until nothing changes.
"""

import math

from omnisim.base.chords import staying
from omnisim.base.kernel import kernel, outlined
from omnisim.contact.mobility import Symmetric, yielding_along
from omnisim.contact.set_valued import TINY, contact_forces
from omnisim.dynamics.normal_forces.tilt import place_load
from omnisim.dynamics.planar_body import free_rate, push_of, slip_by_rolling, through_body, yielding
from omnisim.dynamics.state import TOUCHING
from omnisim.dynamics.twist import Acceleration

MOST_ITERATIONS = 100  # for a share
MOST_SWEEPS = 500  # over the wheels
TOLERANCE = 1e-15  # change of forces and loads, relative to the largest, and of a share
LOST = 1e-12  # of the load times the radius, a torque that is lost in rounding
ROUNDING = 1e-11  # a change below which, if it no longer falls, is rounding


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
        for _ in range(MOST_ITERATIONS):
            t = turning(machine, workspace, w, share)
            if t > 0.0:
                if side > 0:
                    t_high *= staying(t, t_low)
                low, t_low, side = share, t, 1
            else:
                if side < 0:
                    t_low *= staying(t, t_high)
                high, t_high, side = share, t, -1
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
