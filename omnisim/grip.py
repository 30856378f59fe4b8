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

from omnisim.contact.coulomb import CREEP, SLIP, STICK, slip_direction
from omnisim.contact.kinematics import Slip, largest
from omnisim.contact.tracking import Heading
from omnisim.dynamics import contact_equation, contact_state, drive_torque, external_wrench
from omnisim.kernel import kernel
from omnisim.runge_kutta import refresh
from omnisim.state import YAW, places
from omnisim.tableau import EXPLICIT, IMPLICIT

SLIP_FRACTION = 0.75  # of the time in which friction could stop the slip, that one sub-step may take
IMPLICIT_FRACTION = 0.25  # the same of an implicit step, which is there for its accuracy
AUTO_STIFF = 4.0  # relaxation of slip within a step, beyond which "auto" makes it implicit
AUTO_ACCURATE = 0.5  # and up to which its explicit steps go
TURN_FRACTION = 0.7  # of the largest stable step of the method for the turning of the slip's direction
REST = 1e-11  # of 1 m/s and of the speeds that make up the slip, below which it no longer matters
CREEP_SPEED = 1e-7  # m/s: slip that has a direction of its own
CONE = 1e-12  # of mu N, by which a sticking force may pass the cone in rounding


@kernel
def equation_of(parameters, run, w, t):
    """ContactState of wheel w and A, b of its contact equation at run.y."""
    heading = Heading(math.cos(run.y[YAW]), math.sin(run.y[YAW]))
    state = contact_state(parameters, run.mode[w], w, heading, run.y)
    wrench = external_wrench(parameters, run.clock.piece, t, heading)
    torque = drive_torque(parameters, run.clock.piece, t, w)
    a, b = contact_equation(parameters.machine, parameters.wheels[w], state, heading, wrench, torque)
    return state, a, b


@kernel
def step_length(parameters, run, t, h):
    """The step h, or less if slip could come to rest or change its course within it; sets the kind of the step.

    An explicit step of coulomb friction also follows the turning of the slip's direction; method "auto" leaves that to
    an implicit step.
    """
    clock, machine = run.clock, parameters.machine
    relaxation, pace = 0.0, 0.0  # rates at which friction relaxes slip, and at which slip changes, 1/s
    for w in range(len(run.mode)):
        watch = run.watch[w]
        if run.mode[w].grip == SLIP and watch.factor > 0.0:
            state, (hh, hk, kk), b = equation_of(parameters, run, w, t)
            pull_h = b.h - watch.factor * (hh * state.slip.h + hk * state.slip.k)
            pull_k = b.k - watch.factor * (hk * state.slip.h + kk * state.slip.k)
            scale = watch.slip_square + machine.slip_floor * machine.slip_floor
            pace = max(pace, math.sqrt((pull_h * pull_h + pull_k * pull_k) / scale))
            relaxation = max(relaxation, watch.factor * largest((hh, hk, kk)))
    if clock.choice == EXPLICIT:
        clock.implicit = False
        return min(h, min(SLIP_FRACTION / pace, TURN_FRACTION * clock.stability_limit / relaxation))
    h_explicit = min(h, SLIP_FRACTION / pace)
    clock.implicit = clock.choice == IMPLICIT or h_explicit * relaxation > AUTO_STIFF
    return min(h, IMPLICIT_FRACTION / pace) if clock.implicit else min(h_explicit, AUTO_ACCURATE / relaxation)


@kernel
def rests(parameters, run, w):
    """Whether wheel w slips so slowly that it is at rest."""
    limit = parameters.machine.friction * run.watch[w].normal_force
    return run.mode[w].grip == SLIP and limit > 0.0 and run.watch[w].slip_square < rest_speed(parameters, run, w) ** 2


@kernel
def rest_speed(parameters, run, w):
    """Slip of wheel w that no longer matters, m/s: it follows the speeds whose rounding the slip inherits."""
    wheel, at, y = parameters.wheels[w], places(len(run.mode)), run.y
    spin = wheel.radius * abs(y[at.spin_rate + w])
    roller = (wheel.radius - wheel.roller_distance) * abs(y[at.roller_rate + w])
    return REST * (1.0 + abs(y[at.velocity]) + abs(y[at.velocity + 1]) + spin + roller)


@kernel
def come_to_rest(parameters, run, w, t):
    """Take the rest of the slip away; stick if the force lies inside the cone, else creep on. Whether it sticks."""
    change_slip(parameters, run, w, t, Slip(0.0, 0.0))
    run.mode[w].grip = STICK
    refresh(parameters, run, t)
    limit = parameters.machine.friction * run.watch[w].normal_force
    if run.watch[w].margin < -CONE * limit:
        run.mode[w].grip = CREEP
        refresh(parameters, run, t)
    return run.mode[w].grip == STICK


@kernel
def start_slip(parameters, run, w, t):
    """Give a creeping contact the direction of the contact equation at the speed that it has, and let it slip."""
    _, a, b = equation_of(parameters, run, w, t)
    u = slip_direction(a, b, parameters.machine.friction * run.watch[w].normal_force)
    speed = math.sqrt(run.watch[w].slip_square)
    change_slip(parameters, run, w, t, Slip(speed * u.h, speed * u.k))
    run.mode[w].grip = SLIP
    refresh(parameters, run, t)


@kernel
def hold(parameters, run, t):
    """Take the drift of sticking contacts away: they hold the slip acceleration at zero, the slip to rounding."""
    for w in range(len(run.mode)):
        if run.mode[w].grip == STICK and run.watch[w].slip_square > 0.01 * rest_speed(parameters, run, w) ** 2:
            change_slip(parameters, run, w, t, Slip(0.0, 0.0))
            refresh(parameters, run, t)


@kernel
def change_slip(parameters, run, w, t, slip):
    """Change the speeds by the one contact impulse that gives wheel w the slip velocity `slip`."""
    machine, wheel, at, y = parameters.machine, parameters.wheels[w], places(len(run.mode)), run.y
    heading = Heading(math.cos(y[YAW]), math.sin(y[YAW]))
    state, (hh, hk, kk), _ = equation_of(parameters, run, w, t)
    change_h, change_k = slip.h - state.slip.h, slip.k - state.slip.k
    determinant = hh * kk - hk * hk
    impulse_h, impulse_k = (kk * change_h - hk * change_k) / determinant, (hh * change_k - hk * change_h) / determinant
    roller = state.contact.arm_h * impulse_h + state.contact.arm_k * impulse_k
    y[at.velocity] += (impulse_h * heading.cos - impulse_k * heading.sin) / machine.mass
    y[at.velocity + 1] += (impulse_h * heading.sin + impulse_k * heading.cos) / machine.mass
    y[at.spin_rate + w] -= (wheel.radius * impulse_h + roller * state.axis.k) / wheel.axle_inertia
    y[at.yaw_rate] -= (state.contact.l * impulse_h + roller * state.axis.n) / machine.yaw_inertia
    y[at.roller_rate + w] += roller / wheel.axial_inertia
