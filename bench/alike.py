"""Orders observed over machines that begin alike.

Near the limit of friction the error of one machine differs by chance from what a power of the step says, by several
times: by where its steps happen to cut its slips, and by what stops just before or after it would let go. So its order
is the mean of those of many that begin nearly as it does, each the slope of the least-squares line through the
logarithms of its errors, and has an uncertainty.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from omnisim.results.comparison import distance
from omnisim.run.simulation import simulate
from omnisim.run.work_precision import Setting, varied
from omnisim.scene.scene import Scene, parse

MACHINES = 24
LONGEST = 10.0  # times the shortest step: longer ones follow no power
FINER = 8  # times the step of the reference goes into the shortest one
SEED = 1

Alike = Callable[[np.random.Generator], list[str]]  # what to set for one of them


class Order(NamedTuple):
    """The mean and its standard error."""

    order: float
    uncertainty: float


def orders(scene: Scene, alike: Alike, methods: Sequence[str], steps: Sequence[float]) -> dict[str, Order]:
    """By explicit method."""
    taken = sorted(step for step in steps if step <= LONGEST * min(steps))
    generator = np.random.default_rng(SEED)
    slopes = []
    for _ in range(MACHINES):
        machine = parse(scene.text, scene.source, alike(generator))
        reference = simulate(varied(machine, Setting("bs5", "explicit", taken[0] / FINER)))
        errors = [
            [distance(simulate(varied(machine, Setting(method, "explicit", step))), reference) for step in taken]
            for method in methods
        ]
        slopes.append(np.polyfit(np.log(taken), np.log(np.transpose(errors)), 1)[0])
    means, errors_of_means = np.mean(slopes, axis=0), np.std(slopes, axis=0, ddof=1) / math.sqrt(MACHINES)
    return {method: Order(*map(float, pair)) for method, *pair in zip(methods, means, errors_of_means, strict=True)}


def told(found: dict[str, Order]) -> str:
    """In words."""
    listed = ", ".join(f"{method} {order:.2f} ± {error:.2f}" for method, (order, error) in found.items())
    return (
        f"Observed order over {MACHINES} machines that begin alike, by steps up to {LONGEST:g} times the shortest, "
        f"mean and its standard error: {listed}."
    )
