"""Coulomb friction in time: how a contact comes to rest, holds, lets go and slips on.

    SLIP   ---- slip below rest_speed, F inside the cone ---->  STICK
    SLIP   ---- slip below rest_speed, F outside ------------>  CREEP  (through zero without sticking)
    SLIP   ---- slow slip, turned by friction at once ------->  CREEP  (by implicit steps only to stop)
    STICK  ---- |F| reaches mu N ---------------------------->  CREEP
    CREEP  ---- slip no longer young ------------------------>  SLIP
    CREEP  ---- slip turns back ----------------------------->  STICK or CREEP again

Near zero slip v / |v| turns ever faster towards a limit direction, so steps become ever shorter (substeps.py) and slip
never crosses zero. The contact equation gives the limit direction in closed form. There a contact that lets go starts,
until its slip is large enough; and one that has come so near to it that the difference is below the error of a step
goes on along it, and stops at an instant that is located. The direction itself turns: creeping.py.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Slip
from omnisim.contact.set_valued import CREEP, SLIP, STICK
from omnisim.dynamics.impulses import align_slip, change_slip
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.state import Stage
from omnisim.march.creeping import (
    CREEP_SPEED,
    HELD,
    creeping,
    forget_turning,
    hold_direction,
    keep_creep,
    turned_by,
    turning_of,
)
from omnisim.march.runge_kutta import evaluate, refresh
from omnisim.march.slip import course_of
from omnisim.march.slip_bounds import (
    LEAST_STIFF,
    LEAST_TURNED,
    STILL_TURNED,
    rest_speed,
    stiffness,
    stopped_speed,
    unseen,
    youth,
)
from omnisim.march.substeps import SLIP_FRACTION, slip_fraction
from omnisim.march.thin_layer import enter_layer

DRIFTED = 0.01  # of the square of slip that no longer matters: more drift of a sticking contact is taken away
MOST_FREED = 20  # times in a step, after which slip is followed by sub-steps to its end
AHEAD = 0.1  # of the time to a stop, after which the direction of slip is looked at
MOST_LAG = 0.1  # rad, from which on slip does not follow that direction
AT_EASE = 1000.0  # times that friction turns slip while it changes, from which on its direction is a slow one
NOT, SOON, NEAR = range(3)  # how slip goes on in the direction of the contact equation
CREEP_ROUNDING = 1e-3  # of the slip that no longer matters: what contacts that let go together may slip back
CONE = 1e-12  # of mu times load and weight, by which a sticking force may pass the cone in rounding


@kernel
def rests(parameters, run, w, side):
    """Whether a contact of wheel w slips so slowly that it is at rest; in the air nothing holds it there, and in space
    one that begins has no load yet."""
    mode = run.mode[w]
    monitors = run.monitors[w]
    loaded = load_at(parameters, run, w, side) > 0.0 or (parameters.space is not None and mode.pressed[side])
    if not (parameters.machine.friction > 0.0 and loaded):
        return False
    if mode.grip[side] == CREEP and mode.stopping[side]:  # together with another one whose end has been found
        return monitors.margin[side] <= stopped_speed(parameters, run, w, side)
    slow = monitors.slip_square[side] < rest_speed(parameters, mode, w, side, run.y) ** 2
    return mode.grip[side] == SLIP and slow


@kernel
def load_at(parameters, run, w, side):
    """Normal force that holds a contact of wheel w, N; all of its wheel's where two rollers share it."""
    if parameters.space is not None:
        return run.monitors[w].load[side]
    return run.monitors[w].normal_force if run.mode[w].loaded else 0.0


@kernel
def stops(parameters, run, w, side):
    """How a contact that slips goes on along the direction of the contact equation, which attracts its slip.

    NEAR: of its own accord, as it turns: friction turns slip many times within a step that it may be given
    (creeping_period), and has done so for so long that the error of the step hides what else turns it. SOON: its end is
    near, and the error hides what the slip is across that direction. Else NOT.
    """
    mode, monitors = run.mode[w], run.monitors[w]
    if mode.shared or mode.grip[side] != SLIP or monitors.factor[side] == 0.0:
        return NOT
    if mode.freed_step == run.clock.step and mode.freed >= MOST_FREED:
        return NOT
    if stiffness(parameters, run.clock, monitors, side) <= LEAST_STIFF:  # as nearly always
        return NOT
    dt, course = run.clock.dt, course_of(parameters, run, w, side)
    hidden = unseen(run.clock, course)
    followed = run.newton is None
    across = strayed(mode, side, course) if followed else course.across
    turned = course.attraction * dt > LEAST_TURNED
    follows = followed and course.attraction * min(dt, creeping_period(run.clock, course)) > LEAST_TURNED
    foreign = min(across, course.speed * math.exp(-mode.settled[side]))  # not by the turning of that direction itself
    if follows and foreign * course.attraction * dt < hidden:
        return NEAR
    if (turned or not followed) and -course.growth * dt > course.speed and across < hidden:
        return SOON
    return NOT


@kernel
def creeping_period(clock, course):
    """How long slip may go on in the direction of the contact equation at once, s: the part of the time in which it
    doubles, stops or passes by rest that a sub-step may take, as that direction turns with it; any, if friction turns
    it far faster."""
    pace = math.hypot(course.growth / course.speed, course.turning)
    if AT_EASE * pace <= max(course.attraction, 0.0):
        return math.inf
    return slip_fraction(SLIP_FRACTION, pace, clock) / pace


@kernel
def strayed(mode, side, course):
    """What slip is across that direction, m/s: by its turning, and by what it was before and friction has left of that.
    Slip that comes from afar and that direction turn into each other's way: for a moment it turns by nothing."""
    mode.strayed[side] = max(mode.strayed[side], min(course.across / course.speed, 1.0))
    return max(course.across, mode.strayed[side] * course.speed)


@kernel
def slip_freely(parameters, run):
    """Let creeping contacts slip in the direction that they have: where friction no longer turns slip faster than a
    step can follow, or where the step would err, as forces have jumped. Of the others, how long they may creep at
    once, unless the error of a step hides in any case what they are across."""
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            if not creeping(mode, side):
                continue
            mode.period[side] = math.inf
            if run.monitors[w].slip_square[side] <= CREEP_SPEED**2:
                continue
            course = course_of(parameters, run, w, side)
            hidden = course.across <= unseen(run.clock, course)
            if not hidden:
                mode.period[side] = creeping_period(run.clock, course)
            turned = course.attraction * min(run.clock.dt, mode.period[side])
            if turned < STILL_TURNED or not (hidden or mode.foreseen[side]):
                mode.grip[side] = SLIP


@kernel
def cone_rounding(machine, monitors):
    """By how much a sticking force may pass the cone, N: one that is about to lift has forces of the others' size."""
    return CONE * machine.friction * (abs(monitors.normal_force) + machine.mass * machine.gravity)


@kernel
def grip_guard(parameters, run, w, side, at_end):
    """The guard GRIP of a contact that sticks or creeps, N or m/s: inside the cone, or its slip keeps its sense.
    Contacts that let go together leave one another some rounding."""
    mode, y = run.mode[w], run.trial if at_end else run.y
    monitors = run.monitors_end[w] if at_end else run.monitors[w]
    if mode.grip[side] == STICK:
        return monitors.margin[side] + cone_rounding(parameters.machine, monitors)
    return monitors.margin[side] + CREEP_ROUNDING * rest_speed(parameters, mode, w, side, y)


@kernel
def young_guard(parameters, run, w, side, at_end):
    """The guard YOUNG of a contact that creeps, m/s: its slip is slow."""
    mode = run.mode[w]
    monitors = run.monitors_end[w] if at_end else run.monitors[w]
    if mode.shared:
        return CREEP_SPEED - math.sqrt(monitors.slip_square[side])
    if run.newton is None:
        return 0.0
    return youth(parameters, run.clock, mode, monitors, side) if mode.grip[side] == CREEP else 0.0


@outlined
def come_to_rest(parameters, run, w, side, others, t):
    """Take the rest of the slip of contact `side` of wheel w away (-1: of none) and, if `others`, of all that rest.

    Marks them as `stopped` and lets those stick whose force lies inside the cone; the others creep on. On two rollers,
    sticking is being at rest: there the force follows from Gauss' principle, cone included.
    """
    for v in range(len(run.mode)):
        mode = run.mode[v]
        for other in range(contact_count(mode)):
            stopped = (v == w and other == side) or (others and rests(parameters, run, v, other))
            mode.stopped[other] = stopped
            if stopped:
                mode.grip[other] = STICK
                if parameters.space is None:
                    enter_layer(mode)
                if parameters.space is None and mode.shared:
                    change_slip(parameters, run, v, other, Slip(0.0, 0.0))
    forget_turning(parameters, run)
    align_slip(parameters, run)
    refresh(parameters, run, t)
    for v in range(len(run.mode)):
        mode, monitors = run.mode[v], run.monitors[v]
        for other in range(contact_count(mode)):
            outside = monitors.margin[other] < -cone_rounding(parameters.machine, monitors)
            if mode.stopped[other] and not mode.shared and outside:
                mode.stopped[other] = 0
                start_creep(parameters, run, v, other, t)


@outlined
def start_creep(parameters, run, w, side, t):
    """Let a contact at rest slip off in the direction of the contact equation."""
    mode = run.mode[w]
    mode.grip[side], mode.stopping[side] = CREEP, 0
    mode.creep[side, 0] = mode.creep[side, 1] = 0.0
    mode.veer[side, 0] = mode.veer[side, 1] = 0.0
    refresh(parameters, run, t)
    keep_creep(parameters, run, w, side)


@kernel
def begin_to_stop(parameters, run, t):
    """Let slips that are about to stop, or last, go on in the direction of the contact equation, in which they will."""
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            how = stops(parameters, run, w, side)
            if how != NOT:
                course = course_of(parameters, run, w, side)
                mode.grip[side], mode.stopping[side] = CREEP, 1
                mode.creep[side, 0], mode.creep[side, 1] = course.h, course.k
                mode.foreseen[side], mode.veering[side] = how == NEAR, course.turning
                mode.period[side] = creeping_period(run.clock, course) if how == NEAR else math.inf
                mode.veer[side, 0], mode.veer[side, 1] = 0.0, HELD if how == NEAR else 0.0
    refresh(parameters, run, t)
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                keep_creep(parameters, run, w, side)
    if run.newton is None:
        foresee_stops(parameters, run, t)
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                hold_direction(run, w, side, turning_of(parameters, w, side).slip)
    align_slip(parameters, run)
    refresh(parameters, run, t)


@kernel
def foresee_stops(parameters, run, t):
    """At which rate the direction of the contact equation turns for slips that are about to stop, by a state a little
    later; slip lags behind that direction by what it turns while friction draws slip there."""
    ahead = math.inf
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if unforeseen(run.mode[w], side):
                course = course_of(parameters, run, w, side)
                ahead = min(ahead, AHEAD * course.speed / abs(course.growth))
    if ahead == math.inf:
        return
    for m in range(len(run.y)):
        run.trial[m] = run.y[m] + ahead * run.slopes[0, m]
    evaluate(
        parameters, Stage(run.mode, run.clock.piece, t + ahead, run.trial, run.slopes[-1], run.monitors_end, False)
    )
    run.clock.rhs += 1
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            if unforeseen(mode, side):
                creep, course = mode.creep[side], course_of(parameters, run, w, side)
                turning = turned_by(creep, turning_of(parameters, w, side).creep) / ahead
                if abs(turning) < MOST_LAG * course.attraction:
                    mode.foreseen[side], mode.veering[side] = 1, turning
                    lag = turning / course.attraction
                    h, k = creep[0] + lag * creep[1], creep[1] - lag * creep[0]
                    size = math.sqrt(h * h + k * k)
                    creep[0], creep[1] = h / size, k / size


@kernel
def unforeseen(mode, side):
    """Whether slip is about to stop in a direction of which nothing tells how it turns, nor anything holds it."""
    return creeping(mode, side) and mode.stopping[side] == 1 and not mode.foreseen[side] and mode.veer[side, 1] == 0.0


@kernel
def start_slip(parameters, run, w, side, t):
    """Let a contact slip whose slip has grown; a creeping one in the direction of the contact equation."""
    mode = run.mode[w]
    if mode.grip[side] == CREEP and not mode.shared:
        refresh(parameters, run, t)
        keep_creep(parameters, run, w, side)
        align_slip(parameters, run)
        mode.freed = mode.freed + 1 if mode.freed_step == run.clock.step else 1
        mode.freed_step = run.clock.step
    mode.grip[side] = SLIP
    refresh(parameters, run, t)


@kernel
def take_drift_away(parameters, run, t, refreshed):
    """Take drift away: sticking contacts hold the slip acceleration at zero, the slip only to rounding; creeping ones
    have a direction that turns, and their slip follows.

    refreshed: by an event that finds the derivative anew. Where all contacts stick, explicit steps go on with that of
    the drift, which errs by no more than the step has, times the next one.
    """
    drifts = False
    still = run.newton is None and parameters.workspace.articulated is None  # whose bodies follow the speeds
    for w in range(len(run.mode)):
        mode, monitors = run.mode[w], run.monitors[w]
        if mode.shared:
            continue
        for side in range(contact_count(mode)):
            if mode.grip[side] == STICK:
                rest = rest_speed(parameters, mode, w, side, run.y)
                drifts = drifts or monitors.slip_square[side] > DRIFTED * rest * rest
            else:
                still = False
            if mode.grip[side] == CREEP:
                keep_creep(parameters, run, w, side)
                drifts = True
    if drifts:
        align_slip(parameters, run)
        if not (still or refreshed):
            refresh(parameters, run, t)
