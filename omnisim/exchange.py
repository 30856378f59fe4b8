"""Which roller carries the wheel: at the start, when the next one takes over, and when two of them do."""

import math

from omnisim.contact.coulomb import SLIP
from omnisim.contact.reaction import COULOMB, SATURATED
from omnisim.contact.tracking import EXPLICIT, explicit_touches, implicit_touches, roller_axis
from omnisim.grip import come_to_rest, rests
from omnisim.kernel import kernel, merged, outlined
from omnisim.runge_kutta import refresh
from omnisim.state import places, rate_place
from omnisim.wheel import azimuth, rho_of, roller_end

ON_EDGE = 1e-14  # of a radian and of the spin angle: so near to the edge is on it
SWING = 1 / 200  # of a step: a swing about an edge and back that is shorter is none


@outlined
def stand_up(parameters, run):
    """The mode of every wheel at t = 0 as far as its spin tells it; friction is not asked yet."""
    at = places(parameters)
    for w in range(len(run.mode)):
        mode = run.mode[w]
        ahead, behind = touching(parameters, w, run.y)
        backwards = run.y[at.spin_rate + w] < 0.0
        mode.direction, mode.loaded = -1 if backwards else 1, 1
        take_rollers(parameters, run, w, behind if backwards else ahead, False)
    refresh(parameters, run, 0.0)


@outlined
def settle(parameters, run, w):
    """The mode of wheel w at t = 0: on an edge the sense of spin tells the roller, and without spin its acceleration.

    Whether the wheel rests on both rollers there.
    """
    at, mode = places(parameters), run.mode[w]
    ahead, behind = touching(parameters, w, run.y)
    stand_on(parameters, run, w, mode.roller, False, 0.0)
    if run.y[at.spin_rate + w] == 0.0 and run.slopes[0, at.spin_rate + w] < 0.0:
        mode.direction = -1
        stand_on(parameters, run, w, behind, False, 0.0)
        if ahead != behind and run.slopes[0, at.spin_rate + w] > 0.0:
            rest_on_both(parameters, run, w, ahead, 0.0)
    return mode.shared


@merged
def comes_to_rest_between(parameters, run, w, t):
    """Whether a wheel that has just turned back now rests on two rollers; if so, it does from here on.

    Its swings about the edge have become too short to follow, and the neighbour would push it back as well.
    """
    wheel, mode, at = parameters.wheels[w], run.mode[w], places(parameters)
    edge = roller_end(wheel, mode.roller, mode.direction)
    depth = mode.direction * (edge - run.y[at.spin_angle + w])
    push = mode.direction * run.slopes[0, at.spin_rate + w]
    swing = SWING * run.clock.dt
    if depth > max(0.125 * push * swing * swing, ON_EDGE * (1.0 + abs(edge))):
        return False
    here, neighbour = mode.roller, mode.roller + mode.direction
    release_rollers(parameters, run, w)
    stand_on(parameters, run, w, neighbour, False, t)
    if mode.direction * run.slopes[0, at.spin_rate + w] >= 0.0:
        stand_on(parameters, run, w, here, False, t)
        return False
    rest_on_both(parameters, run, w, max(here, neighbour), t)
    return True


@kernel
def rest_on_both(parameters, run, w, ahead, t):
    """Wheel w carried by the roller `ahead` and the one behind it, from time t on; it stands on their edge."""
    at, mode = places(parameters), run.mode[w]
    mode.direction = 1
    run.y[at.spin_angle + w] = roller_end(parameters.wheels[w], ahead, -1)
    run.y[at.spin_rate + w] = 0.0
    run.carry[at.spin_angle + w] = run.carry[at.spin_rate + w] = 0.0
    stand_on(parameters, run, w, ahead, True, t)


@merged
def leave_edge(parameters, run, w, t):
    """The wheel goes on upon the roller whose push alone has ceased; the one that is left behind."""
    mode = run.mode[w]
    release_rollers(parameters, run, w)
    onto_behind = run.watch[w].share < 0.5
    left, kept = (mode.roller, mode.roller - 1) if onto_behind else (mode.roller - 1, mode.roller)
    mode.direction = -1 if onto_behind else 1
    stand_on(parameters, run, w, kept, False, t)
    return left


@outlined
def stand_on(parameters, run, w, roller, shared, t):
    """Make `roller`, if shared also the one behind it, carry wheel w from time t on: rates, friction, derivative."""
    take_rollers(parameters, run, w, roller, shared)
    renew_friction(parameters, run, w, t)


@merged
def renew_friction(parameters, run, w, t):
    """Mode of the friction at the contacts of wheel w as their slip is, and the derivative."""
    mode, slip_speed = run.mode[w], parameters.machine.slip_speed
    for side in range(2):
        mode.grip[side] = SLIP
    refresh(parameters, run, t)
    for side in range(1 + mode.shared):
        if parameters.machine.law == COULOMB:
            if rests(parameters, run, w, side):
                come_to_rest(parameters, run, w, side, False, t)
        elif parameters.machine.law == SATURATED:
            mode.saturated[side] = run.watch[w].slip_square[side] > slip_speed * slip_speed
            refresh(parameters, run, t)


@merged
def touching(parameters, w, y):
    """The rollers of wheel w that touch the floor at state `y`, counted on through every turn: (ahead, behind).

    Twice the same one, or at a common edge the one at q = +alpha, which positive spin takes, and the one at -alpha.
    """
    wheel, at, found, ahead, behind = parameters.wheels[w], places(parameters), False, 0, 0
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


@merged
def take_rollers(parameters, run, w, roller, shared):
    """Make `roller` (counted on through every turn), if shared also the one behind it, touch: rates enter the state.

    The sums of those in the air are taken anew each time, so they never drift.
    """
    mode, count = run.mode[w], parameters.wheels[w].rollers
    mode.roller, mode.shared = roller, shared
    here, behind = roller % count, (roller - 1) % count
    mode.air_cos, mode.air_sin, mode.air_sum = 0.0, 0.0, 0.0
    for i in range(count):
        rate, place = run.rates[w, i], -1
        if parameters.machine.every_rate:
            place = parameters.wheels[w].rates + i
        elif i == here or (shared and i == behind):
            place = rate_place(parameters, roller, w, 0 if i == here else 1)
        else:
            sector = parameters.sector[w, (i - here) % count]
            mode.air_cos += rate * sector[0]
            mode.air_sin += rate * sector[1]
            mode.air_sum += rate
        if place >= 0 and run.y[place] != rate:
            run.y[place], run.carry[place] = rate, 0.0


@kernel
def release_rollers(parameters, run, w):
    """Write the roller rates of the state back to `rates`, where those of all rollers stand."""
    mode, count = run.mode[w], parameters.wheels[w].rollers
    if parameters.machine.every_rate:
        for i in range(count):
            run.rates[w, i] = run.y[parameters.wheels[w].rates + i]
    else:
        for side in range(1 + mode.shared):
            run.rates[w, (mode.roller - side) % count] = run.y[rate_place(parameters, mode.roller, w, side)]
