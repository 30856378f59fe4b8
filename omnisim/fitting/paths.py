"""Paths of the tracked point: measured, simulated, dead-reckoned; and how far they are apart."""

from typing import NamedTuple

import numpy as np

from omnisim.fitting.logs import Log
from omnisim.fitting.parameters import Point


class Path(NamedTuple):
    """position (n, 2) m and yaw (n,) rad of the tracked point in the compared rows."""

    position: np.ndarray
    yaw: np.ndarray


class Errors(NamedTuple):
    """How far a path is from the measured one: in the last row (m, rad), and along it (m, root mean square)."""

    end_position: float
    end_yaw: float
    rms_position: float


def measured(log: Log, rows: np.ndarray) -> Path:
    """What a log has in these rows."""
    return Path(log.position[rows], log.yaw[rows])


def errors(path: Path, log: Path) -> Errors:
    """Of a path beside what is measured."""
    apart = np.hypot(*(path.position - log.position).T)
    return Errors(float(apart[-1]), float(abs(path.yaw[-1] - log.yaw[-1])), float(np.sqrt(np.mean(apart**2))))


def chassis_start(log: Log, point: Point) -> tuple[float, float, float]:
    """Place (m) and yaw (rad) of the chassis origin with which the tracked point has the log's first pose."""
    yaw = log.yaw[0] - point.yaw
    x, y = log.position[0] - turned(np.array([point.x, point.y]), yaw)
    return float(x), float(y), float(yaw)


def of_point(position: np.ndarray, yaw: np.ndarray, point: Point) -> Path:
    """The path of the tracked point from that of the chassis origin."""
    return Path(position + turned(np.array([point.x, point.y]), yaw), yaw + point.yaw)


def turned(vectors: np.ndarray, yaw: np.ndarray | float) -> np.ndarray:
    """Vectors (..., 2) turned by yaw (...), rad."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def between(time: np.ndarray, values: np.ndarray, rates: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Values (m, ...) at wanted times (m,), from rows (n, ...) with their rates, by cubic Hermite polynomials."""
    i = np.clip(np.searchsorted(time, wanted, side="right") - 1, 0, len(time) - 2)
    h = time[i + 1] - time[i]
    s = (wanted - time[i]) / h
    shape = (-1, *(1,) * (values.ndim - 1))
    s, h = s.reshape(shape), h.reshape(shape)
    a, b = values[i], values[i + 1]
    c = h * rates[i] - (b - a)
    d = (b - a) - h * rates[i + 1]
    return (1.0 - s) * a + s * b + s * (1.0 - s) * (c * (1.0 - s) + d * s)


def by_starts(paths: list[Path], weights: np.ndarray) -> np.ndarray:
    """(m, 3 L): how weighted residuals of all rows but the first depend on the pose in which each of L paths starts, x,
    y and yaw in weights: it moves the whole path rigidly, on a level floor exactly."""
    sizes = [3 * (len(path.yaw) - 1) for path in paths]
    found = np.zeros((sum(sizes), 3 * len(paths)))
    row = 0
    for i, (path, size) in enumerate(zip(paths, sizes, strict=True)):
        block = np.zeros((len(path.yaw), 3, 3))
        block[:, 0, 0] = block[:, 1, 1] = block[:, 2, 2] = 1.0
        block[:, :2, 2] = turned(path.position - path.position[0], 0.5 * np.pi)
        found[row : row + size, 3 * i : 3 * i + 3] = (block / weights[:, None] * weights)[1:].reshape(-1, 3)
        row += size
    return found
