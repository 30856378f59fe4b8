"""Which rollers of a machine free in space touch the ground: how contacts begin, end, and what is remembered of them.

The rates of rollers that touch are states; those of all others stand in `rates`, and enter through three sums. A roller
may have several contacts, with the ground before a step and with its edge, or of its lobes: one rate, several forces.
"""

from omnisim.base.kernel import kernel
from omnisim.contact.common_normal import ANY
from omnisim.contact.friction import SATURATED
from omnisim.contact.set_valued import SLIP
from omnisim.contact.support import region_of
from omnisim.dynamics.spatial.acceleration import slip_at
from omnisim.dynamics.spatial.gaps import gap_of
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import meetings, shape_of, standing, touching
from omnisim.march.friction_modes import come_to_rest
from omnisim.march.runge_kutta import refresh


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
    mode.grip[c], mode.stopping[c], mode.stopped[c] = SLIP, 0, 0
    mode.pull[c], mode.settled[c], mode.strayed[c], mode.foreseen[c] = 0.0, 0.0, 0.0, 0
    mode.saturated[c] = branch(parameters, run, w, c)


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
        mode.veer[d, 0], mode.veer[d, 1] = mode.veer[d + 1, 0], mode.veer[d + 1, 1]
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
            rate = run.rates[w, i]
            mode.air_cos += rate * parameters.space.disk[w, 0, i]
            mode.air_sin += rate * parameters.space.disk[w, 1, i]
            mode.air_sum += rate


@kernel
def branch(parameters, run, w, c):
    """Branch of the saturated friction law of contact c, as its slip is."""
    machine = parameters.machine
    if machine.law != SATURATED:
        return 0
    slip = slip_at(parameters, run.mode[w], w, c, run.y)
    return 1 if slip.h * slip.h + slip.k * slip.k > machine.slip_speed * machine.slip_speed else 0
