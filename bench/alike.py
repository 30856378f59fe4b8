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

from omnisim.run.simulation import simulate
from omnisim.run.work_precision import CLEAR, Reference, Setting, Unconverged, converged, untimed, varied
from omnisim.scene.scene import Scene, parse

MACHINES = 24
LONGEST = 10.0  # times the shortest step: longer ones follow no power
FINER = 8  # times the step of the references goes into the shortest one
SEED = 1

Alike = Callable[[np.random.Generator], list[str]]  # what to set for one of them


class Order(NamedTuple):
    """The mean and its standard error."""

    order: float
    uncertainty: float


def orders(scene: Scene, alike: Alike, methods: Sequence[str], steps: Sequence[float]) -> dict[str, Order]:
    """By explicit method. Raises Unconverged if a machine has no reference, or a run of one stops."""
    generator = np.random.default_rng(SEED)
    machines = [parse(scene.text, scene.source, alike(generator)) for _ in range(MACHINES)]
    taken = [step for step in steps if step <= LONGEST * min(steps)]
    references = [converged(machine, min(taken) / FINER, lambda *_: None) for machine in machines]
    found = {}
    for method in methods:
        slopes = [slope(*pair, method, taken) for pair in zip(machines, references, strict=True)]
        found[method] = Order(float(np.mean(slopes)), float(np.std(slopes, ddof=1)) / math.sqrt(MACHINES))
    return found


def slope(machine: Scene, reference: Reference, method: str, steps: Sequence[float]) -> float:
    """Of the logarithm of one machine's error over that of the step, where the reference can tell the error."""
    told = []
    for step in steps:
        setting = Setting(method, "explicit", step)
        row = untimed(setting, simulate(varied(machine, setting)), reference.run)
        if row.error is None:
            raise Unconverged(row.status)
        if row.error > CLEAR * reference.distance:
            told.append((step, row.error))
    return float(np.polyfit(*np.log(np.transpose(told)), 1)[0])


def told(found: dict[str, Order]) -> str:
    """In words."""
    listed = ", ".join(f"{method} {order:.2f} ± {error:.2f}" for method, (order, error) in found.items())
    return (
        f"Observed order over {MACHINES} machines that begin alike, by steps up to {LONGEST:g} times the shortest, "
        f"mean and its standard error: {listed}."
    )
