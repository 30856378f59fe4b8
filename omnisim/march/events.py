"""Events: what ends the validity of a mode, and what the mode is afterwards.

A guard is >= 0 as long as its mode holds. A step at whose end one is negative is cut at the root, and the row below
tells what changes there.

    guard  while the mode holds                           afterwards
    TURN   the spin keeps its sense: direction phi' >= 0  direction reversed; so EXIT is monotone within every step
    EXIT   the roller's end ahead is not passed yet       the neighbour takes over: an exchange
    SHARE  each of two rollers alone would push back      one of them carries on alone
    LOAD   N >= 0, of a wheel in the air N <= 0           it leaves the floor or touches down
    JAM    friction leaves the loads determined           the march stops
    DRIVE  the drive is asked for less than its limits, or it gives its limit, another, or less again
           for more while it gives one of them
    KINK   |v| stays on its side of slip_speed            the other branch of the saturated law
    GRIP   a sticking force stays inside the cone         it creeps off
           a creeping slip keeps its sense                it comes to rest
    YOUNG  creeping slip stays slow                       it slips in a direction of its own

Both trackings pass a roller's end at the same spin angle: |q| = alpha is |c_beta| = c sin alpha. The guard is the
angle, monotone over several turns as well; which rollers touch at the start, each tracking tells by its own condition.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import EVENT_KINDS, JAMMED, LIFT_OFF, RUNNING, TIPPING
from omnisim.contact.friction import SATURATED
from omnisim.contact.set_valued import SLIP, STICK
from omnisim.dynamics.actuation import limit_guard, next_limit
from omnisim.dynamics.indices import contact_count, roller_index
from omnisim.dynamics.normal_forces.rigid_plane import LEAST_REGULAR
from omnisim.dynamics.parameters import CONTACTS
from omnisim.dynamics.state import places
from omnisim.dynamics.wheel import roller_end
from omnisim.march.creeping import forget_turning, keep_young
from omnisim.march.event_log import record
from omnisim.march.friction_modes import grip_guard, young_guard
from omnisim.march.grip_events import SLIPS, STUCK, change_grip, record_grip
from omnisim.march.roller_exchange import comes_to_rest_between, edge_rounding, leave_edge, release_rollers, stand_on
from omnisim.march.runge_kutta import refresh
from omnisim.march.spatial_events import (
    SPATIAL_GUARDS,
    all_stay,
    change_in_space,
    restore_in_space,
    sides_of,
    spatial_guard,
)

TURN, EXIT, SHARE, LOAD, JAM, DRIVE, KINK, GRIP, YOUNG = range(9)
OF_WHEEL, GUARDS = 6, 9  # the first are of the wheel, the others of each of its contacts
ANGLE_ROUNDING = 16.0 * 2.0**-53
EPSILON = 4.0 * 2.0**-52
ROOT = 1e-12  # of a step: an event that is located so well is located
LOAD_PLAY = 1e-12  # of the weight: in the rounding of its load a wheel that has left the floor does not land again
MOST_CHANGES = 50  # of modes that follow one another at one instant
MOST_TRIED = 10  # wheels of which all sets are tried
ON_A_LINE = 1e-9  # of the extent of the wheels squared
EXCHANGE, LIFT, LANDING, SHARED, PARTED, STOP = map(EVENT_KINDS.index, (
    "exchange", "lift_off", "touch_down", "share_begin", "share_end", "stop",
))  # fmt: skip


class Guard(NamedTuple):
    """One guard: its kind, of which wheel, and of which of its contacts if it has one for each."""

    kind: int
    wheel: int
    side: int


NO_GUARD = Guard(-1, -1, 0)


@kernel
def resolution(h, t):
    """To how much time an event is located in a step of length h that starts at t, s."""
    return ROOT * h + EPSILON * (t + h)


@kernel
def guard(parameters, run, which, at_end):
    """Value of a Guard at the start of a step, or `at_end`, at the end of its trial: >= 0 while it holds."""
    if parameters.space is not None:
        return spatial_guard(parameters, run, which.kind, which.wheel, which.side, at_end)
    return upright_guard(parameters, run, which, at_end)


@kernel
def guard_kinds(parameters):
    """How many kinds of guards there are."""
    return GUARDS if parameters.space is None else SPATIAL_GUARDS


@kernel
def guard_count(parameters, run, kind, w):
    """How many guards of a kind wheel w has."""
    if parameters.space is not None:
        return sides_of(parameters, run, kind, w)
    return 2 if kind >= OF_WHEEL and run.mode[w].shared else 1


@kernel
def upright_guard(parameters, run, which, at_end):
    """The same of a machine that is upright."""
    kind, w, side = which
    machine = parameters.machine
    wheel = parameters.wheels[w]
    at = places(parameters)
    mode = run.mode[w]
    y = run.trial if at_end else run.y
    monitors = run.monitors_end[w] if at_end else run.monitors[w]
    direction = mode.direction
    if kind == TURN:  # that of a wheel on two rollers is zero, but for what an implicit step leaves of it
        return 0.0 if mode.shared else direction * y[at.spin_rate + w]
    if kind == EXIT:
        spin_angle = y[at.spin_angle + w]
        rounding = ANGLE_ROUNDING * (1.0 + abs(spin_angle))  # an edge reached to rounding is reached
        return direction * (roller_end(wheel, mode.roller, direction) - spin_angle) - rounding
    if kind == SHARE:
        return monitors.share_margin + edge_rounding(parameters, mode, w, y, monitors) if mode.shared else 0.0
    if kind == LOAD:
        play = LOAD_PLAY * machine.mass * machine.gravity
        return monitors.normal_force if mode.loaded else play - monitors.normal_force
    if kind == JAM:
        return monitors.regular - LEAST_REGULAR
    if kind == DRIVE:
        return limit_guard(parameters.machine, wheel, mode.drive, monitors.demand, y[at.spin_rate + w])
    if kind == KINK:
        if machine.law != SATURATED:
            return 0.0
        excess = math.sqrt(monitors.slip_square[side]) - machine.slip_speed
        return excess if mode.saturated[side] else -excess
    if parameters.workspace.resting is None or mode.grip[side] == SLIP:
        return 0.0
    if kind == GRIP:
        return grip_guard(parameters, run, w, side, at_end)
    return young_guard(parameters, run, w, side, at_end)


@kernel
def all_hold(parameters, run, w):
    """Whether every guard of wheel w holds at the end of a trial: what most steps ask, and all that they ask."""
    if parameters.space is not None:
        return all_stay(parameters, run, w)
    return all_held(parameters, run, w)


@kernel
def all_held(parameters, run, w):
    """The same of a machine that is upright."""
    held = guard(parameters, run, Guard(TURN, w, 0), True) >= 0.0
    held = held and guard(parameters, run, Guard(EXIT, w, 0), True) >= 0.0
    held = held and guard(parameters, run, Guard(SHARE, w, 0), True) >= 0.0
    held = held and guard(parameters, run, Guard(LOAD, w, 0), True) >= 0.0
    held = held and guard(parameters, run, Guard(JAM, w, 0), True) >= 0.0
    held = held and guard(parameters, run, Guard(DRIVE, w, 0), True) >= 0.0
    if parameters.workspace.resting is not None or parameters.machine.law == SATURATED:
        for side in range(contact_count(run.mode[w])):
            held = held and guard(parameters, run, Guard(KINK, w, side), True) >= 0.0
            held = held and guard(parameters, run, Guard(GRIP, w, side), True) >= 0.0
            held = held and guard(parameters, run, Guard(YOUNG, w, side), True) >= 0.0
    return held


@outlined
def transition(parameters, run, log, fired, time):
    """Change the mode after a Guard fired at `time`, and the derivative with it."""
    if parameters.space is not None:
        change_in_space(parameters, run, log, fired.kind, fired.wheel, fired.side, time)
    else:
        forget_turning(parameters, run)
        change_mode(parameters, run, log, fired, time)


@kernel
def change_mode(parameters, run, log, fired, time):
    """The same of a machine that is upright."""
    kind, w, side = fired
    mode = run.mode[w]
    clock = run.clock
    wheel = parameters.wheels[w]
    if kind == TURN:
        mode.direction = -mode.direction
        roller = mode.roller
        if comes_to_rest_between(parameters, run, w, time):
            joins = mode.roller if mode.roller != roller else roller - 1
            record(clock, log, time, SHARED, w, roller_index(wheel, roller), roller_index(wheel, joins))
    elif kind == EXIT:
        roller = mode.roller + mode.direction
        record(clock, log, time, EXCHANGE, w, roller_index(wheel, mode.roller), roller_index(wheel, roller))
        release_rollers(parameters, run, w)
        held = mode.grip[0] == STICK
        stand_on(parameters, run, w, roller, False, time)
        if held != (mode.grip[0] == STICK):
            record_grip(parameters, run, log, time, SLIPS if held else STUCK, w, -1)
    elif kind == SHARE:
        left = leave_edge(parameters, run, w, time)
        record(clock, log, time, PARTED, w, roller_index(wheel, left), roller_index(wheel, mode.roller))
    elif kind == LOAD:
        change_load(parameters, run, log, w, time)
    elif kind == JAM:
        clock.status = JAMMED
        clock.wheel = heaviest(run)
    elif kind == DRIVE:
        spin_rate = run.y[places(parameters).spin_rate + w]
        mode.drive = next_limit(parameters.machine, parameters.wheels[w], mode.drive, run.monitors[w].demand, spin_rate)
        refresh(parameters, run, time)
    elif kind == KINK:
        mode.saturated[side] = 1 - mode.saturated[side]
        refresh(parameters, run, time)
    elif parameters.workspace.resting is not None:
        change_grip(parameters, run, log, kind == GRIP, w, side, time)


@kernel
def change_load(parameters, run, log, w, time):
    """A wheel leaves the floor or touches down; of fewer than three that the machine stands on it falls."""
    mode = run.mode[w]
    clock = run.clock
    record(clock, log, time, LIFT if mode.loaded else LANDING, w, -1, -1)
    if parameters.machine.upright != CONTACTS:
        clock.status, clock.wheel = LIFT_OFF, w
        return
    mode.loaded = 1 - mode.loaded
    mode.grip[0] = mode.grip[1] = SLIP
    if not carried(parameters, run):
        mode.loaded = 1
        clock.status, clock.wheel = TIPPING, w
    refresh(parameters, run, time)


@kernel
def carried(parameters, run):
    """Whether the wheels on the floor do not all stand on one line: less than that carries no machine."""
    count, x, y, xx, xy, yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
    for w in range(len(run.mode)):
        if run.mode[w].loaded:
            point = parameters.workspace.parts[w].point
            count = count + 1
            x = x + point[0]
            y = y + point[1]
            xx, xy, yy = xx + point[0] * point[0], xy + point[0] * point[1], yy + point[1] * point[1]
    if count < 3:
        return False
    xx, xy, yy = xx - x * x / count, xy - x * y / count, yy - y * y / count
    return xx * yy - xy * xy > ON_A_LINE * (xx + yy) * (xx + yy)


@kernel
def heaviest(run):
    """The wheel with the largest load."""
    found = 0
    for w in range(len(run.mode)):
        if run.monitors[w].normal_force > run.monitors[found].normal_force:
            found = w
    return found


@outlined
def restore_consistency(parameters, run, log, time):
    """Guards that the last change has left behind: modes follow until all agree.

    Edges reached at the same instant, and what jumps with the forces: cones, loads, limits of drives. An instant is as
    long as events are resolved: rollers that change together by symmetry do so in one event, and no state in between,
    which only rounding makes, enters the extremes.
    """
    if parameters.space is not None:
        restore_in_space(parameters, run, log, time)
    else:
        restore_modes(parameters, run, log, time)


@kernel
def restore_modes(parameters, run, log, time):
    """The same of a machine that is upright."""
    instant = resolution(run.clock.dt, time)
    spins = places(parameters).spin_rate
    for _ in range(MOST_CHANGES):
        changed = -1
        for kind in (EXIT, DRIVE, GRIP, LOAD):
            for w in range(len(run.mode)):
                sticks = run.mode[w].grip[0] == STICK and not run.mode[w].shared
                if run.clock.status != RUNNING or (kind == GRIP and not sticks):
                    continue
                early = 2.0 * run.mode[w].direction * run.y[spins + w] * instant if kind == EXIT else 0.0
                if guard(parameters, run, Guard(kind, w, 0), False) < early:
                    transition(parameters, run, log, Guard(kind, w, 0), time)
                    changed = kind
        if changed < 0 or run.clock.status != RUNNING:
            keep_young(parameters, run)
            return
    # what else does not come to an end is found out by the step that tries to go on
    if changed == LOAD and not find_loads(parameters, run, log, time):
        run.clock.status = JAMMED
        run.clock.wheel = heaviest(run)


@kernel
def find_loads(parameters, run, log, time):
    """Try all sets of wheels on the floor for one that agrees with its loads, where one change calls for the next
    without end; whether there is one."""
    count = len(run.mode)
    before = 0
    for w in range(count):
        before += run.mode[w].loaded << w
    if count > MOST_TRIED:
        return False
    for chosen in range(1 << count):
        for w in range(count):
            run.mode[w].loaded = (chosen >> w) & 1
            if not run.mode[w].loaded:
                run.mode[w].grip[0] = run.mode[w].grip[1] = SLIP
        if not carried(parameters, run):
            continue
        refresh(parameters, run, time)
        agrees = True
        for w in range(count):
            for kind in (LOAD, JAM):
                agrees = agrees and guard(parameters, run, Guard(kind, w, 0), False) >= 0.0
        if agrees:
            for w in range(count):
                if (before ^ chosen) >> w & 1:
                    record(run.clock, log, time, LANDING if run.mode[w].loaded else LIFT, w, -1, -1)
            return True
    return False
