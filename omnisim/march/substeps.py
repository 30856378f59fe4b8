"""How long a step may be where slip could come to rest or change its course within it, and of which kind it is.

Near zero slip v / |v| turns ever faster towards a limit direction, so a slipping contact is stepped by a fraction of
the time in which it could stop or turn: slip shrinks geometrically and never crosses zero. What happens when it is
almost there is in friction_modes.py and creeping.py.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.methods import EXPLICIT, IMPLICIT, Tableau
from omnisim.contact.friction import passing_speed
from omnisim.contact.kinematics import streaming
from omnisim.contact.mobility import largest
from omnisim.contact.set_valued import CREEP, SLIP, STICK, TINY
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.spatial import touching
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.running import streaming as spatial_streaming
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state
from omnisim.march.creeping import CREEP_SPEED, creep_of, creeping, turning_of
from omnisim.march.slip import attraction, slip_rate, turning_mobility

SLIP_FRACTION = 0.9  # of the time in which slip could stop or turn, that one explicit sub-step may take at most
FINE_FRACTION = 0.2  # the same for methods "auto" and "radau5", which are there for their accuracy
LAYER = 0.25  # of that, with a smooth law
OUTRUN = 20.0  # stable steps by the end of an explicit one that is taken again at half its length
# Part of the coarsest fraction that the coarsest step allows, by tableau: sub-steps must stay behind the error of whole
# steps. With these, machines whose wheels slip take about the least right-hand sides for equal errors: by sub-steps
# twice as long rk4 takes a fifth more, dopri5 a third.
FINENESS = {"heun": 1.0, "rk4": 0.5, "dopri5": 0.28, "bs5": 0.5}
LAYERED = 0.8  # the same of explicit steps of "auto" through a thin layer, within which slip comes to its end by itself
TURN_BEGINS = 2.0  # times the sine by which slip changes its direction: where it turns back, it is none for an instant
AUTO_STIFF = 4.0  # relaxation of slip within a step, beyond which "auto" makes it implicit
AUTO_ACCURATE = 0.5  # and up to which its explicit steps go
LET_GO = 0.25  # part of the rate at which friction turns slip, that a step leaves of it where a load goes to zero
TURN_FRACTION = 0.7  # of the largest stable step of the method for the turning of the slip's direction
LEAST_CREEPING = 2.0 * CREEP_SPEED  # m/s: creeping slip that is slower is stepped as if it were that fast
CREEP_STEP = 1.01  # of the time in which creeping slip doubles or stops, for one step: a little beyond its end


@kernel
def step_length(parameters, run, t, h):
    """The step h, or less if slip could come to rest or change its course within it; sets the kind of the step.

    An explicit step of coulomb friction also follows the turning of the slip's direction; method "auto" leaves that to
    an implicit step.
    """
    machine = parameters.machine
    clock = run.clock
    floor = machine.slip_floor
    # rates at which friction relaxes slip or a roller's rate, or a current settles; at which slip turns; changes, 1/s
    relaxation = max(machine.bearing_relaxation, machine.current_relaxation, TINY)
    turning = TINY
    pace = TINY
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            factor, grip = run.monitors[w].factor[side], run.mode[w].grip[side]
            run.mode[w].pull[side] = 0.0
            if machine.rolling and grip != STICK:  # what sticks turns with the machine, which is heavier
                relaxation = max(relaxation, run.monitors[w].relaxing[side])
            if parameters.workspace.resting is not None and grip == CREEP:  # it will stop soon, or go its own way
                rate, _, _ = slip_rate(parameters, run.mode[w], w, side, run.y, run.slopes[0])
                speed = max(math.sqrt(run.monitors[w].slip_square[side]), LEAST_CREEPING)
                h = min(h, creeping_time(run, w, side, creep_of(parameters, w, side), rate, speed))
            elif grip == SLIP and factor > 0.0:
                rate, slip, a = slip_rate(parameters, run.mode[w], w, side, run.y, run.slopes[0])
                mobility = largest(a)
                if machine.brush:
                    floor = brush_floor(parameters, run.mode[w], w, side, run.y)
                scale = run.monitors[w].slip_square[side] + floor * floor
                size = math.sqrt((rate.h * rate.h + rate.k * rate.k) * scale)
                sine = abs(slip.h * rate.k - slip.k * rate.h) / max(size, TINY)
                pace, relaxation = max(pace, size / scale), max(relaxation, factor * mobility)
                if run.newton is None:
                    a = turning_mobility(parameters, run, w, side, a)
                    attracted = attraction(run.monitors[w], side, rate, slip, a)
                    run.mode[w].pull[side] = attracted / scale
                    angle, sine = sine * size / max(attracted, TINY), TURN_BEGINS * sine
                    share = sine if angle >= sine**5 else angle**0.2  # the lesser: a root takes as long as a stage
                    turning = max(turning, share * factor * mobility)
    if run.newton is None:
        clock.implicit = False
        fraction = slip_fraction(SLIP_FRACTION, pace, clock)
        stable = TURN_FRACTION * clock.stability_limit
        turn = fraction / SLIP_FRACTION
        return min(h, min(fraction / pace, min(stable / relaxation, turn * stable / turning)))
    h_explicit = h
    # viscous friction relaxes slip as fast where it is large
    fraction = LAYER * FINE_FRACTION
    if not machine.viscous:
        fraction = slip_fraction(FINE_FRACTION, pace, clock)
    stiffness = clock.dt * relaxation
    if parameters.workspace.resting is not None:
        h_explicit = min(h, fraction / pace)
        stiffness = h_explicit * relaxation
    clock.implicit = clock.choice == IMPLICIT or stiffness > AUTO_STIFF
    return min(h, fraction / pace) if clock.implicit else min(h_explicit, AUTO_ACCURATE / relaxation)


@kernel
def creeping_time(run, w, side, u, rate, speed):
    """How long creeping slip may be stepped at once, s: a little beyond its end; where its direction turns as the
    stages say, for its period, and where it does not, only until it has doubled."""
    change = math.sqrt(rate.h * rate.h + rate.k * rate.k)
    end = CREEP_STEP * speed / max(change, TINY)
    if run.newton is not None:
        return end
    period = run.mode[w].period[side]
    return period if u.h * rate.h + u.k * rate.k >= 0.0 else min(period, end)


@outlined
def brush_floor(parameters, mode, w, side, y):
    """The slip over which friction of a brush changes at a contact of wheel w, m/s: by as fast as it runs over its
    roller, mu V / c."""
    machine = parameters.machine
    if parameters.space is not None:
        stand = touching.standing(parameters, w, body_of(parameters, y), y)
        touched = touching.touching_at(parameters, mode, w, side, stand)
        joint = touching.joint_rate(stand, touched.roller, y[touching.rate_of_roller(parameters, mode, w, side)])
        stream = spatial_streaming(parameters, mode, w, side, (stand, touched), joint)
    else:
        state = contact_state(parameters, mode, w, side, body_motion(parameters, y), y)
        stream = streaming(parameters.wheels[w], state)
    return machine.friction / machine.creep_stiffness * passing_speed(machine, stream)


@kernel
def slip_fraction(coarsest, pace, clock):
    """Part of the time 1 / pace in which slip changes, that a sub-step of a grid step dt may take.

    Slip of which a whole step is the part f is of the size dt / f, and a sub-step errs by f^5 of the slip it starts
    from: there f ~ dt lets these errors fall with dt^5, as those of dopri5 do, and f ~ dt^(3/4) with dt^4. Where slip
    is less, and changes faster, f^5 ~ pace makes every sub-step err by the same amount, up to the coarsest part that is
    safe.
    """
    largest_slip, ratio = coarsest * clock.fineness, 1.0 / clock.fineness
    less = max(pace * clock.dt / largest_slip, 1.0)
    return coarsest if less >= ratio**5 else largest_slip * less**0.2


def fineness(part: float, choice: int, tableau: Tableau, smooth: bool, layered: bool) -> float:
    """Part of the coarsest fraction that a step allows for the largest slip: ~ dt of explicit methods, and ~ dt^(3/4)
    of the others, whose fraction is less and whose steps cost more. part: the step by a coarse one, at most 1; smooth:
    the law, whose layer near zero slip turns motion into heat that is accounted for; layered: it has a thin layer."""
    if choice != EXPLICIT:
        return min(part**0.75, LAYER) if smooth else part**0.75
    return (LAYERED if layered else FINENESS[tableau.name]) * part


@kernel
def outrun(parameters, run, h):
    """Whether an explicit trial step of coulomb friction has become far too long for the slip that it ended with, or
    for how creeping slip turns."""
    clock = run.clock
    if parameters.workspace.resting is None or clock.implicit:
        return False
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            relaxation = run.monitors_end[w].factor[side] * parameters.machine.slip_mobility
            stiff = run.mode[w].grip[side] == SLIP and h * relaxation > OUTRUN * clock.stability_limit
            if stiff or not math.isfinite(run.monitors_end[w].slip_square[side]):
                return True
            if h > 0.0 and run.newton is None and turns_unforeseen(parameters, run, w, side):
                return True
    return False


@kernel
def turns_unforeseen(parameters, run, w, side):
    """Whether creeping slip of contact `side` of wheel w ended a trial step in another direction than its stages
    foretold, by more than the error of a step hides: where slip begins or a load goes to zero, friction is so weak for
    some microseconds that the direction turns as slowly as slip grows."""
    if not creeping(run.mode[w], side):
        return False
    start, end = run.monitors[w], run.monitors_end[w]
    begins = start.slip_square[side] <= (CREEP_SPEED + parameters.machine.slip_layer) ** 2
    # upright machines stop where a wheel lifts
    let_go = parameters.space is not None and end.factor[side] < LET_GO * start.factor[side]
    if not (begins or let_go):
        return False
    missed = turning_of(parameters, w, side).missed * math.sqrt(end.slip_square[side])
    return abs(missed) > run.clock.aligned
