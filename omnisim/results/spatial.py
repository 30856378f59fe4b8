"""Datasets of a machine free in space: pose and motion of its chassis, and its energies."""

import numpy as np

from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.records import ORIENTATION, POSITION
from omnisim.dynamics.state import places_in
from omnisim.march.spatial_observation import ELASTIC, GRAVITY, KINETIC


def rotations(y: np.ndarray) -> np.ndarray:
    """(T, 3, 3): chassis axes as columns, world components."""
    return matrices(unit_quaternions(y))


def matrices(orientation: np.ndarray) -> np.ndarray:
    """The same of unit quaternions (T, 4), w x y z."""
    w, x, y_, z = orientation.T
    rows = [
        [1 - 2 * (y_ * y_ + z * z), 2 * (x * y_ - w * z), 2 * (x * z + w * y_)],
        [2 * (x * y_ + w * z), 1 - 2 * (x * x + z * z), 2 * (y_ * z - w * x)],
        [2 * (x * z - w * y_), 2 * (y_ * z + w * x), 1 - 2 * (x * x + y_ * y_)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def attitude(orientation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Roll and pitch (T,) of unit quaternions (T, 4), rad: the chassis is turned by yaw, then pitch, then roll."""
    found = matrices(orientation)
    pitch = -np.arcsin(np.clip(found[:, 2, 0], -1.0, 1.0))
    return np.arctan2(found[:, 2, 1], found[:, 2, 2]), pitch


def unit_quaternions(y: np.ndarray) -> np.ndarray:
    """(T, 4): w, x, y, z, of length 1 and without a jump of the sign."""
    found = y[:, ORIENTATION : ORIENTATION + 4]
    return found / np.linalg.norm(found, axis=1)[:, None]


def turned(rotation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (T, 3) or (3,) along chassis axes, in the world (T, 3). Rounded alike however many rows there are."""
    along = np.broadcast_to(vectors, (len(rotation), 3))[:, None, :] * rotation
    return along[:, :, 0] + along[:, :, 1] + along[:, :, 2]


def origin_in_space(parameters: Parameters, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The chassis origin, and its arm from C, world axes (T, 3), m."""
    assert parameters.space is not None
    arm = turned(rotations(y), np.asarray(parameters.space.body.origin))
    return y[:, POSITION : POSITION + 3] + arm, arm


def yaw_in_space(y: np.ndarray) -> np.ndarray:
    """Angle of the chassis x axis seen along z, continuous from row to row, rad."""
    forward = rotations(y)[:, :, 0]
    yaw = np.arctan2(forward[:, 1], forward[:, 0])
    finite = np.isfinite(yaw)
    yaw[finite] = np.unwrap(yaw[finite])
    return yaw


def body_in_space(parameters: Parameters, y: np.ndarray, slopes: np.ndarray) -> dict[str, np.ndarray]:
    """Motion of the chassis and of its origin, world axes."""
    at = places_in(parameters)
    rotation = rotations(y)
    origin, arm = origin_in_space(parameters, y)
    rate = turned(rotation, y[:, at.rate : at.rate + 3])
    bend = turned(rotation, slopes[:, at.rate : at.rate + 3])
    around = np.cross(rate, arm)
    forward = rotation[:, :, 0]
    moving = np.cross(rate, forward)
    curving = np.cross(bend, forward) + np.cross(rate, moving)
    square = forward[:, 0] ** 2 + forward[:, 1] ** 2
    yaw_rate = (forward[:, 0] * moving[:, 1] - forward[:, 1] * moving[:, 0]) / square
    growth = 2.0 * (forward[:, 0] * moving[:, 0] + forward[:, 1] * moving[:, 1])
    turning = forward[:, 0] * curving[:, 1] - forward[:, 1] * curving[:, 0]
    return {
        "body/position": origin,
        "body/velocity": y[:, at.velocity : at.velocity + 3] + around,
        "body/acceleration": slopes[:, at.velocity : at.velocity + 3] + np.cross(bend, arm) + np.cross(rate, around),
        "body/orientation": unit_quaternions(y),
        "body/angular_velocity": rate,
        "body/yaw": yaw_in_space(y),
        "body/yaw_rate": yaw_rate,
        "body/yaw_acceleration": (turning - yaw_rate * growth) / square,
    }


def balanced_in_space(
    parameters: Parameters, y: np.ndarray, energies: np.ndarray, done: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Energies, and what is missing between them and these works."""
    at = places_in(parameters)
    contact_loss, damper_loss = y[:, at.contact_loss], y[:, at.damper_loss]
    whole = energies.sum(axis=1)
    losses = done["energy/friction_loss"] + done["energy/bearing_loss"] + contact_loss + damper_loss
    losses = losses + done.get("energy/rolling_loss", 0.0)
    return {
        "energy/kinetic": energies[:, KINETIC],
        "energy/gravity": energies[:, GRAVITY],
        "energy/elastic": energies[:, ELASTIC],
        "energy/contact_loss": contact_loss,
        "energy/damper_loss": damper_loss,
        "energy/balance": whole - whole[:1] + losses - done["energy/drive_work"] - done["energy/wrench_work"],
    }
