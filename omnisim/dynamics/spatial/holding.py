"""Contacts at rest on a machine free in space: what sticks is held, what creeps slips off as it is accelerated.

The loads follow from the state, so with A the slip acceleration of one contact by the force of another and b that
without any of them

    sticking    v' = b + A F = 0                      creeping    F = -mu N u with v' = kappa u

a linear system for those that stick; the directions u of those that creep are turned by Newton's method until it holds.
Wheels that are held in more ways than they can move have no unique forces: of all, the smallest is taken, by a few
rounds of the proximal point method.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import dot, plus, times
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric, across
from omnisim.contact.set_valued import CREEP, SLIP, TINY, slip_direction, turned
from omnisim.dynamics.spatial.acceleration import slip_change
from omnisim.dynamics.spatial.carriers import factorize, substitute
from omnisim.dynamics.spatial.mobility import lever_along
from omnisim.dynamics.spatial.pose import outward, product, put, put_at, tangent_of, vector
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import standing
from omnisim.dynamics.state import places

PROXIMAL = 1e-8  # of the largest mobility: what keeps the system regular
MOST_PROXIMAL = 4  # rounds, each of which leaves 1e-8 of the error before it
MOST_ROUNDS = 100  # of directions
STEADY = 1e-12  # rad: the next correction would be lost in rounding
ROUNDING = 1e-9  # rad, below which a correction that no longer falls is rounding


@outlined
def hold(parameters, stage, body):
    """Forces at the contacts that stick or creep, and what they change in y'; their heat, W."""
    count = gather(parameters, stage, body)
    if count == 0:
        return 0.0
    holding = parameters.space.holding
    find_mobility(parameters, count)
    last = math.inf
    for _ in range(MOST_ROUNDS):
        stick(holding, count)
        change = 0.0
        for m in range(count):
            if holding.contacts[m].creeps:
                change = max(change, turn_creep(stage, holding, m, count))
        if change <= STEADY or (change <= ROUNDING and change >= last):
            break
        last = change
    heat = 0.0
    for m in range(count):
        heat += yield_to(parameters, stage, body, m)
    return heat


@kernel
def gather(parameters, stage, body):
    """The contacts at rest into the workspace, with their levers and b: how many."""
    space = parameters.space
    holding = space.holding
    count = 0
    for w in range(len(stage.mode)):
        mode = stage.mode[w]
        resting = False
        for c in range(mode.contacts):
            resting = resting or mode.grip[c] != SLIP
        if not resting:
            continue
        stand = standing(parameters, w, body, stage.y)
        for c in range(mode.contacts):
            if mode.grip[c] == SLIP:
                continue
            held, seen = holding.contacts[count], space.touches[w * SLOTS + c]
            held.wheel, held.contact, held.roller = w, c, mode.slot[c]
            held.creeps = mode.grip[c] == CREEP
            held.limit = parameters.machine.friction * max(seen.normal_force, 0.0)
            held.turned = 0.0
            h, k = tangent_of(vector(seen.normal, 0))
            feel(parameters, w, c, stand, holding.felt[count, 0], held, 0, h)
            feel(parameters, w, c, stand, holding.felt[count, 1], held, 1, k)
            bias = slip_change(parameters, mode, w, c, stand, stage.y, stage.dy)
            held.bias[0], held.bias[1] = bias.h, bias.k
            held.force[0], held.force[1] = -held.limit * mode.creep[c, 0], -held.limit * mode.creep[c, 1]
            if not held.creeps:
                held.force[0] = held.force[1] = 0.0
            count += 1
    return count


@kernel
def feel(parameters, w, c, stand, felt, held, side, e):
    """What a unit force along e (hub axes) at contact c of wheel w does, into a row of `felt` and HELD."""
    space = parameters.space
    lever = lever_along(parameters, w, stand.hub, c, e)
    put(felt, lever.moment)
    put_at(felt, 3, lever.force)
    if space.carriers is not None:
        for j in range(len(space.carriers)):
            felt[6 + j] = 0.0
        j = space.hubs[w].carrier
        if j >= 0:
            motion = space.motions[j]
            felt[6 + j] = dot(vector(motion.turning, 0), lever.moment) + dot(vector(motion.at_origin, 0), lever.force)
    held.spin[side], held.arm[side] = lever.spin, lever.roller


@kernel
def find_mobility(parameters, count):
    """A of so many contacts at rest, 1/kg."""
    space, holding = parameters.space, parameters.space.holding
    for m in range(count):
        for e in range(2):
            felt, given = holding.felt[m, e], holding.given[m, e]
            for i in range(len(felt)):
                given[i] = felt[i]
            if space.carriers is not None:
                substitute(space.balance, given)
            else:
                put(given, product(space.body.turning, vector(felt, 0)))
                for i in range(3, 6):
                    given[i] = space.body.mobility * felt[i]
    for m in range(count):
        for n in range(count):
            one, other = holding.contacts[m], holding.contacts[n]
            wheel = parameters.wheels[one.wheel]
            for e in range(2):
                for f in range(2):
                    total = 0.0
                    for i in range(len(space.answer)):
                        total += holding.felt[m, e, i] * holding.given[n, f, i]
                    if one.wheel == other.wheel:
                        total += wheel.spin_mobility * one.spin[e] * other.spin[f]
                        if one.roller == other.roller:
                            total += wheel.axial_mobility * one.arm[e] * other.arm[f]
                    holding.mobility[2 * m + e, 2 * n + f] = total


@kernel
def stick(holding, count):
    """Forces of those that stick, with those of the others as they stand."""
    system, side = holding.system, holding.side
    largest, unknowns = TINY, 0
    for m in range(count):
        if holding.contacts[m].creeps:
            continue
        for e in range(2):
            largest = max(largest, holding.mobility[2 * m + e, 2 * m + e])
    for m in range(count):
        if holding.contacts[m].creeps:
            continue
        for e in range(2):
            column = 0
            for n in range(count):
                if not holding.contacts[n].creeps:
                    for f in range(2):
                        system[unknowns, column] = holding.mobility[2 * m + e, 2 * n + f]
                        column += 1
            system[unknowns, unknowns] += PROXIMAL * largest
            unknowns += 1
    if unknowns == 0:
        return
    factorize(system[:unknowns, :unknowns])
    for _ in range(MOST_PROXIMAL):
        row = 0
        for m in range(count):
            if holding.contacts[m].creeps:
                continue
            rate_h, rate_k = rate_of(holding, m, count)
            side[row], side[row + 1] = -rate_h, -rate_k
            row += 2
        substitute(system[:unknowns, :unknowns], side[:unknowns])
        row = 0
        for m in range(count):
            if not holding.contacts[m].creeps:
                force = holding.contacts[m].force
                force[0] += side[row]
                force[1] += side[row + 1]
                row += 2


@kernel
def rate_of(holding, m, count):
    """Slip acceleration of contact m under all forces as they stand (h, k), m/s^2."""
    rate_h, rate_k = holding.contacts[m].bias[0], holding.contacts[m].bias[1]
    for n in range(count):
        force = holding.contacts[n].force
        rate_h += holding.mobility[2 * m, 2 * n] * force[0] + holding.mobility[2 * m, 2 * n + 1] * force[1]
        rate_k += holding.mobility[2 * m + 1, 2 * n] * force[0] + holding.mobility[2 * m + 1, 2 * n + 1] * force[1]
    return rate_h, rate_k


@kernel
def turn_creep(stage, holding, m, count):
    """Turn the direction of creeping contact m by one Newton correction: its size, rad."""
    held = holding.contacts[m]
    a = Symmetric(
        holding.mobility[2 * m, 2 * m], holding.mobility[2 * m, 2 * m + 1], holding.mobility[2 * m + 1, 2 * m + 1]
    )
    rate_h, rate_k = rate_of(holding, m, count)
    force = held.force
    if force[0] == 0.0 and force[1] == 0.0:  # no direction is known yet
        u = slip_direction(a, Slip(rate_h, rate_k), held.limit)
        u_h, u_k, correction = u.h, u.k, 1.0
    else:
        size = math.sqrt(force[0] * force[0] + force[1] * force[1])
        u_h, u_k = -force[0] / size, -force[1] / size
        along = rate_h * u_h + rate_k * u_k
        resisting = held.limit * across(a, u_h, u_k)
        u_h, u_k, correction = turned(u_h, u_k, rate_h, rate_k, resisting, along, held.turned)
        held.turned = correction
    force[0], force[1] = -held.limit * u_h, -held.limit * u_k
    return abs(correction)


@kernel
def yield_to(parameters, stage, body, m):
    """What the force at contact m changes in y', but for the spin, and what is told of it; its heat, W."""
    space, at = parameters.space, places(parameters)
    held, dy = space.holding.contacts[m], stage.dy
    w, c, force = held.wheel, held.contact, held.force
    wheel, seen, mode = parameters.wheels[w], space.touches[w * SLOTS + c], stage.mode[w]
    for e in range(2):
        given = space.holding.given[m, e]
        linear, angular = outward(body.rotation, vector(given, 3)), vector(given, 0)
        put_at(dy, at.velocity, plus(vector(dy, at.velocity), times(force[e], linear)))
        put_at(dy, at.rate, plus(vector(dy, at.rate), times(force[e], angular)))
        for j in range(6, len(space.answer)):
            dy[at.joint_rate + j - 6] += force[e] * given[j]
        place = wheel.rates + (mode.roller[held.roller] if parameters.machine.every_rate else held.roller)
        dy[place] += wheel.axial_mobility * held.arm[e] * force[e]
        parameters.workspace.parts[w].free_spin += held.spin[e] * force[e]
        seen.force[e] = force[e]
    if stage.monitoring:
        monitors = stage.monitors[w]
        if held.creeps:
            u_h, u_k = -force[0] / held.limit, -force[1] / held.limit
            monitors.margin[c] = u_h * seen.slip[0] + u_k * seen.slip[1]
        else:
            monitors.margin[c] = held.limit - math.sqrt(force[0] * force[0] + force[1] * force[1])
    return -(force[0] * seen.slip[0] + force[1] * seen.slip[1])
