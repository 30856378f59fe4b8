"""Where a machine free in space begins: as the scene places it, or at rest on the ground."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.records import ORIENTATION, POSITION
from omnisim.dynamics.state import places_in
from omnisim.scene.schema import Config


class Pose(NamedTuple):
    """Height of the chassis origin (m), pitch and roll (rad), and s of every carrier (m or rad)."""

    height: float
    pitch: float
    roll: float
    carriers: np.ndarray


def pose_at_start(config: Config, parameters: Parameters) -> Pose:
    """As the scene says, or in static equilibrium."""
    space = parameters.space
    assert space is not None
    count = 0 if space.carriers is None else len(space.carriers)
    initial = config.initial
    return Pose(initial.height or 0.0, math.radians(initial.pitch_deg), math.radians(initial.roll_deg), np.zeros(count))


def state_in_space(config: Config, parameters: Parameters, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """State y (n,) without the rates of the rollers that touch, and rates (W, N) of all rollers, rad/s."""
    space = parameters.space
    assert space is not None
    at = places_in(parameters)
    initial = config.initial
    y = np.zeros(at.rho)
    yaw = math.radians(initial.yaw_deg)
    rotation = about_z(yaw) @ about_y(pose.pitch) @ about_x(pose.roll)
    arm = -rotation @ space.body.origin  # C from the origin
    heading = about_z(yaw)
    rate = np.array([0.0, 0.0, initial.yaw_rate])
    rate += initial.pitch_rate * heading[:, 1] + initial.roll_rate * (heading @ about_y(pose.pitch))[:, 0]
    origin = np.array([*initial.position, pose.height])
    y[POSITION : POSITION + 3] = origin + arm
    y[ORIENTATION : ORIENTATION + 4] = quaternion(yaw, pose.pitch, pose.roll)
    y[at.velocity : at.velocity + 3] = np.add([*initial.velocity, initial.vertical_velocity], np.cross(rate, arm))
    y[at.rate : at.rate + 3] = inner = rotation.T @ rate
    y[at.joint : at.joint + len(pose.carriers)] = pose.carriers
    if parameters.machine.odometry:
        y[at.odometry : at.odometry + 2] = initial.position
    spin_rates = np.array([wheel.spin_rate for wheel in config.wheels])
    count = len(spin_rates)
    y[at.spin_angle : at.spin_angle + count] = [wheel.spin_angle for wheel in config.wheels]
    y[at.spin_rate : at.spin_rate + count] = spin_rates
    return y, roller_rates(config, parameters, y, inner)


def roller_rates(config: Config, parameters: Parameters, y: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """p = chi' + w . a of all rollers (W, N), rad/s; rate: angular velocity of the chassis along its axes."""
    space = parameters.space
    assert space is not None
    at = places_in(parameters)
    rates = np.zeros(space.disk.shape[:2])
    for w, wheel in enumerate(config.wheels):
        record = parameters.wheels[w]
        number = int(record.rollers)
        angle = y[at.spin_angle + w]
        cos_g, sin_g = space.disk[w, :number, 0], space.disk[w, :number, 1]
        cos_q = cos_g * math.cos(angle) + sin_g * math.sin(angle)
        sin_q = sin_g * math.cos(angle) - cos_g * math.sin(angle)
        along, about = space.hubs[w].h @ rate, space.hubs[w].k @ rate + y[at.spin_rate + w]
        turning = record.sin_psi * about - record.cos_psi * (along * cos_q + rate[2] * sin_q)
        rates[w, :number] = np.asarray(wheel.roller_rates) + turning
    return rates


def quaternion(yaw: float, pitch: float, roll: float) -> np.ndarray:
    """Of the turns by yaw, then pitch, then roll: w, x, y, z."""
    (cy, sy), (cp, sp), (cr, sr) = ((math.cos(0.5 * angle), math.sin(0.5 * angle)) for angle in (yaw, pitch, roll))
    return np.array(
        [
            cy * cp * cr + sy * sp * sr,
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
        ]
    )


def about_x(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]])


def about_y(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])


def about_z(angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
