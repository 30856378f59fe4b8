"""Uneven ground as pictures show it: its height and normal at any place, and a mesh of it."""

import math

import numpy as np

from omnisim.contact.floor import Floor
from omnisim.dynamics.ground import floor_of_scene
from omnisim.scene.schema import Config

NEAR, FAR = 2.0, 12.0  # sizes of the machine, around its path: ground that is drawn finely, and at all
FINE = 40  # lines of the mesh to a size of the machine
MOST = 220  # lines each way where it is fine
COARSE = 8  # lines beyond, to each side
ROUND = 7  # points on an edge
FACE = 1e-6  # m, before a step: where its face begins
TINY = 1e-5  # m, of differences


def heights(floor: Floor, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """H(x, y), m, at so many places: what contact/floor.py has kernels for."""
    found = np.full(np.shape(x), floor.level)
    for x0, y0, height, radius in floor.bumps:
        found += height * np.exp(-((x - x0) ** 2 + (y - y0) ** 2) / radius**2)
    for x0, y0, ahead, aside, height, edge, width in floor.steps:
        s = (x - x0) * ahead + (y - y0) * aside
        arc = height - edge + np.sqrt(np.maximum(edge**2 - (width - s) ** 2, 0.0))
        found += np.where(s >= width, height, np.where(s >= 0.0, arc, 0.0))
    return found + grid_heights(floor, x, y)


def grid_heights(floor: Floor, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the grid, between its nodes by cubic Hermite polynomials; beyond it as at its border."""
    if not floor.nodes.size:
        return np.zeros(np.shape(x))
    count = np.array(floor.nodes.shape[1::-1])
    places = (np.stack([x, y], axis=-1) - floor.origin) / floor.spacing
    places = np.clip(places, 0.0, count - 1.0)
    cells = np.minimum(places.astype(int), count - 2)
    (i, j), (u, v) = np.moveaxis(cells, -1, 0), np.moveaxis(places - cells, -1, 0)

    def along(t, first, last, slope, last_slope):
        r = 1.0 - t
        return r * r * (1.0 + 2.0 * t) * first + t * t * (3.0 - 2.0 * t) * last + t * r * (r * slope - t * last_slope)

    near, far = (
        [along(u, *(floor.nodes[j + up, i + k, c] for c in (part, part + 1) for k in (0, 1))) for part in (0, 2)]
        for up in (0, 1)
    )
    return along(v, near[0], far[0], near[1], far[1])


def normals(floor: Floor, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Unit normals (..., 3), by differences; nearly level on the face of a step."""
    slope_x = heights(floor, x + TINY, y) - heights(floor, x - TINY, y)
    slope_y = heights(floor, x, y + TINY) - heights(floor, x, y - TINY)
    found = np.stack([-slope_x, -slope_y, np.full(np.shape(x), 2.0 * TINY)], axis=-1)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def mesh(config: Config, path: np.ndarray, size: float) -> np.ndarray | None:
    """Points (A, B, 3) on the ground around a path (T, 2) of a machine so large, m, A along the way up the first step;
    None of a plane."""
    floor = floor_of_scene(config)
    if floor is None:
        return None
    way = floor.steps[0, 2:4] if len(floor.steps) else np.array([1.0, 0.0])
    axes = np.array([way, [-way[1], way[0]]])
    a, b = (lines(floor, axis, path @ axis, size) for axis in axes)
    grid = np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1) @ axes
    return np.concatenate([grid, heights(floor, grid[..., 0], grid[..., 1])[..., None]], axis=-1)


def lines(floor: Floor, axis: np.ndarray, places: np.ndarray, size: float) -> np.ndarray:
    """Where lines of the mesh cross an axis: closely along the path, and along each edge of a step that they follow."""
    low, high = places.min() - NEAR * size, places.max() + NEAR * size
    count = min(math.ceil((high - low) / size * FINE), MOST)
    beyond = np.geomspace(size / FINE, (FAR - NEAR) * size, COARSE)
    found = [np.linspace(low, high, count), low - beyond, high + beyond]
    for x0, y0, ahead, aside, _, _, width in floor.steps:
        side = float(axis @ (ahead, aside))
        if abs(side) > 1.0 - 1e-9:
            round_edge = width * (1.0 - np.cos(np.linspace(0.0, 0.5 * np.pi, ROUND)))
            found.append(axis @ (x0, y0) + side * np.append(-FACE, round_edge))
    return np.unique(np.concatenate(found))
