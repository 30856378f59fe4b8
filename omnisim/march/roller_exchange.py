"""Which roller carries the wheel: when the next one takes over, and when two of them do. onset.py has the start."""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.friction import SATURATED
from omnisim.contact.set_valued import SLIP
from omnisim.contact.tracking import explicit_touches, implicit_touches, roller_axis
from omnisim.dynamics.indices import carries, contact_count, rate_place, roller_index, roller_of, row_index, sector_of
from omnisim.dynamics.shared_forces import LOST
from omnisim.dynamics.state import TOUCHING, Stage, places
from omnisim.dynamics.wheel import azimuth_of, rho_of, roller_end
from omnisim.march.friction_modes import come_to_rest, rests
from omnisim.march.runge_kutta import copy, evaluate, refresh
from omnisim.march.slip_bounds import rest_speed

ON_EDGE = 1e-14  # of a radian and of the spin angle: so near to the edge is on it
SWING = 1 / 200  # of a step: a swing about an edge and back that is shorter is none
TURNING = 1 / 8  # of the square of its duration, times the acceleration back: how far it comes, (1/2) (duration / 2)^2
MOMENTS = 3  # of this length, after which a torque that grows from nothing is there
SLIP_ROUNDING = 0.1  # of the slip that no longer matters


@kernel
def comes_to_rest_between(parameters, run, w, t):
    """Whether a wheel that has just turned back now rests on two rollers; if so, it does from here on.

    Its swings about the edge have become too short to follow, and the neighbour would push it back as well, or not on.
    A wheel that a table of angles turns is carried by one: nothing tells how two would share its load.
    """
    wheel = parameters.wheels[w]
    if wheel.follows:
        return False
    mode = run.mode[w]
    at = places(parameters)
    edge = roller_end(wheel, mode.roller, mode.direction)
    depth = mode.direction * (edge - run.y[at.spin_angle + w])
    push = mode.direction * run.slopes[0, at.spin_rate + w]
    swing = SWING * run.clock.dt
    if depth > max(TURNING * push * swing * swing, ON_EDGE * (1.0 + abs(edge))):
        return False
    here = mode.roller
    neighbour = mode.roller + mode.direction
    release_rollers(parameters, run, w)
    stand_on(parameters, run, w, neighbour, False, t)
    if edge_torque(parameters, run, w, t) > 0.0:  # what nothing turns rests on both as well
        stand_on(parameters, run, w, here, False, t)
        return False
    rest_on_both(parameters, run, w, max(here, neighbour), t)
    return True


@outlined
def edge_torque(parameters, run, w, t):
    """Torque with which wheel w, on an edge without spin, holds on to the mode that it has there, N m.

    On one roller J phi'' in the sense of `direction`, away from the edge if the roller is to carry on; on two the one
    with which each pushes back. Where that is lost in rounding, it is what it will be some moments later: the first is
    seen of a torque that grows from nothing, the next of the slip that follows, and of smooth friction. Else 0.
    """
    clock = run.clock
    trial = run.trial
    slope = run.slopes[1]
    monitors = run.monitors_end[w]
    rounding = edge_rounding(parameters, run.mode[w], w, run.y, run.monitors[w])
    torque = edge_torque_of(parameters, run.mode[w], w, run.slopes[0], run.monitors[w])
    if abs(torque) > rounding:
        return torque
    moment = SWING * clock.dt
    copy(run.y, trial)
    copy(run.slopes[0], slope)
    for later in range(MOMENTS):
        for m in range(len(trial)):
            trial[m] += moment * slope[m]
        stage = Stage(run.mode, clock.piece, t + (later + 1) * moment, trial, slope, run.monitors_end, True)
        evaluate(parameters, stage)
        clock.rhs += 1
        torque = edge_torque_of(parameters, run.mode[w], w, slope, monitors)
        if abs(torque) > rounding:
            run.monitors[w].share = monitors.share  # which of the two will carry on
            return torque
    return 0.0


@kernel
def edge_torque_of(parameters, mode, w, slope, monitors):
    """That torque by the derivative `slope` and the by-products `monitors` of a state."""
    if mode.shared:
        return monitors.share_margin
    wheel = parameters.wheels[w]
    return mode.direction * slope[places(parameters).spin_rate + w] * (wheel.axle_inertia + wheel.rotor_inertia)


@kernel
def edge_rounding(parameters, mode, w, y, monitors):
    """Rounding of such a torque, N m: of the load, and on two rollers of friction of tiny slip."""
    force = LOST * abs(monitors.normal_force)
    if mode.shared:
        for side in range(TOUCHING):
            if mode.grip[side] == SLIP:
                force += SLIP_ROUNDING * rest_speed(parameters, mode, w, side, y) * monitors.factor[side]
    return force * parameters.wheels[w].radius


@kernel
def rest_on_both(parameters, run, w, ahead, t):
    """Wheel w carried by the roller `ahead` and the one behind it, from time t on; it stands on their edge."""
    run.mode[w].direction = 1
    stop_at_edge(parameters, run, w, ahead)
    stand_on(parameters, run, w, ahead, True, t)


@kernel
def stop_at_edge(parameters, run, w, ahead):
    """Wheel w on the edge between the roller `ahead` and the one behind it, without spin."""
    at = places(parameters)
    run.y[at.spin_angle + w] = roller_end(parameters.wheels[w], ahead, -1)
    run.y[at.spin_rate + w] = 0.0
    run.carry[at.spin_angle + w] = run.carry[at.spin_rate + w] = 0.0


@kernel
def leave_edge(parameters, run, w, t):
    """The wheel goes on upon the roller whose push alone has ceased; the one that is left behind."""
    mode = run.mode[w]
    release_rollers(parameters, run, w)
    onto_behind = run.monitors[w].share < 0.5
    stop_at_edge(parameters, run, w, mode.roller)
    left, kept = (mode.roller, mode.roller - 1) if onto_behind else (mode.roller - 1, mode.roller)
    mode.direction = -1 if onto_behind else 1
    stand_on(parameters, run, w, kept, False, t)
    return left


@outlined
def stand_on(parameters, run, w, roller, shared, t):
    """Make `roller`, if shared also the one behind it, carry wheel w from time t on: rates, friction, derivative."""
    take_rollers(parameters, run, w, roller, shared)
    renew_friction(parameters, run, w, t)


@kernel
def renew_friction(parameters, run, w, t):
    """Mode of the friction at the contacts of wheel w as their slip is, and the derivative."""
    mode = run.mode[w]
    slip_speed = parameters.machine.slip_speed
    for side in range(TOUCHING):
        mode.grip[side] = SLIP
    refresh(parameters, run, t)
    for side in range(contact_count(mode)):
        if parameters.workspace.resting is not None:
            if rests(parameters, run, w, side):
                come_to_rest(parameters, run, w, side, False, t)
        elif parameters.machine.law == SATURATED:
            mode.saturated[side] = run.monitors[w].slip_square[side] > slip_speed * slip_speed
            refresh(parameters, run, t)


@outlined
def touching(parameters, w, y):
    """The rollers of wheel w that touch the floor at state `y`, counted on through every turn: (ahead, behind).

    Twice the same one, or at a common edge the one at q = +alpha, which positive spin takes, and the one at -alpha.
    """
    wheel = parameters.wheels[w]
    at = places(parameters)
    found = False
    ahead = 0
    behind = 0
    for i in range(wheel.rollers):
        q = azimuth_of(parameters, w, i, y[at.spin_angle + w])
        cos_q, sin_q = math.cos(q), math.sin(q)
        if not parameters.machine.implicit_tracking:
            touches = explicit_touches(wheel, cos_q)
        else:
            touches = implicit_touches(wheel, roller_axis(wheel, cos_q, sin_q), rho_of(parameters, y, w, i))
        if touches:
            roller = i + wheel.rollers * math.floor(0.5 - q / (2.0 * math.pi))  # in the turn that brings it down
            ahead = max(ahead, roller) if found else roller
            behind = min(behind, roller) if found else roller
            found = True
    return ahead, behind


@kernel
def take_rollers(parameters, run, w, roller, shared):
    """Make `roller` (counted on through every turn), if shared also the one behind it, touch: rates enter the state.

    The sums of those in the air are taken anew each time, so they never drift.
    """
    mode, wheel = run.mode[w], parameters.wheels[w]
    mode.roller, mode.shared, mode.contacts = roller, shared, 1 + shared
    for side in range(TOUCHING):
        mode.index[side] = roller_index(wheel, roller_of(mode, side))
        mode.row[side] = row_index(wheel, roller_of(mode, side))
    mode.air_cos, mode.air_sin, mode.air_sum = 0.0, 0.0, 0.0
    for i in range(wheel.rollers):
        rate = run.rates[w, i]
        place = -1
        if parameters.machine.every_rate:
            place = wheel.rates + i
        elif carries(wheel, mode, 0, i):
            place = rate_place(parameters, mode, w, 0)
        elif shared and carries(wheel, mode, 1, i):
            place = rate_place(parameters, mode, w, 1)
        else:
            sector = sector_of(parameters, w, i, roller)
            mode.air_cos += rate * sector[0]
            mode.air_sin += rate * sector[1]
            mode.air_sum += rate
        if place >= 0 and run.y[place] != rate:
            run.y[place], run.carry[place] = rate, 0.0


@kernel
def release_rollers(parameters, run, w):
    """Write the roller rates of the state back to `rates`, where those of all rollers stand."""
    mode, wheel = run.mode[w], parameters.wheels[w]
    if parameters.machine.every_rate:
        for i in range(wheel.rollers):
            run.rates[w, i] = run.y[wheel.rates + i]
    else:
        for side in range(contact_count(mode)):
            i = mode.index[side]
            run.rates[w, i] = run.y[rate_place(parameters, mode, w, side)]
