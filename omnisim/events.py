"""Events: what ends the validity of a mode, and what the mode is afterwards.

A guard is >= 0 as long as its mode holds. A step at whose end one is negative is cut at the root, and the row below
tells what changes there.

    guard  while the mode holds                           afterwards
    TURN   the spin keeps its sense: direction phi' >= 0  direction reversed; so EXIT is monotone within every step
    EXIT   the roller's end ahead is not passed yet       the neighbour takes over: an exchange
    KINK   |v| stays on its side of slip_speed            the other branch of the saturated law
    LOAD   N >= 0                                         the wheel leaves the floor: the march stops
    GRIP   a sticking force stays inside the cone         it creeps off
           a creeping slip keeps its sense                it comes to rest
    CREEPING  a creeping slip stays slow                  it slips in a direction of its own

Both trackings pass a roller's end at the same spin angle: |q| = alpha is |c_beta| = c sin alpha. The guard is the
angle, monotone over several turns as well; which rollers touch at the start, each tracking tells by its own condition.
"""

import numpy as np

from omnisim.contact.coulomb import CREEP, SLIP, STICK
from omnisim.contact.reaction import SATURATED
from omnisim.exchange import hand_over, release_roller
from omnisim.grip import CONE, CREEP_SPEED, come_to_rest, start_slip
from omnisim.kernel import kernel
from omnisim.runge_kutta import refresh
from omnisim.state import places
from omnisim.status import LIFT_OFF
from omnisim.trajectory import EVENT_KINDS

TURN, EXIT, KINK, LOAD, GRIP, CREEPING = range(6)
ROUNDING = 4.0 * 2.0**-53
SMOOTH_GUARDS, GUARDS = 4, 6  # the last two are of coulomb friction alone
EXCHANGE, STUCK, SLIPS, LIFT, STOP = (
    EVENT_KINDS.index(kind) for kind in ("exchange", "stick", "slip", "lift_off", "stop")
)

EVENT = np.dtype(
    [
        ("time", np.float64),  # s
        ("kind", np.int64),  # index into EVENT_KINDS
        ("wheel", np.int64),
        ("roller_from", np.int64),  # -1 where not meant
        ("roller_to", np.int64),
    ]
)


@kernel
def guard(parameters, mode, kind, w, y, watch):
    """Value of a guard of wheel w at state `y` with by-products `watch`: >= 0 while the mode holds."""
    machine, wheel, at = parameters.machine, parameters.wheels[w], places(len(parameters.wheels))
    direction = mode[w].direction
    if kind == TURN:
        return direction * y[at.spin_rate + w]
    if kind == EXIT:
        spin_angle = y[at.spin_angle + w]
        rounding = ROUNDING * (1.0 + abs(spin_angle))  # an edge reached to rounding is reached
        return direction * (roller_end(wheel, mode[w].roller, direction) - spin_angle) - rounding
    if kind == KINK:
        if machine.law != SATURATED:
            return 0.0
        excess = watch[w].slip_square - machine.slip_speed * machine.slip_speed
        return excess if mode[w].saturated else -excess
    if kind == LOAD:
        return watch[w].normal_force
    if mode[w].grip == SLIP:
        return 0.0
    if kind == GRIP:
        rounding = CONE * machine.friction * watch[w].normal_force if mode[w].grip == STICK else 0.0
        return watch[w].margin + rounding
    return CREEP_SPEED * CREEP_SPEED - watch[w].slip_square if mode[w].grip == CREEP else 0.0


@kernel
def roller_end(wheel, roller, direction):
    """Spin angle at which a roller ends, for spin of the sense `direction`, rad: one number for both neighbours."""
    return wheel.phase + wheel.alpha * (2 * roller + direction)


@kernel
def transition(parameters, run, log, kind, w, time):
    """Change the mode after a guard of wheel w fired at `time`, and the derivative with it."""
    mode, clock, rollers = run.mode[w], run.clock, parameters.wheels[w].rollers
    if kind == TURN:
        mode.direction = -mode.direction
    elif kind == EXIT:
        roller = mode.roller + mode.direction
        record(clock, log, time, EXCHANGE, w, mode.roller % rollers, roller % rollers)
        release_roller(parameters, run, w)
        held = mode.grip == STICK
        hand_over(parameters, run, w, roller, time)
        if held != (mode.grip == STICK):
            record(clock, log, time, SLIPS if held else STUCK, w, -1, -1)
    elif kind == KINK:
        mode.saturated = 1 - mode.saturated
        refresh(parameters, run, time)
    elif kind == GRIP and mode.grip == STICK:
        record(clock, log, time, SLIPS, w, -1, -1)
        mode.grip = CREEP
        refresh(parameters, run, time)
    elif kind == GRIP:
        settle_slip(parameters, run, log, w, time)
    elif kind == CREEPING:
        start_slip(parameters, run, w, time)
    else:
        record(clock, log, time, LIFT, w, -1, -1)
        clock.status, clock.wheel = LIFT_OFF, w


@kernel
def settle_slip(parameters, run, log, w, time):
    """A slip that has come to its end: the contact sticks or creeps on."""
    if come_to_rest(parameters, run, w, time):
        record(run.clock, log, time, STUCK, w, -1, -1)


@kernel
def record(clock, log, time, kind, w, roller_from, roller_to):
    """Append an event; the march makes sure that there is room."""
    event = log[clock.events]
    event.time, event.kind, event.wheel = time, kind, w
    event.roller_from, event.roller_to = roller_from, roller_to
    clock.events += 1
