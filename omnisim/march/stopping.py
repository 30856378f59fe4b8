"""How a slip that comes to rest goes on until it does: in the direction of the contact equation, as creeping slip.

    NEAR   friction turns it there as fast as that direction turns itself
    SOON   it will be at rest soon, and the error of a step hides what it is across that direction
    ONCE   friction turns it there at once, from whatever direction it has

Where a roller has come down its contact slips as this roller rolls, which its small inertia resists, until what is left
is slip along its axis, which the machine resists. Sub-steps would follow that turn. But it is over soon, and what it
leaves can be told from the equation of slip alone (turning_slip.py): with v_f' the rate of slip along the final
direction, slip ends as if it had begun as

    v_f(0) = v(t) - v_f' t        t: when v(t) has come to that direction

So an impulse gives it that slip at once, beyond the force that goes on along the final direction. In truth this impulse
is spread over the turn, with its centre at the time

    t_c = integral of (v - v_f) / (v(0) - v_f(0))        by what each of them is to the machine, A^-1

until which the machine moves as it would without it: that is made up for by t_c times the change of the derivative.
What remains is a part of the impulse that falls with the square of the turn's duration.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import solution
from omnisim.contact.set_valued import CREEP, SLIP, STICK
from omnisim.dynamics.impulses import align_slip
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.state import Stage, places
from omnisim.dynamics.wheel import roller_end
from omnisim.march.creeping import CREEP_SPEED, HELD, creeping, hold_direction, keep_creep, turned_by, turning_of
from omnisim.march.runge_kutta import copy, evaluate, refresh
from omnisim.march.slip import course_of, slip_rate
from omnisim.march.slip_bounds import LEAST_STIFF, LEAST_TURNED, STILL_TURNED, stiffness, unseen
from omnisim.march.substeps import SLIP_FRACTION, slip_fraction
from omnisim.march.turning_slip import axes_of, gives_way, mobility_beside, turn_in, two_frictions, unresisted

MOST_FREED = 20  # times in a step, after which slip is followed by sub-steps to its end
AHEAD = 0.1  # of the time to a stop, after which the direction of slip is looked at
MOST_LAG = 0.1  # rad, from which on slip does not follow that direction
AT_EASE = 1000.0  # times that friction turns slip while it changes, from which on its direction is a slow one
MARGIN = 10.0  # between what a turn errs by and the square of the part of a step that it takes, of its speed
PRECISE = 3e-5  # part of slip by which turning_slip.py may miss what a turn leaves of it
LAGS = 0.1  # part of the slip that lags behind its direction at first, that the machine feels
UNCHANGED = 2.0  # times as long as a turn takes nothing else happens: no roller comes to its end, no piece does
ALIKE = 0.99  # cosine between final directions of slip by the contact equation and by the turn
NOT, SOON, NEAR, ONCE = range(4)  # how slip goes on in the direction of the contact equation


class Turn(NamedTuple):
    """How friction turns slip into its final direction: how long that takes, s; which speed of the machine goes with
    what slip loses, m/s, and with what it lags behind that direction, m/s by the rate at which that turns, rad/s; the
    direction (h, k), and for how long slip lasts in it, s."""

    time: float
    lost: float
    lagging: float
    h: float
    k: float
    lasting: float


@kernel
def stops(parameters, run, w, side, h):
    """How a contact that slips goes on, in a piece h, along the direction of the contact equation, which attracts it.

    NEAR: of its own accord, as it turns: friction turns slip many times within a step that it may be given
    (creeping_period), and has done so for so long that the error of the step hides what else turns it. SOON: its end is
    near, and the error hides what the slip is across that direction. ONCE: its end is near, and friction turns it there
    in so short a time that the error hides what else happens in it; where that direction is sought from, is left in
    its mode. Else NOT.
    """
    mode, monitors = run.mode[w], run.monitors[w]
    if mode.shared or mode.grip[side] != SLIP or monitors.factor[side] == 0.0:
        return NOT
    if mode.freed_step == run.clock.step and mode.freed >= MOST_FREED:
        return NOT
    if stiffness(parameters, run.clock, monitors, side) <= LEAST_STIFF:  # as nearly always
        return NOT
    dt, course = run.clock.dt, course_of(parameters, run, w, side)
    hidden = unseen(run.clock, course)
    followed = run.newton is None
    across = strayed(mode, side, course) if followed else course.across
    turned = course.attraction * h > LEAST_TURNED
    follows = followed and course.attraction * min(dt, creeping_period(run.clock, course)) > LEAST_TURNED
    foreign = min(across, course.speed * math.exp(-mode.settled[side]))  # not by the turning of that direction itself
    if follows and foreign * course.attraction * dt < hidden:
        return NEAR
    if -course.growth * dt > course.speed:
        drawn = followed and (turned or course.attraction < 0.0)  # from where it is, or from near where it will be
        if parameters.space is None and drawn and turns_at_once(parameters, run, w, course, h):
            return ONCE
        if (turned or not followed) and across < hidden:
            return SOON
    return NOT


@kernel
def turns_at_once(parameters, run, w, course, h):
    """Whether the slip of wheel w, of this Course, turns in so short a time that the error of a step hides what else
    happens meanwhile, within a piece h, while all others stick and none comes to the end of its roller."""
    clock = run.clock
    if parameters.workspace.articulated is not None or not gives_way(parameters.machine):
        return False
    for v in range(len(run.mode)):
        mode = run.mode[v]
        if mode.shared or (v != w and mode.loaded and mode.grip[0] != STICK):
            return False
    turn = turn_ahead(parameters, run, w, course)
    at = places(parameters)
    part, spin = turn.time / clock.dt, abs(run.y[at.spin_rate + w])
    if (PRECISE + MARGIN * part * part) * turn.lost + LAGS * spin * turn.lagging > clock.ended:
        return False
    if UNCHANGED * turn.time > h:  # no row may see the slip that it ends with
        return False
    for v in range(len(run.mode)):
        mode = run.mode[v]
        angle, rate = run.y[at.spin_angle + v], run.y[at.spin_rate + v]
        end = roller_end(parameters.wheels[v], mode.roller, mode.direction)
        if mode.direction * (end - angle) < UNCHANGED * turn.time * abs(rate):
            return False
    creep = run.mode[w].creep[0]
    creep[0], creep[1] = course.h, course.k
    if course.attraction < 0.0:  # it will not be found from there
        creep[0], creep[1] = turn.h, turn.k
    return (spin * turn.lasting) ** 2 > 2.0 * clock.ended  # or last_slip.py ends it


@kernel
def creeping_period(clock, course):
    """How long slip may go on in the direction of the contact equation at once, s: the part of the time in which it
    doubles, stops or passes by rest that a sub-step may take, as that direction turns with it; any, if friction turns
    it far faster."""
    pace = math.hypot(course.growth / course.speed, course.turning)
    if AT_EASE * pace <= max(course.attraction, 0.0):
        return math.inf
    return slip_fraction(SLIP_FRACTION, pace, clock) / pace


@kernel
def strayed(mode, side, course):
    """What slip is across that direction, m/s: by its turning, and by what it was before and friction has left of that.
    Slip that comes from afar and that direction turn into each other's way: for a moment it turns by nothing."""
    mode.strayed[side] = max(mode.strayed[side], min(course.across / course.speed, 1.0))
    return max(course.across, mode.strayed[side] * course.speed)


@kernel
def slip_freely(parameters, run):
    """Let creeping contacts slip in the direction that they have: where friction no longer turns slip faster than a
    step can follow, or where the step would err, as forces have jumped. Of the others, how long they may creep at
    once, unless the error of a step hides in any case what they are across."""
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            if not creeping(mode, side):
                continue
            mode.period[side] = math.inf
            if run.monitors[w].slip_square[side] <= CREEP_SPEED**2:
                continue
            course = course_of(parameters, run, w, side)
            hidden = course.across <= unseen(run.clock, course)
            if not hidden:
                mode.period[side] = creeping_period(run.clock, course)
            turned = course.attraction * min(run.clock.dt, mode.period[side])
            if turned < STILL_TURNED or not (hidden or mode.foreseen[side]):
                mode.grip[side] = SLIP


@kernel
def begin_to_stop(parameters, run, t, h):
    """Let slips that are about to stop, or last, go on in the direction of the contact equation, in which they will; h:
    length of the piece that begins."""
    begun = False
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            how = stops(parameters, run, w, side, h)
            if parameters.space is None and how == ONCE:
                turn_at_once(parameters, run, w, t)
                return  # all others stick
            if how != NOT:
                course = course_of(parameters, run, w, side)
                begin_to_creep(run, w, side, (course.h, course.k))
                begun = True
                if how == NEAR:
                    mode = run.mode[w]
                    mode.foreseen[side], mode.veering[side] = 1, course.turning
                    mode.period[side], mode.veer[side, 1] = creeping_period(run.clock, course), HELD
    if not begun:
        return
    find_directions(parameters, run, t)
    if run.newton is None:
        foresee_stops(parameters, run, t)
    hold_directions(parameters, run)
    align_slip(parameters, run, False)
    refresh(parameters, run, t)


@kernel
def begin_to_creep(run, w, side, direction):
    """Let slip of a contact that is about to stop creep, in a direction (h, k) from which that of the contact equation
    is sought; nothing tells how it turns."""
    mode = run.mode[w]
    mode.grip[side], mode.stopping[side] = CREEP, 1
    mode.creep[side, 0], mode.creep[side, 1] = direction
    mode.foreseen[side], mode.veering[side], mode.period[side] = 0, 0.0, math.inf
    mode.veer[side, 0], mode.veer[side, 1] = 0.0, 0.0


@kernel
def find_directions(parameters, run, t):
    """The directions of all creeping slips at the state itself, and the derivative with them."""
    refresh(parameters, run, t)
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                keep_creep(parameters, run, w, side)


@kernel
def hold_directions(parameters, run):
    """Let all creeping slips keep them until a step turns them."""
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                hold_direction(run, w, side, turning_of(parameters, w, side).slip)


@kernel
def turn_ahead(parameters, run, w, course):
    """About how the slip of wheel w, of this Course, loses that to which its contact gives way most: a Turn."""
    rate, v, a = slip_rate(parameters, run.mode[w], w, 0, run.y, run.slopes[0])
    factor = run.monitors[w].factor[0]
    b = unresisted(rate, a, Slip(-factor * v.h, -factor * v.k))
    h, k, most, least = axes_of(a)
    lost, limit = abs(v.h * h + v.k * k), factor * course.speed
    time = lost / (limit * most)
    left = h * (v.k + time * b.k) - k * (v.h + time * b.h)
    side, heavier = math.copysign(1.0, left), 1.0 / (parameters.machine.mass * most)
    lagging = left * left / (limit * most)
    return Turn(time, lost * heavier, lagging * heavier, -side * k, side * h, abs(left) / (limit * least))


@outlined
def turn_at_once(parameters, run, w, t):
    """Turn the slip of wheel w into the direction of the contact equation, in which it slips on as it did if it would
    not end there."""
    mode, monitors = run.mode[w], run.monitors[w]
    limit = monitors.factor[0] * math.sqrt(monitors.slip_square[0])
    begin_to_creep(run, w, 0, (mode.creep[0, 0], mode.creep[0, 1]))
    find_directions(parameters, run, t)
    hold_directions(parameters, run)
    rate, v, _ = slip_rate(parameters, mode, w, 0, run.y, run.slopes[0])
    a, u = mobility_beside(parameters, run, w), Slip(mode.creep[0, 0], mode.creep[0, 1])
    final = parameters.machine.friction * max(run.monitors[w].normal_force, 0.0)
    b = unresisted(rate, a, Slip(-final * u.h, -final * u.k))
    turned = turn_in(b, a, two_frictions(v, limit, u, final), v)
    slowing = -(rate.h * u.h + rate.k * u.k)
    along = turned.h * u.h + turned.k * u.k
    if turned.gone or slowing <= 0.0 or not along > ALIKE * math.sqrt(turned.h * turned.h + turned.k * turned.k):
        mode.grip[0] = SLIP
        mode.freed, mode.freed_step = MOST_FREED, run.clock.step  # not to be tried again in this step
        refresh(parameters, run, t)
        return
    speed = along + slowing * turned.time
    change = solution(a, Slip(v.h - speed * u.h, v.k - speed * u.k))
    ahead = turned.time * (speed - 0.5 * slowing * turned.time)
    late = solution(a, Slip(turned.way_h - ahead * u.h, turned.way_k - ahead * u.k))
    square = change.h * change.h + change.k * change.k
    centre = (late.h * change.h + late.k * change.k) / square if square > 0.0 else 0.0
    copy(run.slopes[0], run.slopes[-1])
    mode.layer[0], mode.layer[1] = speed * u.h, speed * u.k
    mode.grip[0] = STICK  # with this slip, for the impulse
    align_slip(parameters, run, False)
    mode.grip[0] = CREEP
    mode.layer[0] = mode.layer[1] = 0.0
    refresh(parameters, run, t)
    for m in range(len(run.y)):
        run.y[m] += centre * (run.slopes[-1, m] - run.slopes[0, m])


@kernel
def foresee_stops(parameters, run, t):
    """At which rate the direction of the contact equation turns for slips that are about to stop, by a state a little
    later; slip lags behind that direction by what it turns while friction draws slip there."""
    ahead = math.inf
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if unforeseen(run.mode[w], side):
                course = course_of(parameters, run, w, side)
                ahead = min(ahead, AHEAD * course.speed / abs(course.growth))
    if ahead == math.inf:
        return
    for m in range(len(run.y)):
        run.trial[m] = run.y[m] + ahead * run.slopes[0, m]
    evaluate(
        parameters, Stage(run.mode, run.clock.piece, t + ahead, run.trial, run.slopes[-1], run.monitors_end, False)
    )
    run.clock.rhs += 1
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            if unforeseen(mode, side):
                creep, course = mode.creep[side], course_of(parameters, run, w, side)
                turning = turned_by(creep, turning_of(parameters, w, side).creep) / ahead
                if abs(turning) < MOST_LAG * course.attraction:
                    mode.foreseen[side], mode.veering[side] = 1, turning
                    lag = turning / course.attraction
                    h, k = creep[0] + lag * creep[1], creep[1] - lag * creep[0]
                    size = math.sqrt(h * h + k * k)
                    creep[0], creep[1] = h / size, k / size


@kernel
def unforeseen(mode, side):
    """Whether slip is about to stop in a direction of which nothing tells how it turns, nor anything holds it."""
    return creeping(mode, side) and mode.stopping[side] == 1 and not mode.foreseen[side] and mode.veer[side, 1] == 0.0
