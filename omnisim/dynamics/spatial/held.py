"""Contacts at rest on a machine free in space, their mobility A, and the forces or impulses that hold them.

Wheels that are held in more ways than they can move have no unique forces: of all, the smallest is taken, by a few
rounds of the proximal point method. Forces are asked for in holding.py, impulses in aligning.py.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import combine, dot
from omnisim.contact.set_valued import CREEP, SLIP, TINY
from omnisim.dynamics.spatial.carriers import factorize, substitute
from omnisim.dynamics.spatial.mobility import lever_along
from omnisim.dynamics.spatial.pose import product, put, put_at, tangent_of, vector
from omnisim.dynamics.spatial.seen import standing_seen, touch_place, touching_seen

REGULAR = 1e-6  # of the largest mobility: what is left of each where there is one way to hold
PROXIMAL = 1e-8  # of the largest mobility: what keeps the system regular
MOST_PROXIMAL = 4  # rounds, each of which leaves 1e-8 of the error before it
LOST = 1e-16  # of the largest force: a correction of that size is lost in rounding


class Firm(NamedTuple):
    """Along how many axes contacts are held, and p, 1/kg, which is added to their A: 0 where there is one way to."""

    axes: int
    added: float


@kernel
def gather(parameters, mode, body, aligning):
    """The contacts at rest into the workspace, with their levers, where look_at_all has seen them: how many.
    `aligning`: those of creeping ones are across and along their direction."""
    space = parameters.space
    holding = space.holding
    count = 0
    for w in range(len(mode)):
        for c in range(mode[w].contacts):
            if mode[w].grip[c] == SLIP:
                continue
            seen = space.touches[touch_place(w, c)]
            stand, touched = standing_seen(space.stands[w], body), touching_seen(seen)
            held, creep = holding.contacts[count], mode[w].creep[c]
            held.wheel, held.contact, held.roller = w, c, mode[w].slot[c]
            held.creeps = mode[w].grip[c] == CREEP
            held.limit = parameters.machine.friction * max(seen.normal_force, 0.0)
            held.firm = (1 if aligning else 0) if held.creeps else 2
            held.turned = 0.0
            for i in range(2):
                held.begun[i], held.veer[i] = creep[i], mode[w].veer[c, i]
                held.slip[i] = seen.slip[i]
            h, k = tangent_of(touched.normal)
            axis = touched.roller.axis
            along_h, along_k = dot(axis, h), dot(axis, k)
            size = max(math.sqrt(along_h * along_h + along_k * along_k), TINY)
            held.line[0], held.line[1] = along_h / size, along_k / size
            if aligning and held.creeps:
                along = combine(creep[0], h, creep[1], k, 0.0, h)
                h, k = combine(creep[0], k, -creep[1], h, 0.0, h), along
            feel(parameters, w, stand, touched, held, holding.felt[count], (h, k))
            count += 1
    return count


@kernel
def feel(parameters, w, stand, touched, held, felt, directions):
    """What unit forces along two directions (hub axes) do where a roller of wheel w touches, into `felt` (2, 6 + C) and
    HELD."""
    space = parameters.space
    for e in range(2):
        lever = lever_along(parameters, w, stand.hub, touched, directions[e])
        put(felt[e], lever.moment)
        put_at(felt[e], 3, lever.force)
        for j in range(6, len(space.answer)):
            felt[e, j] = 0.0
        if space.hubs[w].carrier >= 0:
            j = space.hubs[w].carrier
            motion = space.motions[j]
            turning = dot(vector(motion.turning, 0), lever.moment)
            felt[e, 6 + j] = turning + dot(vector(motion.at_origin, 0), lever.force)
        held.spin[e], held.arm[e] = lever.spin, lever.roller


@kernel
def find_mobility(parameters, count):
    """A of so many contacts at rest, 1/kg."""
    space, holding = parameters.space, parameters.space.holding
    for m in range(count):
        for e in range(2):
            felt, given = holding.felt[m, e], holding.given[m, e]
            for i in range(len(felt)):
                given[i] = felt[i]
            if len(space.carriers) > 0:
                substitute(space.balance, len(given), given)
            else:
                put(given, product(space.body.turning, vector(felt, 0)))
                for i in range(3, 6):
                    given[i] = space.body.mobility * felt[i]
    for m in range(count):
        for n in range(m + 1):
            one, other = holding.contacts[m], holding.contacts[n]
            wheel = parameters.wheels[one.wheel]
            for e in range(2):
                for f in range(2 if n < m else e + 1):
                    total = accelerated(holding, m, e, n, f)
                    if one.wheel == other.wheel:
                        total += wheel.spin_mobility * one.spin[e] * other.spin[f]
                        if one.roller == other.roller:
                            total += wheel.axial_mobility * one.arm[e] * other.arm[f]
                    holding.mobility[2 * m + e, 2 * n + f] = holding.mobility[2 * n + f, 2 * m + e] = total


@kernel
def accelerated(holding, m, e, n, f):
    """Slip acceleration of contact m along e by what a unit force at n along f does to chassis and carriers, 1/kg."""
    felt, given = holding.felt[m, e], holding.given[n, f]
    total = dot(vector(felt, 0), vector(given, 0)) + dot(vector(felt, 3), vector(given, 3))
    for j in range(6, len(felt)):
        total += felt[j] * given[j]
    return total


@kernel
def factorize_firm(holding, count):
    """Factors of A along what is held, or of A + p where that can be held in more than one way: the Firm."""
    axes = fill_firm(holding, count, 0.0)
    largest = TINY
    for m in range(axes):
        largest = max(largest, holding.system[m, m])
    if factorize(holding.system, axes) > REGULAR * largest:
        return Firm(axes, 0.0)
    fill_firm(holding, count, PROXIMAL * largest)
    factorize(holding.system, axes)
    return Firm(axes, PROXIMAL * largest)


@kernel
def fill_firm(holding, count, added):
    """A + p along what is held into `system`: along how many axes."""
    axes = 0
    for m in range(count):
        for e in range(holding.contacts[m].firm):
            column = 0
            for n in range(m + 1):
                for f in range(holding.contacts[n].firm):
                    holding.system[axes, column] = holding.mobility[2 * m + e, 2 * n + f]
                    column += 1
            holding.system[axes, axes] += added
            axes += 1
    return axes


@kernel
def stick(holding, count, firm):
    """Forces along what is held, with those of creeping contacts as they stand; firm: their Firm.

    Each round solves (A + p) d = -v'; what it leaves of v' is -p d.
    """
    side = holding.side
    row = 0
    for m in range(count):
        for e in range(holding.contacts[m].firm):
            side[row] = -rate_of(holding, m, e, count)
            row += 1
    last = TINY
    for _ in range(MOST_PROXIMAL):
        substitute(holding.system, firm.axes, side)
        row, largest, change = 0, TINY, 0.0
        for m in range(count):
            force = holding.contacts[m].force
            for e in range(holding.contacts[m].firm):
                force[e] += side[row]
                largest, change = max(largest, abs(force[e])), max(change, abs(side[row]))
                side[row] *= firm.added
                row += 1
        if firm.added == 0.0 or change * change <= LOST * largest * last:  # as they fall, the next is lost
            break
        last = change


@kernel
def rate_of(holding, m, e, count):
    """Slip acceleration of contact m along its axis e under all forces as they stand, m/s^2."""
    rate = holding.contacts[m].bias[e]
    for n in range(count):
        force = holding.contacts[n].force
        rate += holding.mobility[2 * m + e, 2 * n] * force[0] + holding.mobility[2 * m + e, 2 * n + 1] * force[1]
    return rate
