"""The ideal wheel: no slip along the axis of the roller in contact, so that the motion gives the spin rates.

    phi' = (V_h - tan(psi) V_k) / R             V_h, V_k  velocity of the wheel centre along heading and axle, m/s
    V    = (vx - yaw_rate y, vy + yaw_rate x)   x, y      wheel centre, m

The twist (vx, vy, yaw_rate) is that of the chassis origin in chassis axes (m/s, m/s, rad/s).
"""

import math

import numpy as np

from omnisim.config import Config

MOTIONS = ("forward motion", "sideways motion", "rotation")  # components of a twist
RANK_TOLERANCE = 1e-6  # smallest singular value / largest


def wheel_rows(config: Config) -> np.ndarray:
    """Rows (W, 3) of the ideal machine: phi' = rows @ twist, rad/s."""
    wheels, kinds = config.wheels, [config.type_of(wheel) for wheel in config.wheels]
    angles = [
        -k.roller_angle_deg if wheel.mirrored else k.roller_angle_deg for wheel, k in zip(wheels, kinds, strict=True)
    ]
    heading, tan = np.radians([wheel.heading_deg for wheel in wheels]), np.tan(np.radians(angles))
    cos, sin, (x, y) = np.cos(heading), np.sin(heading), np.array([wheel.position for wheel in wheels]).T
    along_x, along_y = cos + tan * sin, sin - tan * cos  # h - tan(psi) k in chassis axes
    return np.array([along_x, along_y, x * along_y - y * along_x]).T / [[kind.radius] for kind in kinds]


def inverse(rows: np.ndarray, distance: float) -> np.ndarray | None:
    """(3, W): the twist that fits spin rates best, twist = inverse @ phi'; None if they leave a motion open.

    distance (m), that of the wheels, makes a speed of the yaw rate.
    """
    scale = _scale(distance)
    spins, values, motions = np.linalg.svd(rows * scale, full_matrices=False)
    if _rank(values) < len(MOTIONS):
        return None
    return (scale[:, None] * motions.T / values) @ spins.T


def undetermined(rows: np.ndarray, distance: float) -> tuple[str, ...]:
    """The MOTIONS that spin rates leave open. distance: see `inverse`."""
    _, values, motions = np.linalg.svd(rows * _scale(distance))
    shares = (motions[_rank(values) :] ** 2).sum(axis=0)  # of each component in the free motions, squared
    return tuple(name for name, share in zip(MOTIONS, shares, strict=True) if share > RANK_TOLERANCE**2)


def _scale(distance: float) -> np.ndarray:
    return np.array([1.0, 1.0, 1.0 / distance if distance > 0.0 else 0.0])


def _rank(values: np.ndarray) -> int:
    return np.count_nonzero(values > RANK_TOLERANCE * values[0])


def rms_distance(config: Config) -> float:
    """Root mean square distance of the wheel centres from the chassis origin, m."""
    squares = [x * x + y * y for x, y in (wheel.position for wheel in config.wheels)]
    return math.sqrt(sum(squares) / len(squares))
