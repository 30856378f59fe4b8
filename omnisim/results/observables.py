"""From recorded rows to the datasets of a trajectory: every quantity that the march itself does not need."""

from functools import cached_property

import numpy as np

from omnisim.base.calls import by_columns
from omnisim.base.copying import copied
from omnisim.base.records import plain
from omnisim.dynamics.energy import kinetic_energy, potential_energy
from omnisim.dynamics.multibody.residuals import residuals
from omnisim.dynamics.parameters import DRIVE_INPUT, SERVO, Parameters
from omnisim.dynamics.state import YAW, Places, Recording, places_in
from omnisim.march.extremes import (
    LENGTHS,
    OF_MOTORS,
    OF_WHEELS,
    bearing_extremes,
    extremes_of,
    odometry_extremes,
)
from omnisim.march.observation import Observed, observed_rows
from omnisim.results.spatial import balanced_in_space, body_in_space, origin_in_space, yaw_in_space
from omnisim.scene.schema import Config

EXTREMES, BEARINGS = "extremes", "bearings"  # a group for each quantity, a group for each wheel
ODOMETRY, YAWS = "odometry's extremes", "odometry's yaw"  # groups
WORKS = ("energy/friction_loss", "energy/bearing_loss", "energy/drive_work", "energy/wrench_work")


class Observables:
    """All datasets of T rows, `interval` seconds apart, but the events: by path in the trajectory file.

    They come in groups, a wheel's or those of energy, each computed when somebody asks for one of it. What overflows is
    infinite, or NaN.
    """

    def __init__(self, parameters: Parameters, rows: Recording, interval: float, config: Config):
        self.parameters = parameters
        self.rows = rows
        self.config = config
        self.interval = interval
        self._groups: dict[str, dict[str, np.ndarray]] = {}

    def __getitem__(self, path: str) -> np.ndarray:
        """Raises KeyError for a dataset that this scene does not have."""
        return self._group(group_of(path))[path]

    def everything(self) -> dict[str, np.ndarray]:
        """All of them."""
        wheels = [f"{folder}/{name}" for folder in ("wheels", BEARINGS) for name in self.names]
        extremes = [f"{EXTREMES}/{name}" for name in (*OF_WHEELS, *OF_MOTORS, *LENGTHS)]
        found: dict[str, np.ndarray] = {}
        for group in ("time", "body", "energy", "odometry", YAWS, ODOMETRY, "constraints", *wheels, *extremes):
            found |= self._group(group)
        return found

    @cached_property
    def times(self) -> np.ndarray:
        """(T,), s"""
        return np.arange(len(self.rows.y)) * self.interval

    @cached_property
    def names(self) -> dict[str, int]:
        """The wheels by name."""
        return {wheel.name: w for w, wheel in enumerate(self.config.wheels)}

    @cached_property
    def plain(self) -> Parameters:
        """Whose machine is read quicker than a record."""
        return self.parameters._replace(machine=plain(self.parameters.machine))

    @cached_property
    def observed(self) -> Observed:
        own = self.parameters._replace(workspace=copied(self.parameters.workspace))  # who marches on has the other
        return observed_rows(own, self.rows, self.times, self.config.bearing_loads)

    def _group(self, name: str) -> dict[str, np.ndarray]:
        if name not in self._groups:
            with np.errstate(over="ignore", invalid="ignore"):  # the caller drops rows that are not finite
                self._groups[name] = self._computed(name)
        return self._groups[name]

    def _computed(self, name: str) -> dict[str, np.ndarray]:
        folder, _, last = name.rpartition("/")
        if name == "time":
            return {"time": self.times}
        if folder == EXTREMES:
            return self._extremes(last)
        parameters = self.plain
        machine = parameters.machine
        if name == "body" and parameters.space is not None:
            return body_in_space(parameters, self.rows.y, self.observed.slopes)
        if name == "body":
            data = body(parameters, self.rows.y, self.observed.slopes, self.config.chassis is None)
            servo = self.config.chassis is not None and machine.upright == SERVO
            return data | ({"body/servo_torque": self.observed.servo} if servo else {})
        if name == "works":
            return works(parameters, self.rows.y)
        if name == "energy":
            data = self._group("works")
            data = data | self._balanced(data)
            return data | (motor_energies(parameters, self.rows.y, data["energy/balance"]) if machine.motors else {})
        if name == "odometry" and machine.odometry:
            return odometry(parameters, self.rows.y)
        if name == YAWS and machine.odometry:
            return odometry_yaws(parameters, self.rows.y)
        if name == ODOMETRY and machine.odometry and len(self.rows.odometry_extremes) == len(self.rows.y):
            return odometry_extremes(self.rows.odometry_extremes)
        if name == "constraints" and parameters.workspace.articulated is not None:
            return residuals(parameters, self.rows.y)
        if folder and last in self.names:
            return self._bearing_extremes(last) if folder == BEARINGS else self._of_wheel(last)
        return {}

    def _balanced(self, done: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Energies, and what is missing between them and these works."""
        if self.parameters.space is None:
            return balanced(self.plain, self.rows, done)
        return balanced_in_space(self.plain, self.rows.y, self.observed.energies, done)

    def _extremes(self, quantity: str) -> dict[str, np.ndarray]:
        """Of all wheels that have this quantity."""
        has = {
            name: w
            for name, w in self.names.items()
            if quantity not in OF_MOTORS or self.config.wheels[w].drive.kind == "dc_motor"
        }
        found = extremes_of(quantity, np.asarray(self.rows.extremes)) if has else {}
        return {
            f"{group}/wheels/{name}/{quantity}": values[:, w]
            for group, values in found.items()
            for name, w in has.items()
        }

    def _bearing_extremes(self, name: str) -> dict[str, np.ndarray]:
        """Of the bearings of one wheel, if anybody asks for them."""
        if not self.config.bearing_loads:
            return {}
        w = self.names[name]
        number = self.config.type_of(self.config.wheels[w]).rollers
        extremes = bearing_extremes(self.rows.bearing_extremes[:, w], number, self.config.chassis is not None)
        return {path.format(name): values for path, values in extremes.items()}

    def _of_wheel(self, name: str) -> dict[str, np.ndarray]:
        """All else of one wheel."""
        w = self.names[name]
        config = self.config
        motor = config.wheels[w].drive.kind == "dc_motor"
        number = config.type_of(config.wheels[w]).rollers
        chassis = config.chassis is not None
        group = wheel_datasets(places_in(self.plain), w, number, self.rows, self.observed)
        if config.wheels[w].drive.controlled:
            group["target_rate"] = targets(self.parameters, w, self.rows.piece, self.times)
        if motor:
            group |= motor_datasets(self.observed.wheels[:, w], self.parameters.wheels[w].resistance)
        seen = np.asarray(self.observed.wheels)[:, w]
        if config.wheels[w].suspension is not None:
            group |= {"suspension_travel": seen["travel"], "suspension_rate": seen["travel_rate"]}
        if config.rocker_of(config.wheels[w]) is not None:
            group |= {"rocker_angle": seen["travel"], "rocker_rate": seen["travel_rate"]}
        if not chassis:
            group["servo_torque"] = self.observed.servo[:, 0]
        if config.bearing_loads:
            group |= bearing_loads(self.observed.bearing_loads[:, w], number, chassis)
        return {f"wheels/{name}/{path}": values for path, values in group.items()}


def group_of(path: str) -> str:
    """The group that a dataset is computed with."""
    first, *rest = path.split("/")
    if first in ("interval_max", "interval_min"):
        if rest[0] != "wheels":
            return ODOMETRY
        return f"{BEARINGS}/{rest[1]}" if rest[-1].startswith("bearing_") else f"{EXTREMES}/{rest[2]}"
    if path in WORKS:
        return "works"
    if first == "odometry" and rest[0].startswith("yaw"):
        return YAWS
    return f"{first}/{rest[0]}" if first == "wheels" else first


def body(parameters: Parameters, y: np.ndarray, slopes: np.ndarray, bare: bool) -> dict[str, np.ndarray]:
    """Motion of the centre of a bare wheel at the constant height R, or of the chassis origin on the floor."""
    at = places_in(parameters)
    height = parameters.wheels[0].radius if bare else 0.0
    arm = to_centre(parameters, y)
    across = np.array([arm[:, 1], -arm[:, 0]]).T
    rate, bend = y[:, at.yaw_rate, None], slopes[:, at.yaw_rate, None]
    motion = np.zeros((3, len(y), 3))
    motion[0, :, :2] = y[:, :YAW] - arm
    motion[0, :, 2] = height
    motion[1, :, :2] = y[:, at.velocity : at.yaw_rate] + rate * across
    motion[2, :, :2] = slopes[:, at.velocity : at.yaw_rate] + bend * across + rate**2 * arm
    return {
        "body/position": motion[0],
        "body/velocity": motion[1],
        "body/acceleration": motion[2],
        "body/yaw": y[:, YAW],
        "body/yaw_rate": rate[:, 0],
        "body/yaw_acceleration": bend[:, 0],
    }


def to_centre(parameters: Parameters, y: np.ndarray) -> np.ndarray:
    """(T, 2), m: from the origin of the body to the common centre of mass, world axes."""
    ahead, left = parameters.machine.centre
    cos, sin = np.cos(y[:, YAW]), np.sin(y[:, YAW])
    return np.array([ahead * cos - left * sin, ahead * sin + left * cos]).T


def odometry(parameters: Parameters, y: np.ndarray) -> dict[str, np.ndarray]:
    """The position that the ideal wheels report, and its error."""
    at = places_in(parameters)
    reported = y[:, at.odometry : at.odometry + 2]
    if parameters.space is not None:
        position = origin_in_space(parameters, y)[0][:, :2]
    else:
        position = y[:, :YAW] - to_centre(parameters, y)
    return {"odometry/position": reported, "odometry/position_error": reported - position}


def odometry_yaws(parameters: Parameters, y: np.ndarray) -> dict[str, np.ndarray]:
    """The same of the yaw."""
    at = places_in(parameters)
    columns = parameters.wheels.odometry
    spin_angles = y[:, at.spin_angle : at.spin_angle + len(columns)]
    yaw = parameters.machine.odometry_yaw + spin_angles @ columns[:, 2]
    turned = y[:, YAW] if parameters.space is None else yaw_in_space(y)
    return {"odometry/yaw": yaw, "odometry/yaw_error": yaw - turned}


def works(parameters: Parameters, y: np.ndarray) -> dict[str, np.ndarray]:
    """What has been lost and done since t = 0, as the march has integrated it."""
    at = places_in(parameters)
    bearing_loss = y[:, at.bearing_loss] if parameters.machine.bearing_friction else np.zeros(len(y))
    found = y[:, at.friction_loss], bearing_loss, y[:, at.drive_work], y[:, at.wrench_work]
    rolling = {"energy/rolling_loss": y[:, at.rolling_loss]} if parameters.machine.rolling else {}
    return dict(zip(WORKS, found, strict=True)) | rolling


def balanced(parameters: Parameters, rows: Recording, done: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Energies, and what is missing between them and these works."""
    machine = parameters.machine
    y = rows.y
    kinetic = by_columns(kinetic_energy, parameters, places_in(parameters), y.T, rows.rates.transpose(1, 2, 0))
    gravity = by_columns(potential_energy, machine, y.T)
    loss, bearing_loss, drive, wrench = (done[path] for path in WORKS)
    loss = loss + done.get("energy/rolling_loss", 0.0)
    return {
        "energy/kinetic": kinetic,
        **({"energy/gravity": gravity} if machine.inclined else {}),
        "energy/balance": kinetic - kinetic[:1] + gravity - gravity[:1] + loss + bearing_loss - drive - wrench,
    }


def motor_energies(parameters: Parameters, y: np.ndarray, mechanical: np.ndarray) -> dict[str, np.ndarray]:
    """What motors take from their supply and where it goes; the balance with it, `mechanical` without."""
    at = places_in(parameters)
    count = len(parameters.wheels)
    currents = y[:, at.current : at.current + count] if parameters.machine.currents else np.zeros((len(y), count))
    magnetic = 0.5 * currents**2 @ parameters.wheels.inductance
    electrical, heat, loss, work = y[:, at.electrical : at.electrical + 4].T
    return {
        "energy/electrical": electrical,
        "energy/heat": heat,
        "energy/motor_loss": loss,
        "energy/motor_work": work,
        "energy/magnetic": magnetic,
        "energy/balance": mechanical + magnetic + heat + loss + work - electrical,
    }


def targets(parameters: Parameters, w: int, pieces: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Target rate of the drive of wheel w at so many times, on these pieces of the tables, rad/s."""
    value, slope = parameters.inputs[pieces, DRIVE_INPUT + w].T
    return value + slope * (times - parameters.starts[pieces])


def motor_datasets(seen: np.ndarray, resistance: float) -> dict[str, np.ndarray]:
    """Datasets of a motor, by path below the group of its wheel."""
    voltage, current = seen["voltage"], seen["current"]
    return {
        "voltage": voltage,
        "current": current,
        "electrical_power": voltage * current,
        "heat": resistance * current**2,
    }


def bearing_loads(found: np.ndarray, rollers: int, chassis: bool) -> dict[str, np.ndarray]:
    """Datasets of what the bearings of a wheel carry, by path below its group; its own only if it has an axle."""
    force, moment = np.moveaxis(found[..., : rollers + 1], (1, 3), (0, 2))
    own = {"bearing_force": force[:, 0], "bearing_moment": moment[:, 0]} if chassis else {}
    return own | {"rollers/bearing_force": force[:, 1:], "rollers/bearing_moment": moment[:, 1:]}


def wheel_datasets(at: Places, w: int, rollers: int, rows: Recording, observed: Observed) -> dict[str, np.ndarray]:
    """Datasets of wheel w with so many rollers, by path below its group."""
    contacts = np.asarray(observed.wheels)[:, w]
    position, velocity, acceleration = observed.motion[:, :, w, :rollers]
    return {
        "spin_angle": rows.y[:, at.spin_angle + w],
        "spin_rate": rows.y[:, at.spin_rate + w],
        "spin_acceleration": observed.slopes[:, at.spin_rate + w],
        "drive_torque": contacts["drive_torque"],
        "drive_power": contacts["drive_torque"] * rows.y[:, at.spin_rate + w],
        "normal_force": contacts["normal_force"],
        "contact_angle": contacts["angle"],
        "contact_roller": contacts["roller"],
        "contact_point": contacts["point"],
        "slip_velocity": contacts["slip_velocity"],
        "friction_force": contacts["friction_force"],
        "contact_share": contacts["share"],
        "contact_torque": contacts["contact_torque"],
        "rollers/axial_rate": rows.rates[:, w, :rollers],
        "rollers/joint_rate": observed.joint_rate[:, w, :rollers],
        "rollers/center_position": position,
        "rollers/center_velocity": velocity,
        "rollers/center_acceleration": acceleration,
    }
