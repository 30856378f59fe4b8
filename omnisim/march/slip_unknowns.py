"""Slip as an unknown of implicit steps, in the place of the two rates that a wheel has to itself.

Friction relaxes slip v at a rate lambda, many times within a step h: the Jacobian of the slopes by the states holds
lambda times the direction in which a contact slips, and that turns by some angle theta in the meantime. Newton's
iteration with one Jacobian for all stages then converges while theta sqrt(lambda h) < 1 alone. Friction as a function
of v does not turn. So at each stage its correction is sought in coordinates in which spin rate and roller rate of a
wheel are replaced by the slip of its contact,

    J_i = T_i J T_i^-1        T_i^-1 dy: dv in the place of these two, all others as they are

with one J, and it converges as theta does, however large lambda is.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.kinematics import slip_jacobian
from omnisim.contact.set_valued import SLIP
from omnisim.dynamics.indices import rate_place
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state

FAST = 1.0  # relaxation of slip within a step from which it is an unknown
SHIFT = 1e-6  # largest change of a state by which slip is differentiated


@kernel
def seek_slip(parameters, run, h):
    """Write to `Newton.sought` whose slip is an unknown in a step of length h: whether that of any wheel is.

    Where friction relaxes the slip of a wheel, at its only contact, faster than the step; slower, states are the better
    unknowns: their J_i differ by theta lambda h, and those of slip by theta.
    """
    some = False
    if parameters.space is None:
        for w in range(len(run.mode)):
            mode, relaxation = run.mode[w], run.monitors[w].factor[0] * parameters.machine.slip_mobility
            run.newton.sought[w] = mode.contacts == 1 and mode.grip[0] == SLIP and h * relaxation > FAST
            some = some or run.newton.sought[w]
    return some


@outlined
def to_slip(parameters, run, y, change):
    """T^-1 at the state y: replace what a change (n,) of the states is to the own rates of wheels by what it is to
    their slip, a central difference."""
    ahead, behind, at = run.newton.stages[7], run.newton.stages[8], places(parameters)
    largest = 0.0
    for m in range(at.integral):
        largest = max(largest, abs(change[m]))
    if not largest > 0.0:
        return
    step = SHIFT / largest
    for m in range(len(y)):
        ahead[m], behind[m] = y[m] + step * change[m], y[m] - step * change[m]
    body_ahead, body_behind = body_motion(parameters, ahead), body_motion(parameters, behind)
    for w in range(len(run.mode)):
        if run.newton.sought[w]:
            mode = run.mode[w]
            one = contact_state(parameters, mode, w, 0, body_ahead, ahead).slip
            other = contact_state(parameters, mode, w, 0, body_behind, behind).slip
            change[at.spin_rate + w] = (one.h - other.h) / (2.0 * step)
            change[rate_place(parameters, mode, w, 0)] = (one.k - other.k) / (2.0 * step)


@outlined
def add_to_stage(parameters, run, increment, change):
    """Add a change (n,) of such unknowns to the increment (n,) of a stage; afterwards `change` is that of the states.

    Slip is linear in the own rates of a wheel at any place: they are found such that it changes as it should, though
    the place may change by far.
    """
    y, state, at = run.y, run.trial, places(parameters)
    for m in range(len(y)):
        state[m] = y[m] + increment[m]
    body = body_motion(parameters, state)
    for w in range(len(run.mode)):
        if run.newton.sought[w]:
            slip = contact_state(parameters, run.mode[w], w, 0, body, state).slip
            change[at.spin_rate + w] += slip.h
            change[rate_place(parameters, run.mode[w], w, 0)] += slip.k
    for m in range(len(y)):
        state[m] += change[m]
    body = body_motion(parameters, state)
    for w in range(len(run.mode)):
        if run.newton.sought[w]:
            spin, roller = at.spin_rate + w, rate_place(parameters, run.mode[w], w, 0)
            h, k = change[spin], change[roller]
            state[spin], state[roller] = y[spin] + increment[spin], y[roller] + increment[roller]
            found = contact_state(parameters, run.mode[w], w, 0, body, state)
            j = slip_jacobian(parameters.wheels[w], found.axis, found.contact)
            h, k = h - found.slip.h, k - found.slip.k
            determinant = j.spin_h * j.roller_k - j.spin_k * j.roller_h
            change[spin] = (h * j.roller_k - k * j.roller_h) / determinant
            change[roller] = (k * j.spin_h - h * j.spin_k) / determinant
    for m in range(len(y)):
        increment[m] += change[m]
