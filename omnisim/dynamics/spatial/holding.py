"""Contacts at rest on a machine free in space: what sticks is held, what creeps slips off as it is accelerated.

The loads follow from the state, so with A the slip acceleration of one contact by the force of another and b that
without any of them

    sticking    v' = b + A F = 0                      creeping    F = -mu N u with v' = kappa u

a linear system for those that stick; the directions u of those that creep are turned by Newton's method until it holds,
each with the A that is left to it while those that stick hold: of two contacts of one wheel, next to nothing.
What holds those that stick is found in held.py.

A roller that lies flat touches at several points of one line. A force along the line does the same at each of them: the
roller is held along it once, and what holds it is parted as their cones allow. While one of them sticks, the others can
slip across the line alone.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import angle_of
from omnisim.base.vector import plus, times
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric, across
from omnisim.contact.set_valued import CREEP, TINY, slip_direction, turned
from omnisim.dynamics.spatial.acceleration import slip_change
from omnisim.dynamics.spatial.held import factorize_firm, find_mobility, gather, rate_of, stick
from omnisim.dynamics.spatial.pose import body_of, outward, put_at, vector
from omnisim.dynamics.spatial.seen import look_at_all, standing_seen, touch_place, touching_seen
from omnisim.dynamics.spatial.touching import rate_of_roller
from omnisim.dynamics.state import places

MOST_ROUNDS = 100  # of directions
STEADY = 1e-12  # rad: the next correction would be lost in rounding
SAME_LINE = 1e-12  # of the mobility along a line: what opposite forces along it may move
ROUNDING = 1e-9  # rad, below which a correction that no longer falls is rounding


@outlined
def hold(parameters, stage, body):
    """Forces at the contacts that stick or creep, and what they change in y'; their heat, W."""
    space = parameters.space
    count = gather(parameters, stage.mode, body, False)
    if count == 0:
        return 0.0
    holding = space.holding
    find_mobility(parameters, count)
    firm = factorize_firm(holding, count)
    find_lines(holding, count)
    for m in range(count):
        held = holding.contacts[m]
        if held.creeps and not held.bound:
            held.yields[0], held.yields[1], held.yields[2] = yielding(holding, m, count, firm)
    for m in range(count):
        held = holding.contacts[m]
        w, c = held.wheel, held.contact
        stand, touched = standing_seen(space.stands[w], body), touching_seen(space.touches[touch_place(w, c)])
        bias = slip_change(parameters, stage.mode[w], w, c, (stand, touched), stage.y, stage.dy)
        held.bias[0], held.bias[1] = bias.h, bias.k
        for e in range(2):
            held.force[e] = -held.limit * held.begun[e] if held.creeps else 0.0
    last = math.inf
    for _ in range(MOST_ROUNDS):
        stick(holding, count, firm)
        change = 0.0
        for m in range(count):
            if holding.contacts[m].creeps:
                change = max(change, turn_creep(holding, m, count))
        if change <= STEADY or (change <= ROUNDING and change >= last):
            break
        last = change
    share_lines(holding, count)
    heat = 0.0
    for m in range(count):
        heat += yield_to(parameters, stage, body, m)
    return heat


@outlined
def held_mobility(parameters, mode, y, w, side):
    """Slip acceleration along h and k by the force at a contact of wheel w that does not stick (Symmetric, 1/kg), while
    those that stick are held."""
    grip, before = mode[w].grip, mode[w].grip[side]
    grip[side] = CREEP
    body = body_of(parameters, y)
    look_at_all(parameters, mode, body, y)
    count = gather(parameters, mode, body, False)
    grip[side] = before
    find_mobility(parameters, count)
    holding, own = parameters.space.holding, 0
    for m in range(count):
        if holding.contacts[m].wheel == w and holding.contacts[m].contact == side:
            own = m
    return yielding(holding, own, count, factorize_firm(holding, count))


@kernel
def yielding(holding, own, count, firm):
    """Slip acceleration of contact `own` along h and k by its force (Symmetric, 1/kg), while those that stick hold."""
    hh, hk = pushed(holding, own, 0, count, firm)
    _, kk = pushed(holding, own, 1, count, firm)
    return Symmetric(hh, hk, kk)


@kernel
def pushed(holding, own, e, count, firm):
    """The same by a unit force along its axis e."""
    for m in range(count):
        held = holding.contacts[m]
        held.bias[0] = held.bias[1] = held.force[0] = held.force[1] = 0.0
    holding.contacts[own].force[e] = 1.0
    stick(holding, count, firm)
    return rate_of(holding, own, 0, count), rate_of(holding, own, 1, count)


@kernel
def find_lines(holding, count):
    """Which contacts at rest lie on one line with others of their roller, and which of these are held along it."""
    for m in range(count):
        one = holding.contacts[m]
        one.leader, one.bound = m, False
        for n in range(count):
            if n != m and in_line(holding, m, n):
                other = holding.contacts[n]
                one.leader = min(one.leader, n)
                one.bound = one.bound or (one.creeps and not other.creeps)


@kernel
def in_line(holding, m, n):
    """Whether opposite forces along the axis of one roller at contacts m and n move nothing: on a plane."""
    one, other = holding.contacts[m], holding.contacts[n]
    if one.wheel != other.wheel or one.roller != other.roller:
        return False
    own, whole = 0.0, 0.0
    for e in range(2):
        for f in range(2):
            at_one = holding.mobility[2 * m + e, 2 * m + f] * one.line[e] * one.line[f]
            at_other = holding.mobility[2 * n + e, 2 * n + f] * other.line[e] * other.line[f]
            own += at_one
            whole += at_one + at_other - 2.0 * holding.mobility[2 * m + e, 2 * n + f] * one.line[e] * other.line[f]
    return whole <= SAME_LINE * own


@kernel
def share_lines(holding, count):
    """Part what contacts that stick on one line hold together along it: S into x_i = S c_i / sum c_i, with c_i what the
    cone of each leaves, c_i^2 = (mu N_i)^2 - (force across)^2. All are inside their cones if any parts are."""
    for m in range(count):
        if holding.contacts[m].leader != m:
            continue
        members, whole, room = 0, 0.0, 0.0
        for n in range(m, count):
            held = holding.contacts[n]
            if held.leader == m and not held.creeps:
                members += 1
                whole += held.force[0] * held.line[0] + held.force[1] * held.line[1]
                room += room_along(held)
        if members < 2 or room == 0.0:
            continue
        for n in range(m, count):
            held = holding.contacts[n]
            if held.leader == m and not held.creeps:
                line, force = held.line, held.force
                more = whole * room_along(held) / room - (force[0] * line[0] + force[1] * line[1])
                force[0] += more * line[0]
                force[1] += more * line[1]


@kernel
def room_along(held):
    """How large the force of a contact along its line may be inside its cone, N."""
    across = held.force[1] * held.line[0] - held.force[0] * held.line[1]
    return math.sqrt(max(held.limit * held.limit - across * across, 0.0))


@kernel
def turn_creep(holding, m, count):
    """Turn the direction of creeping contact m by one Newton correction: its size, rad."""
    held = holding.contacts[m]
    if held.bound:
        return turn_across(holding, m, count)
    a = Symmetric(held.yields[0], held.yields[1], held.yields[2])
    rate_h, rate_k = rate_of(holding, m, 0, count), rate_of(holding, m, 1, count)
    force = held.force
    if force[0] == 0.0 and force[1] == 0.0:  # no direction is known yet
        u = slip_direction(a, Slip(rate_h, rate_k), held.limit)
        u_h, u_k, correction = u.h, u.k, 1.0
    else:
        size = math.sqrt(force[0] * force[0] + force[1] * force[1])
        u_h, u_k = -force[0] / size, -force[1] / size
        along = rate_h * u_h + rate_k * u_k
        resisting = held.limit * across(a, u_h, u_k)
        begun, speed = held.begun, held.slip[0] * u_h + held.slip[1] * u_k
        angle = angle_of(begun[0] * u_h + begun[1] * u_k, begun[0] * u_k - begun[1] * u_h)
        turning = speed * (held.veer[0] + held.veer[1] * angle)  # omega |v|
        rate_h, rate_k, resisting = rate_h + turning * u_k, rate_k - turning * u_h, resisting + speed * held.veer[1]
        u_h, u_k, correction = turned(u_h, u_k, rate_h, rate_k, resisting, along, held.turned)
        held.turned = correction
    force[0], force[1] = -held.limit * u_h, -held.limit * u_k
    return abs(correction)


@kernel
def turn_across(holding, m, count):
    """The same of one whose roller is held along the line on which it lies: it slips across that, in the sense that it
    has or begins with."""
    held = holding.contacts[m]
    across_h, across_k = -held.line[1], held.line[0]
    before = held.force[0] * across_h + held.force[1] * across_k
    if before == 0.0:
        before = -rate_of(holding, m, 0, count) * across_h - rate_of(holding, m, 1, count) * across_k
    force = math.copysign(held.limit, before)
    change = abs(held.force[0] - force * across_h) + abs(held.force[1] - force * across_k)
    held.force[0], held.force[1] = force * across_h, force * across_k
    return change / max(held.limit, TINY)


@kernel
def yield_to(parameters, stage, body, m):
    """What the force at contact m changes in y', but for the spin, and what is told of it; its heat, W."""
    space, at = parameters.space, places(parameters)
    held, dy = space.holding.contacts[m], stage.dy
    w, c, force = held.wheel, held.contact, held.force
    wheel, seen = parameters.wheels[w], space.touches[touch_place(w, c)]
    place = rate_of_roller(parameters, stage.mode[w], w, c)
    for e in range(2):
        given = space.holding.given[m, e]
        linear, angular = outward(body.rotation, vector(given, 3)), vector(given, 0)
        put_at(dy, at.velocity, plus(vector(dy, at.velocity), times(force[e], linear)))
        put_at(dy, at.rate, plus(vector(dy, at.rate), times(force[e], angular)))
        for j in range(6, len(space.answer)):
            dy[at.joint_rate + j - 6] += force[e] * given[j]
        dy[place] += wheel.axial_mobility * held.arm[e] * force[e]
        parameters.workspace.parts[w].free_spin += held.spin[e] * force[e]
        seen.force[e] = force[e]
    u = seen.creep
    if held.creeps:
        u[0], u[1] = -force[0] / max(held.limit, TINY), -force[1] / max(held.limit, TINY)
    if stage.monitoring:
        monitors = stage.monitors[w]
        if held.creeps:
            monitors.margin[c] = u[0] * seen.slip[0] + u[1] * seen.slip[1]
        else:
            monitors.margin[c] = held.limit - math.sqrt(force[0] * force[0] + force[1] * force[1])
    return -(force[0] * seen.slip[0] + force[1] * seen.slip[1])
