"""How much of the spread of a measure each varied key explains: first-order Sobol indices from the runs at hand."""

from typing import NamedTuple

import numpy as np

FEWEST = 20  # runs with a number
REPEATS = 200  # of the bootstrap


class Effect(NamedTuple):
    """Var(E[y | x]) / Var(y), and its standard deviation by bootstrap, 1."""

    share: float
    deviation: float


def first_order(x: np.ndarray, y: np.ndarray) -> Effect | None:
    """The share of the variance of y that x alone explains, from runs x, y (n,); NaN of y has no part in it.

    Runs are put into about n^(1/3) classes of x with as many runs each, or one for each of few values. The spread of
    their means is compared with that of all, less what chance alone gives (epsilon squared of Kelley, 1935).
    None where fewer than FEWEST runs have a number, or nothing varies.
    """
    there = np.isfinite(y)
    x, y = x[there], y[there]
    if len(y) < FEWEST or np.ptp(y) == 0.0 or len(np.unique(x)) < 2:
        return None
    random = np.random.default_rng(0)
    found = [
        epsilon_squared(*(values[chosen] for values in (x, y)))
        for chosen in random.integers(len(y), size=(REPEATS, len(y)))
    ]
    return Effect(epsilon_squared(x, y), float(np.std(found)))


def epsilon_squared(x: np.ndarray, y: np.ndarray) -> float:
    """Epsilon squared of y in classes of x."""
    values, classes = np.unique(x, return_inverse=True)
    most = max(2, round(len(y) ** (1.0 / 3.0)))
    if len(values) > most:
        classes = np.argsort(np.argsort(x, kind="stable"), kind="stable") * most // len(x)
    counts = np.bincount(classes)
    sums = np.bincount(classes, weights=y)
    total = float(np.sum((y - y.mean()) ** 2))
    kept = counts > 0
    between = float(np.sum(counts[kept] * (sums[kept] / counts[kept] - y.mean()) ** 2))
    groups = int(kept.sum())
    if total == 0.0 or len(y) <= groups:
        return 0.0
    within = (total - between) / (len(y) - groups)
    return (between - (groups - 1) * within) / total
