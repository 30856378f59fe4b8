"""Which rollers of a machine free in space touch the ground: how contacts begin, end, and what is remembered of them.

The rates of rollers that touch are states; those of all others stand in `rates`, and enter through three sums. A roller
may have several contacts, with the ground before a step and with its edge, or of its lobes: one rate, several forces.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.common_normal import ANY, Roller, room
from omnisim.contact.floor import pieces
from omnisim.contact.friction import SATURATED
from omnisim.contact.set_valued import SLIP
from omnisim.contact.support import region_of
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import in_world, meetings, roller_on, shape_of, standing, touching
from omnisim.march.friction_modes import come_to_rest
from omnisim.march.runge_kutta import refresh

FAR = 1.0  # m: a gap where no common normal is found, which events can still be located with


@kernel
def gap_of(parameters, y, w, i, meeting):
    """How far roller i of wheel w is from touching at a meeting in state y, m; < 0: it overlaps."""
    return gap_at(parameters, w, standing(parameters, w, body_of(parameters, y), y), i, meeting)


@kernel
def gap_at(parameters, w, stand, i, meeting):
    """The same of its Standing."""
    space = parameters.space
    if space.body.uneven:
        centre, axis = in_world(stand, roller_on(parameters, w, i, stand))
        roller = Roller(shape_of(space, w, meeting), centre, axis)
        away = room(space.floor, meeting % pieces(space.floor), roller)
        if away > 0.0:
            return away
    touched = touching(parameters, w, stand, meeting, ANY, i)
    return min(-min(touched.depth, touched.within), FAR)


@kernel
def in_contact(mode, i, meeting):
    """Whether roller i touches at this meeting."""
    found = False
    for c in range(mode.contacts):
        found = found or (mode.roller[mode.slot[c]] == i and mode.meeting[c] == meeting)
    return found


@kernel
def nothing_meets(parameters, mode, w, y):
    """Whether no roller of wheel w overlaps the ground but where it touches it, in state y.

    On a plane a wheel is round enough: the next to touch is another lobe of a roller that does, its neighbour, or in
    the air that of the lowest place.
    """
    wheel = parameters.wheels[w]
    space = parameters.space
    stand = standing(parameters, w, body_of(parameters, y), y)
    free = True
    if space.body.uneven:
        for meeting in range(meetings(space, w)):
            for i in range(wheel.rollers):
                if not in_contact(mode, i, meeting):
                    free = free and gap_at(parameters, w, stand, i, meeting) >= 0.0
        return free
    rows, lobes = space.hubs[w].row_count, space.hubs[w].lobes
    if mode.contacts == 0:
        lowest = lowest_roller(parameters, w, stand)
        for step in range(-rows, 2 * rows):
            for lobe in range(lobes):
                free = free and gap_at(parameters, w, stand, (lowest + step) % wheel.rollers, lobe) >= 0.0
        return free
    for c in range(mode.contacts):
        for step in range(-rows, rows + 1):
            i = (mode.roller[mode.slot[c]] + step) % wheel.rollers
            for lobe in range(lobes):
                if not in_contact(mode, i, lobe):
                    free = free and gap_at(parameters, w, stand, i, lobe) >= 0.0
    return free


@outlined
def lowest_roller(parameters, w, stand):
    """The roller of the first row of wheel w that is next to the lowest place of the wheel, 0..N-1."""
    wheel, space = parameters.wheels[w], parameters.space
    rows = space.hubs[w].row_count
    first = roller_on(parameters, w, 0, stand)
    # azimuth of the lowest place less that of roller 0
    q_low = math.atan2(-stand.normal.x, stand.normal.z)
    q_0 = math.atan2(first.sin_q, first.cos_q)
    pitch = 2.0 * math.pi * rows / wheel.rollers
    return (round((q_low - q_0) / pitch) * rows) % wheel.rollers


@kernel
def stand_in_space(parameters, run):
    """The contacts at t = 0, and the derivative."""
    for w in range(len(run.mode)):
        mode = run.mode[w]
        mode.rollers = mode.contacts = 0
        sum_air(parameters, run, w)
        for meeting in range(meetings(parameters.space, w)):
            for i in range(parameters.wheels[w].rollers):
                if gap_of(parameters, run.y, w, i, meeting) < 0.0 and mode.contacts < SLOTS:
                    add_contact(parameters, run, w, i, meeting)
    refresh(parameters, run, 0.0)
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for c in range(mode.contacts):
            mode.pressed[c] = run.monitors[w].press[c] >= 0.0
            mode.saturated[c] = branch(parameters, run, w, c)
    refresh(parameters, run, 0.0)
    if parameters.workspace.resting is not None:
        come_to_rest(parameters, run, -1, 0, True, 0.0)


@kernel
def add_contact(parameters, run, w, i, meeting):
    """Let roller i of wheel w touch at a meeting."""
    mode = run.mode[w]
    slot = -1
    for r in range(mode.rollers):
        slot = r if mode.roller[r] == i else slot
    c = mode.contacts
    mode.contacts = c + 1
    mode.first[c] = slot < 0
    if slot < 0:
        slot = mode.rollers
        mode.rollers = slot + 1
        mode.roller[slot] = i
        if not parameters.machine.every_rate:
            place = parameters.wheels[w].rates + slot
            run.y[place], run.carry[place] = run.rates[w, i], 0.0
            sum_air(parameters, run, w)
    mode.slot[c], mode.meeting[c], mode.pressed[c] = slot, meeting, 1
    mode.region[c] = region_here(parameters, run.y, w, i, meeting)
    mode.saturated[c] = 0
    mode.grip[c], mode.stopping[c], mode.stopped[c] = SLIP, 0, 0


@kernel
def region_here(parameters, y, w, i, meeting):
    """In which region the lowest point of roller i of wheel w is."""
    stand = standing(parameters, w, body_of(parameters, y), y)
    tilt = touching(parameters, w, stand, meeting, ANY, i).tilt
    return region_of(shape_of(parameters.space, w, meeting), tilt)


@kernel
def remove_contact(parameters, run, w, c):
    """Let contact c of wheel w end; its roller leaves the ground if it has no other."""
    mode = run.mode[w]
    release(parameters, run, w)
    slot, was_first = mode.slot[c], mode.first[c]
    last = mode.contacts - 1
    for d in range(c, last):
        mode.slot[d], mode.first[d], mode.meeting[d] = mode.slot[d + 1], mode.first[d + 1], mode.meeting[d + 1]
        mode.region[d], mode.pressed[d] = mode.region[d + 1], mode.pressed[d + 1]
        mode.saturated[d], mode.grip[d] = mode.saturated[d + 1], mode.grip[d + 1]
        mode.stopping[d], mode.stopped[d] = mode.stopping[d + 1], mode.stopped[d + 1]
        mode.creep[d, 0], mode.creep[d, 1] = mode.creep[d + 1, 0], mode.creep[d + 1, 1]
    mode.contacts = last
    other = -1
    for d in range(last - 1, -1, -1):
        other = d if mode.slot[d] == slot else other
    if other >= 0:
        mode.first[other] = mode.first[other] or was_first
        return
    for r in range(slot, mode.rollers - 1):
        mode.roller[r] = mode.roller[r + 1]
    for d in range(last):
        if mode.slot[d] > slot:
            mode.slot[d] -= 1
    mode.rollers -= 1
    if parameters.machine.every_rate:
        return
    for r in range(SLOTS):
        place = parameters.wheels[w].rates + r
        run.y[place] = run.rates[w, mode.roller[r]] if r < mode.rollers else 0.0
        run.carry[place] = 0.0
    sum_air(parameters, run, w)


@kernel
def release(parameters, run, w):
    """Write the rates of the rollers that touch back to `rates`, where those of all rollers stand."""
    mode, wheel = run.mode[w], parameters.wheels[w]
    if parameters.machine.every_rate:
        for i in range(wheel.rollers):
            run.rates[w, i] = run.y[wheel.rates + i]
        return
    for slot in range(mode.rollers):
        run.rates[w, mode.roller[slot]] = run.y[wheel.rates + slot]


@kernel
def sum_air(parameters, run, w):
    """The sums over the rollers of wheel w in the air, anew each time, so they never drift."""
    mode, wheel = run.mode[w], parameters.wheels[w]
    mode.air_cos, mode.air_sin, mode.air_sum = 0.0, 0.0, 0.0
    for i in range(wheel.rollers):
        touches = False
        for slot in range(mode.rollers):
            touches = touches or mode.roller[slot] == i
        if not touches:
            rate, place = run.rates[w, i], parameters.space.disk[w, i]
            mode.air_cos += rate * place[0]
            mode.air_sin += rate * place[1]
            mode.air_sum += rate


@kernel
def branch(parameters, run, w, c):
    """Branch of the saturated friction law of contact c, as its slip is."""
    machine = parameters.machine
    if machine.law != SATURATED:
        return 0
    return 1 if run.monitors[w].slip_square[c] > machine.slip_speed * machine.slip_speed else 0
