"""Marching in time: step, locate, grid step, march; the only loops over time.

The grid k * dt never shifts. A grid step is cut at events and at knots of the tables; the remainder of the same step
is taken from there, each piece with the mode frozen, so the order of the method survives.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.contact.kinematics import Slip, inverse_mass
from omnisim.contact.reaction import friction_factor
from omnisim.contact.tracking import IMPLICIT, Heading
from omnisim.dynamics import contact_reaction, rho_of, rhs
from omnisim.events import GUARDS, TURN, guard, release_roller, take_roller, touching, transition
from omnisim.kernel import kernel
from omnisim.state import PER_WHEEL, SPIN_RATE, WHEELS, YAW
from omnisim.status import CROWDED, EVENTS_PER_STEP, LOG_FULL, LOST_TRACK, NOT_FINITE, ROCKING, RUNNING, TOO_STIFF
from omnisim.vector import dot

TURNS_PER_STEP = 100  # reversals of spin in one step: a Zeno sequence of ever shorter swings about an edge
STIFF_STEPS = 8  # surplus of steps too large for the rate at which slip relaxes, before the run stops
LOST = 1e-3  # |rho|^2 - 1 at which the implicit tracking is no longer worth its name
ROUNDING = 1e-14
EPSILON = 4.0 * 2.0**-52

CLOCK = np.dtype(
    [
        ("step", np.int64),  # grid steps done
        ("row", np.int64),  # output rows written
        ("piece", np.int64),  # of the tables
        ("events", np.int64),  # in the log
        ("rhs", np.int64),  # right-hand sides evaluated
        ("stiff", np.int64),  # surplus of steps too large for the rate at which slip relaxes
        ("status", np.int64),
        ("wheel", np.int64),  # that caused the status, or -1
        ("dt", np.float64),  # s
        ("elapsed", np.float64),  # in the grid step under way, s
        ("rate", np.float64),  # relaxation rate of slip when found too stiff, 1/s
        ("stability_limit", np.float64),  # of the method on the negative real axis, 1
    ]
)


class Run(NamedTuple):
    """The mutable part of a march, n states, W wheels, N rollers, s stages.

    y, trial, stage (n,); slopes (s + 1, n): stage derivatives, the first at the start of the step and the last at
    its end; rates (W, N) absolute axial rate of every roller, rad/s (of the one in contact: as of its last exchange);
    mode (W,) records MODE; watch, watch_end (W,) records WATCH at the start and end of the step; clock record CLOCK.
    """

    y: np.ndarray
    trial: np.ndarray
    stage: np.ndarray
    slopes: np.ndarray
    rates: np.ndarray
    mode: np.recarray
    watch: np.recarray
    watch_end: np.recarray
    clock: np.record


class Rows(NamedTuple):
    """What is recorded at the T output times: states (T, n), rates (T, W, N), mode (T, W) and piece (T,)."""

    y: np.ndarray
    rates: np.ndarray
    mode: np.recarray
    piece: np.ndarray


@kernel
def march(parameters, tableau, run, rows, log, steps_per_row, last_step):
    """March to grid step `last_step` or until something stops the run; resumable. Returns the status."""
    clock = run.clock
    if clock.row == 0:
        settle(parameters, run)
        check(parameters, run)
        if clock.status == RUNNING:
            write_row(parameters, run, rows)
    while clock.step < last_step and clock.status == RUNNING:
        if clock.events + 2 * EVENTS_PER_STEP > len(log):
            return LOG_FULL
        grid_step(parameters, tableau, run, log)
        if clock.status == RUNNING:
            clock.step += 1
            clock.elapsed = 0.0
            check(parameters, run)
            if clock.status == RUNNING and clock.step % steps_per_row == 0:
                write_row(parameters, run, rows)
    return clock.status


@kernel
def settle(parameters, run):
    """The mode at t = 0. On an edge the sense of spin tells the roller, and without spin its acceleration."""
    machine = parameters.machine
    for w in range(len(run.mode)):
        at, mode = WHEELS + PER_WHEEL * w, run.mode[w]
        ahead, behind = touching(parameters, w, run.y)
        spin = run.y[at + SPIN_RATE]
        take_roller(parameters, run, w, behind if spin < 0.0 else ahead)
        mode.direction = -1 if spin < 0.0 else 1
        refresh(parameters, run, 0.0)
        mode.saturated = run.watch[w].slip_square > machine.slip_speed * machine.slip_speed
        refresh(parameters, run, 0.0)
        if spin == 0.0 and run.slopes[0, at + SPIN_RATE] < 0.0:
            mode.direction = -1
            if ahead != behind:
                take_roller(parameters, run, w, behind)
                refresh(parameters, run, 0.0)
                if run.slopes[0, at + SPIN_RATE] > 0.0:
                    run.clock.status, run.clock.wheel = ROCKING, w


@kernel
def write_row(parameters, run, rows):
    row = run.clock.row
    for w in range(len(run.mode)):
        release_roller(parameters, run, w)
        rows.mode[row, w] = run.mode[w]
        copy(run.rates[w], rows.rates[row, w])
    copy(run.y, rows.y[row])
    rows.piece[row] = run.clock.piece
    run.clock.row = row + 1


@kernel
def grid_step(parameters, tableau, run, log):
    """One dt, with all its events and knots."""
    clock = run.clock
    start, turns, first_event = clock.step * clock.dt, 0, clock.events
    clock.elapsed = 0.0
    while clock.elapsed < clock.dt:
        h, knot = piece_length(parameters, clock, start)
        advance(parameters, tableau, run, start + clock.elapsed, h)
        h, kind, w = cut_at_event(parameters, tableau, run, start + clock.elapsed, h)
        accept(run)
        clock.elapsed += h
        if kind >= 0:
            transition(parameters, run, log, kind, w, start + clock.elapsed)
            turns += kind == TURN
        elif knot:
            clock.piece += 1
        else:
            return
        if turns > TURNS_PER_STEP:
            clock.status, clock.wheel = ROCKING, w
        elif clock.events - first_event > EVENTS_PER_STEP:
            clock.status, clock.wheel = CROWDED, w
        if clock.status != RUNNING:
            return
        refresh(parameters, run, start + clock.elapsed)


@kernel
def piece_length(parameters, clock, start):
    """Length of the next piece of a grid step, s, and whether a knot of the tables ends it."""
    rest = clock.dt - clock.elapsed
    if clock.piece + 1 < len(parameters.starts):
        to_knot = parameters.starts[clock.piece + 1] - start - clock.elapsed
        if to_knot <= rest + ROUNDING * (start + clock.dt):
            return max(min(to_knot, rest), 0.0), True
    return rest, False


@kernel
def advance(parameters, tableau, run, t, h):
    """One Runge-Kutta step of length h from run.y into run.trial, with the derivative and `watch` at its end."""
    a, b, c = tableau
    y, trial, stage, slopes = run.y, run.trial, run.stage, run.slopes
    stages = len(b)
    for i in range(1, stages):
        combine(y, h, a[i], i, slopes, stage)
        rhs(parameters, run.mode, run.clock.piece, t + c[i] * h, stage, slopes[i], run.watch_end)
    combine(y, h, b, stages, slopes, trial)
    rhs(parameters, run.mode, run.clock.piece, t + h, trial, slopes[stages], run.watch_end)
    run.clock.rhs += stages


@kernel
def combine(y, h, weights, count, slopes, out):
    """out = y + h (weights . slopes) over the first `count` slopes; the sum first, so y is rounded once."""
    for m in range(len(y)):
        out[m] = weights[0] * slopes[0, m]
    for j in range(1, count):
        if weights[j] != 0.0:
            for m in range(len(y)):
                out[m] += weights[j] * slopes[j, m]
    for m in range(len(y)):
        out[m] = y[m] + h * out[m]


@kernel
def accept(run):
    """The trial becomes the state, and its derivative the first stage of the next step."""
    copy(run.trial, run.y)
    copy(run.slopes[-1], run.slopes[0])
    for w in range(len(run.watch)):
        run.watch[w] = run.watch_end[w]


@kernel
def copy(source, target):
    for m in range(len(source)):
        target[m] = source[m]


@kernel
def refresh(parameters, run, t):
    """Derivative at the state itself, after the mode has changed."""
    rhs(parameters, run.mode, run.clock.piece, t, run.y, run.slopes[0], run.watch)
    run.clock.rhs += 1


@kernel
def cut_at_event(parameters, tableau, run, t, h):
    """Shorten the trial step to its first event: its length, the guard that fired (or -1) and the wheel.

    Each violated guard is located on what is left of the step, TURN first, so EXIT sees a monotone spin angle and a
    step that leaves a roller's end and comes back is cut at the turn before it is searched.
    """
    fired, wheel = -1, -1
    for kind in range(GUARDS):
        for w in range(len(run.mode)):
            value = guard(parameters, run.mode, kind, w, run.trial, run.watch_end)
            if value < 0.0:
                h = locate(parameters, tableau, run, t, h, kind, w, value)
                fired, wheel = kind, w
    return h, fired, wheel


@kernel
def locate(parameters, tableau, run, t, h, kind, w, value):
    """Root s of a guard on a step of length h at whose end it has the negative `value`; leaves the trial at s.

    Every evaluation is a step of its own from the start of the step, so the state found is as accurate as any. A
    step that starts ON the root, leaves it and comes back has its event at the later root: so first a point inside
    is sought at which the guard holds. Then a safeguarded secant iteration.
    """
    low, high = 0.0, h
    g_low, g_high = guard(parameters, run.mode, kind, w, run.y, run.watch), value
    while g_low <= 0.0:
        s = 0.5 * high
        if s < ROUNDING * run.clock.dt:
            advance(parameters, tableau, run, t, 0.0)
            return 0.0
        g = trial_guard(parameters, tableau, run, t, s, kind, w)
        if g > 0.0:
            low, g_low = s, g
        else:
            high, g_high = s, g
    tolerance = 1e-12 * h + EPSILON * (t + h)
    s, s_last, g_last = low + (high - low) * g_low / (g_low - g_high), high, g_high
    for iteration in range(60):
        g = trial_guard(parameters, tableau, run, t, s, kind, w)
        correction = g * (s - s_last) / (g_last - g)
        if g > 0.0:
            low = s
        else:
            high = s
        if g == 0.0 or abs(correction) <= tolerance or high - low <= tolerance:
            break
        s_last, g_last = s, g
        s += correction
        if iteration % 4 == 3 or not low < s < high:
            s = 0.5 * (low + high)
    return s


@kernel
def check(parameters, run):
    """Status of the state at a grid point: finite, and no slip relaxing faster than the method can follow.

    The friction force is bounded, so a step too large for it never overflows: slip chatters about zero with the
    amplitude that one step gives. It shows in steps outside the method's stability region that outnumber those
    inside; a slip that only passes through zero has one or two.
    """
    clock, total = run.clock, 0.0
    for m in range(len(run.y)):
        total += run.y[m] * run.y[m] + run.slopes[0, m] * run.slopes[0, m]
    if not math.isfinite(total):
        clock.status = TOO_STIFF if clock.stiff > 0 else NOT_FINITE
        return
    stiff = False
    for w in range(len(run.mode)):
        if parameters.machine.tracking == IMPLICIT:
            rho = rho_of(parameters, run.y, w, run.mode[w].roller % parameters.wheels[w].rollers)
            if abs(dot(rho, rho) - 1.0) > LOST:
                clock.status, clock.wheel = LOST_TRACK, w
                return
        if run.watch[w].factor * parameters.machine.slip_mobility * clock.dt > clock.stability_limit:
            now, at_rest = relaxation_rates(parameters, run, w)
            if now * clock.dt > clock.stability_limit:
                stiff = True
                clock.rate, clock.wheel = at_rest, w
    clock.stiff = clock.stiff + 1 if stiff else max(clock.stiff - 1, 0)
    if clock.stiff >= STIFF_STEPS:
        clock.status = TOO_STIFF


@kernel
def relaxation_rates(parameters, run, w):
    """Rates at which friction relaxes the slip of wheel w, 1/s: at its slip now, and at zero slip."""
    machine, normal = parameters.machine, run.watch[w].normal_force
    heading = Heading(math.cos(run.y[YAW]), math.sin(run.y[YAW]))
    reaction = contact_reaction(parameters, run.mode[w], w, heading, normal, run.y)
    hh, hk, kk = inverse_mass(machine, parameters.wheels[w], reaction.axis, reaction.contact)
    mobility = 0.5 * (hh + kk) + math.sqrt(0.25 * (hh - kk) ** 2 + hk * hk)
    return reaction.factor * mobility, friction_factor(machine, 0, normal, Slip(0.0, 0.0)) * mobility


@kernel
def trial_guard(parameters, tableau, run, t, s, kind, w):
    """Value of a guard after a step of length s."""
    advance(parameters, tableau, run, t, s)
    return guard(parameters, run.mode, kind, w, run.trial, run.watch_end)
