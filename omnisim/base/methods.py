"""Runge-Kutta methods as checked data.

A method is its Butcher tableau. Order conditions are asserted when this module is imported, so a mistyped
coefficient cannot run; stages and stability limit are derived from the coefficients.

Sources: Butcher, Numerical Methods for Ordinary Differential Equations (2016), sections 23 and 31; Dormand & Prince,
J. Comput. Appl. Math. 6 (1980) 19-26 (the weights of order 5; fixed steps need no error estimate); Bogacki & Shampine,
Comput. Math. Appl. 32 (1996) 15-28 (likewise; its terms of order 6 are a tenth of those, for one stage more);
Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), section II.6 (its continuous extension);
Hairer & Wanner, Solving Ordinary Differential Equations II (1996), section IV.8 (Radau IIA).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from math import prod
from operator import mul
from typing import NamedTuple

import numpy as np

EXPLICIT, IMPLICIT, AUTO = range(3)
BETWEEN = Fraction(1, 4)  # of a step: nearly where the derivative of a cubic errs most, 1/2 - sqrt(1/12)
EXTENDED = 4  # order that a quartic may have
WITHIN = (Fraction(1, 4), Fraction(1, 2), Fraction(3, 4))  # a quartic that is right there and at both ends is right


@dataclass(frozen=True, eq=False)
class Tableau:
    """Strictly lower triangular matrix a (s, s), weights b (s,), nodes c (s,), and the order they reach.

    Its continuous extension has that order too, at most 4. It is the cubic that has the states and derivatives at both
    ends of a step, and at a part x of it beside that x^2 (1 - x)^2 h sum bend_i k_i, bend (s + 1,) or (s + 2,): k_s is
    the derivative at the end, k_(s+1) one more, at the part BETWEEN, where the cubic is y + h sum within_i k_i; within
    (s + 1,), empty where that is not needed.
    """

    name: str
    order: int
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    within: np.ndarray
    bend: np.ndarray

    @property
    def stages(self) -> int:
        return len(self.b)

    def amplification(self, z: float) -> float:
        """R(z) = 1 + z b (I - z a)^-1 1, the growth of y' = lambda y in a step with z = lambda dt."""
        ones = np.ones(self.stages)
        return float(1.0 + z * self.b @ np.linalg.solve(np.eye(self.stages) - z * self.a, ones))

    @cached_property
    def stability_limit(self) -> float:
        """Largest -z for which |R(z)| <= 1 all along the negative real axis."""
        inside, outside = 0.0, 1.0
        while abs(self.amplification(-outside)) <= 1.0:
            inside = outside
            outside = outside + 0.25
        for _ in range(50):
            middle = 0.5 * (inside + outside)
            inside, outside = (middle, outside) if abs(self.amplification(-middle)) <= 1.0 else (inside, middle)
        return inside


class Radau(NamedTuple):
    """Radau IIA of order 5: nodes c (3,), and A^-1 (3, 3) = V diag(lambda) V^-1 with one real and a pair of complex
    lambda.

    *_right (3,): columns of V; *_left (3,): rows of V^-1. The third column and row are the conjugates of the second.
    """

    c: np.ndarray
    inverse: np.ndarray
    real_value: float
    complex_value: complex
    real_left: np.ndarray
    complex_left: np.ndarray
    real_right: np.ndarray
    complex_right: np.ndarray


def collocation(c: np.ndarray) -> np.ndarray:
    """Matrix A of the collocation method with nodes c: sum_j a_ij c_j^(k-1) = c_i^k / k for k = 1 .. s."""
    powers = np.arange(len(c))
    return (c[:, None] ** (powers + 1) / (powers + 1)) @ np.linalg.inv(c[:, None] ** powers)


def radau_iia() -> Radau:
    c = np.array([(4.0 - math.sqrt(6.0)) / 10.0, (4.0 + math.sqrt(6.0)) / 10.0, 1.0])
    inverse = np.linalg.inv(collocation(c))
    values, right = np.linalg.eig(inverse)
    left = np.linalg.inv(right)
    real, above = int(np.argmin(abs(values.imag))), int(np.argmax(values.imag))
    return Radau(
        c,
        inverse,
        float(values[real].real),
        complex(values[above]),
        (left[real] * right[2, real]).real.copy(),  # scaled to be real
        left[above].copy(),
        (right[:, real] / right[2, real]).real.copy(),
        right[:, above].copy(),
    )


@cache
def rooted_trees(nodes: int) -> tuple:
    """All rooted trees with so many nodes, each the sorted tuple of the subtrees at its root."""
    if nodes == 1:
        return ((),)
    trees = set()
    for smaller in range(1, nodes):
        for branch in rooted_trees(smaller):
            for rest in rooted_trees(nodes - smaller):
                trees.add(tuple(sorted((*rest, branch))))
    return tuple(sorted(trees))


def size(tree: tuple) -> int:
    return 1 + sum(size(branch) for branch in tree)


def density(tree: tuple) -> int:
    return size(tree) * prod(density(branch) for branch in tree)


def elementary_weights(nodes: int, a: list[list[Fraction]]) -> dict[tuple, list[Fraction]]:
    """By tree of at most so many nodes the factor of each stage in its elementary weight (Butcher 2016, section 31), of
    a that is strictly lower triangular."""
    factors: dict[tuple, list[Fraction]] = {}
    below: dict[tuple, list[Fraction]] = {}
    for tree in (tree for count in range(1, nodes + 1) for tree in rooted_trees(count)):
        factors[tree] = [prod((below[branch][i] for branch in tree), start=Fraction(1)) for i in range(len(a))]
        below[tree] = [dot(row[:i], factors[tree]) for i, row in enumerate(a)]
    return factors


def weights_within(b: list[Fraction], x: Fraction) -> list[Fraction]:
    """Weights of the stages and of the derivative at the end in the increment of the cubic at a part x of a step."""
    y = 1 - x
    weights = [x * x * (1 + 2 * y) * bi for bi in [*b, Fraction(0)]]
    weights[0] += x * y * y
    weights[-1] -= x * x * y
    return weights


def bend_through(b: list[Fraction], x: Fraction) -> list[Fraction]:
    """Weights of the bend by one more derivative, at a part x of the cubic, by what it differs from the cubic's."""
    y = 1 - x
    weights = [6 * x * y * bi for bi in [*b, Fraction(0)]]
    weights[0] += y * (1 - 3 * x)
    weights[-1] -= x * (2 - 3 * x)
    return [weight / (2 * x * y * (x - y)) for weight in [*weights, Fraction(-1)]]


def tableau(name: str, order: int, rows: list[list[str]], weights: list[str], bend: Sequence[str] = ()) -> Tableau:
    """A Tableau from exact fractions, with its own bend or one through a derivative more.

    Asserts b . Phi(tree) = 1 / density(tree) for every tree up to `order`, and the same of its extension.
    """
    b = [Fraction(weight) for weight in weights]
    within = [] if bend else weights_within(b, BETWEEN)
    a = [[Fraction(entry) for entry in row] for row in [*rows, weights]] + [within] * (not bend)
    bent = [Fraction(entry) for entry in bend] or bend_through(b, BETWEEN)
    assert all(len(row) == i for i, row in enumerate(a)), f"{name}: not explicit"
    a = [row + [Fraction(0)] * (len(a) - len(row)) for row in a]
    extended = [(x, weights_within(b, x)) for x in WITHIN]
    for tree, factors in elementary_weights(order, a).items():
        nodes = size(tree)
        assert dot(b, factors) * density(tree) == 1, f"{name}: order condition of {tree} fails"
        for x, cubic in extended if nodes <= EXTENDED else ():
            weight = dot(cubic, factors) + (x * (1 - x)) ** 2 * dot(bent, factors)
            assert weight * density(tree) == x**nodes, f"{name}: order condition of {tree} fails within a step"
    a = [row[: len(b)] for row in a[: len(b)]]
    matrix = np.array([[float(entry) for entry in row] for row in a])
    nodes_c = np.array([float(sum(row)) for row in a])
    return Tableau(name, order, matrix, floats(b), nodes_c, floats(within), floats(bent))


def floats(values: list[Fraction]) -> np.ndarray:
    return np.array([float(value) for value in values])


def dot(weights: list[Fraction], values: list[Fraction]) -> Fraction:
    """Of as many as there are weights."""
    return sum(map(mul, weights, values), Fraction(0))


TABLEAUX = {
    method.name: method
    for method in (
        tableau("heun", 2, [[], ["1"]], ["1/2", "1/2"]),
        tableau("rk4", 4, [[], ["1/2"], ["0", "1/2"], ["0", "0", "1"]], ["1/6", "1/3", "1/3", "1/6"]),
        tableau(
            "dopri5",
            5,
            [
                [],
                ["1/5"],
                ["3/40", "9/40"],
                ["44/45", "-56/15", "32/9"],
                ["19372/6561", "-25360/2187", "64448/6561", "-212/729"],
                ["9017/3168", "-355/33", "46732/5247", "49/176", "-5103/18656"],
            ],
            ["35/384", "0", "500/1113", "125/192", "-2187/6784", "11/84"],
            [
                "-12715105075/11282082432",
                "0",
                "87487479700/32700410799",
                "-10690763975/1880347072",
                "701980252875/199316789632",
                "-1453857185/822651844",
                "69997945/29380423",
            ],
        ),
        tableau(
            "bs5",
            5,
            [
                [],
                ["1/6"],
                ["2/27", "4/27"],
                ["183/1372", "-162/343", "1053/1372"],
                ["68/297", "-4/11", "42/143", "1960/3861"],
                ["597/22528", "81/352", "63099/585728", "58653/366080", "4617/20480"],
                [
                    "174197/959244",
                    "-30942/79937",
                    "8152137/19744439",
                    "666106/1039181",
                    "-29421/29068",
                    "482048/414219",
                ],
            ],
            ["587/8064", "0", "4440339/15491840", "24353/124800", "387/44800", "2152/5985", "7267/94080"],
            [  # two are free: near those with the least terms of order 5
                "-3767/2688",
                "0",
                "384669/163072",
                "3871/8320",
                "-873/8960",
                "-8/3",
                "-7267/6272",
                "5/2",
            ],
        ),
    )
}


class Stages(NamedTuple):
    """What the kernels take: an explicit Tableau, and Radau IIA beside it.

    first (s,): the first stage that counts in each row of a.
    """

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    within: np.ndarray
    bend: np.ndarray
    first: np.ndarray
    radau: Radau


@dataclass(frozen=True, eq=False)
class Method:
    """A method by name: the tableau of its explicit steps, and which steps are explicit."""

    name: str
    choice: int  # EXPLICIT, IMPLICIT or AUTO
    tableau: Tableau

    @cached_property
    def stages(self) -> Stages:
        a = self.tableau.a
        b, c, within, bend = self.tableau.b, self.tableau.c, self.tableau.within, self.tableau.bend
        return Stages(a, b, c, within, bend, (a != 0.0).argmax(axis=1).astype(np.uint32), RADAU)


RADAU = radau_iia()
METHODS = {name: Method(name, EXPLICIT, tableau) for name, tableau in TABLEAUX.items()}
METHODS["radau5"] = Method("radau5", IMPLICIT, TABLEAUX["rk4"])
METHODS["auto"] = Method("auto", AUTO, TABLEAUX["rk4"])
