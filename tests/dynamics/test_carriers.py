"""The factors of symmetric positive definite equations, against LAPACK's."""

import numpy as np
import pytest

from omnisim.dynamics.spatial.carriers import factorize, substitute


def equations(rank: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Of size equations of this rank, within larger arrays whose rest must stay."""
    random = np.random.default_rng(100 * rank + size)
    levers = random.normal(size=(rank, size))
    matrix, side = random.normal(size=(12, 12)), random.normal(size=12)
    matrix[:size, :size] = levers.T @ levers
    return matrix, side


@pytest.mark.parametrize("size", range(1, 11))
def test_factors_solve_the_equations_and_tell_the_least_pivot(size):
    matrix, side = equations(size + 3, size)
    factors, found = matrix.copy(), side.copy()
    least = factorize(factors, size)
    substitute(factors, size, found)
    left = np.abs(matrix[:size, :size] @ found[:size] - side[:size]).max()
    assert left < 1e-13 * np.abs(found).max()  # measured: 3e-15
    pivots = np.diag(np.linalg.cholesky(matrix[:size, :size])) ** 2
    assert least == pytest.approx(pivots.min(), rel=1e-13)  # measured: 4e-15
    assert np.all(found[size:] == side[size:])
    assert np.all(factors[size:] == matrix[size:]) and np.all(factors[:size, size:] == matrix[:size, size:])


@pytest.mark.parametrize("size", range(2, 11))
def test_the_least_pivot_tells_of_equations_that_have_no_inverse(size):
    matrix, _ = equations(size - 1, size)
    assert abs(factorize(matrix, size)) < 1e-10  # measured: 6e-12
