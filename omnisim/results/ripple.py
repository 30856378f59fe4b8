"""The ripple of real rollers: how large what repeats with every roller is."""

import numpy as np

from omnisim.results.layout import ROLLER
from omnisim.results.trajectory import Trajectory

FEWEST_PITCHES, MOST_PITCHES = 4, 200  # of a window; more sharpen nothing that is seen
FEWEST_ROWS = 4  # for each roller: orders up to 2
HIGHEST_ORDER = 5.0


class RippleError(ValueError):
    """A motion without a spectrum; the message says why, of the wheel."""


def spectrum(angle: np.ndarray, rollers: int, values: np.ndarray, rows: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Orders, and the amplitude of `values` (T) at each, in their unit, for a wheel of so many rollers on so many rows.

    Order 1 repeats with every roller, 2 pi / rollers of the spin angle (T), rad: at the exchange frequency, however the
    wheel speeds up; order 1 / rows with every pitch, from a roller to the next on its row. Taken is the end of the
    longest way that the wheel turns without return, a whole number of pitches, in a Hann window. The mean over a pitch
    is taken away, which leaves whole multiples of 1 / rows as they are and removes the slow motion. The Fourier
    integral over the angles, as they are, is by the trapezoidal rule.

    Raises RippleError if the wheel turns less than FEWEST_PITCHES + 1, or rows are too far apart.
    """
    x, y = ripple(angle, rollers // rows, values)
    pitches = min(int(x[-1]), MOST_PITCHES) if len(x) else 0
    if pitches < FEWEST_PITCHES:
        of_row = " of a row" if rows > 1 else ""
        raise RippleError(f"turns past fewer than {FEWEST_PITCHES + 1} rollers{of_row} without return")
    x, y = x[x <= pitches], y[x <= pitches]
    dense = 1.0 / np.diff(x).max() / rows
    if dense < FEWEST_ROWS:
        raise RippleError(f"has {dense:.2g} rows for each roller, too few: take a smaller time.output_interval")
    weights = np.sin(np.pi * x / pitches) ** 2 * np.gradient(x)
    orders = np.arange(1, int(min(HIGHEST_ORDER, dense / 2.0) * rows * pitches) + 1) / pitches
    waves = [np.dot(weights * y, np.exp(-2j * np.pi * order * x)) for order in orders]
    return orders / rows, 2.0 * np.abs(waves) / weights.sum()


def ripple(angle: np.ndarray, count: int, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values less their mean over a pitch, of which a turn has `count`, about each, over pitches counted back from the
    end of the longest way."""
    first, last = longest_way(angle)
    x = np.abs(angle[first : last + 1] - angle[last])[::-1] * count / (2.0 * np.pi)
    y = values[first : last + 1][::-1]
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(x))])
    mean = np.interp(x + 0.5, x, integral) - np.interp(x - 0.5, x, integral)
    inside = (x >= 0.5) & (x <= x[-1] - 0.5)
    return x[inside] - 0.5, (y - mean)[inside]


def longest_way(angle: np.ndarray) -> tuple[int, int]:
    """First and last row of the longest way that an angle goes without turning back or resting."""
    direction = np.sign(np.diff(angle))
    if not direction.any():
        return 0, 0
    turns = np.flatnonzero(np.diff(direction)) + 1
    starts = np.array([0, *turns])
    ends = np.array([*turns, len(direction)])
    longest = np.argmax(np.abs(angle[ends] - angle[starts]))
    return int(starts[longest]), int(ends[longest])


def of_wheel(run: Trajectory, wheel: str, values: np.ndarray, rows: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """The same for a wheel of a run."""
    return spectrum(run[f"wheels/{wheel}/spin_angle"], len(run[ROLLER.format(wheel=wheel)]), values, rows)
