"""Marching in time: locate, grid step, march; the only loops over time.

The grid k * dt never shifts. A grid step is cut at events and at knots of the tables; the remainder of the same step
is taken from there, each piece with the mode frozen, so the order of the method survives.
"""

import math

from omnisim.base.kernel import kernel, merged, outlined
from omnisim.base.status import (
    COMPLETE,
    CROWDED,
    EVENTS_PER_STEP,
    LOG_FULL,
    LOST_TRACK,
    NO_CONVERGENCE,
    NOT_FINITE,
    RESTLESS,
    ROCKING,
    RUNNING,
    SLOW_SLIP,
    STIFF_BEARING,
    STIFF_CURRENT,
    TOO_STIFF,
)
from omnisim.contact.set_valued import CREEP
from omnisim.dynamics.actuation import sample
from omnisim.dynamics.multibody.joint_kinematics import project_bodies
from omnisim.dynamics.state import places
from omnisim.march.events import (
    EXIT,
    GRIP,
    GUARDS,
    NO_GUARD,
    OF_WHEEL,
    TURN,
    Guard,
    all_hold,
    end_slips,
    guard,
    restore_consistency,
    transition,
)
from omnisim.march.extremes import begin_interval, follow, follow_again
from omnisim.march.friction_modes import (
    begin_to_stop,
    outrun,
    rests,
    step_length,
    stopped_speed,
    stops,
    take_drift_away,
)
from omnisim.march.onset import stand
from omnisim.march.radau5 import implicit_step
from omnisim.march.roller_exchange import release_rollers
from omnisim.march.runge_kutta import accept, copy, explicit_step, refresh
from omnisim.march.validity import check, check_energy, too_fast, too_stiff

TURNS_PER_STEP = 1000  # reversals of spin, swings about an edge that never come to rest on both rollers
CUTS_PER_STEP = 1000  # changes of friction, in a step that no branch of the law survives
SLIPS_PER_STEP = 10**6  # sub-steps of slow slip in one step
SLIDING = 1e-6  # of a step: the square of less, by any acceleration, is lost in rounding
SHRINKING = 2.0**-5  # of a step, in the search for a point inside
NEAR = 1e-3  # of a step, between two iterates that tell how good the root is
REACH_GROWTH = 2.0  # of an implicit step over the last one that converged
GRID_ROUNDING = 1e-14
EPSILON = 4.0 * 2.0**-52


@kernel
def march(parameters, method, run, rows, log):
    """March to the goal or until something stops the run; pauses when it has worked enough or the log is full.

    Resumable: returns the status, RUNNING at a pause or at a goal before the end, LOG_FULL if the log needs room.
    """
    clock = run.clock
    if clock.row == 0 and clock.status == RUNNING:
        sampled(parameters, run, False)
        stand(parameters, run, log)
        check(parameters, run)
        bearings, currents = parameters.machine.bearing_relaxation, parameters.machine.current_relaxation
        if clock.status == RUNNING:
            begin_interval(parameters, run, rows, 0)
            write_row(parameters, run, rows)
        if run.newton is None and max(bearings, currents) * clock.dt > clock.stability_limit:
            clock.status, clock.rate = STIFF_BEARING if bearings > currents else STIFF_CURRENT, max(bearings, currents)
    elif clock.status == RUNNING and clock.piece + 1 < len(parameters.starts):
        enter_piece(parameters, run, rows, log)
    while clock.status == RUNNING and clock.step < clock.goal and clock.rhs < clock.pause:
        if clock.events + 2 * EVENTS_PER_STEP > len(log):
            return LOG_FULL
        grid_step(parameters, method, run, rows, log)
        if clock.dt - clock.elapsed <= GRID_ROUNDING * clock.dt * (
            clock.step + 1
        ):  # it may have stopped at its very end
            clock.step += 1
            clock.elapsed = 0.0
            if parameters.machine.sampled and clock.status == RUNNING and sampled(parameters, run, False):
                refresh(parameters, run, clock.step * clock.dt)
                restore_consistency(parameters, run, log, clock.step * clock.dt)
                follow_again(parameters, run, rows, clock.row)
            check(parameters, run)
            if (
                clock.status not in (NOT_FINITE, TOO_STIFF, LOST_TRACK)
                and clock.step == clock.row * clock.steps_per_row
            ):
                write_row(parameters, run, rows)
    if clock.status == RUNNING and clock.step == clock.steps:
        clock.status = COMPLETE
    return clock.status


@outlined
def sampled(parameters, run, again):
    """Whether it is time for some controller to read its rate; all that it is time for have done so."""
    clock, due = run.clock, False
    for w in range(len(run.mode)):
        steps = parameters.wheels[w].sample_steps
        if steps > 0 and clock.step % steps == 0:
            sample(parameters, run.mode[w], clock.piece, clock.step * clock.dt, w, run.y, again)
            due = True
    return due


@merged
def enter_piece(parameters, run, rows, log):
    """Enter a piece of the tables set while the march stood still; a row of this instant is renewed."""
    clock = run.clock
    here = clock.step * clock.dt
    if parameters.starts[clock.piece + 1] <= here:
        clock.piece += 1
        sampled(parameters, run, True)
        refresh(parameters, run, here)
        restore_consistency(parameters, run, log, here)
        on_row = clock.step % clock.steps_per_row == 0
        clock.row -= on_row
        if clock.step == 0:
            begin_interval(parameters, run, rows, 0)
        else:
            follow_again(parameters, run, rows, clock.row)
        if on_row:
            write_row(parameters, run, rows)


@outlined
def write_row(parameters, run, rows):
    row = run.clock.row
    for w in range(len(run.mode)):
        release_rollers(parameters, run, w)
    check_energy(parameters, run)
    for w in range(len(run.mode)):
        rows.mode[row, w] = run.mode[w]
        copy(run.rates[w], rows.rates[row, w])
    copy(run.y, rows.y[row])
    rows.piece[row] = run.clock.piece
    run.clock.row = row + 1
    begin_interval(parameters, run, rows, row + 1)


@merged
def grid_step(parameters, method, run, rows, log):
    """One dt, with all its events and knots; what it passes through enters the extremes of its interval."""
    clock = run.clock
    start, first_event, turns, others, slips = clock.step * clock.dt, clock.events, 0, 0, 0
    clock.elapsed = 0.0
    while clock.elapsed < clock.dt:
        t = start + clock.elapsed
        h, knot = piece_length(parameters, clock, start)
        whole = h
        if parameters.workspace.resting is not None:
            end_old_slips(parameters, run, rows, log, t)
        if parameters.workspace.resting is not None or run.newton is not None:
            h = step_length(parameters, run, t, h)
        h, fired = step_to_event(parameters, method, run, t, h)
        accept(run)
        follow(parameters, run, rows, clock.row)
        if parameters.workspace.articulated is not None:
            project_bodies(parameters, run, True)
        clock.elapsed += h
        if parameters.workspace.resting is not None:
            take_drift_away(parameters, run, start + clock.elapsed)
        kind, w, _ = fired
        if kind >= 0:
            transition(parameters, run, log, fired, start + clock.elapsed)
            restore_consistency(parameters, run, log, start + clock.elapsed)
            follow_again(parameters, run, rows, clock.row)
            turns += kind == TURN
            others += kind not in (TURN, EXIT)
        elif h < whole:
            slips += 1
        elif knot:
            clock.piece += 1
            refresh(parameters, run, start + clock.elapsed)
            restore_consistency(parameters, run, log, start + clock.elapsed)
            follow_again(parameters, run, rows, clock.row)
        else:
            return
        if turns > TURNS_PER_STEP:
            clock.status, clock.wheel = ROCKING, w
        elif others > CUTS_PER_STEP and parameters.workspace.resting is None:
            too_stiff(parameters, run, w)
        elif slips > SLIPS_PER_STEP:
            clock.status, clock.wheel = SLOW_SLIP, max(w, 0)
        elif others > CUTS_PER_STEP:
            clock.status, clock.wheel = RESTLESS, w
        elif clock.events - first_event > EVENTS_PER_STEP:
            clock.status, clock.wheel = CROWDED, w
            if too_fast(parameters, run, w):
                too_stiff(parameters, run, w)
        if clock.status != RUNNING:
            return


@merged
def end_old_slips(parameters, run, rows, log, t):
    """Let contacts stick or creep whose slip has come to its end, or will soon."""
    resting, stopping = False, False
    for w in range(len(run.mode)):
        for side in range(1 + run.mode[w].shared):
            resting = resting or rests(parameters, run, w, side)
    if resting:
        end_slips(parameters, run, log, -1, 0, t)
        follow_again(parameters, run, rows, run.clock.row)
    for w in range(len(run.mode)):
        stopping = stopping or stops(parameters, run, w)
    if stopping:
        begin_to_stop(parameters, run, t)


@kernel
def piece_length(parameters, clock, start):
    """Length of the next piece of a grid step, s, and whether a knot of the tables ends it."""
    rest = clock.dt - clock.elapsed
    if clock.piece + 1 < len(parameters.starts):
        to_knot = parameters.starts[clock.piece + 1] - start - clock.elapsed
        if to_knot <= rest + GRID_ROUNDING * (start + clock.dt):
            return max(min(to_knot, rest), 0.0), True
    return rest, False


@merged
def step_to_event(parameters, method, run, t, h):
    """A trial step of at most h, up to its first event: its length, and the Guard that fired or NO_GUARD."""
    clock = run.clock
    if run.newton is not None and clock.implicit:
        h = min(h, REACH_GROWTH * clock.reach)
    while True:
        advance(parameters, method, run, t, h)
        if clock.converged:
            s, fired = cut_at_event(parameters, method, run, t, h)
            if clock.converged and not outrun(parameters, run, s):
                if run.newton is not None and clock.implicit:
                    clock.reach = h
                return s, fired
        h *= 0.5
        if h < GRID_ROUNDING * clock.dt:
            clock.status = NO_CONVERGENCE if clock.implicit else NOT_FINITE
            return 0.0, NO_GUARD


@merged
def cut_at_event(parameters, method, run, t, h):
    """Shorten the trial step to its first event: its length, and the Guard that fired or NO_GUARD.

    Each violated guard is located on what is left of the step, TURN first, so EXIT sees a monotone spin angle and a
    step that leaves a roller's end and comes back is cut at the turn before it is searched.
    """
    fired, undisturbed = NO_GUARD, True
    for w in range(len(run.mode)):
        undisturbed = undisturbed and all_hold(parameters, run, w)
    if undisturbed:
        return h, fired
    for kind in range(GUARDS):
        for w in range(len(run.mode)):
            for side in range(2 if kind >= OF_WHEEL and run.mode[w].shared else 1):
                value = guard(parameters, run, Guard(kind, w, side), True)
                if value < 0.0:
                    fired = Guard(kind, w, side)
                    h = locate(parameters, method, run, t, h, fired, value)
    return h, fired


@outlined
def locate(parameters, method, run, t, h, which, value):
    """Root s of a Guard on a step of length h at whose end it has the negative `value`; leaves the trial at s.

    Every evaluation is a step of its own from the start of the step, so the state found is as accurate as any. A
    step that starts ON the root, leaves it and comes back has its event at the later root: so first a point inside
    is sought at which the guard holds. Then a safeguarded secant iteration.
    """
    kind, w, side = which
    low, high = 0.0, h
    g_low, g_high = guard(parameters, run, which, False), value
    at_once = g_low <= 0.0 and leaves_at_once(parameters, run, which)
    while g_low <= 0.0:
        s = SHRINKING * high
        if at_once or s < GRID_ROUNDING * run.clock.dt:
            advance_again(parameters, method, run, t, 0.0)
            return 0.0
        g = trial_guard(parameters, method, run, t, s, which)
        if g > 0.0:
            low, g_low = s, g
        else:
            high, g_high = s, g
    tolerance, slack, enough = 1e-12 * h + EPSILON * (t + h), 0.0, 0.0
    s, s_last, g_last = low + (high - low) * g_low / (g_low - g_high), high, g_high
    spin, direction = places(parameters).spin_rate + w, run.mode[w].direction
    if kind == EXIT:  # the angle and its rate are known at both ends
        enough = SLIDING * h
        if low == 0.0 and value >= -direction * run.trial[spin] * tolerance:  # the trial is that of the whole step
            return h
        if low == 0.0 and high == h:
            s = hermite_root(h, g_low, g_high, -direction * run.y[spin], -direction * run.trial[spin], s)
    elif parameters.workspace.resting is not None and kind == GRIP and run.mode[w].grip[side] == CREEP:
        slack = stopped_speed(parameters, run, w, side)  # what is left of the slip is taken away
        if low == 0.0 and value >= -slack:
            return h
    for iteration in range(60):
        g = trial_guard(parameters, method, run, t, s, which)
        if not math.isfinite(g + s):  # of a state that has burst nothing can be located
            return h
        correction = g * (s - s_last) / (g_last - g)
        if kind == EXIT:
            correction = g / (direction * run.trial[spin])
        if g > 0.0:
            low = s
        else:
            high = s
        # A chord over a guard that bends sharply gives a small correction far from the root: judge it at its scale.
        near = abs(correction) <= tolerance and (kind == EXIT or abs(s - s_last) <= NEAR * h)
        if abs(g) <= slack or near or high - low <= tolerance:
            break
        if abs(correction) <= enough and low <= s + correction <= high:
            slide(run, correction)
            return s + correction
        s_last, g_last = s, g
        s += correction
        if iteration % 4 == 3 or not low < s < high:
            s = 0.5 * (low + high)
    return s


@kernel
def slide(run, time):
    """Move the trial on by a time whose square no longer matters, along its derivative."""
    derivative = run.slopes[-1]
    for m in range(len(run.trial)):
        run.increment[m] += time * derivative[m]
        run.trial[m] = run.y[m] + run.increment[m]


@kernel
def leaves_at_once(parameters, run, which):
    """Whether a Guard that is on its root at the start of a step, or beyond, does not come back: spin that has no rate
    or the other sense and goes on to gain it, and creeping slip that has turned."""
    kind, w, side = which
    if kind == TURN:
        return run.mode[w].direction * run.slopes[0, places(parameters).spin_rate + w] < 0.0
    return kind == GRIP and run.mode[w].grip[side] == CREEP


@kernel
def hermite_root(h, g_0, g_1, rate_0, rate_1, s):
    """Root in [0, h] of the cubic with these values and rates at its ends, from the guess s."""
    x, d_0, d_1 = s / h, h * rate_0, h * rate_1
    for _ in range(3):
        y = 1.0 - x
        value = y * y * ((1.0 + 2.0 * x) * g_0 + x * d_0) + x * x * ((1.0 + 2.0 * y) * g_1 - y * d_1)
        slope = 6.0 * x * y * (g_1 - g_0) + y * (1.0 - 3.0 * x) * d_0 + x * (3.0 * x - 2.0) * d_1
        x = min(max(x - value / slope, 0.0), 1.0)
    return x * h if 0.0 < x < 1.0 else s


@merged
def advance(parameters, method, run, t, h):
    """One step of length h from run.y into run.trial, explicit or implicit as the clock says."""
    clock = run.clock
    if run.newton is not None and clock.implicit:
        clock.converged = implicit_step(parameters, method, run, t, h)
    else:
        clock.converged = True
        explicit_step(parameters, method, run, t, h)


@outlined
def advance_again(parameters, method, run, t, h):
    """The same, compiled once for all uses but the first trial of a step."""
    advance(parameters, method, run, t, h)


@merged
def trial_guard(parameters, method, run, t, s, which):
    """Value of a guard after a step of length s."""
    advance_again(parameters, method, run, t, s)
    return guard(parameters, run, which, True)
