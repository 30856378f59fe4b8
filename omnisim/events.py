"""Events: what ends the validity of a mode, and what the mode is afterwards.

A guard is >= 0 as long as its mode holds. A step at whose end one is negative is cut at the root, and the row below
tells what changes there.

    guard  while the mode holds                           afterwards
    TURN   the spin keeps its sense: direction phi' >= 0  direction reversed; so EXIT is monotone within every step
    EXIT   the roller's end ahead is not passed yet       the neighbour takes over: an exchange
    KINK   |v| stays on its side of slip_speed            the other branch of the saturated law
    LOAD   N >= 0                                         the wheel leaves the floor: the march stops

Both trackings pass a roller's end at the same spin angle: |q| = alpha is |c_beta| = c sin alpha. The guard is the
angle, monotone over several turns as well; which rollers touch at the start, each tracking tells by its own condition.
"""

import math

import numpy as np

from omnisim.contact.reaction import SATURATED
from omnisim.contact.tracking import EXPLICIT, explicit_touches, implicit_touches, roller_axis
from omnisim.dynamics import azimuth, rho_of
from omnisim.kernel import kernel
from omnisim.state import PER_WHEEL, ROLLER_RATE, SPIN_ANGLE, SPIN_RATE, WHEELS
from omnisim.status import LIFT_OFF

TURN, EXIT, KINK, LOAD = range(4)
GUARDS = 4
KINDS = ("exchange", "stick", "slip", "lift_off", "touch_down", "share_begin", "share_end", "stop")
EXCHANGE, STOP = KINDS.index("exchange"), KINDS.index("stop")
LIFT = KINDS.index("lift_off")

EVENT = np.dtype(
    [
        ("time", np.float64),  # s
        ("kind", np.int64),  # index into KINDS
        ("wheel", np.int64),
        ("roller_from", np.int64),  # -1 where not meant
        ("roller_to", np.int64),
    ]
)


@kernel
def guard(parameters, mode, kind, w, y, watch):
    """Value of a guard of wheel w at state `y` with by-products `watch`: >= 0 while the mode holds."""
    machine, wheel, at = parameters.machine, parameters.wheels[w], WHEELS + PER_WHEEL * w
    direction = mode[w].direction
    if kind == TURN:
        return direction * y[at + SPIN_RATE]
    if kind == EXIT:
        return direction * (roller_end(wheel, mode[w].roller, direction) - y[at + SPIN_ANGLE])
    if kind == KINK:
        if machine.law != SATURATED:
            return 0.0
        excess = watch[w].slip_square - machine.slip_speed * machine.slip_speed
        return excess if mode[w].saturated else -excess
    return watch[w].normal_force


@kernel
def roller_end(wheel, roller, direction):
    """Spin angle at which a roller ends, for spin of the sense `direction`, rad: one number for both neighbours."""
    return wheel.phase + wheel.alpha * (2 * roller + direction)


@kernel
def transition(parameters, run, log, kind, w, time):
    """Change the mode after a guard of wheel w fired at `time`."""
    mode, clock = run.mode[w], run.clock
    if kind == TURN:
        mode.direction = -mode.direction
    elif kind == EXIT:
        roller_from = mode.roller % parameters.wheels[w].rollers
        release_roller(parameters, run, w)
        take_roller(parameters, run, w, mode.roller + mode.direction)
        record(clock, log, time, EXCHANGE, w, roller_from, mode.roller % parameters.wheels[w].rollers)
    elif kind == KINK:
        mode.saturated = 1 - mode.saturated
    else:
        record(clock, log, time, LIFT, w, -1, -1)
        clock.status, clock.wheel = LIFT_OFF, w


@kernel
def take_roller(parameters, run, w, roller):
    """Make `roller` (counted on through every turn) the one in contact: its rate enters the state.

    The sums of those in the air are taken anew each time, so they never drift.
    """
    mode, at, count = run.mode[w], WHEELS + PER_WHEEL * w, parameters.wheels[w].rollers
    mode.roller = roller
    here = roller % count
    run.y[at + ROLLER_RATE] = run.rates[w, here]
    mode.air_cos, mode.air_sin, mode.air_sum = 0.0, 0.0, 0.0
    for i in range(count):
        if i != here:
            rate, sector = run.rates[w, i], parameters.sector[w, (i - here) % count]
            mode.air_cos += rate * sector[0]
            mode.air_sin += rate * sector[1]
            mode.air_sum += rate


@kernel
def touching(parameters, w, y):
    """The rollers of wheel w that touch the floor at state `y`, counted on through every turn: (ahead, behind).

    Twice the same one, or at a common edge the one at q = +alpha, which positive spin takes, and the one at -alpha.
    """
    wheel, at, found, ahead, behind = parameters.wheels[w], WHEELS + PER_WHEEL * w, False, 0, 0
    for i in range(wheel.rollers):
        q = azimuth(wheel, i, y[at + SPIN_ANGLE])
        cos_q, sin_q = math.cos(q), math.sin(q)
        if parameters.machine.tracking == EXPLICIT:
            touches = explicit_touches(wheel, cos_q)
        else:
            touches = implicit_touches(wheel, roller_axis(wheel, cos_q, sin_q), rho_of(parameters, y, w, i))
        if touches:
            roller = i + wheel.rollers * math.floor(0.5 - q / (2.0 * math.pi))
            ahead = max(ahead, roller) if found else roller
            behind = min(behind, roller) if found else roller
            found = True
    return ahead, behind


@kernel
def release_roller(parameters, run, w):
    """Write the rate of the contacting roller back to `rates`, where those of all rollers stand."""
    here = run.mode[w].roller % parameters.wheels[w].rollers
    run.rates[w, here] = run.y[WHEELS + PER_WHEEL * w + ROLLER_RATE]


@kernel
def record(clock, log, time, kind, w, roller_from, roller_to):
    """Append an event; the march makes sure that there is room."""
    event = log[clock.events]
    event.time, event.kind, event.wheel = time, kind, w
    event.roller_from, event.roller_to = roller_from, roller_to
    clock.events += 1
