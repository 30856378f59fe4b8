"""One explicit Runge-Kutta step with a frozen mode, the tableau as data."""

from omnisim.dynamics import rhs
from omnisim.kernel import kernel, outlined


@kernel
def explicit_step(parameters, method, run, t, h):
    """One Runge-Kutta step of length h from run.y into run.trial, with the derivative and `watch` at its end."""
    a, b, c = method.a, method.b, method.c
    y, trial, stage, slopes = run.y, run.trial, run.stage, run.slopes
    stages = len(b)
    for i in range(1, stages + 1):
        if i < stages:
            point, time = stage, t + c[i] * h
            combine(y, h, a[i], i, slopes, stage)
        else:
            point, time = trial, t + h
            combine(run.carry, h, b, stages, slopes, run.increment)
            for m in range(len(y)):
                trial[m] = y[m] + run.increment[m]
        rhs(parameters, run.mode, run.clock.piece, time, point, slopes[i], run.watch_end)
    run.clock.rhs += stages


@kernel
def combine(y, h, weights, count, slopes, out):
    """out = y + h (weights . slopes) over the first `count` slopes; the sum first, so y is rounded once."""
    for m in range(len(y)):
        out[m] = weights[0] * slopes[0, m]
    for j in range(1, count):
        if weights[j] != 0.0:
            for m in range(len(y)):
                out[m] += weights[j] * slopes[j, m]
    for m in range(len(y)):
        out[m] = y[m] + h * out[m]


@kernel
def accept(run):
    """The trial becomes the state, and its derivative the first stage of the next step.

    What was lost in rounding y + increment is carried into the next increment (Kahan), so millions of steps add up to
    the rounding of one.
    """
    for m in range(len(run.y)):
        run.carry[m] = run.increment[m] - (run.trial[m] - run.y[m])
    copy(run.trial, run.y)
    copy(run.slopes[-1], run.slopes[0])
    for w in range(len(run.watch)):
        run.watch[w] = run.watch_end[w]


@outlined
def evaluate(parameters, mode, piece, t, y, dy, watch):
    """The right-hand side, compiled once for all its uses but the stages of explicit steps."""
    rhs(parameters, mode, piece, t, y, dy, watch)


@kernel
def refresh(parameters, run, t):
    """Derivative at the state itself, after the mode has changed."""
    evaluate(parameters, run.mode, run.clock.piece, t, run.y, run.slopes[0], run.watch)
    run.clock.rhs += 1


@kernel
def copy(source, target):
    for m in range(len(source)):
        target[m] = source[m]
