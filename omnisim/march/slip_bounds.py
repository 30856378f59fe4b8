"""What a step does not see of slip: how much of it the error of the step hides, and what no longer matters at all.

Slip that slow friction turns comes ever nearer to the direction of the contact equation. What is left of it across that
direction, v_n, may be taken away at once when that changes the motion by no more than the step errs in any case. So
these bounds fall with powers of the step.
"""

import math

from omnisim.base.kernel import kernel
from omnisim.base.methods import EXPLICIT, Tableau
from omnisim.dynamics.indices import rate_place
from omnisim.dynamics.spatial.touching import rate_of_roller
from omnisim.dynamics.state import places
from omnisim.march.creeping import CREEP_SPEED

REST = 1e-11  # of 1 m/s and of the speeds that make up the slip, below which it no longer matters
ALIGNED, FINE_ALIGNED = 3e-4, 1e-6  # m/s; the second for methods "auto" and "radau5"
FINE_POWER = 4  # of the step, of the second
STOPPING = 1.7e-3  # m/s of the machine by v_n^2 / v, of the coarsest step, explicit methods
# m/s of the machine, of the coarsest step, by tableau: it stays behind what whole steps err
ENDING = {"heun": 4e-8, "rk4": 4e-8, "dopri5": 1e-8, "bs5": 3e-9}
LEAST_ALIGNED = 1e-13  # m/s of slip, of the finest step: taking the last slip away at REST costs more
STOPPED = 0.1  # of the slip that no longer matters, at which creeping slip has come to its end, or
STOPPED_OF_STOPPING = 1e-4  # of that which may be taken away across its direction
LEAST_STIFF = 2.0  # relaxation of slip within a step, below which sub-steps cost nothing
STILL_STIFF = 0.5 * LEAST_STIFF  # the same of slip that creeps already: less, lest it begin and end in turn
# Relaxation of a direction within a step, from which on it is that of the contact equation, and below which it is its
# own again: a step must have forgotten what the direction was before.
LEAST_TURNED, STILL_TURNED = 4.0, 2.0


def alignment(part: float, choice: int, order: int) -> float:
    """Slip across the direction of the contact equation that a step does not see, m/s: ~ dt^order, as its error.

    part: the step by a coarse one, at most 1.
    """
    coarsest, power = (ALIGNED, order) if choice == EXPLICIT else (FINE_ALIGNED, FINE_POWER)
    return max(coarsest * part**power, LEAST_ALIGNED)


def stopping_alignment(part: float, choice: int, order: int) -> float:
    """Twice the error in a speed of the machine by slip that is about to stop, which a step does not see, m/s.

    Friction would have turned it soon in any case: what remains of slip v_n across slip v is a speed v_n^2 / 2 v along
    it, and of that what the contact gives the machine. Where other contacts slip as well, v_n itself counts, by a small
    part: so v_n ~ dt^order stays with the method's own error. Implicit steps follow it at no cost.
    part: the step by a coarse one, at most 1.
    """
    return STOPPING * part ** (2 * order) if choice == EXPLICIT else 0.0


def ending(part: float, tableau: Tableau) -> float:
    """Change of a speed, m/s, by what changes in the last of a slip (last_slip.py), which a step does not see:
    ~ dt^order, as its error. part: the step by a coarse one, at most 1."""
    return ENDING[tableau.name] * part**tableau.order


@kernel
def unseen(clock, course):
    """What slip that is about to stop may be across the direction of the contact equation unseen by a step, m/s, by its
    Course."""
    return max(clock.aligned, math.sqrt(clock.stopping * course.lightness * course.speed))


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
        clock.aligned - slip_across(monitors, side),
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
def stopped_speed(parameters, run, w, side):
    """Slip that counts as the end of creeping slip, m/s."""
    rest = rest_speed(parameters, run.mode[w], w, side, run.y)
    return max(STOPPED * rest, STOPPED_OF_STOPPING * run.clock.stopping)
