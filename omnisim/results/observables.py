"""From recorded rows to the datasets of a trajectory: every quantity that the march itself does not need."""

import numpy as np

from omnisim.base.calls import by_columns
from omnisim.base.records import plain
from omnisim.dynamics.energy import kinetic_energy, potential_energy
from omnisim.dynamics.multibody.residuals import residuals
from omnisim.dynamics.parameters import DRIVE_INPUT, SERVO, Parameters
from omnisim.dynamics.state import YAW, Places, Recording, places_in
from omnisim.march.extremes import bearing_extremes, odometry_extremes, wheel_extremes
from omnisim.march.observation import Observed, observed_rows
from omnisim.scene.schema import Config


@np.errstate(over="ignore", invalid="ignore")  # the caller drops rows that are not finite
def datasets(parameters: Parameters, rows: Recording, interval: float, config: Config) -> dict[str, np.ndarray]:
    """All datasets of T rows, `interval` seconds apart, but the events: by path in the trajectory file."""
    times = np.arange(len(rows.y)) * interval
    observed = observed_rows(parameters, rows, times, config.bearing_loads)
    parameters = parameters._replace(machine=plain(parameters.machine))
    data = {"time": times} | body(parameters, rows.y, observed.slopes, config.chassis is None)
    data |= energy(parameters, rows)
    if parameters.machine.motors:
        data |= motor_energies(parameters, rows.y, data["energy/balance"])
    if parameters.machine.odometry:
        data |= odometry(parameters, rows.y, data["body/position"])
        data |= odometry_extremes(rows.odometry_extremes)
    if config.chassis is not None and parameters.machine.upright == SERVO:
        data["body/servo_torque"] = observed.servo
    if parameters.workspace.articulated is not None:
        data |= residuals(parameters, rows.y)
    for w, (wheel, number) in enumerate(zip(config.wheels, parameters.wheels.rollers.tolist(), strict=True)):
        group = wheel_datasets(places_in(parameters), w, number, rows, observed)
        if wheel.drive.controlled:
            group["target_rate"] = targets(parameters, w, rows.piece, times)
        if parameters.wheels[w].motor:
            group |= motor_datasets(observed.wheels[:, w], parameters.wheels[w].resistance)
        if config.chassis is None:
            group["servo_torque"] = observed.servo[:, 0]
        if config.bearing_loads:
            group |= bearing_loads(observed.bearing_loads[:, w], number, config.chassis is not None)
        data |= {f"wheels/{wheel.name}/{path}": values for path, values in group.items()}
        extremes = wheel_extremes(rows.extremes[:, w], bool(parameters.wheels[w].motor))
        if config.bearing_loads:
            extremes |= bearing_extremes(rows.bearing_extremes[:, w], number, config.chassis is not None)
        data |= {path.format(wheel.name): values for path, values in extremes.items()}
    return data


def body(parameters: Parameters, y: np.ndarray, slopes: np.ndarray, bare: bool) -> dict[str, np.ndarray]:
    """Motion of the centre of a bare wheel at the constant height R, or of the chassis origin on the floor."""
    at = places_in(parameters)
    ahead, left = parameters.machine.centre
    height = parameters.wheels[0].radius if bare else 0.0
    cos, sin = np.cos(y[:, YAW]), np.sin(y[:, YAW])
    x_arm, y_arm = ahead * cos - left * sin, ahead * sin + left * cos  # C from the origin
    arm, across = np.array([x_arm, y_arm]).T, np.array([y_arm, -x_arm]).T
    rate, bend = y[:, at.yaw_rate, None], slopes[:, at.yaw_rate, None]
    motion = np.zeros((3, len(y), 3))
    motion[0, :, :2], motion[0, :, 2] = y[:, :YAW] - arm, height
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


def odometry(parameters: Parameters, y: np.ndarray, position: np.ndarray) -> dict[str, np.ndarray]:
    """The pose that the ideal wheels report, and its error."""
    at = places_in(parameters)
    columns = parameters.wheels.odometry
    spin_angles = y[:, at.spin_angle : at.spin_angle + len(columns)]
    reported = y[:, at.odometry : at.odometry + 2]
    yaw = parameters.machine.odometry_yaw + spin_angles @ columns[:, 2]
    return {
        "odometry/position": reported,
        "odometry/yaw": yaw,
        "odometry/position_error": reported - position[:, :2],
        "odometry/yaw_error": yaw - y[:, YAW],
    }


def energy(parameters: Parameters, rows: Recording) -> dict[str, np.ndarray]:
    """Kinetic energy, the works since t = 0, and what is missing between them."""
    machine = parameters.machine
    y = rows.y
    at = places_in(parameters)
    kinetic = by_columns(kinetic_energy, parameters, at, y.T, rows.rates.transpose(1, 2, 0))
    loss, drive, wrench = y[:, at.friction_loss], y[:, at.drive_work], y[:, at.wrench_work]
    bearing_loss = y[:, at.bearing_loss] if machine.bearing_friction else np.zeros(len(y))
    gravity = by_columns(potential_energy, machine, y.T)
    return {
        "energy/kinetic": kinetic,
        **({"energy/gravity": gravity} if machine.inclined else {}),
        "energy/friction_loss": loss,
        "energy/bearing_loss": bearing_loss,
        "energy/drive_work": drive,
        "energy/wrench_work": wrench,
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
    force, moment = found[:, : rollers + 1, 0], found[:, : rollers + 1, 1]
    own = {"bearing_force": force[:, 0], "bearing_moment": moment[:, 0]} if chassis else {}
    return own | {"rollers/bearing_force": force[:, 1:], "rollers/bearing_moment": moment[:, 1:]}


def wheel_datasets(at: Places, w: int, rollers: int, rows: Recording, observed: Observed) -> dict[str, np.ndarray]:
    """Datasets of wheel w with so many rollers, by path below its group."""
    contacts, mode = np.asarray(observed.wheels)[:, w], np.asarray(rows.mode)[:, w]
    position, velocity, acceleration = observed.motion[:, :, w, :rollers]
    return {
        "spin_angle": rows.y[:, at.spin_angle + w],
        "spin_rate": rows.y[:, at.spin_rate + w],
        "spin_acceleration": observed.slopes[:, at.spin_rate + w],
        "drive_torque": contacts["drive_torque"],
        "drive_power": contacts["drive_torque"] * rows.y[:, at.spin_rate + w],
        "normal_force": contacts["normal_force"],
        "contact_angle": contacts["angle"],
        "contact_roller": mode["roller"] % rollers,
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
