"""A trial step: from the state into the trial, and its end moved along the cubic that has the states and derivatives
at both ends."""

from omnisim.base.kernel import kernel, outlined
from omnisim.dynamics.indices import contact_count
from omnisim.march.creeping import creep_of, creeping
from omnisim.march.radau5 import implicit_step
from omnisim.march.runge_kutta import explicit_step
from omnisim.march.slip import slip_of

REACH = 0.02  # of a step, by which its end may be moved along a cubic; of an implicit one, whose states may have
IMPLICIT_REACH = 1e-6  # changed much faster than any cubic does, so little that its square is lost in rounding


@kernel
def advance(parameters, method, run, t, h):
    """One step of length h from run.y into run.trial, explicit or implicit as the clock says."""
    clock = run.clock
    if run.newton is not None and clock.implicit:
        clock.converged = implicit_step(parameters, method, run, t, h)
    else:
        clock.converged = True
        explicit_step(parameters, method, run, t, h)


@outlined
def advance_again(parameters, method, run, t, h):
    """The same, compiled once for all uses but the first trial of a step."""
    advance(parameters, method, run, t, h)


@kernel
def reach(clock):
    return IMPLICIT_REACH if clock.implicit else REACH


@kernel
def cubic(h, x):
    """How much of the increment of a step h and of the derivatives at both its ends the increment at a part x of it has
    on the cubic: whole, first, last."""
    y = 1.0 - x
    return x * x * (1.0 + 2.0 * y), h * x * y * y, -h * x * x * y


@kernel
def slide(parameters, run, h, time):
    """Move the end of the trial step h on by a time, s, along the cubic that has the states and derivatives at both
    ends. The derivative and what depends on it stay behind, for the event to find anew; creeping slip does not."""
    whole, first, last = cubic(h, 1.0 + time / h)
    for m in range(len(run.trial)):
        run.increment[m] = whole * run.increment[m] + (first * run.slopes[0, m] + last * run.slopes[-1, m])
        run.trial[m] = run.y[m] + run.increment[m]
    if parameters.workspace.resting is not None:
        for w in range(len(run.mode)):
            mode, monitors = run.mode[w], run.monitors_end[w]
            for side in range(contact_count(mode)):
                if creeping(mode, side):
                    slip, creep = slip_of(parameters, mode, w, side, run.trial), creep_of(parameters, w, side)
                    monitors.slip_square[side] = slip.h * slip.h + slip.k * slip.k
                    monitors.margin[side] = slip.h * creep.h + slip.k * creep.k
