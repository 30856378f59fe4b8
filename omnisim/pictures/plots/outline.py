"""The machine from above, where it is at a few instants: wheels, the frame between them, which way is front."""

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from omnisim.scene.rollers import half_width
from omnisim.scene.schema import Config

MOST = 6  # instants
APART = 1.3  # machine sizes along the path, at least: outlines do not cover each other


def outline(config: Config) -> tuple[list[np.ndarray], np.ndarray]:
    """Polygons (K, 2), m, in chassis axes: frame and wheels; a triangle that points to the front.

    The frame joins the wheel centres in turn. A bare wheel is its rectangle, and its heading the front.
    """
    wheels = [rectangle(config, wheel) for wheel in config.wheels]
    places = np.array([wheel.position for wheel in config.wheels])
    middle = places.mean(axis=0)
    order = np.argsort(np.arctan2(*(places - middle).T[::-1]))
    ahead, side = np.concatenate(wheels).max(axis=0)
    front = np.array([[ahead, 0.0], [0.5 * ahead, 0.25 * side], [0.5 * ahead, -0.25 * side]])
    return [places[order], *wheels] if len(wheels) > 2 else wheels, front


def rectangle(config: Config, wheel) -> np.ndarray:
    """A wheel from above (4, 2): two radii long, as wide as its rollers reach."""
    kind = config.type_of(wheel)
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * (kind.radius, half_width(kind))
    return moved(corners, np.array([*wheel.position, math.radians(wheel.heading_deg)]))


def moved(points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """Points (K, 2) in the axes of a pose x, y, yaw to those around it."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return points @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]


def instants(way: np.ndarray, size: float) -> np.ndarray:
    """Rows along a way (T), m, for outlines: the first, the last, between them at most MOST - 2, APART sizes apart."""
    parts = int(min(MOST - 1, max(1.0, way[-1] // (APART * size))))
    return np.unique(np.append(way.searchsorted(np.linspace(0.0, way[-1], parts + 1)[:-1]), len(way) - 1))


def draw_outlines(axes: Axes, config: Config, poses: np.ndarray, colour: str, filled: bool) -> None:
    """Outlines at some of the poses x, y, yaw (T, 3). None where the path is short beside the machine."""
    polygons, front = outline(config)
    corners = np.concatenate(polygons)
    size = float(np.hypot(*np.ptp(corners, axis=0)))
    if np.ptp(poses[:, :2], axis=0).max() < 0.5 * size:
        return
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])
    rows = instants(way, size)
    drawn = [moved(polygon, pose) for pose in poses[rows] for polygon in polygons]
    marks = [moved(front, pose) for pose in poses[rows]]
    look: dict[str, Any] = {"facecolor": colour, "alpha": 0.18} if filled else {"facecolor": "none", "alpha": 0.5}
    axes.add_collection(PolyCollection(drawn, edgecolor=colour, **look, zorder=1.1))
    axes.add_collection(PolyCollection(marks, facecolor=colour, linewidth=0.0, alpha=0.35, zorder=1.1))
    axes.update_datalim(np.concatenate(drawn))
