"""Coulomb friction in time: how a contact comes to rest, holds, lets go and slips on.

    SLIP   ---- slip below rest_speed, F inside the cone ---->  STICK
    SLIP   ---- slip below rest_speed, F outside ------------>  CREEP  (through zero without sticking)
    STICK  ---- |F| reaches mu N ---------------------------->  CREEP
    CREEP  ---- slip above CREEP_SPEED ---------------------->  SLIP
    CREEP  ---- slip turns back ----------------------------->  STICK or CREEP again

Near zero slip v / |v| turns ever faster towards a limit direction, so a slipping contact is stepped by a fraction of
the time in which it could stop or turn: slip shrinks geometrically and never crosses zero. A contact that lets go
starts in that limit direction, which the contact equation gives in closed form, until its slip is large enough.
"""

import math

from omnisim.body import add_held, eliminate, holding_force, plane, set_contact, set_held
from omnisim.contact.coulomb import CREEP, SLIP, STICK, TINY
from omnisim.contact.kinematics import (
    Motion,
    Slip,
    inverse_mass,
    largest,
    slip_acceleration,
    slip_jacobian,
    spin_inertia,
)
from omnisim.contact.reaction import COULOMB
from omnisim.kernel import kernel, outlined
from omnisim.runge_kutta import refresh
from omnisim.state import places, rate_place
from omnisim.tableau import EXPLICIT, IMPLICIT
from omnisim.wheel import body_motion, centre_acceleration, contact_state, world_heading

SLIP_FRACTION = 0.75  # of the time in which slip could stop, that one explicit sub-step may take at most
FINE_FRACTION = 0.2  # the same for methods "auto" and "radau5", which are there for their accuracy
# The same of implicit steps with a smooth law: its layer near zero slip turns motion into heat that is accounted for.
LAYER_FRACTION = 0.05
OUTRUN = 20.0  # stable steps by the end of an explicit one that is taken again at half its length
AUTO_STIFF = 4.0  # relaxation of slip within a step, beyond which "auto" makes it implicit
AUTO_ACCURATE = 0.5  # and up to which its explicit steps go
COARSE_STEP = 1e-2  # s: a grid step from which on sub-steps are as coarse as is safe
TURN_FRACTION = 0.7  # of the largest stable step of the method for the turning of the slip's direction
REST = 1e-11  # of 1 m/s and of the speeds that make up the slip, below which it no longer matters
CREEP_SPEED = 1e-7  # m/s: slip that has a direction of its own
CREEP_STEP = 4.0  # of the time in which slip grows to that, for one step
CONE = 1e-12  # of mu N, by which a sticking force may pass the cone in rounding


@kernel
def slip_rate(parameters, run, w, side):
    """v' (Slip, m/s^2) at a contact of wheel w as the motion goes, and the largest mobility there, 1/kg."""
    wheel, at, slope, body = parameters.wheels[w], places(parameters), run.slopes[0], body_motion(parameters, run.y)
    state = contact_state(parameters, run.mode[w], w, side, body, run.y)
    x, y, yaw = slope[at.velocity], slope[at.velocity + 1], slope[at.yaw_rate]
    centre = centre_acceleration(wheel, body, x * body.cos + y * body.sin, y * body.cos - x * body.sin, yaw)
    roller = slope[rate_place(parameters, run.mode[w].roller, w, side)]
    motion = Motion(centre.h, centre.k, slope[at.spin_rate + w], yaw, roller)
    mobility = inverse_mass(parameters.machine, wheel, state.axis, state.contact)
    return slip_acceleration(wheel, state, motion), largest(mobility)


@kernel
def step_length(parameters, run, t, h):
    """The step h, or less if slip could come to rest or change its course within it; sets the kind of the step.

    An explicit step of coulomb friction also follows the turning of the slip's direction; method "auto" leaves that to
    an implicit step.
    """
    clock, floor = run.clock, parameters.machine.slip_floor
    # rates at which friction relaxes slip or a roller's rate, and at which slip changes, 1/s
    relaxation, pace = max(parameters.machine.bearing_relaxation, TINY), TINY
    for w in range(len(run.mode)):
        for side in range(1 + run.mode[w].shared):
            factor, grip = run.watch[w].factor[side], run.mode[w].grip[side]
            if grip == CREEP:  # it will have a direction of its own soon
                rate, _ = slip_rate(parameters, run, w, side)
                h = min(h, CREEP_STEP * CREEP_SPEED / max(math.sqrt(rate.h * rate.h + rate.k * rate.k), TINY))
            elif grip == SLIP and factor > 0.0:
                rate, mobility = slip_rate(parameters, run, w, side)
                scale = run.watch[w].slip_square[side] + floor * floor
                pace = max(pace, math.sqrt((rate.h * rate.h + rate.k * rate.k) / scale))
                relaxation = max(relaxation, factor * mobility)
    if clock.choice == EXPLICIT:
        clock.implicit = False
        fraction = slip_fraction(SLIP_FRACTION, pace, clock)
        turn = TURN_FRACTION * fraction / SLIP_FRACTION
        return min(h, min(fraction / pace, turn * clock.stability_limit / relaxation))
    h_explicit, fraction, stiffness = h, LAYER_FRACTION, clock.dt * relaxation
    if parameters.machine.law == COULOMB:
        fraction = slip_fraction(FINE_FRACTION, pace, clock)
        h_explicit = min(h, fraction / pace)
        stiffness = h_explicit * relaxation
    clock.implicit = clock.choice == IMPLICIT or stiffness > AUTO_STIFF
    return min(h, fraction / pace) if clock.implicit else min(h_explicit, AUTO_ACCURATE / relaxation)


@kernel
def slip_fraction(coarsest, pace, clock):
    """Part of the time 1 / pace in which slip changes, that a sub-step of a grid step dt may take.

    Slip of which a whole step is the part f is of the size dt / f, and a sub-step errs by f^5 of the slip it starts
    from: f ~ dt^(3/4) there lets these errors fall with dt^4. Where slip is less, and changes faster, f^5 ~ pace makes
    every sub-step err by the same amount, up to the coarsest part that is safe.
    """
    largest_slip, ratio = coarsest * clock.fineness, 1.0 / clock.fineness
    less = max(pace * clock.dt / largest_slip, 1.0)
    return coarsest if less >= ratio**5 else largest_slip * less**0.2


def fineness(dt: float) -> float:
    """Part of the coarsest fraction that a step dt (s) allows for the largest slip."""
    return min(1.0, (dt / COARSE_STEP) ** 0.75)


@kernel
def outrun(parameters, run, h):
    """Whether an explicit trial step of coulomb friction has become far too long for the slip that it ended with."""
    clock = run.clock
    if parameters.machine.law != COULOMB or clock.implicit:
        return False
    for w in range(len(run.mode)):
        for side in range(1 + run.mode[w].shared):
            relaxation = run.watch_end[w].factor[side] * parameters.machine.slip_mobility
            stiff = run.mode[w].grip[side] == SLIP and h * relaxation > OUTRUN * clock.stability_limit
            if stiff or not math.isfinite(run.watch_end[w].slip_square[side]):
                return True
    return False


@kernel
def rests(parameters, run, w, side):
    """Whether a contact of wheel w slips so slowly that it is at rest; in the air nothing holds it there."""
    mode, watch, limit = run.mode[w], run.watch[w], parameters.machine.friction * run.watch[w].normal_force
    slow = watch.slip_square[side] < rest_speed(parameters, mode, w, side, run.y) ** 2
    return mode.loaded == 1 and mode.grip[side] == SLIP and limit > 0.0 and slow


@kernel
def rest_speed(parameters, mode, w, side, y):
    """Slip of a contact that no longer matters, m/s: it follows the speeds whose rounding the slip inherits."""
    wheel, at = parameters.wheels[w], places(parameters)
    spin = wheel.radius * abs(y[at.spin_rate + w])
    yaw = (abs(wheel.offset[0]) + abs(wheel.offset[1])) * abs(y[at.yaw_rate])
    rate = y[rate_place(parameters, mode.roller, w, side)]
    roller = (wheel.radius - wheel.roller_distance) * abs(rate)
    return REST * (1.0 + abs(y[at.velocity]) + abs(y[at.velocity + 1]) + spin + yaw + roller)


@outlined
def come_to_rest(parameters, run, w, side, t):
    """Take the rest of the slip away; stick if the force lies inside the cone, else creep on. Whether it sticks.

    On two rollers, sticking is being at rest: there the force follows from Gauss' principle, cone included.
    """
    mode = run.mode[w]
    mode.grip[side] = STICK
    if mode.shared:
        change_slip(parameters, run, w, side, Slip(0.0, 0.0))
    else:
        stop_slip(parameters, run)
    refresh(parameters, run, t)
    limit = parameters.machine.friction * run.watch[w].normal_force
    if not mode.shared and run.watch[w].margin[side] < -CONE * limit:
        mode.grip[side] = CREEP
        refresh(parameters, run, t)
    return mode.grip[side] == STICK


@outlined
def start_slip(parameters, run, w, side, t):
    """Let a contact slip whose slip has grown; a creeping one in the direction of the contact equation."""
    mode = run.mode[w]
    if mode.grip[side] == CREEP and not mode.shared:
        refresh(parameters, run, t)
        force = parameters.room.contacts[2 * w].force  # against that direction
        size = max(math.sqrt(force[0] * force[0] + force[1] * force[1]), TINY)
        speed = math.sqrt(run.watch[w].slip_square[side])
        change_slip(parameters, run, w, side, Slip(-speed * force[0] / size, -speed * force[1] / size))
    mode.grip[side] = SLIP
    refresh(parameters, run, t)


@kernel
def hold(parameters, run, t):
    """Take the drift of sticking contacts away: they hold the slip acceleration at zero, the slip to rounding."""
    drifts = False
    for w in range(len(run.mode)):
        if run.mode[w].grip[0] == STICK and not run.mode[w].shared:
            rest = rest_speed(parameters, run.mode[w], w, 0, run.y)
            drifts = drifts or run.watch[w].slip_square[0] > 0.01 * rest * rest
    if drifts:
        stop_slip(parameters, run)
        refresh(parameters, run, t)


@outlined
def stop_slip(parameters, run):
    """Change the speeds by the impulses at all sticking contacts that leave none of them any slip.

    The equations of body.py for a sticking contact, with its slip in the place of its slip acceleration.
    """
    machine, room, y, at = parameters.machine, parameters.room, run.y, places(parameters)
    body, balance = body_motion(parameters, run.y), room.balance
    for i in range(3):
        for j in range(7):
            balance[i, j] = 0.0
    balance[0, 0] = balance[1, 1] = machine.mass
    balance[2, 2] = machine.yaw_inertia
    for w in range(len(run.mode)):
        if run.mode[w].grip[0] == STICK and not run.mode[w].shared:
            wheel, contact = parameters.wheels[w], room.contacts[2 * w]
            state = contact_state(parameters, run.mode[w], w, 0, body, y)
            set_contact(machine, wheel, contact, state, 0)
            set_held(machine, wheel, contact, state, state.slip)
            add_held(balance, contact, 3)
    eliminate(balance, 3, 7)
    change = plane(balance)
    for w in range(len(run.mode)):
        if run.mode[w].grip[0] == STICK and not run.mode[w].shared:
            wheel, contact = parameters.wheels[w], room.contacts[2 * w]
            impulse_h, impulse_k = holding_force(contact, change)
            spin = contact.spin[0] * impulse_h + contact.spin[1] * impulse_k
            roller = contact.arm[0] * impulse_h + contact.arm[1] * impulse_k
            y[at.spin_rate + w] += spin / spin_inertia(wheel)
            y[rate_place(parameters, run.mode[w].roller, w, 0)] += roller / wheel.axial_inertia
    y[at.velocity] += change.x * body.cos - change.y * body.sin
    y[at.velocity + 1] += change.x * body.sin + change.y * body.cos
    y[at.yaw_rate] += change.yaw


@outlined
def change_slip(parameters, run, w, side, slip):
    """Change the speeds by the one impulse at a contact of wheel w that gives it the slip velocity `slip`."""
    machine, wheel, mode, at, y = parameters.machine, parameters.wheels[w], run.mode[w], places(parameters), run.y
    body = body_motion(parameters, y)
    state = contact_state(parameters, mode, w, side, body, y)
    hh, hk, kk = inverse_mass(machine, wheel, state.axis, state.contact, mode.shared)
    change_h, change_k = slip.h - state.slip.h, slip.k - state.slip.k
    determinant = hh * kk - hk * hk
    impulse_h, impulse_k = (kk * change_h - hk * change_k) / determinant, (hh * change_k - hk * change_h) / determinant
    j = slip_jacobian(wheel, state.axis, state.contact)
    heading = world_heading(wheel, body)
    y[at.velocity] += (impulse_h * heading.cos - impulse_k * heading.sin) / machine.mass
    y[at.velocity + 1] += (impulse_h * heading.sin + impulse_k * heading.cos) / machine.mass
    if not mode.shared:
        y[at.spin_rate + w] += (j.spin_h * impulse_h + j.spin_k * impulse_k) / spin_inertia(wheel)
    y[at.yaw_rate] += (j.yaw_h * impulse_h + j.yaw_k * impulse_k) / machine.yaw_inertia
    y[rate_place(parameters, mode.roller, w, side)] += (
        j.roller_h * impulse_h + j.roller_k * impulse_k
    ) / wheel.axial_inertia
