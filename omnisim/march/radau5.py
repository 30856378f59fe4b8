"""One step of the Radau IIA method of order 5 with a frozen mode, for scenes whose slip relaxes faster than a step.

The increments Z of the three stages solve Z = h A f(y + Z). Simplified Newton iteration, as in Hairer & Wanner, Solving
Ordinary Differential Equations II (1996), section IV.8: with A^-1 = V diag(lambda) V^-1 the 3n equations fall into one
real and one complex system of n,

    (lambda / h - J) dw = V^-1 (f(y + Z) - A^-1 Z / h)        w = V^-1 Z

J couples the states `Newton.active` alone, those that forces depend on, without those that are idle; the others follow
by quadrature. In the place of the own rates of wheels that slip it is their slip that is sought (slip_unknowns.py).
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.state import Stage, places
from omnisim.march.runge_kutta import evaluate
from omnisim.march.slip_unknowns import add_to_stage, seek_slip, to_slip

MOST_ITERATIONS = 25
TOLERANCE = 4e-15  # change of the stages, relative to 1 + |y|, below which nothing is left to gain
FLOOR = 1e-10  # change below which an iteration that no longer converges is at its rounding
FALLING = 0.5  # of the change before: a change at its rounding that is more no longer falls
STALLED = 0.9  # the same of an iteration that gets nowhere and is given up, after
FIRST_ITERATIONS = 2  # which may still grow
STEEP = 1e-3  # of the slip over which friction changes, by which states are shifted for the Jacobian
LEAST_SHIFT, MOST_SHIFT = (
    1e-11,
    1e-7,
)  # rad, m/s, rad/s: of these shifts; less is lost in rounding, more is no derivative


@outlined
def implicit_step(parameters, method, run, t, h):
    """One step of length h from run.y into run.trial, with the derivative and `monitors` at its end.

    Whether the iteration converged; if not, the trial means nothing and a shorter step is to be taken.
    """
    radau = method.radau
    newton = run.newton
    mode = run.mode
    piece = run.clock.piece
    n = len(run.y)
    y = run.y
    z = newton.stages[:3]
    slopes = newton.stages[3:6]
    active = newton.busy[: gather(parameters, run)]
    converged = h == 0.0
    for i in range(3):
        for m in range(n):
            z[i, m] = 0.0
    seeks = seek_slip(parameters, run, h)
    if not converged:
        differentiate(parameters, run, t, active, seeks)
        factorize_all(radau, newton, h, len(active))
    last = math.inf
    for iteration in range(MOST_ITERATIONS):
        if converged:
            break
        for i in range(3):
            at_stage(run, z[i])
            evaluate(parameters, Stage(mode, piece, t + radau.c[i] * h, run.trial, slopes[i], run.monitors_end, True))
        run.clock.rhs += 3
        change = correct(parameters, radau, run, h, active, seeks)
        if not math.isfinite(change):
            return False
        converged = change <= TOLERANCE or (change <= FLOOR and change > FALLING * last)
        if not converged and iteration > FIRST_ITERATIONS and change > STALLED * last:
            return False
        last = change
    for m in range(n):
        run.increment[m] = run.carry[m] + z[2, m]
        run.trial[m] = y[m] + run.increment[m]
    evaluate(parameters, Stage(mode, piece, t + h, run.trial, run.slopes[-1], run.monitors_end, True))
    run.clock.rhs += 1
    return converged


@kernel
def gather(parameters, run):
    """Write the active states that are not idle to `Newton.busy`: how many."""
    newton = run.newton
    count = 0
    for m in newton.active:
        if not idle(parameters, run, m):
            newton.busy[count] = m
            count += 1
    return count


@kernel
def differentiate(parameters, run, t, active, seeks):
    """Forward differences of the active slopes at the start of the step; `seeks`: slip is an unknown.

    Friction changes over a slip of |v| + slip_speed: the shifts stay far below it, as far as rounding allows.
    """
    newton = run.newton
    speed = 1.0
    shifted, along, change = newton.stages[6], newton.stages[3], newton.stages[4]
    jacobian = newton.real[: len(active)]
    for w in range(len(run.monitors)):
        for side in range(contact_count(run.mode[w])):
            speed = min(speed, math.sqrt(run.monitors[w].slip_square[side]) + parameters.machine.slip_floor)
    shift = min(max(STEEP * speed, LEAST_SHIFT), MOST_SHIFT)
    for j in range(len(active)):
        for m in range(len(along)):
            along[m] = 0.0
            change[m] = 0.0
        change[active[j]] = shift
        add(parameters, run, along, change, seeks)
        at_stage(run, along)
        evaluate(parameters, Stage(run.mode, run.clock.piece, t, run.trial, shifted, run.monitors_end, True))
        for m in range(len(along)):
            shifted[m] = (shifted[m] - run.slopes[0, m]) / shift
        if parameters.space is None and seeks:
            to_slip(parameters, run, run.y, shifted)
        for i in range(len(active)):
            jacobian[i, j] = shifted[active[i]]
    run.clock.rhs += len(active)


@kernel
def idle(parameters, run, m):
    """Whether nothing depends on a state: the slot of a roller rate that no roller uses."""
    if parameters.space is None or parameters.machine.every_rate:
        return False
    place = m - places(parameters).roller_rate
    if place < 0 or place >= parameters.machine.slots * len(run.mode):
        return False
    return place % parameters.machine.slots >= run.mode[place // parameters.machine.slots].rollers


@kernel
def factorize_all(radau, newton, h, k):
    """LU factors of lambda / h - J for the real and the complex eigenvalue, of k states."""
    jacobian = newton.real[:k]
    real = newton.real[k : 2 * k]
    cplx = newton.complex[:k]
    for i in range(k):
        for j in range(k):
            real[i, j] = -jacobian[i, j]
            cplx[i, j] = -jacobian[i, j]
        real[i, i] += radau.real_value / h
        cplx[i, i] += radau.complex_value / h
    factorize(real, newton.pivots[0, :k])
    factorize(cplx, newton.pivots[1, :k])


@kernel
def correct(parameters, radau, run, h, active, seeks):
    """One Newton correction of the increments z: its largest entry relative to 1 + |y|; `seeks`: slip is an unknown."""
    newton, y = run.newton, run.y
    z, slopes = newton.stages[:3], newton.stages[3:6]
    k = len(active)
    real_side, complex_side = newton.real[2 * k], newton.complex[k]
    for i in range(3):
        for m in range(len(y)):
            lacking = slopes[i, m]
            for j in range(3):
                lacking -= radau.inverse[i, j] / h * z[j, m]
            slopes[i, m] = lacking
        if parameters.space is None and seeks:
            at_stage(run, z[i])
            to_slip(parameters, run, run.trial, slopes[i])
    a = 0
    for m in range(len(y)):
        real, cplx = 0.0, 0.0j
        for i in range(3):
            real += radau.real_left[i] * slopes[i, m]
            cplx += radau.complex_left[i] * slopes[i, m]
        if a < k and active[a] == m:
            real_side[a], complex_side[a] = real, cplx
            a += 1
        else:
            spread(radau, slopes, m, real * h / radau.real_value, cplx * h / radau.complex_value)
    substitute(newton.real[k : 2 * k], newton.pivots[0, :k], real_side)
    substitute(newton.complex[:k], newton.pivots[1, :k], complex_side)
    for a in range(k):
        spread(radau, slopes, active[a], real_side[a], complex_side[a])
    largest = 0.0
    for i in range(3):
        add(parameters, run, z[i], slopes[i], seeks)
        for m in range(len(y)):
            size = abs(slopes[i, m]) / (1.0 + abs(y[m]))
            if not size <= largest:  # a NaN must not hide
                largest = size
    return largest


@kernel
def add(parameters, run, increment, change, seeks):
    """Add a change (n,) of the unknowns to the increment (n,) of a stage; `seeks`: slip is one of them."""
    if parameters.space is None and seeks:
        add_to_stage(parameters, run, increment, change)
    else:
        for m in range(len(increment)):
            increment[m] += change[m]


@kernel
def at_stage(run, increment):
    """The state at a stage of these increments into the trial."""
    for m in range(len(increment)):
        run.trial[m] = run.y[m] + increment[m]


@kernel
def spread(radau, corrections, m, real, cplx):
    """What a correction of state m in eigenvectors is at the stages."""
    for i in range(3):
        corrections[i, m] = radau.real_right[i] * real + 2.0 * (radau.complex_right[i] * cplx).real


@kernel
def factorize(matrix, pivots):
    """LU factors in place with partial pivoting; pivots[k] is the row that came to k."""
    n = len(pivots)
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[p, k]):
                p = i
        pivots[k] = p
        for j in range(n):
            matrix[k, j], matrix[p, j] = matrix[p, j], matrix[k, j]
        for i in range(k + 1, n):
            matrix[i, k] /= matrix[k, k]
            for j in range(k + 1, n):
                matrix[i, j] -= matrix[i, k] * matrix[k, j]


@kernel
def substitute(matrix, pivots, side):
    """Solve with the factors: `side` becomes the solution."""
    n = len(pivots)
    for k in range(n):
        p = pivots[k]
        side[k], side[p] = side[p], side[k]
    for k in range(n):
        for i in range(k + 1, n):
            side[i] -= matrix[i, k] * side[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            side[k] -= matrix[k, j] * side[j]
        side[k] /= matrix[k, k]
