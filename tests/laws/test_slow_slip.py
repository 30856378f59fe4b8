"""Slow slip under Coulomb friction, which turns as it lasts: the order of the method, at a cost of few steps.

The references are runs by dopri5 at 1e-4 s; an independent method, radau5 at 1e-4 s, follows the turning itself.
"""

from functools import cache

import numpy as np
import pytest

import omnisim
from bench.machine_scenes import platform
from bench.precision import NEAR_LIMIT
from omnisim.results.comparison import distance

SCENES = {
    "near limit": lambda method, step: omnisim.load(NEAR_LIMIT, [f"solver.method={method}", f"time.step={step!r}"]),
    "platform": lambda method, step: platform("diagonal with yaw", "rate", method, step),
}


@cache
def run(scene, method, step):
    found = omnisim.simulate(SCENES[scene](method, step))
    assert found.complete, found.attributes["status"]
    return found


@pytest.mark.parametrize(
    ("scene", "method", "order", "bound", "work"),
    [  # measured, at 5e-4 s: order, error, right-hand sides; sub-steps of the turning took 82,000, 158,000, 142,000
        ("near limit", "rk4", 3.8, 1e-6, 35_000),  # 4.06, 6.7e-7, 31500
        ("near limit", "dopri5", 4.4, 4e-9, 70_000),  # 4.66, 2.1e-9, 64300
        ("platform", "rk4", 3.8, 6e-10, 30_000),  # 5.03, 1.9e-10, 27100
        ("platform", "dopri5", 3.8, 1e-10, 55_000),  # 4.20, 4.5e-11, 49100
    ],
)
def test_slow_slip_costs_no_order_and_few_sub_steps(scene, method, order, bound, work):
    exact, coarse, fine = (run(scene, *setting) for setting in (("dopri5", 1e-4), (method, 1e-3), (method, 5e-4)))
    error = distance(fine, exact)
    assert error < bound and fine.attributes["rhs_evaluations"] < work
    assert np.log2(distance(coarse, exact) / error) > order


def test_an_implicit_method_that_follows_the_turning_finds_the_same_motion():
    assert distance(run("near limit", "radau5", 1e-4), run("near limit", "dopri5", 1e-4)) < 1e-10  # measured 2.1e-11


def test_an_error_of_1e_9_is_reached_near_the_limit():
    assert distance(run("near limit", "dopri5", 2.5e-4), run("near limit", "dopri5", 1e-4)) < 1e-9  # measured 3.6e-10
