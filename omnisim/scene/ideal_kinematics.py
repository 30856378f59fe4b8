"""The ideal wheel: no slip along the axis of the roller in contact, so that the motion gives the spin rates.

    phi' = (V_h - tan(psi) V_k) / R             V_h, V_k  velocity of the wheel centre along heading and axle, m/s
    V    = (vx - yaw_rate y, vy + yaw_rate x)   x, y      wheel centre, m; the middle of rows that stand beside it

The twist (vx, vy, yaw_rate) is that of the chassis origin in chassis axes (m/s, m/s, rad/s).

Variants of one machine have the same wheels at the same places thousands of times: what follows from those is kept.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from omnisim.scene.schema import Config

MOTIONS = ("forward motion", "sideways motion", "rotation")  # components of a twist
RANK_TOLERANCE = 1e-6  # smallest singular value / largest
MECANUM = math.radians(20.0)  # roller angle from which on a wheel is one
PARALLEL = 1e-3  # sine between headings


class Stance(NamedTuple):
    """What of a wheel the ideal machine knows: heading and roller angle with its hand (deg), place and radius (m)."""

    heading: float
    roller_angle: float
    x: float
    y: float
    radius: float


def _stances(config: Config) -> tuple[Stance, ...]:
    found = []
    for wheel in config.wheels:
        kind = config.type_of(wheel)
        angle = -kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg
        x, y = wheel.position
        if kind.middle:
            heading = math.radians(wheel.heading_deg)
            x, y = x - kind.middle * math.sin(heading), y + kind.middle * math.cos(heading)
        found.append(Stance(wheel.heading_deg, angle, x, y, kind.radius))
    return tuple(found)


def wheel_rows(config: Config) -> np.ndarray:
    """Rows (W, 3) of the ideal machine: phi' = rows @ twist, rad/s. Not to be written into."""
    return _rows(_stances(config))


@lru_cache
def _rows(stances: tuple[Stance, ...]) -> np.ndarray:
    heading, roller_angle, x, y, radius = np.array(stances).T
    cos, sin, tan = np.cos(np.radians(heading)), np.sin(np.radians(heading)), np.tan(np.radians(roller_angle))
    along_x, along_y = cos + tan * sin, sin - tan * cos  # h - tan(psi) k in chassis axes
    return _fixed(np.array([along_x, along_y, x * along_y - y * along_x]).T / radius[:, None])


def _tangents(config: Config) -> np.ndarray:
    """tan(psi) of every wheel, its hand included."""
    return np.tan(np.radians([stance.roller_angle for stance in _stances(config)]))


def inverse(rows: np.ndarray, distance: float) -> np.ndarray | None:
    """(3, W): the twist that fits spin rates best, twist = inverse @ phi'; None if they leave a motion open. Not to be
    written into.

    distance (m), that of the wheels, makes a speed of the yaw rate.
    """
    return _inverse(rows.tobytes(), distance)


@lru_cache
def _inverse(rows: bytes, distance: float) -> np.ndarray | None:
    scale, (spins, values, motions) = _scale(distance), _decomposed(rows, distance)
    if _rank(values) < len(MOTIONS):
        return None
    return _fixed((scale[:, None] * motions.T / values) @ spins[:, : len(values)].T)


@lru_cache
def _decomposed(rows: bytes, distance: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Singular values and vectors of rows (W, 3) as bytes, their last column divided by the distance."""
    spins, values, motions = np.linalg.svd(np.frombuffer(rows).reshape(-1, len(MOTIONS)) * _scale(distance))
    return spins, values, motions


def undetermined(rows: np.ndarray, distance: float) -> tuple[str, ...]:
    """The MOTIONS that spin rates leave open. distance: see `inverse`."""
    return _undetermined(rows.tobytes(), distance)


@lru_cache
def _undetermined(rows: bytes, distance: float) -> tuple[str, ...]:
    _, values, motions = _decomposed(rows, distance)
    shares = (motions[_rank(values) :] ** 2).sum(axis=0)  # of each component in the free motions, squared
    return tuple(name for name, share in zip(MOTIONS, shares, strict=True) if share > RANK_TOLERANCE**2)


def _fixed(values: np.ndarray) -> np.ndarray:
    """The same, which nobody can change: it is handed out again."""
    values.flags.writeable = False
    return values


def _scale(distance: float) -> np.ndarray:
    return np.array([1.0, 1.0, 1.0 / distance if distance > 0.0 else 0.0])


def _rank(values: np.ndarray) -> int:
    return int(np.count_nonzero(values > RANK_TOLERANCE * values[0]))


def rms_distance(config: Config) -> float:
    """Root mean square distance of the wheel centres from the chassis origin, m."""
    squares = [x * x + y * y for x, y in (wheel.position for wheel in config.wheels)]
    return math.sqrt(sum(squares) / len(squares))


class Handedness(NamedTuple):
    """Mecanum wheels that stand at the wrong corner for their hand: their names, what follows, and the cure."""

    wrong: tuple[str, ...]
    told: str
    cure: str


def handedness(config: Config) -> Handedness | None:
    """Of four parallel mecanum wheels, one at each corner, those whose rollers have the hand of the other diagonal.

    Seen from above the axes of the rollers on the floor form an O, of those on top an X. A wheel at (a, b) from the
    middle, along and across the headings, turns the machine by a lever |a tan(psi) + b|: of an O the sum of two
    lengths, of an X their difference, which is 0 in a square.
    """
    wheels = config.wheels
    tan = _tangents(config)
    heading = np.radians([wheel.heading_deg for wheel in wheels])
    if len(wheels) != 4 or np.abs(tan).min() < math.tan(MECANUM) or np.ptp(np.sin(heading - heading[0])) > PARALLEL:
        return None
    places = np.array([wheel.position for wheel in wheels])
    cos, sin = (math.cos(heading[0]), math.sin(heading[0]))
    a, b = ((places - places.mean(axis=0)) @ [[cos, -sin], [sin, cos]]).T
    wrong = a * b * tan < 0.0
    if not wrong.any() or len(set(zip(a > 0.0, b > 0.0, strict=True))) != 4:
        return None
    names = tuple(wheel.name for wheel, is_wrong in zip(wheels, wrong, strict=True) if is_wrong)
    lever = np.abs(a * tan + b).max()
    best = (np.abs(a * tan) + np.abs(b)).max()
    able = f"turns by a lever of {lever:.3g} m, not {best:.3g} m" if lever > RANK_TOLERANCE * best else "cannot turn"
    told = f"the axes of rollers on the floor, seen from above, form an X for an O, so that the machine {able}"
    if not wrong.all():
        told = f"the rollers of {', '.join(names)} have the hand of the other diagonal"
    mirrored = [wheel.name for wheel, is_wrong in zip(wheels, wrong, strict=True) if wheel.mirrored != is_wrong]
    return Handedness(names, told, f"mirrored = true on {', '.join(mirrored) or 'none'}, and on no other wheel")
