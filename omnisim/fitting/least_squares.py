"""Weighted least squares of paths against logs, with the Jacobian by runs in parallel.

Of every compared row k but the first, where each run starts, the residual is

    (p_k - q_k) / s_p        p, q  simulated and measured position, m
    (y_k - w_k) / s_y        y, w  simulated and measured yaw, rad
                             s     weights: standard deviations, m and rad

What the logs do not tell is held where it starts by a pull that is far too weak for what they do tell.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from omnisim.fitting.fit_file import Fit
from omnisim.fitting.logs import FitError
from omnisim.fitting.paths import Path, measured
from omnisim.fitting.simulation import Interrupted

DIFFERENCE = 1e-3  # of a parameter's range
TOLERANCE = 1e-6  # of cost and step, relative, at which the search ends
MOST_TRIALS = 50
PULL = 1e-3  # of a parameter towards its start, deviations by range: without it SciPy creeps where J is singular


class Paths(Protocol):
    """A way from values of the parameters to paths: for each point the path of each log."""

    def __call__(self, points: np.ndarray, logs: list[int]) -> list[list[Path]]: ...


class Trial(NamedTuple):
    """A point that the search has tried: how often it has, the weighted root mean square there and the best so far."""

    number: int
    rms: float
    best: float


class Solution(NamedTuple):
    """values (P,) of the parameters; paths of the fitted logs; residuals (m,), x, y and yaw of each row, log by log;
    jacobian (m, P), None if the search was interrupted before there was one; whether it has converged."""

    values: np.ndarray
    paths: list[Path]
    residuals: np.ndarray
    jacobian: np.ndarray | None
    converged: bool
    interrupted: bool
    trials: int


class Search:
    """The unknowns, residuals and Jacobian of a fit, by one way to its paths.

    used: numbers of the parameters that are searched; the others keep their start.
    """

    def __init__(self, fit: Fit, paths: Paths, used: Sequence[int], told: Callable[[Trial], object]):
        self.fit = fit
        self.paths = paths
        self.used = list(used)
        self.told = told
        self.logs = fit.fitted
        weights = fit.config.weights
        self.weights = np.array([weights.position, weights.position, weights.yaw])
        self.measured = [measured(fit.logs[i], fit.compared(fit.logs[i])) for i in self.logs]
        self.trials = 0
        self.reach = fit.high[self.used] - fit.low[self.used]
        self.best: tuple[float, np.ndarray, list[Path], np.ndarray] | None = None
        self.last: tuple[np.ndarray, list[Path]] | None = None
        self.jacobian_there: np.ndarray | None = None

    def values(self, unknowns: np.ndarray) -> np.ndarray:
        """All parameters (P,)."""
        found = self.fit.start.copy()
        found[self.used] = unknowns
        return found

    def paths_at(self, unknowns: np.ndarray) -> list[Path]:
        if self.last is None or not np.array_equal(self.last[0], unknowns):
            self.last = (unknowns.copy(), self.paths(self.values(unknowns)[None], self.logs)[0])
        return self.last[1]

    def residuals(self, unknowns: np.ndarray) -> np.ndarray:
        """(m + P,) of these unknowns, and their pulls."""
        paths = self.paths_at(unknowns)
        found = self.compared(paths)
        rms = float(np.sqrt(np.mean(found**2)))
        self.trials += 1
        if self.best is None or rms < self.best[0]:
            self.best = (rms, unknowns.copy(), paths, found)
        self.told(Trial(self.trials, rms, self.best[0]))
        return np.append(found, PULL * (unknowns - self.fit.start[self.used]) / self.reach)

    def compared(self, paths: list[Path]) -> np.ndarray:
        """(m,) residuals of these paths."""
        rows = [
            np.column_stack([path.position - log.position, path.yaw - log.yaw])[1:] / self.weights
            for path, log in zip(paths, self.measured, strict=True)
        ]
        return np.concatenate(rows).ravel()

    def jacobian(self, unknowns: np.ndarray) -> np.ndarray:
        """(m + P, P) by differences into each range."""
        above = unknowns + DIFFERENCE * self.reach > self.fit.high[self.used]
        steps = np.where(above, -DIFFERENCE, DIFFERENCE) * self.reach
        points = np.array([self.values(unknowns + step) for step in np.diag(steps)])
        paths = self.paths(points, self.logs)
        base = self.compared(self.paths_at(unknowns))
        columns = [(self.compared(path) - base) / step for path, step in zip(paths, steps, strict=True)]
        self.jacobian_there = np.column_stack(columns)
        return np.vstack([self.jacobian_there, np.diag(PULL / self.reach)])

    def nearer(self, values: np.ndarray, others: list[Path]) -> bool:
        """Whether the paths with these values (P,) are nearer to the logs than others, of all logs."""
        mine = self.paths(values[None], self.logs)[0]
        cost, other = (float(np.sum(self.compared(paths) ** 2)) for paths in (mine, [others[i] for i in self.logs]))
        return cost < other

    def solve(self, begin: np.ndarray) -> Solution:
        """The best values from a point (P,) on, by the trust region reflective method of SciPy, which stays within the
        ranges. Raises FitError without SciPy."""
        try:
            from scipy.optimize import least_squares  # here: SciPy comes with an extra
        except ModuleNotFoundError:
            raise FitError("omnisim fit needs SciPy: pip install 'omnisim-engine[study]'") from None
        low, high = self.fit.low[self.used], self.fit.high[self.used]
        converged = interrupted = False
        try:
            end = least_squares(
                self.residuals, begin[self.used], self.jacobian, (low, high), x_scale=self.reach,
                ftol=TOLERANCE, xtol=TOLERANCE, gtol=None, max_nfev=MOST_TRIALS,
            )  # fmt: skip
            converged = end.status > 0
        except Interrupted:
            interrupted = True
        if self.best is None:
            raise Interrupted
        _, unknowns, paths, residuals = self.best
        values = self.values(unknowns)
        return Solution(values, paths, residuals, self.jacobian_there, converged, interrupted, self.trials)
