"""The ideal wheel: no slip along the axis of the roller in contact, so that the motion gives the spin rates.

    phi' = (V_h - tan(psi) V_k) / R             V_h, V_k  velocity of the wheel centre along heading and axle, m/s
    V    = (vx - yaw_rate y, vy + yaw_rate x)   x, y      wheel centre, m

The twist (vx, vy, yaw_rate) is that of the chassis origin in chassis axes (m/s, m/s, rad/s).
"""

import numpy as np

from omnisim.config import Config, Wheel

MOTIONS = ("forward motion", "sideways motion", "rotation")  # components of a twist
RANK_TOLERANCE = 1e-6  # smallest singular value / largest


def wheel_rows(config: Config) -> np.ndarray:
    """Rows (W, 3) of the ideal machine: phi' = rows @ twist, rad/s."""
    return np.array([_row(config, wheel) for wheel in config.wheels])


def _row(config: Config, wheel: Wheel) -> tuple[float, float, float]:
    kind = config.type_of(wheel)
    psi = np.radians(-kind.roller_angle_deg if wheel.mirrored else kind.roller_angle_deg)
    heading, (x, y) = np.radians(wheel.heading_deg), wheel.position
    along_x = np.cos(heading) + np.tan(psi) * np.sin(heading)  # h - tan(psi) k in chassis axes
    along_y = np.sin(heading) - np.tan(psi) * np.cos(heading)
    return along_x / kind.radius, along_y / kind.radius, (x * along_y - y * along_x) / kind.radius


def pseudo_inverse(rows: np.ndarray) -> np.ndarray:
    """(3, W): the twist that fits spin rates best, twist = pseudo_inverse(rows) @ phi'."""
    return np.linalg.pinv(rows)


def invertible(rows: np.ndarray, distance: float) -> bool:
    """Whether spin rates give all three components of the twist."""
    return not undetermined(rows, distance)


def undetermined(rows: np.ndarray, distance: float) -> tuple[str, ...]:
    """The MOTIONS that spin rates leave open. `distance` (m), that of the wheels, makes a speed of the yaw rate."""
    _, values, motions = np.linalg.svd(rows * (1.0, 1.0, 1.0 / distance if distance > 0.0 else 0.0))
    values = np.append(values, np.zeros(3 - len(values)))
    free = motions[values <= RANK_TOLERANCE * values[0]]
    shares = np.linalg.norm(free, axis=0)  # of each component in the free motions
    return tuple(name for name, share in zip(MOTIONS, shares, strict=True) if share > RANK_TOLERANCE)


def rms_distance(config: Config) -> float:
    """Root mean square distance of the wheel centres from the chassis origin, m."""
    return float(np.sqrt(np.mean([x * x + y * y for x, y in (wheel.position for wheel in config.wheels)])))
