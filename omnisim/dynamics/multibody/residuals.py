"""How well the bodies of a state keep what joints and floor ask of them: residuals of all constraints, row by row."""

from typing import NamedTuple

import numpy as np

from omnisim.dynamics.indices import row_index
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import BODY_STATES, places_in


class Bodies(NamedTuple):
    """Places and motions of all bodies in T states: (T, bodies, 3), and rotation matrices (T, bodies, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    rate: np.ndarray


class Joint(NamedTuple):
    """A revolute joint at `point` and along `axis` of the parent, and along `own_axis` of the child, whose centre of
    mass it holds."""

    parent: int
    child: int
    point: np.ndarray
    axis: np.ndarray
    own_axis: np.ndarray


def residuals(parameters: Parameters, y: np.ndarray) -> dict[str, np.ndarray]:
    """Datasets of the multibody formulation for states y (T, n): residuals of the constraints and the drift.

    Of positions: distances between the two points that a joint holds together (m), sines of the angles between its two
    axes, height and tilt of the chassis, and norms of the quaternions less 1; of velocities their rates (m/s, rad/s).
    """
    at = places_in(parameters)
    machine = parameters.machine
    wheels, _, most = parameters.sector.shape
    states = y[:, at.bodies : at.drift].reshape(len(y), 1 + wheels * (most + 1), BODY_STATES)
    position, quaternion, velocity, rate = np.split(states, (3, 7, 10), axis=-1)  # as in rigid_body.py
    bodies = Bodies(position, matrices(quaternion), velocity, rate)
    chassis = bodies.rotation[:, 0]
    up = np.array([0.0, 0.0, 1.0])
    arm = chassis @ machine.lever
    height = position[:, 0, 2] - arm[:, 2] - machine.height
    rise = velocity[:, 0, 2] - np.cross(rate[:, 0], arm)[:, 2]
    gaps = [height, *(chassis[..., 2] - up).T]
    speeds = [rise, *rate[:, 0, :2].T]
    joints = []
    for w, wheel in enumerate(parameters.wheels):
        disk = 1 + w * (most + 1)
        heading = np.array([[wheel.cos_heading, -wheel.sin_heading], [wheel.sin_heading, wheel.cos_heading]])
        centre = np.array([*(heading @ wheel.offset), wheel.radius - machine.height]) - machine.lever
        axle = np.array([-wheel.sin_heading, wheel.cos_heading, 0.0])
        joints.append(Joint(0, disk, centre, axle, np.array([0.0, 1.0, 0.0])))
        for i in range(int(wheel.rollers)):
            row = parameters.roller_rows[row_index(wheel, i)]
            gamma = row.phase + 2.0 * wheel.alpha * i
            d = np.array([np.sin(gamma), 0.0, -np.cos(gamma)])  # in the disk, whose spin angle is in its rotation
            axis = wheel.cos_psi * np.cross([0.0, 1.0, 0.0], d) + wheel.sin_psi * np.array([0.0, 1.0, 0.0])
            place = wheel.roller_distance * d + np.array([0.0, row.offset, 0.0])
            joints.append(Joint(disk, disk + 1 + i, place, axis, up))
    for joint in joints:
        gaps += position_residuals(bodies, joint)
        speeds += velocity_residuals(bodies, joint)
    norms = np.linalg.norm(quaternion, axis=-1)
    gaps += list((norms[:, norms[0] > 0.0] - 1.0).T) if len(y) else []
    return {
        "constraints/position": np.abs(gaps).max(axis=0),
        "constraints/velocity": np.abs(speeds).max(axis=0),
        "constraints/position_drift": y[:, at.drift].copy(),
        "constraints/velocity_drift": y[:, at.drift + 1].copy(),
    }


def position_residuals(bodies: Bodies, joint: Joint) -> list[np.ndarray]:
    """Six (T,): the gap between the two points of a joint, and the sines of the angles between its two axes."""
    parent, child = joint.parent, joint.child
    arm, along = bodies.rotation[:, parent] @ joint.point, bodies.rotation[:, parent] @ joint.axis
    now = bodies.rotation[:, child] @ joint.own_axis
    return [*(bodies.position[:, child] - bodies.position[:, parent] - arm).T, *np.cross(along, now).T]


def velocity_residuals(bodies: Bodies, joint: Joint) -> list[np.ndarray]:
    """Six (T,): the relative velocity of the two points, and the relative rate but for that about the axis."""
    parent, child = joint.parent, joint.child
    arm, along = bodies.rotation[:, parent] @ joint.point, bodies.rotation[:, parent] @ joint.axis
    rate = bodies.rate[:, parent]
    relative = bodies.rate[:, child] - rate
    apart = bodies.velocity[:, child] - bodies.velocity[:, parent] - np.cross(rate, arm)
    return [*apart.T, *(relative - np.sum(relative * along, axis=1)[:, None] * along).T]


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
