"""One explicit Runge-Kutta step with a frozen mode, the tableau as data."""

from omnisim.base.kernel import kernel, outlined
from omnisim.dynamics.multibody.joint_kinematics import project_bodies
from omnisim.dynamics.right_hand_side import rhs
from omnisim.dynamics.state import Stage
from omnisim.march.creeping import any_creeps, begin_turning, end_turning, go_on_turning


@kernel
def explicit_step(parameters, method, run, t, h):
    """One Runge-Kutta step of length h from run.y into run.trial, with the derivative and `monitors` at its end."""
    a, b, c, first = method.a, method.b, method.c, method.first
    y, trial, slopes, carry, increment = run.y, run.trial, run.slopes, run.carry, run.increment
    stages, turning = len(b), False
    if parameters.workspace.resting is not None and run.newton is None:
        turning = h > 0.0 and any_creeps(run)
        if turning:
            begin_turning(parameters, run, c[1], h)
    for i in range(1, stages + 1):
        last = i == stages
        if not last:
            part = c[i]
            if first[i] == i - 1:
                for m in range(len(y)):
                    trial[m] = y[m] + h * (a[i, i - 1] * slopes[i - 1, m])
            else:
                lead(a[i], first[i], i, slopes, trial)
                for m in range(len(y)):
                    rate = trial[m] + (a[i, i - 2] * slopes[i - 2, m] + a[i, i - 1] * slopes[i - 1, m])
                    trial[m] = y[m] + h * rate
        else:
            part = 1.0
            lead(b, 0, stages, slopes, increment)
            for m in range(len(y)):
                rate = increment[m] + (b[i - 2] * slopes[i - 2, m] + b[i - 1] * slopes[i - 1, m])
                increment[m] = carry[m] + h * rate
                trial[m] = y[m] + increment[m]
        rhs(parameters, Stage(run.mode, run.clock.piece, t + part * h, trial, slopes[i], run.monitors_end, last))
        if parameters.workspace.resting is not None and run.newton is None and turning:
            if last:
                end_turning(parameters, run, h)
            else:
                go_on_turning(parameters, run, part, c[i + 1] if i + 1 < stages else 1.0, h)
    run.clock.rhs += stages


@kernel
def lead(weights, first, count, slopes, out):
    """Weighted sum of the slopes from `first` on, without the last two of `count`.

    Two at a time: a pass over a state of a dozen numbers takes as long as the arithmetic in it.
    """
    j = first + (count - first) % 2
    if j > first:
        for m in range(len(out)):
            out[m] = weights[first] * slopes[first, m]
    elif j < count - 2:
        for m in range(len(out)):
            out[m] = weights[j] * slopes[j, m] + weights[j + 1] * slopes[j + 1, m]
        j += 2
    else:
        for m in range(len(out)):
            out[m] = 0.0
    while j < count - 2:
        for m in range(len(out)):
            out[m] += weights[j] * slopes[j, m] + weights[j + 1] * slopes[j + 1, m]
        j += 2


@kernel
def accept(run):
    """The trial becomes the state, and its derivative the first stage of the next step.

    What was lost in rounding y + increment is carried into the next increment (Kahan), so millions of steps add up to
    the rounding of one.
    """
    y, trial, increment, carry, slopes = run.y, run.trial, run.increment, run.carry, run.slopes
    for m in range(len(y)):
        carry[m] = increment[m] - (trial[m] - y[m])
        y[m] = trial[m]
        slopes[0, m] = slopes[-1, m]
    for w in range(len(run.monitors)):
        run.monitors[w] = run.monitors_end[w]


@outlined
def evaluate(parameters, stage):
    """The right-hand side, compiled once for all its uses but the stages of explicit steps."""
    rhs(parameters, stage)


@kernel
def refresh(parameters, run, t):
    """Derivative at the state itself, after the mode or the state have changed; bodies follow."""
    run.clock.smooth = 0.0
    if parameters.workspace.articulated is not None:
        project_bodies(parameters, run, False)
    evaluate(parameters, Stage(run.mode, run.clock.piece, t, run.y, run.slopes[0], run.monitors, True))
    run.clock.rhs += 1


@kernel
def copy(source, target):
    for m in range(len(source)):
        target[m] = source[m]
