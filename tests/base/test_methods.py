"""Runge-Kutta methods as data."""

import math
from fractions import Fraction

import numpy as np
import pytest

from omnisim.base.methods import BETWEEN, TABLEAUX, density, elementary_weights, rooted_trees, tableau

pytestmark = pytest.mark.short


@pytest.mark.parametrize("method", TABLEAUX.values(), ids=TABLEAUX)
def test_the_amplification_is_the_exponential_up_to_the_order_and_not_beyond(method):
    z = 0.01
    error = method.amplification(z) - math.exp(z)
    leading = z ** (method.order + 1) / math.factorial(method.order + 1)
    assert abs(error) < 2.0 * leading
    assert abs(error) > 0.1 * leading or method.stages > method.order  # more stages may do better on linear problems


def test_the_stability_limits_are_the_known_ones():
    assert TABLEAUX["heun"].stability_limit == pytest.approx(2.0, abs=1e-9)
    assert TABLEAUX["rk4"].stability_limit == pytest.approx(2.785293563405282, abs=1e-9)
    assert TABLEAUX["dopri5"].stability_limit == pytest.approx(3.306567892634, abs=1e-9)
    assert TABLEAUX["bs5"].stability_limit == pytest.approx(3.987927198726, abs=1e-9)


def test_by_one_stage_more_the_terms_beyond_the_order_are_a_tenth():
    def beyond(method):
        a = [[Fraction(entry) for entry in row] for row in method.a.tolist()]
        factors = elementary_weights(6, a)
        errors = [method.b @ np.array(factors[tree], float) - 1 / density(tree) for tree in rooted_trees(6)]
        return np.linalg.norm(errors)

    assert beyond(TABLEAUX["bs5"]) < 0.11 * beyond(TABLEAUX["dopri5"])  # measured 5.2e-5 by 5.0e-4


def test_there_are_as_many_rooted_trees_as_cayley_counted():
    assert [len(rooted_trees(nodes)) for nodes in range(1, 8)] == [1, 1, 2, 4, 9, 20, 48]


def test_a_mistyped_coefficient_cannot_be_imported():
    with pytest.raises(AssertionError, match="order condition"):
        tableau("typo", 4, [[], ["1/2"], ["0", "1/2"], ["0", "0", "1"]], ["1/6", "1/3", "1/3", "1/5"])
    with pytest.raises(AssertionError, match="order condition"):
        tableau("too proud", 5, [[], ["1/2"], ["0", "1/2"], ["0", "0", "1"]], ["1/6", "1/3", "1/3", "1/6"])
    with pytest.raises(AssertionError, match="explicit"):
        tableau("implicit", 2, [["1/2"]], ["1"])


@pytest.mark.parametrize("method", TABLEAUX.values(), ids=TABLEAUX)
def test_nodes_are_row_sums_and_weights_add_up_to_one(method):
    np.testing.assert_allclose(method.a.sum(axis=1), method.c, rtol=0, atol=1e-14)
    assert method.b.sum() == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("method", TABLEAUX.values(), ids=TABLEAUX)
def test_the_continuous_extension_errs_within_a_step_with_its_order(method):
    """y' = -y^2 t, y = 2 / (2 / y_0 + t^2 - t_0^2): by h^(order + 1), at most h^5, which order 5 gives as it is."""

    def slope(t, y):
        return -y * y * t

    def extended(h, x, t=0.5, y=1.0):
        slopes = []
        for row, c in zip(method.a, method.c, strict=True):
            slopes.append(slope(t + c * h, y + h * np.dot(row[: len(slopes)], slopes)))
        end = h * np.dot(method.b, slopes)
        slopes.append(slope(t + h, y + end))
        cubic = x * x * (3.0 - 2.0 * x) * end + h * x * (1.0 - x) * ((1.0 - x) * slopes[0] - x * slopes[-1])
        if len(method.within):
            slopes.append(slope(t + float(BETWEEN) * h, y + h * np.dot(method.within, slopes)))
        found = y + cubic + (x * (1.0 - x)) ** 2 * h * np.dot(method.bend, slopes)
        return abs(found - 2.0 / (2.0 / y + (t + x * h) ** 2 - t * t))

    rates = [np.log2(extended(0.1, x) / extended(0.05, x)) for x in (0.2, 0.45, 0.7)]
    assert min(rates) > min(method.order, 4) + 0.5  # measured 2.9, 5.0, 4.7, 4.8; by h^3, h^5, h^5, h^5
    assert len(method.within) == (0 if method.order == 5 else method.stages + 1)
