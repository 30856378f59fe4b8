"""A trial step, and the first event in it: each guard's root inside the step, located to rounding.

An exchange is aimed at: the step ends where a Taylor series puts it, as one that creeping slip ends in does a little
later (substeps.py). What is missing then is a small part e of the step h, and the state is moved there along the cubic
that has the states and derivatives at its ends. That errs by e^2 h^4 / 24 of the fourth derivative, and e of an
exchange falls with h^2.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import (
    NO_CONVERGENCE,
    NOT_FINITE,
)
from omnisim.contact.set_valued import CREEP
from omnisim.dynamics.state import places
from omnisim.march.creeping import creep_of, creeping
from omnisim.march.events import (
    EXIT,
    GRIP,
    NO_GUARD,
    TURN,
    Guard,
    all_hold,
    guard,
    guard_count,
    guard_kinds,
    resolution,
)
from omnisim.march.slip import slip_rate
from omnisim.march.slip_bounds import stopped_speed
from omnisim.march.spatial_events import of_state_alone
from omnisim.march.spatial_location import cut_along, ends_anywhere, locate_in_space
from omnisim.march.substeps import outrun
from omnisim.march.trial import advance, advance_again, reach, slide

AHEAD = 1.5  # times the way of a step, at the rate of its start: what is further away is no aim
SHRINKING = 2.0**-5  # of a step, in the search for a point inside
CREEP_REACH = 0.05  # of a step, by which its end is moved on to the end of creeping slip
NEAR = 1e-3  # of a step, between two iterates that tell how good the root is
REACH_GROWTH = 2.0  # of an implicit step over the last one that converged
GRID_ROUNDING = 1e-14  # of a step and of the time: what is left of a step that is none
MOST_ITERATIONS = 60  # for a root, of which halving alone would need 50
HALVING = 4  # every so many iterations halve what is left: a chord may creep along a guard that bends
HERMITE_ITERATIONS = 5  # Newton's, from the end of a step
AT_NO_RATE = 1e-9  # of what a guard changes by in a step: at its start it does not
FOUND = 1e-6  # part of the furthest way to a root, that the last of them takes at most if there is one


@kernel
def step_to_event(parameters, method, run, t, h, longest):
    """A trial step of at most h, up to its first event: its length, and the Guard that fired or NO_GUARD. longest: a
    length up to which its end may be moved on, if it is aimed at an event."""
    clock = run.clock
    if run.newton is not None and clock.implicit:
        h = min(h, REACH_GROWTH * clock.reach)
    h, aimed = aim(parameters, run, h)
    while True:
        advance(parameters, method, run, t, h)
        if clock.converged:
            s, fired = cut_at_event(parameters, method, run, t, h)
            if parameters.space is None and fired.kind < 0 and aimed.kind >= 0:
                s, fired = move_on(parameters, run, aimed, h, longest)
            if clock.converged and not outrun(parameters, run, s):
                rest = GRID_ROUNDING * (t + clock.dt)  # of a piece, in rounding: it tells nothing of longer steps
                if run.newton is not None and clock.implicit and h > rest:
                    clock.reach = h if aimed.kind < 0 else max(h, clock.reach)  # nor does one that was aimed
                return s, fired
        h *= 0.5
        if h < GRID_ROUNDING * clock.dt:
            clock.status = NO_CONVERGENCE if clock.implicit else NOT_FINITE
            return 0.0, NO_GUARD


@kernel
def aim(parameters, run, h):
    """A step of at most h that ends at the first exchange which a Taylor series foretells, or about where creeping slip
    does: its length, and the Guard of that event or NO_GUARD."""
    aimed = NO_GUARD
    if parameters.space is not None:
        return h, aimed
    if parameters.workspace.resting is not None and run.newton is None:
        aimed = ending_creep(parameters, run, h)
    spins = places(parameters).spin_rate
    for w in range(len(run.mode)):
        which = Guard(EXIT, w, 0)
        value, rate = guard(parameters, run, which, False), guard_rate(parameters, run, which, False)
        if 0.0 < value < -AHEAD * rate * h:
            square = rate * rate + 2.0 * run.mode[w].direction * run.slopes[0, spins + w] * value
            s = 2.0 * value / (math.sqrt(square) - rate) if square > 0.0 else h
            if s < h:
                h, aimed = s, which
    return h, aimed


@kernel
def ending_creep(parameters, run, h):
    """The Guard of the first creeping slip that comes to its end by about the end of a step h, or NO_GUARD."""
    aimed, first = NO_GUARD, AHEAD * h
    for w in range(len(run.mode)):
        if creeping(run.mode[w], 0):
            which = Guard(GRIP, w, 0)
            time = -guard(parameters, run, which, False) / guard_rate(parameters, run, which, False)
            if 0.0 < time < first:
                aimed, first = which, time
    return aimed


@kernel
def move_on(parameters, run, aimed, h, longest):
    """Move the end of a trial step h, in which nothing fired, on to the event that it was aimed at, if that is near and
    no further than the `longest` step: its length, and the Guard of that event or NO_GUARD."""
    correction = to_root(parameters, run, aimed, h)
    further = CREEP_REACH if aimed.kind == GRIP else reach(run.clock)
    if abs(correction) <= further * h and h + correction <= longest:
        slide(parameters, run, h, correction)
        return h + correction, aimed
    return h, NO_GUARD


@kernel
def creeps(run, which):
    """Whether a Guard is the sense of creeping slip."""
    kind, w, side = which
    return kind == GRIP and run.mode[w].grip[side] == CREEP


@kernel
def guard_rate(parameters, run, which, at_end):
    """Rate of the Guard of an exchange, rad/s, or of creeping slip, m/s^2, at the start of a step or `at_end`."""
    kind, w, side = which
    y = run.trial if at_end else run.y
    if parameters.space is None and kind == EXIT:
        return -run.mode[w].direction * y[places(parameters).spin_rate + w]
    rate, _, _ = slip_rate(parameters, run.mode[w], w, side, y, run.slopes[-1 if at_end else 0])
    creep = creep_of(parameters, w, side)
    return rate.h * creep.h + rate.k * creep.k


@kernel
def cut_at_event(parameters, method, run, t, h):
    """Shorten the trial step to its first event: its length, and the Guard that fired or NO_GUARD.

    Each violated guard is located on what is left of the step, TURN first, so EXIT sees a monotone spin angle and a
    step that leaves a roller's end and comes back is cut at the turn before it is searched. In space many contacts may
    change at one instant: where a step cannot be ended along its extension each in its turn, as in no time the guard of
    one that has changed tells nothing but rounding.
    """
    fired, undisturbed = NO_GUARD, True
    for w in range(len(run.mode)):
        undisturbed = undisturbed and all_hold(parameters, run, w)
    if undisturbed:
        return h, fired
    if parameters.space is not None and parameters.workspace.resting is None and ends_anywhere(parameters, run):
        return cut_along(parameters, method, run, t, h)
    for kind in range(guard_kinds(parameters)):
        for w in range(len(run.mode)):
            for side in range(guard_count(parameters, run, kind, w)):
                value = guard(parameters, run, Guard(kind, w, side), True)
                if value < 0.0:
                    fired = Guard(kind, w, side)
                    h = locate(parameters, method, run, t, h, fired, value)
                    if parameters.space is not None and h <= GRID_ROUNDING * (t + run.clock.dt):
                        return h, fired
    return h, fired


@outlined
def locate(parameters, method, run, t, h, which, value):
    """Root s of a Guard on a step of length h at whose end it has the negative `value`; leaves the trial at s.

    Every evaluation is a step of its own from the start of the step, so the state found is as accurate as any. A
    step that starts ON the root, leaves it and comes back has its event at the later root: so first a point inside
    is sought at which the guard holds. Then a safeguarded iteration: of secants, or where the rate of the guard is
    known at both ends of a trial, of cubics.
    """
    kind, w, side = which
    if parameters.space is not None and of_state_alone(kind):
        return locate_in_space(parameters, method, run, t, h, which)
    low, high = 0.0, h
    s, g = h, value  # where the trial is
    s_last, g_last = 0.0, guard(parameters, run, which, False)
    if g_last <= 0.0:
        at_once = leaves_at_once(parameters, run, which, h, value)
        while g <= 0.0:
            s_last, g_last, high = s, g, s
            s *= SHRINKING
            if at_once or s < GRID_ROUNDING * run.clock.dt:
                advance_again(parameters, method, run, t, 0.0)
                return 0.0
            g = trial_guard(parameters, method, run, t, s, which)
    tolerance = resolution(h, t)
    slack = 0.0
    with_rate = parameters.space is None and kind == EXIT
    if parameters.workspace.resting is not None and creeps(run, which):
        slack, with_rate = stopped_speed(parameters, run, w, side), True  # what is left of the slip is taken away
    for iteration in range(MOST_ITERATIONS):
        if not math.isfinite(g + s):  # of a state that has burst nothing can be located
            return h
        correction = g * (s - s_last) / (g_last - g)
        if with_rate:
            correction = to_root(parameters, run, which, s)
        if g > 0.0:
            low = s
        else:
            high = s
        # A chord over a guard that bends sharply gives a small correction far from the root: judge it at its scale.
        near = abs(correction) <= tolerance and (with_rate or abs(s - s_last) <= NEAR * h)
        if abs(g) <= slack or near or high - low <= tolerance:
            break
        if with_rate and abs(correction) <= reach(run.clock) * s:
            slide(parameters, run, s, correction)
            return s + correction
        s_last, g_last = s, g
        s += correction
        if iteration % HALVING == HALVING - 1 or not low < s < high:
            s = 0.5 * (low + high)
        g = trial_guard(parameters, method, run, t, s, which)
    return s


@kernel
def to_root(parameters, run, which, h):
    """Time from the end of the trial step h to the root of the cubic that a Guard with a rate follows, s; infinite if
    Newton's method finds none: beyond its end a guard may turn back."""
    g_0, g_1 = guard(parameters, run, which, False), guard(parameters, run, which, True)
    d_0, d_1 = h * guard_rate(parameters, run, which, False), h * guard_rate(parameters, run, which, True)
    x, change = 1.0, 0.0
    for _ in range(HERMITE_ITERATIONS):
        y = 1.0 - x
        value = y * y * ((1.0 + 2.0 * x) * g_0 + x * d_0) + x * x * ((1.0 + 2.0 * y) * g_1 - y * d_1)
        slope = 6.0 * x * y * (g_1 - g_0) + y * (1.0 - 3.0 * x) * d_0 + x * (3.0 * x - 2.0) * d_1
        change = value / slope
        x -= change
    return (x - 1.0) * h if abs(change) <= FOUND * reach(run.clock) else math.inf


@kernel
def leaves_at_once(parameters, run, which, h, value):
    """Whether a Guard that is on its root at the start of a step h, or beyond, and has the negative `value` at its end,
    does not come back: creeping slip that has turned; and spin that has no rate or the other sense and goes on to gain
    it, or begins to, by the cubic of the step, where it changes at no rate yet."""
    kind, w, _ = which
    if parameters.space is None and kind == TURN:
        spin, direction = places(parameters).spin_rate + w, run.mode[w].direction
        first, last = h * direction * run.slopes[0, spin], h * direction * run.slopes[-1, spin]
        return first < 0.0 or (first <= AT_NO_RATE * -value and 3.0 * value < last)
    return creeps(run, which)


@kernel
def trial_guard(parameters, method, run, t, s, which):
    """Value of a guard after a step of length s."""
    advance_again(parameters, method, run, t, s)
    return guard(parameters, run, which, True)
