"""The direction of creeping slip, and how it turns.

Friction turns slow slip at the rate mu N A / |v|, faster than anything else moves: the slip has the direction u(t) of
the contact equation. Where u turns at the rate omega, slip lags behind the direction from rest, and the next derivative
along the motion tells omega without any of the sub-steps that would follow the turning itself. What the error of omega
leaves of slip across u after a step is taken away by an impulse across it, as friction would have done (impulses.py).
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Slip
from omnisim.contact.set_valued import CREEP
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.march.runge_kutta import evaluate, refresh

NEVER = -1.0  # s: when it has not been found yet how the direction turns
MOMENT = 1 / 32  # of a step, after which that is seen
ROUNDS = 2  # in which it is found where nothing was known of it


@kernel
def creep_of(parameters, w, side):
    """Direction of creeping slip at a contact of wheel w as the last right-hand side found it (Slip)."""
    if parameters.space is not None:
        touch = parameters.space.touches[w * SLOTS + side]
        return Slip(touch.creep[0], touch.creep[1])
    contact = parameters.workspace.contacts[parameters.wheels[w].contacts + side]
    return Slip(contact.creep[0], contact.creep[1])


@kernel
def keep_creep(parameters, run, w, side):
    """Remember the direction of creeping slip that the last right-hand side found."""
    mode = run.mode[w]
    creep = creep_of(parameters, w, side)
    mode.creep[side, 0], mode.creep[side, 1] = creep.h, creep.k


@kernel
def keep_all(parameters, run):
    """The same of all wheels that creep on one roller."""
    for w in range(len(run.mode)):
        if veers(run.mode[w]):
            keep_creep(parameters, run, w, 0)


@kernel
def begin_veering(mode, rate):
    """The direction in which a wheel creeps turns at about this rate, rad/s."""
    mode.veer[0], mode.veer[1], mode.veer[2] = rate, 0.0, NEVER


@kernel
def forget_veering(run, t):
    """Forces have jumped at the time t: nothing tells any more how the rates change at which creeping slips turn."""
    for w in range(len(run.mode)):
        veer = run.mode[w].veer
        if veer[2] != NEVER:
            veer[0] += veer[1] * (t - veer[2])
        veer[1], veer[2] = 0.0, NEVER


@kernel
def veers(mode):
    """Whether a wheel creeps on its one roller, in a direction that turns."""
    return mode.grip[0] == CREEP and not mode.shared


@outlined
def foresee_veering(parameters, run, t, h):
    """Find at which rates the directions of creeping slips turn at the start of a step h: by a derivative a moment
    later. Each depends on the rate itself, by as much as slip changes while friction turns it, and is found in rounds.
    """
    some, fresh, moment = False, False, MOMENT * h
    for w in range(len(run.mode)):
        if veers(run.mode[w]):
            some, fresh = True, fresh or run.mode[w].veer[2] == NEVER
    if not some or t + moment == t:
        return
    for _ in range(ROUNDS if fresh else 1):
        if fresh:
            refresh(parameters, run, t)
            keep_all(parameters, run)
        for m in range(len(run.y)):
            run.trial[m] = run.y[m] + moment * run.slopes[0, m]
        evaluate(parameters, run.mode, run.clock.piece, t + moment, run.trial, run.slopes[1], run.monitors_end)
        run.clock.rhs += 1
        for w in range(len(run.mode)):
            mode = run.mode[w]
            if veers(mode):
                u, later, veer = mode.creep[0], creep_of(parameters, w, 0), mode.veer
                rate = math.atan2(u[0] * later.k - u[1] * later.h, u[0] * later.h + u[1] * later.k) / moment
                veer[1] = (rate - veer[0]) / (t - veer[2]) if not fresh and t > veer[2] else 0.0
                veer[0], veer[2] = rate, t
