"""Where the bodies of a machine are in every row of a run: the links of its URDF, each in the frame of its parent.

Orientations are unit quaternions w, x, y, z, as in trajectories, from a body's axes to those of its parent.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from omnisim.cad.robot_description import Body, bodies
from omnisim.results.layout import Recorded
from omnisim.results.rollers import joint_angles
from omnisim.scene.schema import Config

X, Y, Z = np.eye(3)


class Pose(NamedTuple):
    """position (T, 3), m, and orientation (T, 4)."""

    position: np.ndarray
    orientation: np.ndarray


class Twist(NamedTuple):
    """linear (T, 3), m/s, and angular (T, 3), rad/s, of a body along its own axes."""

    linear: np.ndarray
    angular: np.ndarray


class Joint(NamedTuple):
    """position, rate and effort (T,): rad, rad/s, N m; of what slides m, m/s, N. The effort is that of a drive."""

    position: np.ndarray
    rate: np.ndarray
    effort: np.ndarray


class Frames:
    """Of the bodies of a machine, parents first: `poses` by name, each in the frame of its parent, of the root in the
    world; `joints` by name of the body that turns or slides on it."""

    def __init__(self, trajectory: Recorded, config: Config):
        self.trajectory, self.config = trajectory, config
        self.bodies = tuple(bodies(config))
        self.root = self.bodies[0].name
        self.parents = {body.name: body.parent for body in self.bodies}
        states = joint_states(trajectory, config)
        self.joints = {body.name: states[body.name] for body in self.bodies if body.parent is not None}
        self.poses = {self.root: self.base} | {
            body.name: hung(body, self.joints[body.name].position) for body in self.bodies if body.parent is not None
        }

    @cached_property
    def base(self) -> Pose:
        """Of the root in the world."""
        run = self.trajectory
        if "body/orientation" in run:
            return Pose(run["body/position"], run["body/orientation"])
        orientation = about(Z, run["body/yaw"])
        if self.config.chassis is None:  # the wheel itself
            orientation = product(orientation, about(Y, run[f"wheels/{run.wheels[0]}/spin_angle"]))
        return Pose(run["body/position"], orientation)

    @cached_property
    def base_twist(self) -> Twist:
        """Of the root."""
        run, back = self.trajectory, inverse(self.base.orientation)
        rate = run["body/angular_velocity"] if "body/angular_velocity" in run else run["body/yaw_rate"][:, None] * Z
        if self.config.chassis is None:
            axle = turned(about(Z, run["body/yaw"]), Y)
            rate = rate + run[f"wheels/{run.wheels[0]}/spin_rate"][:, None] * axle
        return Twist(turned(back, run["body/velocity"]), turned(back, rate))

    def in_world(self, name: str) -> Pose:
        """Of a body."""
        parent = self.parents[name]
        return self.poses[name] if parent is None else carried(self.in_world(parent), self.poses[name])


def joint_states(trajectory: Recorded, config: Config) -> dict[str, Joint]:
    """By name of the body on the joint. Those of wheels have the torque of their drives, all others turn freely."""
    still = np.zeros(len(trajectory.time))
    found = {}
    for wheel in config.wheels:
        path = f"wheels/{wheel.name}"
        spin = (trajectory[f"{path}/{name}"] for name in ("spin_angle", "spin_rate", "drive_torque"))
        found[f"{wheel.name}_wheel"] = Joint(*spin)
        columns = joint_angles(trajectory, wheel.name).T, trajectory[f"{path}/rollers/joint_rate"].T
        for number, (angle, rate) in enumerate(zip(*columns, strict=True)):
            found[f"{wheel.name}_roller_{number}"] = Joint(angle, rate, still)
        if wheel.suspension is not None:
            travel = trajectory[f"{path}/suspension_travel"], trajectory[f"{path}/suspension_rate"]
            found[f"{wheel.name}_hub"] = Joint(*travel, still)
    for rocker in config.axles:
        path = f"wheels/{rocker.wheels[0]}"  # as that of the other
        found[f"{rocker.name}_rocker"] = Joint(
            trajectory[f"{path}/rocker_angle"], trajectory[f"{path}/rocker_rate"], still
        )
    return found


def hung(body: Body, position: np.ndarray) -> Pose:
    """A body in the frame of its parent at these positions (T,) of its joint."""
    axis, place = np.array(body.axis.split(), float), np.array(body.place)
    roll, pitch, yaw = (about(axis, np.array([angle])) for axis, angle in zip((X, Y, Z), body.angles, strict=True))
    origin = product(product(yaw, pitch), roll)
    if body.slides:
        way = position[:, None] * turned(origin, axis)
        return Pose(place + way, np.broadcast_to(origin, (len(position), 4)))
    return Pose(np.broadcast_to(place, (len(position), 3)), product(origin, about(axis, position)))


# --- quaternions ----------------------------------------------------------------------------------


def about(axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """(T, 4): of turns by angles (T,), rad, about a unit vector."""
    return np.concatenate([np.cos(0.5 * angle)[:, None], np.sin(0.5 * angle)[:, None] * axis], axis=1)


def product(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(T, 4): of the second turn within the axes that the first has turned."""
    w, v = first[:, :1], first[:, 1:]
    w_, v_ = second[:, :1], second[:, 1:]
    scalar = w * w_ - (v * v_).sum(axis=1, keepdims=True)
    return np.concatenate([scalar, w * v_ + w_ * v + np.cross(v, v_)], axis=1)


def inverse(orientation: np.ndarray) -> np.ndarray:
    return orientation * [1.0, -1.0, -1.0, -1.0]


def turned(orientation: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (T, 3) or (3,) along axes of this orientation (T, 4), along those of its parent."""
    w, v = orientation[:, :1], orientation[:, 1:]
    across = np.cross(v, vectors)
    return vectors + 2.0 * (w * across + np.cross(v, across))


def carried(parent: Pose, child: Pose) -> Pose:
    """The child, in the frame in which its parent is."""
    position = parent.position + turned(parent.orientation, child.position)
    return Pose(position, product(parent.orientation, child.orientation))
