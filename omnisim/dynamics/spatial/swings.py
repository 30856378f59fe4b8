"""How a machine free in space swings on its rubber and springs: small motions of an upright machine that rolls freely.

    M q'' + C q' + K q = 0,   q = (rise of C, turns about chassis x and y, s of every carrier)

M: masses as in the equations of motion. K = sum over contacts of stiffness j j^T, and of springs; C likewise. j: how q
raises a wheel, which touches below its centre; gravity's part in K is left out, as it is small.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.dynamics.parameters import Parameters

RISE, ROLL, PITCH = range(3)
NAMES = ("heave", "roll", "pitch")
SHARING = 2.0  # rollers that carry a wheel where one takes over from the next


class Swing(NamedTuple):
    """What swings most, how often undamped (Hz), and its damping as a part of what would stop it without a swing."""

    name: str
    frequency: float
    damping: float


def swings(parameters: Parameters) -> list[Swing]:
    """The slow ones first."""
    mass, damping, stiffness = matrices(parameters, 1.0)
    root = np.linalg.inv(np.linalg.cholesky(mass))
    squares, ways = np.linalg.eigh(root @ stiffness @ root.T)
    reach = float(np.abs(np.asarray(parameters.space.hubs.centre)).max())  # type: ignore[union-attr]
    found = []
    for square, way in zip(squares, (root.T @ ways).T, strict=True):
        rate = math.sqrt(max(square, 0.0))
        size = np.abs(way) * np.array([1.0, reach, reach] + [1.0] * (len(way) - 3))
        most = int(np.argmax(size))
        part = float(way @ damping @ way) / (2.0 * rate) if rate > 0.0 else 0.0
        found.append(Swing(NAMES[most] if most < 3 else "hub", rate / (2.0 * math.pi), part))
    return found


def fastest_swing(parameters: Parameters) -> float:
    """Largest rate of these motions, 1/s, with two rollers on the ground of each wheel: what explicit steps follow."""
    mass, damping, stiffness = matrices(parameters, SHARING)
    count = len(mass)
    inverse = np.linalg.inv(mass)
    upper = np.hstack([np.zeros((count, count)), np.eye(count)])
    lower = np.hstack([-inverse @ stiffness, -inverse @ damping])
    return float(np.abs(np.linalg.eigvals(np.vstack([upper, lower]))).max())


def matrices(parameters: Parameters, sharing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C, K (3 + carriers squared), SI, with so many contacts of each wheel."""
    space = parameters.space
    assert space is not None
    carriers = list(space.carriers)
    count = 3 + len(carriers)
    mass, damping, stiffness = (np.zeros((count, count)) for _ in range(3))
    body = space.body
    x, y = body.moment[:2]
    mass[:3, :3] = [[body.base_mass, y, -x], [y, *body.inertia[0, :2]], [-x, *body.inertia[1, :2]]]
    for j, carrier in enumerate(carriers):
        centre, axis = np.asarray(carrier.centre), np.asarray(carrier.axis)
        way, turns = raised(centre, count), np.eye(3, count, 1)[:2]
        if carrier.turns:
            way[3 + j] = np.cross(axis, centre - carrier.point)[2]
            turns[:, 3 + j] = axis[:2]
        else:
            way[3 + j] = 1.0
        mass += carrier.mass * np.outer(way, way) + turns.T @ np.asarray(carrier.inertia)[:2, :2] @ turns
        if carrier.turns:  # what it does sideways too
            aside = np.cross(axis, centre - carrier.point)[:2]
            mass[3 + j, 3 + j] += carrier.mass * float(aside @ aside)
        stiffness[3 + j, 3 + j] += carrier.stiffness
        damping[3 + j, 3 + j] += carrier.damping
    for hub in space.hubs:
        way = raised(np.asarray(hub.centre), count)
        if hub.carrier >= 0:
            carrier = carriers[hub.carrier]
            arm = np.asarray(hub.centre) - carrier.point
            way[3 + hub.carrier] = np.cross(carrier.axis, arm)[2] if carrier.turns else 1.0
        stiffness += sharing * hub.stiffness * np.outer(way, way)
        damping += sharing * hub.damping * np.outer(way, way)
    return mass, damping, stiffness


def raised(point: np.ndarray, count: int) -> np.ndarray:
    """How q raises a point that is fixed to the chassis, from C."""
    way = np.zeros(count)
    way[RISE], way[ROLL], way[PITCH] = 1.0, point[1], -point[0]
    return way
