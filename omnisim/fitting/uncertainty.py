"""What logs tell of the parameters: deviations, intervals, correlation, and what they cannot tell.

Residuals r (m,) of x, y and yaw, their Jacobian J (m, P) by the parameters, and A (m, S) by the poses in which the runs
start leave the covariance

    C = H J^T (V + A V_0 A^T) J H        H = (J^T J)^-1        V = diag(v_c)
    v_c = sum r_c^2 / (m_c / tau_c - (P + S) m_c / m)

with the part of r that J and A leave. Positions and yaw, c, have variances of their own: what the weights say of them
need not be true. Residuals along a path are no independent observations: where a model errs, it errs for seconds. tau
is the integrated autocorrelation time of the residuals, in rows (Sokal, Monte Carlo methods in statistical mechanics,
1989): so many rows count as one. It is 1 for white noise. Runs start in what the first row has measured, which has
noise too: V_0, from differences of successive residuals. Intervals are those of Student's t with as many degrees of
freedom as the sum of m_c / tau_c - P - S.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from omnisim.fitting.parameters import Parameter

LEVEL = 0.95
CHANNELS = (slice(0, 2), slice(2, 3))  # of residuals (n, 3): positions, yaw
WINDOW = 5.0  # autocorrelation times, over which autocorrelations are summed (Sokal)
SINGULAR = 1e-9  # of the largest singular value: less is rounding
LARGE_SHARE = 0.3  # of a direction that the logs cannot tell, from which on a parameter belongs to it
AT_END = 1e-3  # of the range of a parameter
ALIKE = 0.98  # correlation, from which on two estimates are told as one
INTERRUPTED = "the search was interrupted before it knew how paths depend on the parameters"


class Uncertainty(NamedTuple):
    """deviation, low and high (P,) of the 95 % intervals, cut at the ends of each range; correlation (P, P); all NaN
    where nothing is known. correlated_rows: rows of positions, and of yaw, that count as one. untold: sentences on what
    the logs cannot tell."""

    deviation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    correlation: np.ndarray
    correlated_rows: tuple[float, ...]
    untold: tuple[str, ...]


class Remains(NamedTuple):
    """What a fit leaves of its logs: jacobian (m, P), starts (m, S) and residuals (n, 3) of each log, all weighted."""

    jacobian: np.ndarray
    starts: np.ndarray
    residuals: Sequence[np.ndarray]


def unknown(count: int) -> Uncertainty:
    """Of so many parameters whose Jacobian is not there."""
    nothing = np.full(count, np.nan)
    return Uncertainty(nothing, nothing, nothing, np.full((count, count), np.nan), (np.nan, np.nan), (INTERRUPTED,))


def uncertainty(parameters: Sequence[Parameter], values: np.ndarray, remains: Remains) -> Uncertainty:
    """Of the parameters at these values."""
    from scipy.stats import t as student  # here: SciPy comes with an extra

    ranges = np.array([one.range for one in parameters])
    found, freedom, times = covariance(remains._replace(jacobian=remains.jacobian * ranges))
    own = np.sqrt(np.diag(found))
    correlation = found / np.outer(own, own)
    reach = float(student.ppf(0.5 + 0.5 * LEVEL, freedom))
    low = np.maximum(values - reach * own * ranges, [one.low for one in parameters])
    high = np.minimum(values + reach * own * ranges, [one.high for one in parameters])
    untold = (*ends(parameters, values), *not_told(parameters, found, 2.0 * reach), *alike(parameters, correlation))
    return Uncertainty(own * ranges, low, high, correlation, times, untold)


def covariance(remains: Remains) -> tuple[np.ndarray, float, tuple[float, ...]]:
    """C (P, P), its degrees of freedom, 1 or more, and the rows of each channel that count as one. A parameter that
    nothing depends on has a deviation that is large, and finite."""
    jacobian, starts, residuals = remains
    r = np.concatenate(residuals)
    all_unknowns = np.column_stack([jacobian, starts])
    r = (r.ravel() - all_unknowns @ np.linalg.lstsq(all_unknowns, r.ravel())[0]).reshape(r.shape)
    parts = np.split(r, np.cumsum([len(one) for one in residuals])[:-1])
    variances = np.empty_like(r)
    of_starts = np.empty(r.shape[1])
    times = []
    freedom = 0.0
    for channel in CHANNELS:
        times.append(correlation_time([part[:, channel] for part in parts]))
        size = r[:, channel].size
        left = max(size / times[-1] - all_unknowns.shape[1] * size / r.size, 1.0)
        variances[:, channel] = np.sum(r[:, channel] ** 2) / left
        of_starts[channel] = 0.5 * np.mean(np.concatenate([np.diff(part[:, channel], axis=0) for part in parts]) ** 2)
        freedom += left
    back = pseudo_inverse(jacobian)
    by_starts = back @ starts
    noise = np.tile(of_starts, starts.shape[1] // len(of_starts))
    found = (back * variances.ravel()) @ back.T + (by_starts * noise) @ by_starts.T
    return found, freedom, tuple(times)


def pseudo_inverse(jacobian: np.ndarray) -> np.ndarray:
    """(P, m): H J^T. Columns that are 0 or depend on each other count as if they nearly were."""
    norms = np.maximum(np.linalg.norm(jacobian, axis=0), SINGULAR * max(np.abs(jacobian).max(), SINGULAR))
    left, sizes, right = np.linalg.svd(jacobian / norms, full_matrices=False)
    return (right.T / np.maximum(sizes, SINGULAR * sizes[0])) @ left.T / norms[:, None]


def correlation_time(residuals: Sequence[np.ndarray]) -> float:
    """The integrated autocorrelation time of residuals (n, c) of each log, rows: 1 + 2 sum of the autocorrelations, up
    to the first lag that is WINDOW times as long; 1 or more."""
    longest = max(len(r) for r in residuals)
    sums = np.zeros(longest)
    for r in residuals:
        size = 2 * len(r)
        spectrum = np.abs(np.fft.rfft(r, size, axis=0)) ** 2
        sums[: len(r)] += np.fft.irfft(spectrum, size, axis=0)[: len(r)].sum(axis=1)
    if sums[0] <= 0.0:
        return 1.0
    times = 1.0 + 2.0 * np.cumsum(sums[1:]) / sums[0]
    enough = np.flatnonzero(np.arange(1, longest) >= WINDOW * times)
    return float(max(1.0, times[enough[0]] if len(enough) else times.max()))


def ends(parameters: Sequence[Parameter], values: np.ndarray) -> list[str]:
    """What is at an end of its range."""
    return [
        f"{one.key} is at the {'lower' if value - one.low < AT_END * one.range else 'upper'} end of its range"
        for one, value in zip(parameters, values, strict=True)
        if min(value - one.low, one.high - value) < AT_END * one.range
    ]


def not_told(parameters: Sequence[Parameter], found: np.ndarray, reach: float) -> list[str]:
    """Directions of the covariance (P, P), in ranges, along which so many deviations are as wide as a range."""
    told = []
    variances, directions = np.linalg.eigh(found)
    for variance, direction in zip(variances, directions.T, strict=True):
        if reach * np.sqrt(max(variance, 0.0)) < 1.0:
            continue
        shares = np.abs(direction)
        names = [one.key for one, share in zip(parameters, shares, strict=True) if share > LARGE_SHARE * shares.max()]
        if len(names) == 1:
            told.append(f"the logs cannot tell {names[0]}: its interval is as wide as its range")
        else:
            told.append(f"the logs cannot tell {', '.join(names)} apart")
    return told


def alike(parameters: Sequence[Parameter], correlation: np.ndarray) -> list[str]:
    """Pairs of estimates that hardly differ in what they do."""
    return [
        f"the logs hardly tell {parameters[i].key} from {parameters[j].key}: correlation {correlation[i, j]:.3f}"
        for i, j in combinations(range(len(parameters)), 2)
        if abs(correlation[i, j]) > ALIKE
    ]
