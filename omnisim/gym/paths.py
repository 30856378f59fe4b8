"""Paths: poses over time, named or given, and what a machine that follows one wants to know at its control instants."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

SPACING = 0.01  # s, of the table of a named path
POINTS = 4001  # of a shape, by which its length is measured


def path(name: str, size: float = 1.0, speed: float = 0.5) -> np.ndarray:
    """A named path as a table (K, 4) of times (s), x, y (m) and yaw (rad), as the option `path` takes one.

    line          2 sizes ahead
    square        of that side, to the left, in the heading of the start; at rest at each corner
    circle        of that diameter, to the left, the heading along it
    figure_eight  a lemniscate (Gerono's) 2 sizes long, the heading along it

    All begin at the origin with yaw 0, and begin and end at rest. size: m; speed: the largest, m/s. Along each leg of
    length L the distance is L (3 u^2 - 2 u^3), u the share of its time 1.5 L / speed.
    """
    if name not in SHAPES:
        raise ValueError(f"path: no path is called {name!r}; must be {', '.join(SHAPES)}, or a table (K, 4)")
    for what, value in (("size", size), ("speed", speed)):
        if not (isinstance(value, int | float) and 0.0 < value < math.inf):
            raise ValueError(f"path: {what} must be a finite number > 0, not {value!r}")
    tables: list[np.ndarray] = []
    begun = 0.0
    for leg in SHAPES[name]:
        poses = size * leg(np.linspace(0.0, 1.0, POINTS))
        poses[:, 2] /= size  # an angle
        steps = np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        duration = 1.5 * along[-1] / speed
        u = np.linspace(0.0, 1.0, math.ceil(duration / SPACING) + 1)
        wanted = along[-1] * u * u * (3.0 - 2.0 * u)
        columns = [np.interp(wanted, along, values) for values in poses.T]
        tables.append(np.column_stack([begun + duration * u, *columns])[bool(tables) :])
        begun += duration
    return np.concatenate(tables)


def straight(start: tuple[float, float], end: tuple[float, float]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda share: np.column_stack([np.outer(1.0 - share, start) + np.outer(share, end), 0.0 * share])


def circle(share: np.ndarray) -> np.ndarray:
    angle = 2.0 * np.pi * share
    return np.column_stack([0.5 * np.sin(angle), 0.5 * (1.0 - np.cos(angle)), angle])


def figure_eight(share: np.ndarray) -> np.ndarray:
    angle = 2.0 * np.pi * share
    x, y = np.sin(angle), np.sin(angle) * np.cos(angle)
    yaw = np.unwrap(np.arctan2(np.cos(2.0 * angle), np.cos(angle)))
    turn = math.sqrt(0.5)  # it leaves its middle at 45 deg
    return np.column_stack([turn * (x + y), turn * (y - x), yaw - np.pi / 4.0])


SHAPES: dict[str, list[Callable[[np.ndarray], np.ndarray]]] = {
    "line": [straight((0.0, 0.0), (2.0, 0.0))],
    "square": [
        straight((0.0, 0.0), (1.0, 0.0)),
        straight((1.0, 0.0), (1.0, 1.0)),
        straight((1.0, 1.0), (0.0, 1.0)),
        straight((0.0, 1.0), (0.0, 0.0)),
    ],
    "circle": [circle],
    "figure_eight": [figure_eight],
}


class Path(NamedTuple):
    """A path at the control instants: how many steps it takes, poses (x, y, yaw) and their rates, world axes.

    poses: (steps + 1, 1 + A, 3), each followed by those so many seconds later as the option `ahead` says; rates:
    (steps + 1, 3). Beyond its end a path rests.
    """

    steps: int
    poses: np.ndarray
    rates: np.ndarray


def sampled(table: np.ndarray, interval: float, ahead: tuple[float, ...]) -> Path:
    """The Path of a table, linear between its rows."""
    times = table[:, 0]
    steps = math.ceil(times[-1] / interval - 1e-9)
    instants = interval * np.arange(steps + 1)

    def at(moments: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(moments, times, values) for values in table[:, 1:].T], axis=-1)

    rates = (at(instants + 0.5 * interval) - at(instants - 0.5 * interval)) / interval
    return Path(steps, at(instants[:, None] + np.array([0.0, *ahead])), rates)


def checked(given: Any) -> np.ndarray:
    """The table of the option `path`: a name, or an array (K, 4). Raises ValueError."""
    if isinstance(given, str):
        return path(given)
    try:
        table = np.array(given, float)
    except (TypeError, ValueError):
        raise ValueError(f"path: must be {', '.join(SHAPES)}, or a table (K, 4) of time, x, y and yaw") from None
    if table.ndim != 2 or table.shape[1] != 4 or len(table) < 2:
        raise ValueError(f"path: a table must be (K, 4), K >= 2, of time, x, y and yaw, not {table.shape}")
    if not np.isfinite(table).all():
        raise ValueError(f"path: row {int(np.argmin(np.isfinite(table).all(axis=1)))} is not finite")
    if table[0, 0] != 0.0 or not (np.diff(table[:, 0]) > 0.0).all():
        raise ValueError("path: times must begin at 0 and increase")
    return table
