"""Coulomb friction in time: how a contact comes to rest, holds, lets go and slips on.

    SLIP   ---- slip below rest_speed, F inside the cone ---->  STICK
    SLIP   ---- slip below rest_speed, F outside ------------>  CREEP  (through zero without sticking)
    SLIP   ---- slip about to stop, turning no more --------->  CREEP  (in space also slow slip that lasts)
    STICK  ---- |F| reaches mu N ---------------------------->  CREEP
    CREEP  ---- slip no longer young ------------------------>  SLIP
    CREEP  ---- slip turns back ----------------------------->  STICK or CREEP again

Near zero slip v / |v| turns ever faster towards a limit direction, so steps become ever shorter (substeps.py) and slip
never crosses zero. The contact equation gives the limit direction in closed form. There a contact that lets go starts,
until its slip is large enough; and one that has come so near to it that the difference is below the error of a step
stops along it, at an instant that is located.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.methods import EXPLICIT
from omnisim.contact.frame import Slip
from omnisim.contact.kinematics import slip_acceleration
from omnisim.contact.mobility import across, inverse_mass
from omnisim.contact.set_valued import CREEP, SLIP, STICK
from omnisim.dynamics.impulses import align_slip, change_slip
from omnisim.dynamics.indices import contact_count, rate_place
from omnisim.dynamics.spatial.acceleration import slip_at, slip_change
from omnisim.dynamics.spatial.mobility import contact_mobility
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import rate_of_roller, standing, touching_at
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import acceleration_of, body_motion, wheel_motion
from omnisim.dynamics.wheel import contact_state
from omnisim.march.runge_kutta import refresh

DRIFTED = 0.01  # of the square of slip that no longer matters: more drift of a sticking contact is taken away
REST = 1e-11  # of 1 m/s and of the speeds that make up the slip, below which it no longer matters
CREEP_SPEED = 1e-7  # m/s: slip that has no direction of its own in any case
# What a coarse step does not see of slip across its final direction:
ALIGNED, FINE_ALIGNED = 3e-4, 1e-6  # m/s; the second for methods "auto" and "radau5"
STOPPING = 2.4e-6  # m/s, twice the error in the speed of the machine; of slip that is about to stop, explicit methods
STOPPED = 0.1  # of the slip that no longer matters, at which creeping slip has come to its end, or
STOPPED_OF_STOPPING = 1e-3  # of that which may be taken away across its direction
LEAST_ALIGNED = 1e-13  # m/s of slip, of the finest step: taking the last slip away at REST costs more
MOST_FREED = 20  # times in a step, after which slip is followed by sub-steps to its end
LEAST_STIFF = 2.0  # relaxation of slip within a step, below which sub-steps cost nothing
STILL_STIFF = 0.5 * LEAST_STIFF  # the same of slip that creeps already: less, lest it begin and end in turn
AT_EASE = 0.5  # of what a step does not see, that slip which lasts may turn in it: less, for the same reason
NOT, SOON, LASTING = range(3)  # how slip goes on in the direction of the contact equation
CREEP_ROUNDING = 1e-3  # of the slip that no longer matters: what contacts that let go together may slip back
CONE = 1e-12  # of mu times load and weight, by which a sticking force may pass the cone in rounding


@kernel
def slip_rate(parameters, mode, w, side, y, slope):
    """v' (Slip, m/s^2) at a contact of wheel w in a state y with this derivative, v (Slip, m/s), and A, 1/kg."""
    if parameters.space is not None:
        stand = standing(parameters, w, body_of(parameters, y), y)
        mobility = contact_mobility(parameters, w, stand.hub, touching_at(parameters, mode, w, side, stand))
        change = slip_change(parameters, mode, w, side, stand, y, slope)
        return change, slip_at(parameters, mode, w, side, y), mobility
    return upright_slip_rate(parameters, mode, w, side, y, slope)


@kernel
def upright_slip_rate(parameters, mode, w, side, y, slope):
    """The same of a machine that is upright."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    body = body_motion(parameters, y)
    state = contact_state(parameters, mode, w, side, body, y)
    acceleration = acceleration_of(parameters, body, slope)
    roller = slope[rate_place(parameters, mode, w, side)]
    motion = wheel_motion(wheel, body.twist, acceleration, slope[at.spin_rate + w], roller)
    mobility = inverse_mass(parameters.machine, wheel, state.axis, state.contact)
    return slip_acceleration(wheel, state, motion), state.slip, mobility


def alignment(part: float, choice: int) -> float:
    """Slip across the direction of the contact equation that a step does not see, m/s: ~ dt^4, as its error.

    part: the step by a coarse one, at most 1.
    """
    coarsest = ALIGNED if choice == EXPLICIT else FINE_ALIGNED
    return max(coarsest * part**4, LEAST_ALIGNED)


def stopping_alignment(part: float, choice: int, lightness: float) -> float:
    """Twice the error in the speed of slip that is about to stop, which a step does not see, m/s.

    Friction would have turned it soon in any case: what remains of slip v_n across slip v is a speed v_n^2 / 2 v along
    it, and of that what the contact gives the machine; with dt^6 it stays behind the method's own error where slow slip
    lasts. Implicit steps follow it at no cost.
    part: the step by a coarse one, at most 1; lightness: mass of the machine by that with which a contact resists its
    slip, 1.
    """
    return lightness * STOPPING * part**6 if choice == EXPLICIT else 0.0


@kernel
def unseen(clock, stopping, speed):
    """Slip across the direction of the contact equation that a step does not see, m/s, of slip of this speed."""
    return max(clock.aligned, math.sqrt(clock.stopping * speed)) if stopping else clock.aligned


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
def creep_of(parameters, w, side):
    """Direction of creeping slip at a contact of wheel w as the last right-hand side found it (Slip)."""
    if parameters.space is not None:
        touch = parameters.space.touches[w * SLOTS + side]
        return Slip(touch.creep[0], touch.creep[1])
    contact = parameters.workspace.contacts[parameters.wheels[w].contacts + side]
    return Slip(contact.creep[0], contact.creep[1])


@kernel
def slip_of(parameters, mode, w, side, y):
    """Slip velocity (Slip, m/s) at a contact of wheel w in state y."""
    if parameters.space is not None:
        return slip_at(parameters, mode, w, side, y)
    return contact_state(parameters, mode, w, side, body_motion(parameters, y), y).slip


@kernel
def stopped_speed(parameters, run, w, side):
    """Slip that counts as the end of creeping slip, m/s."""
    rest = rest_speed(parameters, run.mode[w], w, side, run.y)
    return max(STOPPED * rest, STOPPED_OF_STOPPING * run.clock.stopping)


@kernel
def stops(parameters, run, w, side):
    """SOON if a contact slips that will stop within a step in a direction that attracts, and is so near to it that the
    error of a step hides what it slips across: by the turning of the slip, |v x v'|, and the rate of attraction.

    LASTING if, in space, it turns so little within a step that the error of the step hides it: a wheel on two rollers
    slips on one of them as slowly as their heights differ, for as long as it rolls over their ends, and friction turns
    that slip a million times faster than anything moves. Implicit steps follow it all the same. Else NOT.
    """
    mode, monitors = run.mode[w], run.monitors[w]
    if mode.shared or mode.grip[side] != SLIP or monitors.factor[side] == 0.0:
        return NOT
    if mode.freed_step == run.clock.step and mode.freed >= MOST_FREED:
        return NOT
    stiff = stiffness(parameters, run.clock, monitors, side) > LEAST_STIFF
    rate, slip, mobility = slip_rate(parameters, mode, w, side, run.y, run.slopes[0])
    along = slip.h * rate.h + slip.k * rate.k
    turn = slip.h * rate.k - slip.k * rate.h
    square = monitors.slip_square[side]
    attraction = monitors.factor[side] * across(mobility, slip.h, slip.k) + along
    soon = square < -along * run.clock.dt and stiff
    speed = math.sqrt(square)
    if soon and abs(turn) * speed < attraction * unseen(run.clock, True, speed):
        return SOON
    if parameters.space is None or run.newton is not None or not stiff:
        return NOT
    return LASTING if abs(turn) * run.clock.dt < AT_EASE * run.clock.aligned * speed else NOT


@kernel
def stiffness(parameters, clock, monitors, side):
    """Relaxation of slip within a grid step, at most, 1."""
    return monitors.factor[side] * parameters.machine.slip_mobility * clock.dt


@kernel
def slip_across(monitors, side):
    """Slip of a creeping contact across the direction of the contact equation, m/s."""
    return math.sqrt(max(monitors.slip_square[side] - monitors.margin[side] ** 2, 0.0))


@kernel
def youth(parameters, clock, mode, monitors, side):
    """Positive while creeping slip is too young for a direction of its own: so slow, or else so little of it across
    the direction of the contact equation that the error of a step hides it, while sub-steps would have to be short."""
    speed = math.sqrt(monitors.slip_square[side])
    hidden = min(
        unseen(clock, mode.stopping[side], speed) - slip_across(monitors, side),
        stiffness(parameters, clock, monitors, side) - STILL_STIFF,
    )
    return max(CREEP_SPEED - speed, hidden)


@kernel
def rest_speed(parameters, mode, w, side, y):
    """Slip of a contact that no longer matters, m/s: it follows the speeds whose rounding the slip inherits."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    spin = wheel.radius * abs(y[at.spin_rate + w])
    yaw = (abs(wheel.offset[0]) + abs(wheel.offset[1])) * abs(y[at.yaw_rate])
    if parameters.space is not None:
        rate = y[rate_of_roller(parameters, mode, w, side)]
    else:
        rate = y[rate_place(parameters, mode, w, side)]
    roller = (wheel.radius - wheel.roller_distance) * abs(rate)
    return REST * (1.0 + abs(y[at.velocity]) + abs(y[at.velocity + 1]) + spin + yaw + roller)


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
                if parameters.space is None and mode.shared:
                    change_slip(parameters, run, v, other, Slip(0.0, 0.0))
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
                slip = slip_of(parameters, mode, w, side, run.y)
                mode.grip[side], mode.stopping[side] = CREEP, how == SOON
                speed = math.sqrt(run.monitors[w].slip_square[side])
                mode.creep[side, 0], mode.creep[side, 1] = slip.h / speed, slip.k / speed
    refresh(parameters, run, t)
    if parameters.space is not None:
        slip_on(parameters, run, t)
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if run.mode[w].grip[side] == CREEP and not run.mode[w].shared:
                keep_creep(parameters, run, w, side)
    align_slip(parameters, run)
    refresh(parameters, run, t)


@kernel
def slip_on(parameters, run, t):
    """Let creeping contacts slip whose direction, found with all that hold, is not that of their slip: one that another
    contact of its wheel holds across is turned far less easily than it would be alone."""
    changed = False
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            if mode.grip[side] == CREEP and youth(parameters, run.clock, mode, run.monitors[w], side) < 0.0:
                mode.grip[side] = SLIP
                mode.freed = mode.freed + 1 if mode.freed_step == run.clock.step else 1
                mode.freed_step = run.clock.step
                changed = True
    if changed:
        refresh(parameters, run, t)


@kernel
def keep_creep(parameters, run, w, side):
    """Remember the direction of creeping slip that the last right-hand side found."""
    mode = run.mode[w]
    creep = creep_of(parameters, w, side)
    mode.creep[side, 0], mode.creep[side, 1] = creep.h, creep.k


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
                drifts = drifts or slip_across(monitors, side) > 0.0
    if drifts:
        align_slip(parameters, run)
        if not (still or refreshed):
            refresh(parameters, run, t)
