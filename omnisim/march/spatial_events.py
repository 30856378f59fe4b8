"""Events of a machine free in space: what ends the validity of its modes, and what they are afterwards.

    guard  while the mode holds                                           afterwards
    DOWN   the chassis is above the ground                                the march stops
    LIMIT  as DRIVE of events.py
    APART  delta >= 0: the rubber is pressed in                           the contact ends
    PIECE  the contact is on its piece of the floor                       it ends
    PRESS  stiffness delta + damping delta' >= 0, or <= 0 while N = 0     the rubber presses no more, or again
    ARC    the lowest point is on its arc of the generatrix               it is on the next
    KINK, GRIP, YOUNG as in events.py
    MEET   what does not touch of a roller is apart from the ground       it touches

Contacts begin and end where delta = 0, N may end before, and the lowest point passes from an arc of the generatrix to
the next, at last to the edge of the roller's end: at each of them the force has a kink, and stepped through it would
cost the order of the method.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import CHASSIS_DOWN, EVENT_KINDS, TOO_MANY_TOUCH
from omnisim.base.vector import Vec3, dot
from omnisim.contact.floor import surface
from omnisim.contact.friction import SATURATED
from omnisim.contact.set_valued import SLIP, STICK
from omnisim.contact.support import next_region, region_guard
from omnisim.dynamics.actuation import limit_guard, next_limit
from omnisim.dynamics.spatial.gaps import gap_of, in_contact, may_be_next
from omnisim.dynamics.spatial.pose import body_of, outward, vector
from omnisim.dynamics.spatial.reaction import react
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import meetings, rate_of_roller, shape_of, standing, touching_at
from omnisim.dynamics.state import places
from omnisim.march.creeping import forget_turning, keep_young
from omnisim.march.event_log import record
from omnisim.march.friction_modes import grip_guard, young_guard
from omnisim.march.grip_events import change_grip
from omnisim.march.runge_kutta import refresh
from omnisim.march.spatial_contacts import add_contact, remove_contact

DOWN, LIMIT, APART, PIECE, PRESS, ARC, KINK, GRIP, YOUNG, MEET = range(10)  # KINK, GRIP, YOUNG as in events.py
OF_FORCES = (LIMIT, KINK, GRIP, YOUNG)  # guards that need a right-hand side: the others need the state alone
SPATIAL_GUARDS = 10
MOST_CHANGES = 50  # of modes that follow one another at one instant
BEGIN, END = EVENT_KINDS.index("contact_begin"), EVENT_KINDS.index("contact_end")
LIFT, LANDING = EVENT_KINDS.index("lift_off"), EVENT_KINDS.index("touch_down")


@kernel
def of_state_alone(kind):
    """Whether guards of this kind are functions of the state alone."""
    return kind not in OF_FORCES


@kernel
def sides_of(parameters, run, kind, w):
    """How many guards of a kind wheel w has at the end of a trial; of MEET none while it touches with nothing more."""
    if kind == MEET:
        overlaps = run.monitors_end[w].gap < 0.0
        return parameters.wheels[w].rollers * meetings(parameters.space, w) if overlaps else 0
    if kind in (DOWN, LIMIT):
        return 1
    return run.mode[w].contacts


@kernel
def spatial_guard(parameters, run, kind, w, side, at_end):
    """Value of a guard at the start of a step, or `at_end`, at the end of its trial: >= 0 while it holds."""
    mode = run.mode[w]
    y = run.trial if at_end else run.y
    monitors = run.monitors_end[w] if at_end else run.monitors[w]
    if kind == APART:
        return monitors.depth[side]
    if kind == PRESS:
        return monitors.press[side] if mode.pressed[side] else -monitors.press[side]
    if kind == ARC:
        return monitors.inside[side]
    if kind == PIECE:
        return monitors.within[side]
    if kind == LIMIT:
        spin_rate = y[places(parameters).spin_rate + w]
        return limit_guard(parameters.machine, parameters.wheels[w], mode.drive, monitors.demand, spin_rate)
    if kind == KINK:
        if parameters.machine.law != SATURATED:
            return 0.0
        excess = math.sqrt(monitors.slip_square[side]) - parameters.machine.slip_speed
        return excess if mode.saturated[side] else -excess
    if kind in (GRIP, YOUNG):
        if parameters.workspace.resting is None or mode.grip[side] == SLIP:
            return 0.0
        if kind == GRIP:
            return grip_guard(parameters, run, w, side, at_end)
        return young_guard(parameters, run, w, side, at_end)
    if kind == DOWN:
        return clearance(parameters, y) if w == 0 else 0.0
    return 0.0 if monitors.gap >= 0.0 else gap_in(parameters, mode, w, side, y)


@kernel
def may_meet(parameters, mode, w, side):
    """Whether a guard MEET of wheel w may fire: of most rollers, which are in the air, none may."""
    rollers = parameters.wheels[w].rollers
    i, meeting = side % rollers, side // rollers
    return may_be_next(parameters, mode, w, i) and not in_contact(mode, i, meeting)


@kernel
def gap_in(parameters, mode, w, side, y):
    """Value of guard MEET of wheel w in state y."""
    rollers = parameters.wheels[w].rollers
    return gap_of(parameters, y, w, side % rollers, side // rollers) if may_meet(parameters, mode, w, side) else 0.0


@outlined
def guard_in(parameters, mode, kind, w, side, y):
    """Value in state y of a guard that needs no more."""
    if kind == DOWN:
        return clearance(parameters, y)
    if kind == MEET:
        return gap_in(parameters, mode, w, side, y)
    stand = standing(parameters, w, body_of(parameters, y), y)
    touched = touching_at(parameters, mode, w, side, stand)
    if kind == APART:
        return touched.depth
    if kind == PIECE:
        return touched.within
    if kind == ARC:
        return region_guard(shape_of(parameters.space, w, mode.meeting[side]), mode.region[side], touched.tilt)
    found = react(parameters, mode, w, side, stand, touched, y[rate_of_roller(parameters, mode, w, side)])
    return found.press if mode.pressed[side] else -found.press


@kernel
def all_stay(parameters, run, w):
    """Whether every guard of wheel w holds at the end of a trial."""
    mode, monitors = run.mode[w], run.monitors_end[w]
    held = spatial_guard(parameters, run, LIMIT, w, 0, True) >= 0.0
    held = held and spatial_guard(parameters, run, DOWN, w, 0, True) >= 0.0
    for c in range(mode.contacts):
        press = monitors.press[c] if mode.pressed[c] else -monitors.press[c]
        held = held and monitors.depth[c] >= 0.0 and press >= 0.0
        held = held and monitors.inside[c] >= 0.0 and monitors.within[c] >= 0.0
        if parameters.machine.law == SATURATED:
            held = held and spatial_guard(parameters, run, KINK, w, c, True) >= 0.0
        if parameters.workspace.resting is not None:
            held = held and spatial_guard(parameters, run, GRIP, w, c, True) >= 0.0
            held = held and spatial_guard(parameters, run, YOUNG, w, c, True) >= 0.0
    return held and monitors.gap >= 0.0


@kernel
def clearance(parameters, y):
    """Height of the lowest corner of the chassis over the ground, m."""
    space = parameters.space
    body = body_of(parameters, y)
    rotation = body.rotation
    up = Vec3(rotation.x.z, rotation.y.z, rotation.z.z)
    least = math.inf
    for i in range(space.body.corners):
        corner = vector(space.body.hull[i], 0)
        height = body.position.z + dot(up, corner)
        if space.body.uneven:
            place = outward(rotation, corner)
            height -= surface(space.floor, body.position.x + place.x, body.position.y + place.y).height
        least = min(least, height)
    return least


@outlined
def change_in_space(parameters, run, log, kind, w, side, time):
    """Change the modes after a guard fired at `time`, of contacts all that change with it, and the derivative."""
    mode, changes = run.mode[w], parameters.space.changes
    forget_turning(parameters, run)
    if kind == DOWN:
        run.clock.status, run.clock.wheel = CHASSIS_DOWN, -1
    elif kind == LIMIT:
        spin_rate = run.y[places(parameters).spin_rate + w]
        mode.drive = next_limit(parameters.machine, parameters.wheels[w], mode.drive, run.monitors[w].demand, spin_rate)
    elif kind == KINK:
        mode.saturated[side] = 1 - mode.saturated[side]
    elif of_state_alone(kind):
        count, then = 0, time - run.clock.late
        while changes[count, 0] >= 0:
            change_contact(parameters, run, log, changes[count, 0], changes[count, 1], changes[count, 2], then)
            count += 1
        run.clock.late = 0.0
    elif parameters.workspace.resting is not None:
        change_grip(parameters, run, log, kind == GRIP, w, side, time)
    refresh(parameters, run, time)


@kernel
def change_contact(parameters, run, log, kind, w, side, time):
    """Let a contact begin, end, press or go on, as a guard tells that fired at `time`."""
    mode, clock = run.mode[w], run.clock
    if kind in (APART, PIECE):
        if clock.late > 0.0:  # rubber was stretched since: what the loss has given for that is given back
            depth = run.monitors[w].depth[side]
            run.y[places(parameters).contact_loss] += 0.5 * parameters.space.hubs[w].stiffness * depth * depth
        record(clock, log, time, END, w, mode.roller[mode.slot[side]], -1)
        remove_contact(parameters, run, w, side)
        if mode.contacts == 0 and not passed_on(parameters.space.changes, w):
            record(clock, log, time, LIFT, w, -1, -1)
    elif kind == PRESS:
        mode.pressed[side] = 1 - mode.pressed[side]
        mode.grip[side] = SLIP
    elif kind == ARC:
        shape = shape_of(parameters.space, w, mode.meeting[side])
        stand = standing(parameters, w, body_of(parameters, run.y), run.y)
        tilt = touching_at(parameters, mode, w, side, stand).tilt
        mode.region[side] = next_region(shape, mode.region[side], tilt)
    elif mode.contacts == SLOTS:
        clock.status, clock.wheel = TOO_MANY_TOUCH, w
    else:
        rollers = parameters.wheels[w].rollers
        if mode.contacts == 0 and not passed_on(parameters.space.changes, w):
            record(clock, log, time, LANDING, w, -1, -1)
        record(clock, log, time, BEGIN, w, -1, side % rollers)
        add_contact(parameters, run, w, side % rollers, side // rollers)


@kernel
def passed_on(changes, w):
    """Whether the ground passes wheel w on from piece to piece: contacts end and begin at once, none is in the air."""
    ends = begins = False
    count = 0
    while changes[count, 0] >= 0:
        if changes[count, 1] == w:
            ends = ends or changes[count, 0] in (APART, PIECE)
            begins = begins or changes[count, 0] == MEET
        count += 1
    return ends and begins


@outlined
def restore_in_space(parameters, run, log, time):
    """Limits of drives and cones that the last change has left behind: modes follow until all agree."""
    for _ in range(MOST_CHANGES):
        changed = False
        for w in range(len(run.mode)):
            if spatial_guard(parameters, run, LIMIT, w, 0, False) < 0.0:
                change_in_space(parameters, run, log, LIMIT, w, 0, time)
                changed = True
            for c in range(run.mode[w].contacts):
                sticks = parameters.workspace.resting is not None and run.mode[w].grip[c] == STICK
                if sticks and spatial_guard(parameters, run, GRIP, w, c, False) < 0.0:
                    change_in_space(parameters, run, log, GRIP, w, c, time)
                    changed = True
        if not changed:
            keep_young(parameters, run)
            return
