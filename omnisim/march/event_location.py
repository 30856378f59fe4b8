"""A trial step, and the first event in it: each guard's root inside the step, located to rounding."""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import (
    NO_CONVERGENCE,
    NOT_FINITE,
)
from omnisim.contact.set_valued import CREEP
from omnisim.dynamics.state import places
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
from omnisim.march.friction_modes import stopped_speed
from omnisim.march.radau5 import implicit_step
from omnisim.march.runge_kutta import explicit_step
from omnisim.march.substeps import outrun

SLIDING = 1e-6  # of a step: the square of less, by any acceleration, is lost in rounding
SHRINKING = 2.0**-5  # of a step, in the search for a point inside
NEAR = 1e-3  # of a step, between two iterates that tell how good the root is
REACH_GROWTH = 2.0  # of an implicit step over the last one that converged
GRID_ROUNDING = 1e-14  # of a step and of the time: what is left of a step that is none
MOST_ITERATIONS = 60  # for a root, of which halving alone would need 50
HALVING = 4  # every so many iterations halve what is left: a chord may creep along a guard that bends
HERMITE_ITERATIONS = 3  # Newton's, from a chord of a guard that a cubic follows


@kernel
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
                rest = GRID_ROUNDING * (t + clock.dt)  # of a piece, in rounding: it tells nothing of longer steps
                if run.newton is not None and clock.implicit and h > rest:
                    clock.reach = h
                return s, fired
        h *= 0.5
        if h < GRID_ROUNDING * clock.dt:
            clock.status = NO_CONVERGENCE if clock.implicit else NOT_FINITE
            return 0.0, NO_GUARD


@kernel
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
    for kind in range(guard_kinds(parameters)):
        for w in range(len(run.mode)):
            for side in range(guard_count(parameters, run, kind, w)):
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
    tolerance = resolution(h, t)
    slack = 0.0
    enough = 0.0
    s = low + (high - low) * g_low / (g_low - g_high)
    s_last = high
    g_last = g_high
    if parameters.space is None and kind == EXIT:  # the angle and its rate are known at both ends
        enough = SLIDING * h
        if low == 0.0 and value >= exit_rate(parameters, run, w, run.trial) * tolerance:  # of the whole step
            return h
        if low == 0.0 and high == h:
            rates = exit_rate(parameters, run, w, run.y), exit_rate(parameters, run, w, run.trial)
            s = hermite_root(h, g_low, g_high, rates[0], rates[1], s)
    elif parameters.workspace.resting is not None and kind == GRIP and run.mode[w].grip[side] == CREEP:
        slack = stopped_speed(parameters, run, w, side)  # what is left of the slip is taken away
        if low == 0.0 and value >= -slack:
            return h
    for iteration in range(MOST_ITERATIONS):
        g = trial_guard(parameters, method, run, t, s, which)
        if not math.isfinite(g + s):  # of a state that has burst nothing can be located
            return h
        correction = g * (s - s_last) / (g_last - g)
        if parameters.space is None and kind == EXIT:
            correction = -g / exit_rate(parameters, run, w, run.trial)
        if g > 0.0:
            low = s
        else:
            high = s
        # A chord over a guard that bends sharply gives a small correction far from the root: judge it at its scale.
        close = (parameters.space is None and kind == EXIT) or abs(s - s_last) <= NEAR * h
        near = abs(correction) <= tolerance and close
        if abs(g) <= slack or near or high - low <= tolerance:
            break
        if abs(correction) <= enough and low <= s + correction <= high:
            slide(run, correction)
            return s + correction
        s_last, g_last = s, g
        s += correction
        if iteration % HALVING == HALVING - 1 or not low < s < high:
            s = 0.5 * (low + high)
    return s


@kernel
def exit_rate(parameters, run, w, y):
    """Rate at which the guard EXIT of wheel w changes in state y, rad/s."""
    return -run.mode[w].direction * y[places(parameters).spin_rate + w]


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
    if parameters.space is not None:
        return False
    if kind == TURN:
        return run.mode[w].direction * run.slopes[0, places(parameters).spin_rate + w] < 0.0
    return kind == GRIP and run.mode[w].grip[side] == CREEP


@kernel
def hermite_root(h, g_0, g_1, rate_0, rate_1, s):
    """Root in [0, h] of the cubic with these values and rates at its ends, from the guess s."""
    x, d_0, d_1 = s / h, h * rate_0, h * rate_1
    for _ in range(HERMITE_ITERATIONS):
        y = 1.0 - x
        value = y * y * ((1.0 + 2.0 * x) * g_0 + x * d_0) + x * x * ((1.0 + 2.0 * y) * g_1 - y * d_1)
        slope = 6.0 * x * y * (g_1 - g_0) + y * (1.0 - 3.0 * x) * d_0 + x * (3.0 * x - 2.0) * d_1
        x = min(max(x - value / slope, 0.0), 1.0)
    return x * h if 0.0 < x < 1.0 else s


@kernel
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


@kernel
def trial_guard(parameters, method, run, t, s, which):
    """Value of a guard after a step of length s."""
    advance_again(parameters, method, run, t, s)
    return guard(parameters, run, which, True)
