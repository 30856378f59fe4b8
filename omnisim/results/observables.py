"""From recorded rows to the datasets of a trajectory: every quantity that the march itself does not need."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.calls import direct
from omnisim.base.kernel import kernel
from omnisim.base.records import blank, plain
from omnisim.base.vector import Vec3, combine, cross
from omnisim.contact.kinematics import joint_rate
from omnisim.contact.tracking import IMPLICIT_TRACKING, roller_axis
from omnisim.dynamics.indices import roller_index, row_index
from omnisim.dynamics.multibody.joint_forces import recover, resolve_joints
from omnisim.dynamics.multibody.residuals import residuals
from omnisim.dynamics.normal_forces import servo
from omnisim.dynamics.parameters import DRIVE_INPUT, MULTIBODY, SERVO, Parameters
from omnisim.dynamics.state import MONITORS, YAW, Places, Recording, X, Y, places, places_in
from omnisim.dynamics.wheel import (
    azimuth,
    body_motion,
    centre_acceleration,
    centre_velocity,
    external_wrench,
    rho_of,
    world_heading,
)
from omnisim.march.extremes import bearing_extremes, odometry_extremes, wheel_extremes
from omnisim.march.runge_kutta import evaluate
from omnisim.scene.schema import Config

OBSERVED_WHEEL = np.dtype(
    [
        ("normal_force", np.float64),  # N
        ("drive_torque", np.float64),  # N m
        ("voltage", np.float64),  # of the motor, V
        ("current", np.float64),  # A
        ("share", np.float64),  # of the roller ahead while two carry the load, 1
        ("contact_torque", np.float64),  # on the roller about the normal, N m
        ("angle", np.float64),  # q of the roller in contact, rad
        ("point", np.float64, (3,)),  # world, m
        ("slip_velocity", np.float64, (2,)),  # h, k, m/s
        ("friction_force", np.float64, (2,)),  # on the roller, N
    ]
)


class Observed(NamedTuple):
    """What `observe` finds in T rows of W wheels of at most N rollers.

    slopes (T, n): y'; servo (T, 2): torque about chassis x and y, N m; wheels (T, W): records OBSERVED_WHEEL;
    joint_rate (T, W, N), rad/s; motion (3, T, W, N, 3): position, velocity and acceleration of every roller centre,
    world axes; bearing_loads (T, W, N + 1, 2, 3): force (N) and moment (N m) of the axles of each wheel and its
    rollers, along their own directions, or no rows if nobody asks for them.
    """

    slopes: np.ndarray
    servo: np.ndarray
    wheels: np.recarray
    joint_rate: np.ndarray
    motion: np.ndarray
    bearing_loads: np.ndarray


@kernel
def observe(parameters, rows, times, monitors, observed):
    """Evaluate every row."""
    at, workspace = places(parameters), parameters.workspace
    for row in range(len(times)):
        y, mode, slopes = rows.y[row], rows.mode[row], observed.slopes[row]
        evaluate(parameters, mode, rows.piece[row], times[row], y, slopes, monitors)
        body, multibody = body_motion(parameters, y), parameters.machine.formulation == MULTIBODY
        wrench, turning = external_wrench(parameters, rows.piece[row], times[row], body), slopes[at.yaw_rate]
        if multibody:
            observed.servo[row, 0], observed.servo[row, 1] = workspace.loads.servo[0], workspace.loads.servo[1]
        else:
            observed.servo[row, 0], observed.servo[row, 1] = servo(
                parameters.machine, parameters.wheels, workspace, wrench, body.yaw_rate, turning
            )
        for w in range(len(parameters.wheels)):
            wheel, seen, part = parameters.wheels[w], observed.wheels[row, w], workspace.parts[w]
            contact, heading = workspace.contacts[part.first], world_heading(wheel, body)
            seen.normal_force = max(part.normal_force, 0.0) if part.loaded else 0.0
            seen.drive_torque, seen.share, seen.contact_torque = part.drive_torque, contact.share, contact.torque
            seen.voltage, seen.current = part.voltage, part.current
            seen.angle = contact_angle(parameters, mode[w], w, heading, y)
            along, across = wheel.offset[0], wheel.offset[1] + contact.l
            seen.point[0] = y[X] + along * heading.cos - across * heading.sin
            seen.point[1] = y[Y] + along * heading.sin + across * heading.cos
            for i in range(2):
                seen.slip_velocity[i], seen.friction_force[i] = contact.slip[i], contact.force[i]
            observe_rollers(parameters, rows, row, w, body, observed)
            if len(observed.bearing_loads):
                if not multibody:
                    recover(parameters, mode[w], w, y, slopes, rows.rates[row, w])
                resolve_joints(parameters, w, y, observed.bearing_loads[row, w])


@kernel
def contact_angle(parameters, mode, w, heading, y):
    """q of the roller in contact, rad: from the spin angle, or from the rho that the implicit tracking integrated."""
    wheel, at = parameters.wheels[w], places(parameters)
    if parameters.machine.tracking == IMPLICIT_TRACKING:
        rho = rho_of(parameters, y, w, roller_index(wheel, mode.roller))
        return math.atan2(-rho.x * heading.cos - rho.y * heading.sin, rho.z)
    return azimuth(wheel, parameters.roller_rows[mode.row[0]], mode.roller, y[at.spin_angle + w])


@kernel
def observe_rollers(parameters, rows, row, w, body, observed):
    """Joint rates of the rollers of wheel w, and the rigid motion of their centres O + R1 d with the wheel."""
    wheel, y, dy, at = parameters.wheels[w], rows.y[row], observed.slopes[row], places(parameters)
    heading, spin_rate, yaw_rate = world_heading(wheel, body), y[at.spin_rate + w], y[at.yaw_rate]
    spin_acceleration, turning = dy[at.spin_rate + w], spin_rate * yaw_rate
    h, k = Vec3(heading.cos, heading.sin, 0.0), Vec3(-heading.sin, heading.cos, 0.0)
    up = Vec3(0.0, 0.0, 1.0)
    rate = combine(spin_rate, k, yaw_rate, up, 0.0, up)
    rate_rate = combine(spin_acceleration, k, dy[at.yaw_rate], up, -turning, h)  # k' = -theta' h
    slow, x, y_rate = centre_velocity(wheel, body), dy[at.velocity], dy[at.velocity + 1]
    fast = centre_acceleration(
        wheel, body, x * body.cos + y_rate * body.sin, y_rate * body.cos - x * body.sin, dy[at.yaw_rate]
    )
    centre = combine(wheel.offset[0], h, wheel.offset[1], k, 1.0, Vec3(y[X], y[Y], wheel.radius))
    velocity, acceleration = combine(slow.h, h, slow.k, k, 0.0, up), combine(fast.h, h, fast.k, k, 0.0, up)
    for i in range(wheel.rollers):
        own = parameters.roller_rows[row_index(wheel, i)]
        q = azimuth(wheel, own, i, y[at.spin_angle + w])
        axis = roller_axis(wheel, math.cos(q), math.sin(q))
        observed.joint_rate[row, w, i] = joint_rate(axis, rows.rates[row, w, i], spin_rate, yaw_rate)
        if parameters.machine.tracking == IMPLICIT_TRACKING:  # what it integrated is what it shows
            d = combine(-1.0, rho_of(parameters, y, w, i), 0.0, up, 0.0, up)
        else:
            d = combine(math.sin(q), h, -math.cos(q), up, 0.0, up)
        arm = combine(wheel.roller_distance, d, own.offset, k, 0.0, up)
        around = cross(rate, arm)
        store(observed.motion[0, row, w, i], combine(1.0, centre, 1.0, arm, 0.0, up))
        store(observed.motion[1, row, w, i], combine(1.0, velocity, 1.0, around, 0.0, up))
        curved = combine(1.0, cross(rate_rate, arm), 1.0, cross(rate, around), 1.0, acceleration)
        store(observed.motion[2, row, w, i], curved)


@kernel
def store(target, vector):
    target[0], target[1], target[2] = vector.x, vector.y, vector.z


def observed_rows(parameters: Parameters, rows: Recording, times: np.ndarray, bearing_loads: bool = False) -> Observed:
    """What `observe` finds in these rows, recorded at these times (T,), s."""
    count, wheels, rollers = rows.rates.shape
    observed = Observed(
        slopes=np.empty_like(rows.y),
        servo=np.empty((count, 2)),
        wheels=blank(OBSERVED_WHEEL, count, wheels),
        joint_rate=np.empty((count, wheels, rollers)),
        motion=np.empty((3, count, wheels, rollers, 3)),
        bearing_loads=np.zeros((count if bearing_loads else 0, wheels, rollers + 1, 2, 3)),
    )
    direct(observe, parameters, rows, times, blank(MONITORS, wheels), observed)
    return observed


@np.errstate(over="ignore", invalid="ignore")  # the caller drops rows that are not finite
def datasets(parameters: Parameters, rows: Recording, interval: float, config: Config) -> dict[str, np.ndarray]:
    """All datasets of T rows, `interval` seconds apart, but the events: by path in the trajectory file."""
    times = np.arange(len(rows.y)) * interval
    observed = observed_rows(parameters, rows, times, config.bearing_loads)
    multibody = parameters.machine.formulation == MULTIBODY
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
    if multibody:
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
    at, (ahead, left) = places_in(parameters), parameters.machine.centre
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
    at, columns = places_in(parameters), parameters.wheels.odometry
    spin_angles = y[:, at.spin_angle : at.spin_angle + len(columns)]
    reported, yaw = y[:, at.odometry : at.odometry + 2], parameters.machine.odometry_yaw + spin_angles @ columns[:, 2]
    return {
        "odometry/position": reported,
        "odometry/yaw": yaw,
        "odometry/position_error": reported - position[:, :2],
        "odometry/yaw_error": yaw - y[:, YAW],
    }


def energy(parameters: Parameters, rows: Recording) -> dict[str, np.ndarray]:
    """Kinetic energy, the works since t = 0, and what is missing between them."""
    machine, wheels, y, at = parameters.machine, np.asarray(parameters.wheels), rows.y, places_in(parameters)
    doubled = machine.mass * (y[:, at.velocity] ** 2 + y[:, at.velocity + 1] ** 2)
    doubled += machine.yaw_inertia * y[:, at.yaw_rate] ** 2
    doubled += y[:, at.spin_rate : at.roller_rate] ** 2 @ (wheels["axle_inertia"] + wheels["rotor_inertia"])
    doubled += np.sum(rows.rates**2, axis=2) @ wheels["axial_inertia"]
    kinetic = 0.5 * doubled
    loss, drive, wrench = y[:, at.friction_loss], y[:, at.drive_work], y[:, at.wrench_work]
    bearing_loss = y[:, at.bearing_loss] if machine.bearing_friction else np.zeros(len(y))
    gravity = potential(machine, y)
    return {
        "energy/kinetic": kinetic,
        **({"energy/gravity": gravity} if machine.inclined else {}),
        "energy/friction_loss": loss,
        "energy/bearing_loss": bearing_loss,
        "energy/drive_work": drive,
        "energy/wrench_work": wrench,
        "energy/balance": kinetic - kinetic[:1] + gravity - gravity[:1] + loss + bearing_loss - drive - wrench,
    }


def potential(machine: np.record, y: np.ndarray) -> np.ndarray:
    """Energy of all bodies in gravity (T), J: -M g . r_C from the world's origin, the constant part included."""
    return machine.mass * (machine.gravity * machine.height - y[:, [X, Y]] @ machine.downhill)


def motor_energies(parameters: Parameters, y: np.ndarray, mechanical: np.ndarray) -> dict[str, np.ndarray]:
    """What motors take from their supply and where it goes; the balance with it, `mechanical` without."""
    at, count = places_in(parameters), len(parameters.wheels)
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
