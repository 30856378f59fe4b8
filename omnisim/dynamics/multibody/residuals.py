"""How well the bodies of a state keep what joints and floor ask of them: residuals of all constraints, row by row."""

import numpy as np

from omnisim.dynamics.indices import row_index
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import BODY_STATES, places_in


def residuals(parameters: Parameters, y: np.ndarray) -> dict[str, np.ndarray]:
    """Datasets of the multibody formulation for states y (T, n): residuals of the constraints and the drift.

    Of positions: distances between the two points that a joint holds together (m), sines of the angles between its two
    axes, height and tilt of the chassis, and norms of the quaternions less 1; of velocities their rates (m/s, rad/s).
    """
    at, machine = places_in(parameters), parameters.machine
    wheels, most = parameters.sector.shape[:2]
    bodies = y[:, at.bodies : at.drift].reshape(len(y), 1 + wheels * (most + 1), BODY_STATES)
    position, velocity, rate, rotation = (
        bodies[..., :3],
        bodies[..., 7:10],
        bodies[..., 10:],
        matrices(bodies[..., 3:7]),
    )
    chassis, up = rotation[:, 0], np.array([0.0, 0.0, 1.0])
    arm = chassis @ machine.lever
    height = position[:, 0, 2] - arm[:, 2] - machine.height
    rise = velocity[:, 0, 2] - np.cross(rate[:, 0], arm)[:, 2]
    gaps, speeds = [height, *(chassis[..., 2] - up).T], [rise, *rate[:, 0, :2].T]
    for w, wheel in enumerate(parameters.wheels):
        disk = 1 + w * (most + 1)
        heading = np.array([[wheel.cos_heading, -wheel.sin_heading], [wheel.sin_heading, wheel.cos_heading]])
        centre = np.array([*(heading @ wheel.offset), wheel.radius - machine.height]) - machine.lever
        axle = np.array([-wheel.sin_heading, wheel.cos_heading, 0.0])
        joint_residuals(gaps, speeds, bodies, rotation, 0, disk, centre, axle, np.array([0.0, 1.0, 0.0]))
        for i in range(int(wheel.rollers)):
            row = parameters.roller_rows[row_index(wheel, i)]
            gamma = row.phase + 2.0 * wheel.alpha * i
            d = np.array([np.sin(gamma), 0.0, -np.cos(gamma)])  # in the disk, whose spin angle is in its rotation
            axis = wheel.cos_psi * np.cross([0.0, 1.0, 0.0], d) + wheel.sin_psi * np.array([0.0, 1.0, 0.0])
            place = wheel.roller_distance * d + np.array([0.0, row.offset, 0.0])
            joint_residuals(gaps, speeds, bodies, rotation, disk, disk + 1 + i, place, axis, up)
    norms = np.linalg.norm(bodies[..., 3:7], axis=-1)
    gaps += list((norms[:, norms[0] > 0.0] - 1.0).T) if len(y) else []
    return {
        "constraints/position": np.abs(gaps).max(axis=0),
        "constraints/velocity": np.abs(speeds).max(axis=0),
        "constraints/position_drift": y[:, at.drift].copy(),
        "constraints/velocity_drift": y[:, at.drift + 1].copy(),
    }


def joint_residuals(gaps, speeds, bodies, rotation, parent, child, point, axis, own_axis) -> None:
    """Append the residuals of a revolute joint at `point` and along `axis` of the parent, and along `own_axis` of the
    child, whose centre of mass it holds."""
    arm, along = rotation[:, parent] @ point, rotation[:, parent] @ axis
    now = rotation[:, child] @ own_axis
    gaps += list((bodies[:, child, :3] - bodies[:, parent, :3] - arm).T)
    gaps += list(np.cross(along, now).T)
    rate = bodies[:, parent, 10:]
    speeds += list((bodies[:, child, 7:10] - bodies[:, parent, 7:10] - np.cross(rate, arm)).T)
    relative = bodies[:, child, 10:] - rate
    speeds += list((relative - np.sum(relative * along, axis=1)[:, None] * along).T)


def matrices(q: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), whatever their norm."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    square = w * w + x * x + y * y + z * z
    rows = (
        (w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z),
    )
    matrix = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return matrix / np.where(square > 0.0, square, 1.0)[..., None, None]
