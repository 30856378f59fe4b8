"""The direction of creeping slip, and how it turns.

Friction turns slow slip at the rate mu N A / |v|, faster than anything else moves: to follow that would take ever
shorter steps. So an explicit step takes the direction u at each of its stages from the contact equation, in which the
rate omega = u' . n at which u itself turns stands with the small factor |v|. It is that of the polynomial through the
directions at the stages so far and at this one: with c_i their nodes, theta the angle from the direction at the start,
and p the polynomial without this stage,

    h omega(c) = p'(c) + (theta - p(c)) sum 1 / (c - c_i)

which damps what the direction at the start is away from that of the contact equation, for every step and method. The
step begins with the direction of the slip itself and, unless forces have jumped since, with the rate at which it turned
at the end of the step before. What slip then has across u at the end is taken away by an impulse across it, as friction
would have done (impulses.py).
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import angle_of
from omnisim.contact.frame import Slip
from omnisim.contact.set_valued import CREEP
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.spatial.records import SLOTS

CREEP_SPEED = 1e-7  # m/s: slip that has no direction of its own in any case
HELD = 1e30  # 1/s: by the angle from where a direction began, holds it there


@kernel
def turning_of(parameters, w, side):
    """The record, with the fields TURNING, of how creeping slip turns at a contact of wheel w."""
    if parameters.space is not None:
        return parameters.space.touches[w * SLOTS + side]
    return parameters.workspace.contacts[parameters.wheels[w].contacts + side]


@kernel
def creep_of(parameters, w, side):
    """Direction of creeping slip at a contact of wheel w as the last right-hand side found it (Slip)."""
    creep = turning_of(parameters, w, side).creep
    return Slip(creep[0], creep[1])


@kernel
def creeping(mode, side):
    """Whether slip creeps at a contact in a direction that turns: not while two rollers share the load of a wheel."""
    return mode.grip[side] == CREEP and not mode.shared


@kernel
def keep_creep(parameters, run, w, side):
    """Remember the direction of creeping slip that the last right-hand side found."""
    mode = run.mode[w]
    creep = creep_of(parameters, w, side)
    mode.creep[side, 0], mode.creep[side, 1] = creep.h, creep.k


@kernel
def keep_young(parameters, run):
    """Slip that has no direction of its own yet begins in that which all forces of this instant give it."""
    if parameters.workspace.resting is not None:
        for w in range(len(run.mode)):
            for side in range(contact_count(run.mode[w])):
                young = run.monitors[w].slip_square[side] < CREEP_SPEED**2
                if creeping(run.mode[w], side) and young:
                    keep_creep(parameters, run, w, side)


@kernel
def search_anew(workspace):
    """Let the next search for directions begin with those of the modes: a state alone, not what was evaluated before
    it, tells its forces to the last bit."""
    for contact in workspace.contacts:
        contact.creep[0] = contact.creep[1] = 0.0


@kernel
def hold_direction(run, w, side, slip):
    """Let a creeping contact of this slip (2,) keep its direction until a step turns it; young slip, and that of
    implicit steps, has that from rest."""
    young = slip[0] * slip[0] + slip[1] * slip[1] < CREEP_SPEED * CREEP_SPEED
    veer = run.mode[w].veer[side]
    veer[0], veer[1] = 0.0, 0.0 if young or run.newton is not None else HELD


@kernel
def any_creeps(run):
    """Whether slip creeps at any contact in a direction that turns."""
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                return True
    return False


@outlined
def begin_turning(parameters, run, c, h):
    """Begin a step h in the directions that creeping slips have; its first stage is at the part c of it."""
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            if creeping(mode, side):
                course = turning_of(parameters, w, side)
                course.nodes = 1
                course.node[0] = course.angle[0] = course.difference[0] = 0.0
                if mode.foreseen[side]:
                    course.nodes = 2
                    course.node[1] = course.angle[1] = 0.0
                    course.difference[1] = mode.veering[side] * h
    foresee_turning(parameters, run, c, h)


@outlined
def go_on_turning(parameters, run, c, following, h):
    """The right-hand side has found the directions at the part c of a step h; the next stage is at the part
    `following`."""
    see_turning(parameters, run, c)
    foresee_turning(parameters, run, following, h)


@kernel
def foresee_turning(parameters, run, c, h):
    """At which rate the directions of creeping slips turn at the part c of a step h, by the directions there."""
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                course, veer = turning_of(parameters, w, side), run.mode[w].veer[side]
                if course.node[course.nodes - 1] == c:  # two stages at one time: the later one knows better
                    course.nodes -= 1
                value, slope, product, change = 0.0, 0.0, 1.0, 0.0
                for i in range(course.nodes):
                    value, slope = value + course.difference[i] * product, slope + course.difference[i] * change
                    change, product = change * (c - course.node[i]) + product, product * (c - course.node[i])
                veer[1] = change / (product * h)
                veer[0] = slope / h - value * veer[1]


@kernel
def see_turning(parameters, run, c):
    """Enter the directions that the right-hand side found there."""
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                course = turning_of(parameters, w, side)
                angle = turned_by(run.mode[w].creep[side], course.creep)
                value, product = 0.0, 1.0
                for i in range(course.nodes):
                    value, product = value + course.difference[i] * product, product * (c - course.node[i])
                course.node[course.nodes] = c
                course.angle[course.nodes] = angle
                course.missed = angle - value
                course.difference[course.nodes] = course.missed / product
                course.nodes += 1


@outlined
def end_turning(parameters, run, h):
    """Keep at which rate the directions turn at the end of a step h, by their last stages, and hold them there."""
    see_turning(parameters, run, 1.0)
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            if creeping(run.mode[w], side):
                course = turning_of(parameters, w, side)
                n = course.nodes - 1
                node, angle = course.node, course.angle
                rate = (angle[n] - angle[n - 1]) / (node[n] - node[n - 1])
                if n > 1 and node[n - 1] > node[n - 2]:
                    before = (angle[n - 1] - angle[n - 2]) / (node[n - 1] - node[n - 2])
                    rate += (rate - before) * (node[n] - node[n - 1]) / (node[n] - node[n - 2])
                course.veering = rate / h
                hold_direction(run, w, side, course.slip)


@kernel
def keep_turning(parameters, run, h):
    """Remember the rates at which creeping slips turned at the end of a step h, and for how long friction has drawn
    others towards the direction of the contact equation; or away from it: then that begins anew."""
    for w in range(len(run.mode)):
        mode = run.mode[w]
        for side in range(contact_count(mode)):
            mode.foreseen[side] = creeping(mode, side)
            if mode.foreseen[side]:
                mode.veering[side] = turning_of(parameters, w, side).veering
            pull = mode.pull[side]
            mode.settled[side] = mode.settled[side] + h * pull if pull >= 0.0 else 0.0
            mode.strayed[side] *= math.exp(-h * pull) if pull >= 0.0 else 0.0


@kernel
def forget_turning(parameters, run):
    """Forces have jumped: nothing tells any more how creeping slips turn."""
    for w in range(len(run.mode)):
        for side in range(contact_count(run.mode[w])):
            run.mode[w].foreseen[side] = 0
            run.mode[w].settled[side] = run.mode[w].strayed[side] = 0.0
        if parameters.space is None:
            run.mode[w].seen[3] = -1.0


@kernel
def turned_by(first, then):
    """Angle from one unit vector to another, rad."""
    return angle_of(first[0] * then[0] + first[1] * then[1], first[0] * then[1] - first[1] * then[0])
