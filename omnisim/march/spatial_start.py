"""Where a machine free in space begins: as the scene places it, or at rest on the ground."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.calls import direct
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.equilibrium import NoEquilibriumError, find_equilibrium, weigh
from omnisim.dynamics.spatial.records import ORIENTATION, POSITION
from omnisim.dynamics.state import places_in
from omnisim.march.spatial_events import clearance
from omnisim.scene.problems import ConfigError, Problem
from omnisim.scene.rollers import thickest
from omnisim.scene.schema import Config

HEIGHT = ("initial", "height")
FREE = ("scene", "upright")  # what asks for a pose
TIPPED = math.radians(60.0)  # of pitch or roll: it may rest there, but does not stand


class Pose(NamedTuple):
    """Height of the chassis origin (m), pitch and roll (rad), and s of every carrier (m or rad)."""

    height: float
    pitch: float
    roll: float
    carriers: np.ndarray


def pose_at_start(config: Config, parameters: Parameters) -> Pose:
    """As the scene says, or in static equilibrium. Raises ConfigError if there is none, or for a sunken wheel."""
    space = parameters.space
    assert space is not None
    count = len(space.carriers)
    initial = config.initial
    if initial.placed:
        pitch, roll = math.radians(initial.pitch_deg), math.radians(initial.roll_deg)
        pose = Pose(initial.height or 0.0, pitch, roll, np.zeros(count))
        above_ground(config, parameters, pose)
        return pose
    return standing_pose(config, parameters)[0]


def standing_pose(config: Config, parameters: Parameters) -> tuple[Pose, np.ndarray]:
    """The Pose in static equilibrium where the scene puts the machine, and the loads of its wheels (W,), N.

    Raises ConfigError if there is none.
    """
    space = parameters.space
    assert space is not None
    count = len(space.carriers)

    def state_at(x: np.ndarray) -> np.ndarray:
        return positions(config, parameters, Pose(x[0], x[1], x[2], x[3:]))

    try:
        x, loads = find_equilibrium(parameters, state_at, count)
        if max(abs(x[1]), abs(x[2])) > TIPPED:
            raise NoEquilibriumError("it tips over")
        if direct(clearance, parameters, state_at(x)) < 0.0:
            raise NoEquilibriumError("its chassis would be in the ground")
    except NoEquilibriumError as error:
        what = f"missing, and where the scene puts the machine it has no pose at rest to begin in: {error}"
        raise ConfigError([Problem(HEIGHT, f"{what}; give a height, pitch_deg or roll_deg", FREE)]) from None
    return Pose(x[0], x[1], x[2], x[3:]), loads


def above_ground(config: Config, parameters: Parameters, pose: Pose) -> None:
    """Raises ConfigError for a wheel deeper in the ground than its rollers are thick: nothing there is right."""
    assert parameters.space is not None
    loads = np.zeros(len(config.wheels))
    direct(weigh, parameters, positions(config, parameters, pose), 1.0, loads)
    depths = loads / np.asarray(parameters.space.hubs.stiffness)
    for wheel, depth in zip(config.wheels, depths, strict=True):
        most = thickest(config.type_of(wheel))
        if depth > most:
            what = f"wheel '{wheel.name}' begins below the ground: the depths of its rollers in it add up to"
            sizes = f"{depth:.3g} m, more than the radius of one, {most:.3g} m"
            raise ConfigError([Problem(HEIGHT, f"{what} {sizes}; give a greater height")])


def positions(config: Config, parameters: Parameters, pose: Pose) -> np.ndarray:
    """State y (n,) of a machine that does not move."""
    space = parameters.space
    assert space is not None
    at = places_in(parameters)
    y = np.zeros(at.rho)
    yaw = math.radians(config.initial.yaw_deg)
    rotation = about_z(yaw) @ about_y(pose.pitch) @ about_x(pose.roll)
    y[POSITION : POSITION + 3] = [*config.initial.position, pose.height] - rotation @ space.body.origin
    y[ORIENTATION : ORIENTATION + 4] = quaternion(yaw, pose.pitch, pose.roll)
    y[at.joint : at.joint + len(pose.carriers)] = pose.carriers
    y[at.spin_angle : at.spin_angle + len(config.wheels)] = [wheel.spin_angle for wheel in config.wheels]
    if parameters.machine.odometry:
        y[at.odometry : at.odometry + 2] = config.initial.position
    return y


def state_in_space(config: Config, parameters: Parameters, pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    """State y (n,) without the rates of the rollers that touch, and rates (W, N) of all rollers, rad/s."""
    space = parameters.space
    assert space is not None
    at = places_in(parameters)
    initial = config.initial
    y = positions(config, parameters, pose)
    heading = about_z(math.radians(initial.yaw_deg))
    rotation = heading @ about_y(pose.pitch) @ about_x(pose.roll)
    rate = np.array([0.0, 0.0, initial.yaw_rate])
    rate += initial.pitch_rate * heading[:, 1] + initial.roll_rate * (heading @ about_y(pose.pitch))[:, 0]
    around = -np.cross(rate, rotation @ space.body.origin)
    y[at.velocity : at.velocity + 3] = np.add([*initial.velocity, initial.vertical_velocity], around)
    y[at.rate : at.rate + 3] = inner = rotation.T @ rate
    y[at.spin_rate : at.spin_rate + len(config.wheels)] = [wheel.spin_rate for wheel in config.wheels]
    return y, roller_rates(config, parameters, y, inner)


def roller_rates(config: Config, parameters: Parameters, y: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """p = chi' + w . a of all rollers (W, N), rad/s; rate: angular velocity of the chassis along its axes."""
    space = parameters.space
    assert space is not None
    at = places_in(parameters)
    rates = np.zeros((len(space.disk), space.disk.shape[2]))
    for w, wheel in enumerate(config.wheels):
        record = parameters.wheels[w]
        number = int(record.rollers)
        angle = y[at.spin_angle + w]
        cos_g, sin_g = space.disk[w, 0, :number], space.disk[w, 1, :number]
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
