"""Where in a trial step an event of a machine free in space is: most of its guards need the state alone.

They are followed along the trial's continuous extension, a quartic: of a method that has none of its own (methods.py)
the one to where the last step began, or if the motion has not been smooth since, with one derivative more. A smooth
explicit step ends where that has the first root, and all that change within a moment change together: it errs with h^5,
once for an event. Where states change much faster than any cubic, as they may in an implicit step, or forces at the end
are wanted too, a step is taken to the root found on the cubic that has the states and derivatives at both ends. What is
missing then is a part e of the step h so small that the state is moved on along it, which errs by e^2 h^4 / 24 of the
fourth derivative.
"""

import math

from omnisim.base import methods
from omnisim.base.chords import FOUND, settled, staying
from omnisim.base.kernel import kernel, outlined
from omnisim.dynamics.state import Stage
from omnisim.march.events import NO_GUARD, Guard, guard
from omnisim.march.runge_kutta import evaluate, lead
from omnisim.march.spatial_events import (
    APART,
    ARC,
    DOWN,
    MEET,
    OF_FORCES,
    PIECE,
    PRESS,
    all_stay,
    guard_in,
    may_meet,
    sides_of,
)
from omnisim.march.trial import IMPLICIT_REACH, advance_again, cubic, slide

BETWEEN = float(methods.BETWEEN)
LEAST_SMOOTH = 0.1  # of a step: rounding of a last one that was shorter would bend it more than the motion does
SHORT_REACH = 1e-3  # of a step, by which an explicit one is moved on
MOMENT = 1e-9  # of a grid step: what follows within it happens at the same instant
BEND = 1e-6  # the same of forces that only bend, where lowest points pass from arc to arc: they err by its square
SHRINKING = 2.0**-5  # of a step, in the search for a point inside
ROUNDING = 1e-14  # of a step and of the time: what is nearer to the start of a step is there
MOST_ITERATIONS = 60  # for a root, of which halving alone would need 50
HALVING = 4  # every so many iterations halve what is left


@kernel
def ends_anywhere(parameters, run):
    """Whether a trial step with a smooth law may be ended where its extension says: an explicit one, at whose end every
    guard holds that needs forces."""
    held = not run.clock.implicit
    for kind in OF_FORCES:
        for w in range(len(run.mode)):
            for side in range(sides_of(parameters, run, kind, w)):
                held = held and guard(parameters, run, Guard(kind, w, side), True) >= 0.0
    return held


@outlined
def cut_along(parameters, method, run, t, h):
    """Move the end of such a trial step of length h to its first event: its length, and the Guard that fired or
    NO_GUARD; those that fire with it in `changes`.

    Where all that fires is the end of a contact whose rubber presses no more, nothing jumps or bends: the step stays as
    long as it is, and the clock knows how late that is.
    """
    bend(parameters, method, run, t, h)
    x, fired, others = 1.0, NO_GUARD, -1
    for w in range(len(run.mode)):
        if all_stay(parameters, run, w):
            continue
        for kind in (DOWN, APART, PIECE, PRESS, ARC, MEET):
            for side in range(sides_of(parameters, run, kind, w)):
                if kind == MEET and not may_meet(parameters, run.mode[w], w, side):
                    continue
                which = Guard(kind, w, side)
                value = guard(parameters, run, which, True)
                others += value < 0.0
                if value < 0.0 and fired.kind >= 0:
                    value = guard_along(parameters, run, which, h, x)
                if value < 0.0:
                    x, fired = root_before(parameters, run, which, h, x, value), which
    if fired.kind < 0 or not math.isfinite(x):  # in a state that has burst nothing can be located
        return h, NO_GUARD
    note_changes(parameters, run, fired, h, x)
    if others == 0 and fired.kind == APART and not run.mode[fired.wheel].pressed[fired.side]:
        run.clock.late = (1.0 - x) * h
        return h, fired
    slide_along(parameters, run, h, x)
    return x * h, fired


@kernel
def note_changes(parameters, run, fired, h, x):
    """Write into `changes` the Guard that has fired at a part x of the trial step h, and those negative at the end that
    do so a moment later: contacts from the last of a wheel to its first, so that one which ends leaves the numbers of
    those that follow."""
    most = len(parameters.space.changes) - 1
    later, bent = after(run.clock.dt, h, x, MOMENT), after(run.clock.dt, h, x, BEND)
    count = 0
    for w in range(len(run.mode)):
        if all_stay(parameters, run, w):
            continue
        contacts = sides_of(parameters, run, APART, w)
        for place in range(contacts):
            ends = False
            for kind in (APART, PIECE, PRESS, ARC):
                which = Guard(kind, w, contacts - 1 - place)
                by = bent if kind == ARC else later
                if not ends and count < most and fires(parameters, run, which, fired, h, by):
                    count = note(parameters, count, which)
                    ends = kind in (APART, PIECE)
        for side in range(sides_of(parameters, run, MEET, w)):
            which = Guard(MEET, w, side)
            waits = count < most and may_meet(parameters, run.mode[w], w, side)
            if waits and fires(parameters, run, which, fired, h, later):
                count = note(parameters, count, which)


@kernel
def after(dt, h, x, moment):
    """Part of the trial step h that is so much of a grid step dt after x, or its end."""
    return x + min(moment * dt / max(h, moment * dt), max(1.0 - x, 0.0))


@kernel
def note(parameters, count, which):
    """Write a Guard into `changes` after so many others: how many there are then."""
    changes = parameters.space.changes
    changes[count, 0], changes[count, 1], changes[count, 2] = which
    changes[count + 1, 0] = -1
    return count + 1


@kernel
def fires(parameters, run, which, fired, h, later):
    """Whether a Guard is the one that has fired in a trial step h, or negative at its end and at a part `later`."""
    if which == fired:
        return True
    return guard(parameters, run, which, True) < 0.0 and guard_along(parameters, run, which, h, later) < 0.0


@outlined
def locate_in_space(parameters, method, run, t, h, which):
    """Root s of such a Guard on a step of length h at whose end it is negative; leaves the trial at s."""
    near = IMPLICIT_REACH if run.clock.implicit else SHORT_REACH
    unbend(parameters)
    note(parameters, 0, which)
    low, high, s = 0.0, h, h
    for iteration in range(MOST_ITERATIONS):
        value = guard_along(parameters, run, which, s, 1.0)
        if not math.isfinite(value + s):  # of a state that has burst nothing can be located
            return h
        if value < 0.0:
            x, high = root_before(parameters, run, which, s, 1.0, value), s
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
def root_before(parameters, run, which, h, x, value):
    """Part of the trial step h, before x where a Guard has this negative value, at which it is zero on the extension; 0
    if it is positive nowhere before.

    A step that starts ON the root, leaves it and comes back has its event at the later root: so first a point inside is
    sought at which the guard holds.
    """
    low, high, at_high = 0.0, x, value
    kept = which.kind != MEET  # of its gaps, all that is kept is the least
    at_low = guard(parameters, run, which, False) if kept else guard_along(parameters, run, which, h, low)
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
    """Part of the trial step h at which a Guard is zero on its extension, between two with values of both signs
    (x, value)."""
    (low, at_low), (high, at_high) = positive, negative
    x, moved, side = high, 0.0, 0
    for _ in range(MOST_ITERATIONS):
        last, x = x, (low * at_high - high * at_low) / (at_high - at_low)
        before, moved = moved, abs(x - last)
        if settled(moved, before) or high - low <= FOUND:
            break
        found = guard_along(parameters, run, which, h, x)
        if found < 0.0:
            if side < 0:
                at_low *= staying(found, at_high)
            high, at_high, side = x, found, -1
        else:
            if side > 0:
                at_high *= staying(found, at_low)
            low, at_low, side = x, found, 1
    return x


@kernel
def unbend(parameters):
    """Let the extension of a trial step be the cubic."""
    for m in range(len(parameters.space.bent)):
        parameters.space.bent[m] = 0.0


@kernel
def bend(parameters, method, run, t, h):
    """Write into `bent` what the extension of the trial step h has beside its cubic."""
    y, slopes, bent, state = run.y, run.slopes, parameters.space.bent, parameters.space.shifted
    known, more = len(method.b) + 1, 0.0  # derivatives of the step, the weight of one between
    if len(method.within) > 0:
        if run.clock.smooth > LEAST_SMOOTH * h:
            bend_to_last(parameters, run, h)
            return
        lead(method.within, 0, known + 2, slopes, state)
        for m in range(len(state)):
            state[m] = y[m] + h * state[m]
        evaluate(parameters, Stage(run.mode, run.clock.piece, t + BETWEEN * h, state, bent, run.monitors, False))
        run.clock.rhs += 1
        more = method.bend[known]
    else:
        unbend(parameters)
    lead(method.bend, 0, known + 2, slopes, state)
    for m in range(len(bent)):
        bent[m] = h * (state[m] + more * bent[m])


@kernel
def bend_to_last(parameters, run, h):
    """The same of a quartic through the state where the last step began."""
    bent, last_state = parameters.space.bent, parameters.space.last
    x = -run.clock.smooth / h
    whole, first, last = cubic(h, x)
    scale = 1.0 / (x * x * (1.0 - x) * (1.0 - x))
    for m in range(len(bent)):
        step = whole * run.increment[m] + (first * run.slopes[0, m] + last * run.slopes[-1, m])
        bent[m] = scale * (last_state[m] - run.y[m] - step)


@outlined
def guard_along(parameters, run, which, h, x):
    """Value of a Guard at a part x of the trial step h, on its extension."""
    state, bent = parameters.space.shifted, parameters.space.bent
    whole, first, last = cubic(h, x)
    more = x * x * (1.0 - x) * (1.0 - x)
    for m in range(len(state)):
        step = whole * run.increment[m] + (first * run.slopes[0, m] + last * run.slopes[-1, m])
        state[m] = run.y[m] + step + more * bent[m]
    return guard_in(parameters, run.mode[which.wheel], which.kind, which.wheel, which.side, state)


@kernel
def slide_along(parameters, run, h, x):
    """Move the end of the trial step h to a part x of it, on its extension."""
    bent = parameters.space.bent
    more = x * x * (1.0 - x) * (1.0 - x)
    slide(parameters, run, h, (x - 1.0) * h)
    for m in range(len(bent)):
        run.increment[m] += more * bent[m]
        run.trial[m] = run.y[m] + run.increment[m]


@kernel
def stay(parameters, run, t):
    """Let the trial end where the step starts."""
    for m in range(len(run.trial)):
        run.increment[m], run.trial[m] = run.carry[m], run.y[m]
    evaluate(parameters, Stage(run.mode, run.clock.piece, t, run.trial, run.slopes[-1], run.monitors_end, True))
    run.clock.rhs += 1
