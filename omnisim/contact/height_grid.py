"""A bicubic spline through a grid of heights, level at the border and beyond it: two continuous derivatives inside."""

from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel
from omnisim.contact.surface import Surface


def spline_nodes(heights: np.ndarray) -> np.ndarray:
    """Floor.nodes of heights (rows, columns): what cubic Hermite polynomials need for two continuous derivatives."""
    if not heights.size:
        return np.zeros((0, 0, 4))
    along_x, along_y = differences(heights.T).T, differences(heights)
    return np.ascontiguousarray(np.stack([heights, along_x, along_y, differences(along_x)], axis=-1))


def differences(values: np.ndarray) -> np.ndarray:
    """Slopes by node (n, m) of the cubic splines through values (n, m) along the first axis, level at both ends.

    Continuous second derivatives: d_(i-1) + 4 d_i + d_(i+1) = 3 (v_(i+1) - v_(i-1)), d = 0 at the ends; solved by
    elimination.
    """
    found = np.zeros_like(values)
    found[1:-1] = 3.0 * (values[2:] - values[:-2])
    pivots = [4.0]
    for i in range(2, len(values) - 1):
        found[i] -= found[i - 1] / pivots[-1]
        pivots.append(4.0 - 1.0 / pivots[-1])
    for i in range(len(values) - 2, 0, -1):
        found[i] = (found[i] - found[i + 1]) / pivots[i - 1]
    return found


class Bounds(NamedTuple):
    """What a grid is never above (m), and what its second derivative along no direction exceeds (1/m)."""

    highest: float
    bend: float


def grid_bounds(nodes: np.ndarray, spacing: tuple[float, float]) -> Bounds:
    """Bounds of a grid: a cell lies within the hull of its Bezier points, its derivatives within their differences."""
    if not nodes.size:
        return Bounds(0.0, 0.0)
    height, along_x, along_y, both = np.moveaxis(nodes, -1, 0)
    points = bezier_points(bezier_points(height, along_y).T, bezier_points(along_x, both).T)  # along x, then y
    bends = [6.0 * most_bent(points, axis) / spacing[axis] ** 2 for axis in (0, 1)]
    twist = 9.0 * float(np.abs(np.diff(np.diff(points, axis=0), axis=1)).max()) / (spacing[0] * spacing[1])
    return Bounds(float(points.max()), max(bends) + twist)


def most_bent(points: np.ndarray, axis: int) -> float:
    """Largest second difference of Bezier points of one cell along an axis."""
    second = np.abs(np.diff(points, 2, axis=axis))
    across = np.arange(second.shape[axis]) % 3 == 2  # of two cells
    return float(second.compress(~across, axis=axis).max())


def bezier_points(values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Bezier points (3 n - 2, m) of the cubics between values (n, m) along the first axis."""
    found = np.empty((3 * len(values) - 2, values.shape[1]))
    found[::3] = values
    found[1::3] = values[:-1] + slopes[:-1] / 3.0
    found[2::3] = values[1:] - slopes[1:] / 3.0
    return found


def grid_hollowness(nodes: np.ndarray, spacing: tuple[float, float]) -> float:
    """The largest curvature at the nodes of a grid where it is hollow, 1/m."""
    if not nodes.size:
        return 0.0
    height, along_x, along_y, both = np.moveaxis(nodes, -1, 0)
    xx = bends(height.T, along_x.T).T / spacing[0] ** 2
    yy = bends(height, along_y) / spacing[1] ** 2
    xy = both / (spacing[0] * spacing[1])
    return max(0.0, float((0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), xy)).max()))


def bends(values: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """Second derivatives (n, m) at the nodes of cubic splines along the first axis."""
    after = 6.0 * (values[1:] - values[:-1]) - 4.0 * slopes[:-1] - 2.0 * slopes[1:]
    last = 6.0 * (values[-2] - values[-1]) + 2.0 * slopes[-2] + 4.0 * slopes[-1]
    return np.concatenate([after, last[None]])


class Cubic(NamedTuple):
    """The four cubic Hermite polynomials of a cell, or derivatives of them: of heights and of slopes at both ends."""

    first: float
    last: float
    first_slope: float
    last_slope: float


@kernel
def cell_of(place, count):
    """The cell of `count` nodes in which a place lies, counted in cells; the place in it, 0 to 1; 1 if it is inside the
    grid, else 0, and the place that of its border."""
    inside = 1.0 if 0.0 < place < count - 1 else 0.0
    if not place > 0.0:
        place = 0.0
    if place > count - 1:
        place = 1.0 * (count - 1)
    cell = min(int(place), count - 2)
    return cell, place - cell, inside


@kernel
def cubic(t):
    """Values, first and second derivatives (Cubic) at t, 0 to 1."""
    r = 1.0 - t
    value = Cubic(r * r * (1.0 + 2.0 * t), t * t * (3.0 - 2.0 * t), t * r * r, -t * t * r)
    slope = Cubic(-6.0 * t * r, 6.0 * t * r, r * (1.0 - 3.0 * t), t * (3.0 * t - 2.0))
    bend = Cubic(12.0 * t - 6.0, 6.0 - 12.0 * t, 6.0 * t - 4.0, 6.0 * t - 2.0)
    return value, slope, bend


@kernel
def mixed(a, b, column, slope):
    """One line of a cell along y: nodes a and b, and there the height (column 0) or its difference along x (1)."""
    return (
        slope.first * a[column]
        + slope.last * b[column]
        + slope.first_slope * a[column + 2]
        + slope.last_slope * (b[column + 2])
    )


@kernel
def blended(corners, by_x, by_y):
    """The cell's height, or that derivative of it of which these are the polynomials along x and y."""
    a, b, c, d = corners
    near, far = mixed(a, c, 0, by_y), mixed(b, d, 0, by_y)
    near_slope, far_slope = mixed(a, c, 1, by_y), mixed(b, d, 1, by_y)
    return by_x.first * near + by_x.last * far + by_x.first_slope * near_slope + by_x.last_slope * far_slope


@kernel
def grid_surface(nodes, origin, spacing, x, y):
    """The Surface of the grid: within a cell a bicubic polynomial, beyond the border as at it."""
    i, u, in_x = cell_of((x - origin[0]) / spacing[0], nodes.shape[1])
    j, v, in_y = cell_of((y - origin[1]) / spacing[1], nodes.shape[0])
    corners = nodes[j, i], nodes[j, i + 1], nodes[j + 1, i], nodes[j + 1, i + 1]
    value_x, slope_x, bend_x = cubic(u)
    value_y, slope_y, bend_y = cubic(v)
    by_x, by_y = in_x / spacing[0], in_y / spacing[1]
    return Surface(
        blended(corners, value_x, value_y),
        blended(corners, slope_x, value_y) * by_x,
        blended(corners, value_x, slope_y) * by_y,
        blended(corners, bend_x, value_y) * by_x * by_x,
        blended(corners, slope_x, slope_y) * by_x * by_y,
        blended(corners, value_x, bend_y) * by_y * by_y,
    )
