"""Where in a trial step an event of a machine free in space is: most of its guards need the state alone.

They are followed along the cubic that has the states and derivatives at both ends of the trial, which costs no
right-hand side. A step is taken to the root found there, and what is missing then is a part e of the step h so small
that the state is moved on along its cubic, which errs by e^2 h^4 / 24 of the fourth derivative.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.march.runge_kutta import evaluate
from omnisim.march.spatial_events import OF_STATE, guard_in
from omnisim.march.trial import IMPLICIT_REACH, advance_again, cubic, slide

SHORT_REACH = 1e-3  # of a step, by which an explicit one is moved on
SHRINKING = 2.0**-5  # of a step, in the search for a point inside
ROUNDING = 1e-14  # of a step and of the time: what is nearer to the start of a step is there
ROOT = 1e-12  # of a step, to which a root on a cubic is found
MOST_ITERATIONS = 60  # for a root, of which halving alone would need 50
HALVING = 4  # every so many iterations halve what is left


@kernel
def of_state_alone(kind):
    """Whether guards of this kind are functions of the state alone."""
    return kind in OF_STATE


@outlined
def locate_in_space(parameters, method, run, t, h, which):
    """Root s of such a Guard on a step of length h at whose end it is negative; leaves the trial at s."""
    near = IMPLICIT_REACH if run.clock.implicit else SHORT_REACH
    low, high, s = 0.0, h, h
    for iteration in range(MOST_ITERATIONS):
        value = guard_along(parameters, run, which, s, 1.0)
        if not math.isfinite(value + s):  # of a state that has burst nothing can be located
            return h
        if value < 0.0:
            x, high = root_before(parameters, run, which, s, value), s
        else:
            x, low = root_beyond(parameters, run, which, s, value, near), s
        if x * s <= ROUNDING * (t + run.clock.dt):
            stay(parameters, run, t)
            return 0.0
        if abs(x - 1.0) <= near:
            slide(parameters, run, s, (x - 1.0) * s)
            return x * s
        s *= x
        if iteration % HALVING == HALVING - 1 or not low < s < high:
            s = 0.5 * (low + high)
        advance_again(parameters, method, run, t, s)
    return s


@kernel
def root_before(parameters, run, which, h, value):
    """Part of the trial step h, at whose end a Guard has this negative value, at which it is zero on the cubic; 0 if it
    is positive nowhere before.

    A step that starts ON the root, leaves it and comes back has its event at the later root: so first a point inside is
    sought at which the guard holds.
    """
    low, at_low, high, at_high = 0.0, guard_along(parameters, run, which, h, 0.0), 1.0, value
    while at_low <= 0.0:
        if low > 0.0:
            high, at_high = low, at_low
        low = SHRINKING * high
        if low * h < ROUNDING * run.clock.dt:
            return 0.0
        at_low = guard_along(parameters, run, which, h, low)
    return root_between(parameters, run, which, h, (low, at_low), (high, at_high))


@kernel
def root_beyond(parameters, run, which, h, value, near):
    """The same where it is positive at the end: within a part `near` beyond it, or where a chord over that points."""
    further = guard_along(parameters, run, which, h, 1.0 + near)
    if further < 0.0:
        return root_between(parameters, run, which, h, (1.0, value), (1.0 + near, further))
    return 1.0 + near * value / (value - further) if further < value else math.inf


@outlined
def root_between(parameters, run, which, h, positive, negative):
    """Part of the trial step h at which a Guard is zero on its cubic, between two with values of both signs (x, value):
    by chords, of which the end that stays counts half each time (Dowell & Jarratt 1971)."""
    (low, at_low), (high, at_high) = positive, negative
    x, side = high, 0
    for _ in range(MOST_ITERATIONS):
        last, x = x, (low * at_high - high * at_low) / (at_high - at_low)
        if abs(x - last) <= ROOT or high - low <= ROOT:
            break
        found = guard_along(parameters, run, which, h, x)
        if found < 0.0:
            high, at_high = x, found
            at_low *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            low, at_low = x, found
            at_high *= 0.5 if side > 0 else 1.0
            side = 1
    return x


@kernel
def guard_along(parameters, run, which, h, x):
    """Value of a Guard at a part x of the trial step h, on the cubic."""
    state = parameters.space.shifted
    whole, first, last = cubic(h, x)
    for m in range(len(state)):
        step = whole * run.increment[m] + (first * run.slopes[0, m] + last * run.slopes[-1, m])
        state[m] = run.y[m] + step
    return guard_in(parameters, run.mode[which.wheel], which.kind, which.wheel, which.side, state)


@kernel
def stay(parameters, run, t):
    """Let the trial end where the step starts."""
    for m in range(len(run.trial)):
        run.increment[m], run.trial[m] = run.carry[m], run.y[m]
    evaluate(parameters, run.mode, run.clock.piece, t, run.trial, run.slopes[-1], run.monitors_end)
    run.clock.rhs += 1
