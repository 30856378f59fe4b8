"""Vectors of the oracle: the places in the 18 numbers of a body, products, and rates of what turns."""

from collections.abc import Callable
from math import cos, sin, sqrt

import numpy as np

UP = np.array([0.0, 0.0, 1.0])
FLAT = np.array([1.0, 1.0, 0.0])
# Places in the 18 numbers of a body; AXIS is the second column of its Q.
POSITION, ROTATION, VELOCITY, OMEGA = slice(3), slice(3, 12), slice(12, 15), slice(15, 18)
AXIS = slice(4, 12, 3)
TURN = 2e-4  # rad, of differences: to some 1e-12 of what they are of
SKEW = np.zeros((3, 9))
SKEW[[0, 1, 2], [7, 2, 3]], SKEW[[0, 1, 2], [5, 6, 1]] = 1.0, -1.0


def skew(w: np.ndarray) -> np.ndarray:
    """Matrices of w x, shape (..., 3, 3)."""
    return (w @ SKEW).reshape(*w.shape, 3)


def cross(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """left x right along the last axis; several times faster than np.cross on a handful of rows."""
    return (skew(left) @ right[..., None])[..., 0]


def along_turning(function: Callable[[np.ndarray], np.ndarray], axis: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Rate of a function of a unit axis that turns with the rate w: as along_motion."""
    return along_motion(lambda _, axis: function(axis), (0.0 * axis, axis), (0.0 * w, w))


def along_motion(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray],
    place: tuple[np.ndarray, np.ndarray],
    motion: tuple[np.ndarray, np.ndarray],
) -> np.ndarray:
    """Rate of a function of a centre and a unit axis, which move with a velocity and turn with a rate: central
    differences of fourth order."""
    (centre, axis), (v, w) = place, motion
    rate = sqrt(w @ w)
    if rate == 0.0:
        return v
    about, across = w / rate, cross(w / rate, axis)
    level = (about @ axis) * about
    at = [
        function(centre + k * TURN / rate * v, level + cos(k * TURN) * (axis - level) + sin(k * TURN) * across)
        for k in (-2, -1, 1, 2)
    ]
    return rate / (12.0 * TURN) * (at[0] - 8.0 * at[1] + 8.0 * at[2] - at[3])
