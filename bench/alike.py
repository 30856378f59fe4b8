"""Orders observed over machines that begin alike.

Near the limit of friction the error of one machine differs by chance from what a power of the step says, by several
times: by where its steps happen to cut its slips, and by what stops just before or after it would let go. So its order
is the mean of those of many that begin nearly as it does, each the slope of the least-squares line through the
logarithms of its errors, and has an uncertainty.

Long steps may err less than short ones lead one to expect, since sub-steps of slip do not grow with them; then that
slope is less than the order of the method, and errors are below its power of the step all the same. So geometric means
of the errors are also told beside that power, through the mean of one step more, half the shortest.
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from bench.common import table
from omnisim.base.methods import METHODS
from omnisim.run.work_precision import CLEAR, Setting, Unconverged, exact
from omnisim.scene.scene import Scene, parse

MACHINES = 96
LONGEST = 10.0  # times the shortest step: longer ones follow no power
SEED = 1

Alike = Callable[[np.random.Generator], list[str]]  # what to set for one of them


class Order(NamedTuple):
    """The mean and its standard error; by step (s), the geometric mean of the errors, m or rad; the largest of these by
    the power of the step through that of the shortest, and its standard error."""

    order: float
    uncertainty: float
    errors: dict[str, float]
    by_power: float
    by_power_uncertainty: float


def orders(scene: Scene, alike: Alike, methods: Sequence[str], steps: Sequence[float]) -> dict[str, Order]:
    """By explicit method. Raises Unconverged if a machine has no reference, or a run of one stops."""
    generator = np.random.default_rng(SEED)
    taken = [step for step in steps if step <= LONGEST * min(steps)]
    shortest = min(steps) / 2
    settings = [Setting(method, "explicit", step) for method in methods for step in [*taken, shortest]]
    found = [exact(parse(scene.text, scene.source, alike(generator)), settings) for _ in range(MACHINES)]
    stopped = [row.status for one in found for row in one.rows if row.error is None]
    if stopped:
        raise Unconverged(stopped[0])
    trusted = np.array([one.reference.distance for one in found])
    errors = np.array([[row.error for row in one.rows] for one in found]).reshape(MACHINES, len(methods), -1)
    return {method: order_of(method, [*taken, shortest], errors[:, i], trusted) for i, method in enumerate(methods)}


def order_of(method: str, steps: Sequence[float], errors: np.ndarray, trusted: np.ndarray) -> Order:
    """From the errors (MACHINES, steps), the last step the shortest, and what references are trusted to (MACHINES,)."""
    *longer, shortest = steps
    slopes = [slope(longer, own[:-1], distance) for own, distance in zip(errors, trusted, strict=True)]
    logs = np.log(np.maximum(errors, trusted[:, None]))
    mean = np.exp(np.mean(logs, axis=0))
    beside = logs[:, :-1] - logs[:, -1:] - METHODS[method].tableau.order * np.log(np.array(longer) / shortest)
    ratios = np.exp(np.mean(beside, axis=0))
    largest = int(np.argmax(ratios))
    return Order(
        float(np.mean(slopes)),
        standard_error(slopes),
        {f"{step:g}": float(error) for step, error in zip(steps, mean, strict=True)},
        float(ratios[largest]),
        float(ratios[largest]) * standard_error(beside[:, largest]),
    )


def standard_error(values: Sequence[float]) -> float:
    """Of their mean."""
    return float(np.std(values, ddof=1)) / math.sqrt(len(values))


def slope(steps: Sequence[float], own: Sequence[float], trusted: float) -> float:
    """Of the logarithm of one machine's own errors over that of the step, where the reference, trusted to so much, can
    tell them."""
    clear = [pair for pair in zip(steps, own, strict=True) if pair[1] > CLEAR * trusted]
    return float(np.polyfit(*np.log(np.transpose(clear)), 1)[0])


def told(found: dict[str, Order]) -> str:
    """In words, and the mean errors."""
    listed = ", ".join(f"{method} {order.order:.2f} ± {order.uncertainty:.2f}" for method, order in found.items())
    steps = list(next(iter(found.values())).errors)
    lines = [
        [
            method,
            *(f"{error:.1e}" for error in own.errors.values()),
            f"{own.by_power:.2f} ± {own.by_power_uncertainty:.2f}",
        ]
        for method, own in found.items()
    ]
    return "\n\n".join(
        [
            f"Observed order over {MACHINES} machines that begin alike, by steps up to {LONGEST:g} times the shortest "
            f"of the ladder, mean and its standard error: {listed}. Their errors, geometric means:",
            table(["method", *(f"{step} s" for step in steps), "at most, by h^p through the last"], lines),
        ]
    )
