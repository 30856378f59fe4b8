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
from omnisim.dynamics.state import places
from omnisim.march.creeping import (
    CREEP_SPEED,
    forget_turning,
    keep_creep,
)
from omnisim.march.runge_kutta import refresh
from omnisim.march.slip_bounds import (
    rest_speed,
    stopped_speed,
    youth,
)
from omnisim.march.thin_layer import enter_layer

DRIFTED = 0.01  # of the square of slip that no longer matters: more drift of a sticking contact is taken away
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
    align_slip(parameters, run, False)
    refresh(parameters, run, t)
    if parameters.space is None and run.newton is None and run.clock.lasted > 0.0:
        end_in_the_mean(parameters, run)
    for v in range(len(run.mode)):
        mode, monitors = run.mode[v], run.monitors[v]
        for other in range(contact_count(mode)):
            outside = monitors.margin[other] < -cone_rounding(parameters.machine, monitors)
            if mode.stopped[other] and not mode.shared and outside:
                mode.stopped[other] = 0
                start_creep(parameters, run, v, other, t)


@kernel
def end_in_the_mean(parameters, run):
    """Let the last of a slip (last_slip.py), which the derivative at its start has brought to its end, have gone by the
    mean of that and of the one that has been found there; its heat is known."""
    for m in range(len(run.y)):
        run.y[m] += 0.5 * run.clock.lasted * (run.slopes[0, m] - run.slopes[-1, m])
    run.clock.lasted = 0.0
    loss = places(parameters).friction_loss
    lost = run.y[loss]
    align_slip(parameters, run, False)
    run.y[loss] = lost


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
def start_slip(parameters, run, w, side, t):
    """Let a contact slip whose slip has grown; a creeping one in the direction of the contact equation."""
    mode = run.mode[w]
    if mode.grip[side] == CREEP and not mode.shared:
        refresh(parameters, run, t)
        keep_creep(parameters, run, w, side)
        align_slip(parameters, run, False)
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
    explicit = run.newton is None and parameters.workspace.articulated is None  # whose bodies follow the speeds
    still = explicit
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
        align_slip(parameters, run, explicit and not refreshed)
        if not (still or refreshed):
            refresh(parameters, run, t)
