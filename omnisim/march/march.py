"""Marching in time: grid step, march; the only loops over time.

The grid k * dt never shifts. A grid step is cut at events and at knots of the tables; the remainder of the same step
is taken from there, each piece with the mode frozen, so the order of the method survives.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.status import (
    COMPLETE,
    CROWDED,
    EVENTS_PER_STEP,
    HOVERING,
    LOG_FULL,
    LOST_TRACK,
    NOT_FINITE,
    RESTLESS,
    ROCKING,
    RUNNING,
    SLOW_SLIP,
    STIFF_BEARING,
    STIFF_CURRENT,
    TOO_STIFF,
)
from omnisim.dynamics.actuation import sample
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.multibody.joint_kinematics import project_bodies
from omnisim.march.creeping import forget_turning, keep_turning
from omnisim.march.event_location import GRID_ROUNDING, step_to_event
from omnisim.march.events import (
    EXIT,
    TURN,
    restore_consistency,
    transition,
)
from omnisim.march.extremes import begin_interval, follow, follow_again
from omnisim.march.friction_modes import rests, take_drift_away
from omnisim.march.grip_events import end_slips
from omnisim.march.last_slip import end_slip
from omnisim.march.onset import stand
from omnisim.march.roller_exchange import release_rollers
from omnisim.march.runge_kutta import accept, copy, refresh
from omnisim.march.spatial_contacts import release, stand_in_space
from omnisim.march.spatial_events import PRESS, of_state_alone
from omnisim.march.stopping import begin_to_stop, slip_freely
from omnisim.march.substeps import step_length
from omnisim.march.thin_layer import any_layered, follow_layer, relax_slips
from omnisim.march.validity import check, check_energy, too_fast, too_stiff

TURNS_PER_STEP = 1000  # reversals of spin, swings about an edge that never come to rest on both rollers
CUTS_PER_STEP = 1000  # changes of friction, in a step that no branch of the law survives
TOLD = 1e-9  # of a step: a shorter one, which rounding left over at a knot, tells of no rate
PRESSES_PER_STEP = 1000  # of a roller that its friction lifts as soon as it presses
UNBENT = 1e-9  # of inputs and their slopes, by which rounding may change them at a knot
SLIPS_PER_STEP = 10**6  # sub-steps of slow slip in one step


@kernel
def march(parameters, method, run, rows, log):
    """March to the goal or until something stops the run; pauses when it has worked enough or the log is full.

    Resumable: returns the status, RUNNING at a pause or at a goal before the end, LOG_FULL if the log needs room.
    """
    clock = run.clock
    if clock.row == 0 and clock.status == RUNNING:
        sampled(parameters, run, False)
        if parameters.space is not None:
            stand_in_space(parameters, run)
            restore_consistency(parameters, run, log, 0.0)
        else:
            stand(parameters, run, log)
            relax(parameters, run, 0.0)
        check(parameters, run)
        bearings, currents = parameters.machine.bearing_relaxation, parameters.machine.current_relaxation
        if clock.status == RUNNING:
            begin_interval(parameters, run, rows, 0)
            write_row(parameters, run, rows)
        if run.newton is None and max(bearings, currents) * clock.dt > clock.stability_limit:
            clock.status = STIFF_BEARING if bearings > currents else STIFF_CURRENT
            clock.rate = max(bearings, currents)
    elif clock.status == RUNNING and clock.piece + 1 < len(parameters.starts):
        enter_piece(parameters, run, rows, log)
    while clock.status == RUNNING and clock.step < clock.goal and clock.rhs < clock.pause:
        if clock.events + 2 * EVENTS_PER_STEP > len(log):
            return LOG_FULL
        grid_step(parameters, method, run, rows, log)
        if not step_left(clock):  # it may have stopped at its very end
            clock.step += 1
            clock.elapsed = 0.0
            if parameters.machine.sampled and clock.status == RUNNING and sampled(parameters, run, False):
                refresh(parameters, run, clock.step * clock.dt)
                restore_consistency(parameters, run, log, clock.step * clock.dt)
                relax(parameters, run, clock.step * clock.dt)
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
    clock = run.clock
    due = False
    for w in range(len(run.mode)):
        steps = parameters.wheels[w].sample_steps
        if steps > 0 and clock.step % steps == 0:
            sample(parameters, run.mode[w], clock.piece, clock.step * clock.dt, w, run.y, again)
            due = True
    if due:
        forget_turning(parameters, run)
    return due


@kernel
def enter_piece(parameters, run, rows, log):
    """Enter a piece of the tables set while the march stood still; a row of this instant is renewed."""
    clock = run.clock
    here = clock.step * clock.dt
    if parameters.starts[clock.piece + 1] <= here:
        next_piece(parameters, run, here)
        sampled(parameters, run, True)
        refresh(parameters, run, here)
        restore_consistency(parameters, run, log, here)
        relax(parameters, run, here)
        on_row = clock.step % clock.steps_per_row == 0
        clock.row -= on_row
        if clock.step == 0:
            begin_interval(parameters, run, rows, 0)
        else:
            follow_again(parameters, run, rows, clock.row)
        if on_row:
            write_row(parameters, run, rows)


@kernel
def next_piece(parameters, run, t):
    """The next piece of the tables begins at the time t; what jumps or bends there turns creeping slips otherwise."""
    clock = run.clock
    ends, begins = parameters.inputs[clock.piece], parameters.inputs[clock.piece + 1]
    span, step = t - parameters.starts[clock.piece], t - parameters.starts[clock.piece + 1]
    goes_on = True
    for i in range(len(ends)):
        last, first = ends[i, 0] + span * ends[i, 1], begins[i, 0] + step * begins[i, 1]
        goes_on = goes_on and abs(first - last) <= UNBENT * (abs(first) + abs(last))
        goes_on = goes_on and abs(begins[i, 1] - ends[i, 1]) <= UNBENT * (abs(begins[i, 1]) + abs(ends[i, 1]))
    clock.piece += 1
    if not goes_on:
        forget_turning(parameters, run)


@outlined
def write_row(parameters, run, rows):
    row = run.clock.row
    release_all(parameters, run)
    check_energy(parameters, run)
    for w in range(len(run.mode)):
        rows.mode[row, w] = run.mode[w]
        copy(run.rates[w], rows.rates[row, w])
    copy(run.y, rows.y[row])
    rows.piece[row] = run.clock.piece
    run.clock.row = row + 1
    begin_interval(parameters, run, rows, row + 1)


@kernel
def release_all(parameters, run):
    """Write the roller rates of the state back to `rates`."""
    for w in range(len(run.mode)):
        if parameters.space is not None:
            release(parameters, run, w)
        else:
            release_rollers(parameters, run, w)


@kernel
def step_left(clock):
    """Whether more is left of a grid step than rounding, as of a knot that ends it."""
    return clock.dt - clock.elapsed > GRID_ROUNDING * clock.dt * (clock.step + 1)


@kernel
def grid_step(parameters, method, run, rows, log):
    """One dt, with all its events and knots; what it passes through enters the extremes of its interval."""
    clock = run.clock
    start = clock.step * clock.dt
    first_event = clock.events
    turns = 0
    others = 0
    presses = 0
    slips = 0
    clock.elapsed = 0.0
    while step_left(clock):
        t = start + clock.elapsed
        h, knot = piece_length(parameters, clock, start)
        whole = h
        if parameters.workspace.resting is not None:
            end_old_slips(parameters, run, rows, log, t, h)
        h, fired = next_step(parameters, method, run, t, h)
        if parameters.space is not None:
            copy(run.y, parameters.space.last)
        accept(run)
        clock.smooth = h
        kind, w, _ = fired
        if parameters.space is None or kind < 0 or not of_state_alone(kind):  # of others the forces are found anew
            follow(parameters, run, rows, clock.row)
        if parameters.workspace.articulated is not None:
            project_bodies(parameters, run, True)
        clock.elapsed += h
        if parameters.workspace.resting is not None:
            if run.newton is None and h > TOLD * clock.dt:
                keep_turning(parameters, run, h)
            if parameters.space is None and any_layered(parameters, run):
                follow_layer(parameters, run, h)
            take_drift_away(parameters, run, start + clock.elapsed, kind >= 0 and kind != TURN)
        if kind >= 0:
            transition(parameters, run, log, fired, start + clock.elapsed)
            restore_consistency(parameters, run, log, start + clock.elapsed)
            relax(parameters, run, start + clock.elapsed)
            follow_again(parameters, run, rows, clock.row)
            if parameters.space is None:
                turns += kind == TURN
                others += kind not in (TURN, EXIT)
            else:
                others += not of_state_alone(kind)
                presses += kind == PRESS
        elif h < whole:
            slips += 1
        elif knot:
            next_piece(parameters, run, start + clock.elapsed)
            refresh(parameters, run, start + clock.elapsed)
            restore_consistency(parameters, run, log, start + clock.elapsed)
            relax(parameters, run, start + clock.elapsed)
            follow_again(parameters, run, rows, clock.row)
        else:
            return
        if turns > TURNS_PER_STEP:
            clock.status, clock.wheel = ROCKING, w
        elif others > CUTS_PER_STEP and parameters.workspace.resting is None:
            clock.wheel = w
            too_stiff(parameters, run, w, RESTLESS)
        elif slips > SLIPS_PER_STEP:
            clock.status = SLOW_SLIP
            clock.wheel = max(w, 0)
        elif others > CUTS_PER_STEP:
            clock.status, clock.wheel = RESTLESS, w
        elif presses > PRESSES_PER_STEP:
            clock.status, clock.wheel = HOVERING, w
        elif clock.events - first_event > EVENTS_PER_STEP:
            clock.status, clock.wheel = CROWDED, w
            if too_fast(parameters, run, w):
                too_stiff(parameters, run, w, CROWDED)
        if clock.status != RUNNING:
            return


@kernel
def next_step(parameters, method, run, t, h):
    """A trial step of at most h, up to its first event: its length, and the Guard that fired or NO_GUARD."""
    if parameters.workspace.resting is not None and run.newton is None:
        s, fired = end_slip(parameters, run, t, h)
        if fired.kind >= 0:
            return s, fired
    longest = h
    if parameters.workspace.resting is not None or run.newton is not None:
        h = step_length(parameters, run, t, h)
    return step_to_event(parameters, method, run, t, h, longest)


@kernel
def relax(parameters, run, t):
    """Slips within a thin layer relax, where forces have jumped."""
    if parameters.space is None and parameters.workspace.resting is not None and any_layered(parameters, run):
        relax_slips(parameters, run, t)


@kernel
def end_old_slips(parameters, run, rows, log, t, h):
    """Let contacts stick or creep whose slip has come to its end, or will soon; h: length of the piece that begins."""
    resting = False
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            resting = resting or rests(parameters, run, w, side)
    if resting:
        end_slips(parameters, run, log, -1, 0, t)
        relax(parameters, run, t)
        follow_again(parameters, run, rows, run.clock.row)
    if run.newton is None:
        slip_freely(parameters, run)
    begin_to_stop(parameters, run, t, h)


@kernel
def piece_length(parameters, clock, start):
    """Length of the next piece of a grid step, s, and whether a knot of the tables ends it."""
    rest = clock.dt - clock.elapsed
    if clock.piece + 1 < len(parameters.starts):
        to_knot = parameters.starts[clock.piece + 1] - start - clock.elapsed
        if to_knot <= rest + GRID_ROUNDING * (start + clock.dt):
            return max(min(to_knot, rest), 0.0), True
    return rest, False
