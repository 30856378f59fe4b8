"""One step of the Radau IIA method of order 5 with a frozen mode, for scenes whose slip relaxes faster than a step.

The increments Z of the three stages solve Z = h A f(y + Z). Simplified Newton iteration, as in Hairer & Wanner, Solving
Ordinary Differential Equations II (1996), section IV.8: with A^-1 = V diag(lambda) V^-1 the 3n equations fall into one
real and one complex system of n,

    (lambda / h - J) dw = V^-1 f(y + Z) - lambda / h w        w = V^-1 Z

J couples the states `Newton.active` alone, those that forces depend on, without those that are idle; the others follow
by quadrature.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.state import places
from omnisim.march.runge_kutta import copy, evaluate

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
    if not converged:
        differentiate(parameters, run, t, active)
        factorize_all(radau, newton, h, len(active))
    last = math.inf
    for iteration in range(MOST_ITERATIONS):
        if converged:
            break
        for i in range(3):
            for m in range(n):
                run.trial[m] = y[m] + z[i, m]
            evaluate(parameters, mode, piece, t + radau.c[i] * h, run.trial, slopes[i], run.monitors_end)
        run.clock.rhs += 3
        change = correct(radau, newton, y, h, active)
        if not math.isfinite(change):
            return False
        converged = change <= TOLERANCE or (change <= FLOOR and change > FALLING * last)
        if not converged and iteration > FIRST_ITERATIONS and change > STALLED * last:
            return False
        last = change
    for m in range(n):
        run.increment[m] = run.carry[m] + z[2, m]
        run.trial[m] = y[m] + run.increment[m]
    evaluate(parameters, mode, piece, t + h, run.trial, run.slopes[-1], run.monitors_end)
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
def differentiate(parameters, run, t, active):
    """Forward differences of the active slopes at the start of the step.

    Friction changes over a slip of |v| + slip_speed: the shifts stay far below it, as far as rounding allows.
    """
    newton = run.newton
    speed = 1.0
    shifted = newton.stages[6]
    jacobian = newton.real[: len(active)]
    for w in range(len(run.monitors)):
        for side in range(contact_count(run.mode[w])):
            speed = min(speed, math.sqrt(run.monitors[w].slip_square[side]) + parameters.machine.slip_floor)
    shift = min(max(STEEP * speed, LEAST_SHIFT), MOST_SHIFT)
    copy(run.y, run.trial)
    for j in range(len(active)):
        m = active[j]
        run.trial[m] = run.y[m] + shift
        taken = run.trial[m] - run.y[m]
        evaluate(parameters, run.mode, run.clock.piece, t, run.trial, shifted, run.monitors_end)
        run.trial[m] = run.y[m]
        for i in range(len(active)):
            row = active[i]
            jacobian[i, j] = (shifted[row] - run.slopes[0, row]) / taken
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
def correct(radau, newton, y, h, active):
    """One Newton correction of the increments z: its largest entry relative to 1 + |y|."""
    z = newton.stages[:3]
    slopes = newton.stages[3:6]
    k = len(active)
    real_side = newton.real[2 * k]
    complex_side = newton.complex[k]
    largest, a = 0.0, 0
    for m in range(len(y)):
        real, cplx = 0.0, 0.0j
        for i in range(3):
            real += radau.real_left[i] * (slopes[i, m] - radau.real_value / h * z[i, m])
            cplx += radau.complex_left[i] * (slopes[i, m] - radau.complex_value / h * z[i, m])
        if a < k and active[a] == m:
            real_side[a], complex_side[a] = real, cplx
            a += 1
        else:
            largest = max(largest, change(radau, z, m, real * h / radau.real_value, cplx * h / radau.complex_value, y))
    substitute(newton.real[k : 2 * k], newton.pivots[0, :k], real_side)
    substitute(newton.complex[:k], newton.pivots[1, :k], complex_side)
    for a in range(k):
        size = change(radau, z, active[a], real_side[a], complex_side[a], y)
        if not size <= largest:  # a NaN must not hide
            largest = size
    return largest


@kernel
def change(radau, z, m, real, cplx, y):
    """Add a correction in eigenvectors to the increments of state m: its largest entry relative to 1 + |y|."""
    largest = 0.0
    for i in range(3):
        correction = radau.real_right[i] * real + 2.0 * (radau.complex_right[i] * cplx).real
        z[i, m] += correction
        if not abs(correction) <= largest:
            largest = abs(correction)
    return largest / (1.0 + abs(y[m]))


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
