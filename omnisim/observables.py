"""From recorded rows to the datasets of a trajectory: every quantity that the march itself does not need."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.contact.kinematics import joint_rate
from omnisim.contact.tracking import IMPLICIT, Heading, roller_axis
from omnisim.dynamics import contact_reaction, rhs
from omnisim.kernel import kernel
from omnisim.multipliers import servo_load, servo_torque
from omnisim.parameters import Parameters
from omnisim.state import WATCH, YAW, Rows, X, Y, places, places_in
from omnisim.vector import Vec3, combine, cross
from omnisim.wheel import all_rollers, azimuth, contact_state, drive_torque, external_wrench, free_motion, rho_of

CONTACT = np.dtype(
    [
        ("normal_force", np.float64),  # N
        ("drive_torque", np.float64),  # N m
        ("servo_torque", np.float64),  # N m
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

    slopes (T, n): y'; contacts (T, W): records CONTACT; joint_rate (T, W, N), rad/s; motion (3, T, W, N, 3): position,
    velocity and acceleration of every roller centre, world axes, SI.
    """

    slopes: np.ndarray
    contacts: np.recarray
    joint_rate: np.ndarray
    motion: np.ndarray


@kernel
def observe(parameters, rows, times, watch, observed):
    """Evaluate every row."""
    at = places(parameters)
    for row in range(len(times)):
        t, piece, y, mode = times[row], rows.piece[row], rows.y[row], rows.mode[row]
        rhs(parameters, mode, piece, t, y, observed.slopes[row], watch)
        heading = Heading(math.cos(y[YAW]), math.sin(y[YAW]))
        wrench = external_wrench(parameters, piece, t, heading)
        for w in range(len(parameters.wheels)):
            wheel, contact, normal = parameters.wheels[w], observed.contacts[row, w], max(watch[w].normal_force, 0.0)
            torque, share = drive_torque(parameters, piece, t, w), watch[w].share
            state = contact_state(parameters, mode[w], w, 0, heading, y)
            rollers = all_rollers(parameters, mode[w], w, state.cos_q, state.sin_q, y)
            motion = free_motion(parameters, wheel, state, rollers, heading, wrench, torque)
            reaction = contact_reaction(parameters, mode[w], w, 0, state, motion, normal, share)
            servo = servo_torque(wheel, rollers, y[at.spin_rate + w], y[at.yaw_rate])
            contact.servo_torque = servo + servo_load(wheel, reaction, share * normal)
            if mode[w].shared:
                other = contact_state(parameters, mode[w], w, 1, heading, y)
                second = contact_reaction(parameters, mode[w], w, 1, other, motion, normal, 1.0 - share)
                contact.servo_torque += servo_load(wheel, second, (1.0 - share) * normal)
            contact.normal_force, contact.drive_torque, contact.share = normal, torque, share
            contact.contact_torque = reaction.torque
            contact.angle = contact_angle(parameters, mode[w], w, heading, y)
            contact.point[0] = y[X] - state.contact.l * heading.sin
            contact.point[1] = y[Y] + state.contact.l * heading.cos
            contact.slip_velocity[0], contact.slip_velocity[1] = state.slip.h, state.slip.k
            contact.friction_force[0], contact.friction_force[1] = reaction.force.h, reaction.force.k
            observe_rollers(parameters, rows, row, w, heading, observed)


@kernel
def contact_angle(parameters, mode, w, heading, y):
    """q of the roller in contact, rad: from the spin angle, or from the rho that the implicit tracking integrated."""
    wheel, at = parameters.wheels[w], places(parameters)
    if parameters.machine.tracking == IMPLICIT:
        rho = rho_of(parameters, y, w, mode.roller % wheel.rollers)
        return math.atan2(-rho.x * heading.cos - rho.y * heading.sin, rho.z)
    return azimuth(wheel, mode.roller, y[at.spin_angle + w])


@kernel
def observe_rollers(parameters, rows, row, w, heading, observed):
    """Joint rates of the rollers of wheel w, and the rigid motion of their centres O + R1 d with the wheel."""
    wheel, y, dy, at = parameters.wheels[w], rows.y[row], observed.slopes[row], places(parameters)
    spin_rate, yaw_rate = y[at.spin_rate + w], y[at.yaw_rate]
    spin_acceleration, turning = dy[at.spin_rate + w], spin_rate * yaw_rate
    h, k = Vec3(heading.cos, heading.sin, 0.0), Vec3(-heading.sin, heading.cos, 0.0)
    up = Vec3(0.0, 0.0, 1.0)
    rate = combine(spin_rate, k, yaw_rate, up, 0.0, up)
    rate_rate = combine(spin_acceleration, k, dy[at.yaw_rate], up, -turning, h)  # k' = -theta' h
    centre = Vec3(y[X], y[Y], wheel.radius)
    velocity = Vec3(y[at.velocity], y[at.velocity + 1], 0.0)
    acceleration = Vec3(dy[at.velocity], dy[at.velocity + 1], 0.0)
    for i in range(wheel.rollers):
        q = azimuth(wheel, i, y[at.spin_angle + w])
        axis = roller_axis(wheel, math.cos(q), math.sin(q))
        observed.joint_rate[row, w, i] = joint_rate(axis, rows.rates[row, w, i], spin_rate, yaw_rate)
        if parameters.machine.tracking == IMPLICIT:  # what it integrated is what it shows
            d = combine(-1.0, rho_of(parameters, y, w, i), 0.0, up, 0.0, up)
        else:
            d = combine(math.sin(q), h, -math.cos(q), up, 0.0, up)
        arm = combine(wheel.roller_distance, d, 0.0, up, 0.0, up)
        around = cross(rate, arm)
        store(observed.motion[0, row, w, i], combine(1.0, centre, 1.0, arm, 0.0, up))
        store(observed.motion[1, row, w, i], combine(1.0, velocity, 1.0, around, 0.0, up))
        curved = combine(1.0, cross(rate_rate, arm), 1.0, cross(rate, around), 1.0, acceleration)
        store(observed.motion[2, row, w, i], curved)


@kernel
def store(target, vector):
    target[0], target[1], target[2] = vector.x, vector.y, vector.z


@np.errstate(over="ignore", invalid="ignore")  # the caller drops rows that are not finite
def datasets(parameters: Parameters, rows: Rows, interval: float, names: list[str]) -> dict[str, np.ndarray]:
    """All datasets of T rows, `interval` seconds apart, but the events: by path in the trajectory file."""
    times, (count, wheels, rollers) = np.arange(len(rows.y)) * interval, rows.rates.shape
    watch = np.zeros(wheels, WATCH).view(np.recarray)
    observed = Observed(
        slopes=np.empty_like(rows.y),
        contacts=np.zeros((count, wheels), CONTACT).view(np.recarray),
        joint_rate=np.empty((count, wheels, rollers)),
        motion=np.empty((3, count, wheels, rollers, 3)),
    )
    observe(parameters, rows, times, watch, observed)
    data = {"time": times} | body(parameters, rows.y, observed.slopes) | energy(parameters, rows)
    for w, name in enumerate(names):
        group = wheel(parameters, w, rows, observed)
        data |= {f"wheels/{name}/{path}": values for path, values in group.items()}
    return data


def body(parameters: Parameters, y: np.ndarray, slopes: np.ndarray) -> dict[str, np.ndarray]:
    """Motion of the wheel centre, at the constant height R."""
    at = places_in(parameters)
    height, flat = np.full(len(y), parameters.wheels[0].radius), np.zeros(len(y))
    return {
        "body/position": np.column_stack([y[:, X], y[:, Y], height]),
        "body/velocity": np.column_stack([y[:, at.velocity], y[:, at.velocity + 1], flat]),
        "body/acceleration": np.column_stack([slopes[:, at.velocity], slopes[:, at.velocity + 1], flat]),
        "body/yaw": y[:, YAW],
        "body/yaw_rate": y[:, at.yaw_rate],
        "body/yaw_acceleration": slopes[:, at.yaw_rate],
    }


def energy(parameters: Parameters, rows: Rows) -> dict[str, np.ndarray]:
    """Kinetic energy, the works since t = 0, and what is missing between them."""
    machine, y, at = parameters.machine, rows.y, places_in(parameters)
    doubled = machine.mass * (y[:, at.velocity] ** 2 + y[:, at.velocity + 1] ** 2)
    doubled += machine.yaw_inertia * y[:, at.yaw_rate] ** 2
    for w, wheel in enumerate(parameters.wheels):
        doubled += wheel.axle_inertia * y[:, at.spin_rate + w] ** 2
        doubled += wheel.axial_inertia * np.sum(rows.rates[:, w, : wheel.rollers] ** 2, axis=1)
    kinetic = 0.5 * doubled
    loss, drive, wrench = y[:, at.friction_loss], y[:, at.drive_work], y[:, at.wrench_work]
    bearings = y[:, at.bearing_loss] if machine.bearings else np.zeros(len(y))
    return {
        "energy/kinetic": kinetic,
        "energy/friction_loss": loss,
        "energy/bearing_loss": bearings,
        "energy/drive_work": drive,
        "energy/wrench_work": wrench,
        "energy/balance": kinetic - kinetic[:1] + loss + bearings - drive - wrench,
    }


def wheel(parameters: Parameters, w: int, rows: Rows, observed: Observed) -> dict[str, np.ndarray]:
    """Datasets of one wheel, by path below its group."""
    count, at, contacts = parameters.wheels[w].rollers, places_in(parameters), observed.contacts[:, w]
    position, velocity, acceleration = observed.motion[:, :, w, :count]
    return {
        "spin_angle": rows.y[:, at.spin_angle + w],
        "spin_rate": rows.y[:, at.spin_rate + w],
        "spin_acceleration": observed.slopes[:, at.spin_rate + w],
        "drive_torque": contacts.drive_torque,
        "normal_force": contacts.normal_force,
        "contact_angle": contacts.angle,
        "contact_roller": rows.mode[:, w].roller % count,
        "contact_point": contacts.point,
        "slip_velocity": contacts.slip_velocity,
        "friction_force": contacts.friction_force,
        "contact_share": contacts.share,
        "contact_torque": contacts.contact_torque,
        "servo_torque": contacts.servo_torque,
        "rollers/axial_rate": rows.rates[:, w, :count],
        "rollers/joint_rate": observed.joint_rate[:, w, :count],
        "rollers/center_position": position,
        "rollers/center_velocity": velocity,
        "rollers/center_acceleration": acceleration,
    }
