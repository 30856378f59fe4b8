"""The last of a slip: how it comes to rest while nothing else changes.

Near its end slip v obeys v' = b - S v / |v|, S = mu N A, where b, the slip acceleration without this friction, and S
are as good as constant, while the direction of v turns ever faster: steps through it would have to be ever shorter. But
what this friction does to the machine until v = 0 depends on the time T alone that this takes,

    v + b T = A P        P: the impulse that friction takes away

So the equation of v, two numbers, is solved for T (turning_slip.py), the machine goes on for T as it moves, and an
impulse takes away what slip is left (impulses.py). Where it sticks then, the mean of the derivatives at both ends takes
the place of the first: that errs with T^3.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Slip
from omnisim.contact.mobility import across, applied
from omnisim.contact.set_valued import SLIP, TINY
from omnisim.dynamics.normal_forces.solution import loads_known
from omnisim.dynamics.state import places
from omnisim.march.events import EXIT, GRIP, NO_GUARD, TURN, Guard, guard
from omnisim.march.slip import slip_rate
from omnisim.march.turning_slip import gives_way, mobility_beside, one_friction, turn_in, unresisted

BEFORE = 20.0  # times the angle by which a wheel may turn: when b and S are looked at first
LEAST_SIZE = 1.0  # m/s^2 of b, at least: where it is less, T is still the time of an event
PRECISE = 1e-3  # part of the time in which slip turns that T is off by, half as much again at worst
UNSTEADY = 0.01  # part of what b and S change within T, that their rates until now do not tell
BENT = 5e-3  # part of the square of the angle by which a wheel turns meanwhile, that the mean of two derivatives misses
ANSWER = 0.2  # part of a load that may change as friction turns, where contacts carry roll and pitch
UNTURNED = 0.1  # rad, by which friction may turn slip of others meanwhile
SURELY = 0.9  # part of |v| / |v'| that slip lasts at least


@kernel
def end_slip(parameters, run, t, h):
    """Let the slip of a contact come to rest within a piece h, if the error of a step hides what changes meanwhile: the
    time that this takes, s, and the Guard of its end, or NO_GUARD. The trial is the state then.

    Not where bodies follow the speeds, spins give no way, or rollers resist their turning.
    """
    if parameters.space is None and parameters.workspace.articulated is None and gives_way(parameters.machine):
        spins, soon = places(parameters).spin_rate, BEFORE * math.sqrt(2.0 * run.clock.ended)
        for w in range(len(run.mode)):
            mode, monitors = run.mode[w], run.monitors[w]
            slips = mode.grip[0] == SLIP and not mode.shared
            relaxing = monitors.factor[0] * parameters.machine.slip_mobility  # slip lasts longer than 1 / relaxing
            if slips and relaxing * soon > abs(run.y[spins + w]):
                time = time_left(parameters, run, w, t)
                if time < h:
                    go_on(parameters, run, w, time)
                    if nothing_else_ends(parameters, run, w, time):
                        run.clock.lasted = time
                        return time, Guard(GRIP, w, 0)
    return 0.0, NO_GUARD


@kernel
def go_on(parameters, run, w, time):
    """The trial: what the state is after a time, s, if its derivative stays but for the slip of wheel w, which falls to
    nothing, so that its heat goes by the mean of it. That heat is not in the derivative that stays behind."""
    for m in range(len(run.y)):
        run.increment[m] = run.carry[m] + time * run.slopes[0, m]
        run.slopes[-1, m] = run.slopes[0, m]
    rate, slip, _ = slip_rate(parameters, run.mode[w], w, 0, run.y, run.slopes[0])
    loss, factor = places(parameters).friction_loss, run.monitors[w].factor[0]
    run.increment[loss] += 0.5 * time * time * factor * (slip.h * rate.h + slip.k * rate.k)
    run.slopes[-1, loss] -= factor * (slip.h * slip.h + slip.k * slip.k)
    for m in range(len(run.y)):
        run.trial[m] = run.y[m] + run.increment[m]
    for v in range(len(run.mode)):
        run.monitors_end[v] = run.monitors[v]


@outlined
def time_left(parameters, run, w, t):
    """Time in which the slip of wheel w comes to rest, s; infinite if it does not, or if an error would show.

    How fast b and S change is seen from what they were when this was last asked: T goes by what they will be in the
    middle of it.
    """
    mode, clock = run.mode[w], run.clock
    rate, slip, _ = slip_rate(parameters, mode, w, 0, run.y, run.slopes[0])
    a, factor = mobility_beside(parameters, run, w), run.monitors[w].factor[0]
    b = unresisted(rate, a, Slip(-factor * slip.h, -factor * slip.k))
    speed = math.sqrt(slip.h * slip.h + slip.k * slip.k)
    limit = factor * speed
    whole, size, seen = limit * (a.hh + a.kk), max(math.sqrt(b.h * b.h + b.k * b.k), LEAST_SIZE), mode.seen
    change = math.sqrt((b.h - seen[0]) ** 2 + (b.k - seen[1]) ** 2) + size * abs(1.0 - seen[2] / whole)
    past, known = t - seen[3], seen[3] >= 0.0
    drift = 0.5 * change / past if known else math.inf
    half = 0.5 * speed * speed / max(-(slip.h * rate.h + slip.k * rate.k), TINY) / past  # of the time left, by that
    middle = Slip(b.h + half * (b.h - seen[0]), b.k + half * (b.k - seen[1]))
    stronger = 1.0 + half * (1.0 - seen[2] / whole)
    seen[0], seen[1], seen[2], seen[3] = b.h, b.k, whole, t
    least = SURELY * speed / math.sqrt(rate.h * rate.h + rate.k * rate.k)
    if not (known and UNSTEADY * drift * least * least <= clock.ended):
        return math.inf
    time, turns = time_to_rest(middle, a, limit * stronger, slip)
    missed = PRECISE * size * turns + UNSTEADY * drift * time * time
    if not loads_known(parameters.machine):
        missed += ANSWER * size * turns
    turned = run.y[places(parameters).spin_rate + w] * time
    fallen = parameters.machine.mobility * limit * time * time  # how far friction moves the machine meanwhile
    return time if missed + BENT * (turned * turned + fallen) <= clock.ended else math.inf


@kernel
def time_to_rest(b, a, limit, v):
    """The time T after which slip v (Slip, m/s) comes to rest, s, infinite if it does not, and for how much of it it
    has turned. b in m/s^2, a in 1/kg, limit: mu N, N."""
    turned = turn_in(b, a, one_friction(limit), v)
    if turned.time == math.inf:
        return math.inf, math.inf
    rest = 1.0 / math.sqrt(turned.h * turned.h + turned.k * turned.k)
    u_h, u_k = turned.h * rest, turned.k * rest
    s_h, s_k = applied(a, limit * u_h, limit * u_k)
    rate_h, rate_k = b.h - s_h, b.k - s_k
    along, turn = u_h * rate_h + u_k * rate_k, u_h * rate_k - u_k * rate_h
    drawn = limit * across(a, u_h, u_k) + along
    time = turned.time
    if not turned.gone:
        bend, curve = turn - (u_h * s_k - u_k * s_h), u_h * s_h + u_k * s_k + along - 2.0 * drawn
        time += straight_on(along, turn, drawn, bend, curve) / rest
    return time, time - turned.straight


@kernel
def straight_on(along, turn, drawn, bend, curve):
    """T by the speed, of slip near its final direction, to the second order in the angle from it; that falls with a
    power of the speed that is left. along, turn: v' along and across v, m/s^2; drawn: by how much the second falls with
    the angle; bend, curve: first and second derivative of the first by the angle."""
    angle = -turn / drawn
    final = along - bend * angle + 0.5 * curve * angle * angle
    return (bend * angle / (final - drawn) - 1.0) / final if final < 0.0 else math.inf


@kernel
def nothing_else_ends(parameters, run, w, time):
    """Whether, until a time, s, no wheel but w is about to slip otherwise, and none comes to the end of its roller or
    turns back in the trial."""
    for v in range(len(run.mode)):
        mode, factor = run.mode[v], run.monitors[v].factor[0]
        if mode.shared or (v != w and time * factor * parameters.machine.slip_mobility > UNTURNED):
            return False
        for kind in (TURN, EXIT):
            if guard(parameters, run, Guard(kind, v, 0), True) < 0.0:
                return False
    return True
