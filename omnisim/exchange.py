"""Which roller carries the wheel: at the start, and when the next one takes over."""

import math

from omnisim.contact.coulomb import SLIP
from omnisim.contact.reaction import COULOMB, SATURATED
from omnisim.contact.tracking import EXPLICIT, explicit_touches, implicit_touches, roller_axis
from omnisim.dynamics import azimuth, rho_of
from omnisim.grip import come_to_rest, rests
from omnisim.kernel import kernel
from omnisim.runge_kutta import refresh
from omnisim.state import places
from omnisim.status import ROCKING


@kernel
def settle(parameters, run):
    """The mode at t = 0. On an edge the sense of spin tells the roller, and without spin its acceleration."""
    for w in range(len(run.mode)):
        at, mode = places(len(parameters.wheels)), run.mode[w]
        ahead, behind = touching(parameters, w, run.y)
        spin = run.y[at.spin_rate + w]
        mode.direction = -1 if spin < 0.0 else 1
        hand_over(parameters, run, w, behind if spin < 0.0 else ahead, 0.0)
        if spin == 0.0 and run.slopes[0, at.spin_rate + w] < 0.0:
            mode.direction = -1
            hand_over(parameters, run, w, behind, 0.0)
            if ahead != behind and run.slopes[0, at.spin_rate + w] > 0.0:
                run.clock.status, run.clock.wheel = ROCKING, w


@kernel
def hand_over(parameters, run, w, roller, t):
    """Make `roller` carry wheel w from time t on: its rate, the mode of its friction, the derivative."""
    take_roller(parameters, run, w, roller)
    refresh(parameters, run, t)
    if parameters.machine.law == COULOMB:
        run.mode[w].grip = SLIP
        refresh(parameters, run, t)
        if rests(parameters, run, w):
            come_to_rest(parameters, run, w, t)
    elif parameters.machine.law == SATURATED:
        slip_speed = parameters.machine.slip_speed
        run.mode[w].saturated = run.watch[w].slip_square > slip_speed * slip_speed
        refresh(parameters, run, t)


@kernel
def touching(parameters, w, y):
    """The rollers of wheel w that touch the floor at state `y`, counted on through every turn: (ahead, behind).

    Twice the same one, or at a common edge the one at q = +alpha, which positive spin takes, and the one at -alpha.
    """
    wheel, at, found, ahead, behind = parameters.wheels[w], places(len(parameters.wheels)), False, 0, 0
    for i in range(wheel.rollers):
        q = azimuth(wheel, i, y[at.spin_angle + w])
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
def take_roller(parameters, run, w, roller):
    """Make `roller` (counted on through every turn) the one in contact: its rate enters the state.

    The sums of those in the air are taken anew each time, so they never drift.
    """
    mode, at, count = run.mode[w], places(len(parameters.wheels)), parameters.wheels[w].rollers
    mode.roller = roller
    here = roller % count
    run.y[at.roller_rate + w], run.carry[at.roller_rate + w] = run.rates[w, here], 0.0
    mode.air_cos, mode.air_sin, mode.air_sum = 0.0, 0.0, 0.0
    for i in range(count):
        if i != here:
            rate, sector = run.rates[w, i], parameters.sector[w, (i - here) % count]
            mode.air_cos += rate * sector[0]
            mode.air_sin += rate * sector[1]
            mode.air_sum += rate


@kernel
def release_roller(parameters, run, w):
    """Write the rate of the contacting roller back to `rates`, where those of all rollers stand."""
    here = run.mode[w].roller % parameters.wheels[w].rollers
    run.rates[w, here] = run.y[places(len(run.mode)).roller_rate + w]
