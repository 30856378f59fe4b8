"""From recorded rows to the datasets of a trajectory: every quantity that the march itself does not need."""

import math

import numpy as np

from omnisim.contact.tracking import IMPLICIT, Heading
from omnisim.dynamics import contact_reaction, drive_torque, external_wrench, rhs
from omnisim.kernel import kernel
from omnisim.multipliers import servo_torque
from omnisim.parameters import Parameters
from omnisim.start import roller_azimuths, roller_directions
from omnisim.state import WATCH, YAW, Rows, X, Y, places

CONTACT = np.dtype(
    [
        ("normal_force", np.float64),  # N
        ("drive_torque", np.float64),  # N m
        ("servo_torque", np.float64),  # N m
        ("along_axle", np.float64),  # l, m
        ("slip_velocity", np.float64, (2,)),  # h, k, m/s
        ("friction_force", np.float64, (2,)),  # on the roller, N
    ]
)


@kernel
def observe(parameters, rows, times, watch, slopes, contacts):
    """Evaluate every row: y' into `slopes` (T, n), and records CONTACT of each wheel into `contacts` (T, W)."""
    at = places(len(parameters.wheels))
    for row in range(len(times)):
        t, piece, y, mode = times[row], rows.piece[row], rows.y[row], rows.mode[row]
        rhs(parameters, mode, piece, t, y, slopes[row], watch)
        heading = Heading(math.cos(y[YAW]), math.sin(y[YAW]))
        wrench = external_wrench(parameters, piece, t, heading)
        for w in range(len(parameters.wheels)):
            contact, normal = contacts[row, w], max(watch[w].normal_force, 0.0)
            torque = drive_torque(parameters, piece, t, w)
            reaction = contact_reaction(parameters, mode[w], w, heading, normal, wrench, torque, y)
            spin_rate = y[at.spin_rate + w]
            contact.normal_force = normal
            contact.drive_torque = torque
            contact.servo_torque = servo_torque(parameters.wheels[w], reaction, normal, spin_rate, y[at.yaw_rate])
            contact.along_axle = reaction.state.contact.l
            contact.slip_velocity[0], contact.slip_velocity[1] = reaction.state.slip.h, reaction.state.slip.k
            contact.friction_force[0], contact.friction_force[1] = reaction.force.h, reaction.force.k


@np.errstate(over="ignore", invalid="ignore")  # the caller drops rows that are not finite
def datasets(parameters: Parameters, rows: Rows, interval: float, names: list[str]) -> dict[str, np.ndarray]:
    """All datasets of T rows, `interval` seconds apart, but the events: by path in the trajectory file."""
    times = np.arange(len(rows.y)) * interval
    slopes = np.empty_like(rows.y)
    contacts = np.zeros(rows.mode.shape, CONTACT).view(np.recarray)
    watch = np.zeros(len(names), WATCH).view(np.recarray)
    observe(parameters, rows, times, watch, slopes, contacts)
    data = {"time": times} | body(parameters, rows.y, slopes) | energy(parameters, rows)
    for w, name in enumerate(names):
        group = wheel(parameters, w, rows, slopes, contacts[:, w])
        data |= {f"wheels/{name}/{path}": values for path, values in group.items()}
    return data


def body(parameters: Parameters, y: np.ndarray, slopes: np.ndarray) -> dict[str, np.ndarray]:
    """Motion of the wheel centre, at the constant height R."""
    at = places(len(parameters.wheels))
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
    machine, y, at = parameters.machine, rows.y, places(len(parameters.wheels))
    doubled = machine.mass * (y[:, at.velocity] ** 2 + y[:, at.velocity + 1] ** 2)
    doubled += machine.yaw_inertia * y[:, at.yaw_rate] ** 2
    for w, wheel in enumerate(parameters.wheels):
        doubled += wheel.axle_inertia * y[:, at.spin_rate + w] ** 2
        doubled += wheel.axial_inertia * np.sum(rows.rates[:, w, : wheel.rollers] ** 2, axis=1)
    kinetic = 0.5 * doubled
    loss, drive, wrench = y[:, at.friction_loss], y[:, at.drive_work], y[:, at.wrench_work]
    return {
        "energy/kinetic": kinetic,
        "energy/friction_loss": loss,
        "energy/drive_work": drive,
        "energy/wrench_work": wrench,
        "energy/balance": kinetic - kinetic[:1] + loss - drive - wrench,
    }


def wheel(
    parameters: Parameters, w: int, rows: Rows, slopes: np.ndarray, contacts: np.recarray
) -> dict[str, np.ndarray]:
    """Datasets of one wheel, by path below its group."""
    record, y, at = parameters.wheels[w], rows.y, places(len(parameters.wheels))
    to_rollers = tracked_directions(parameters, w, y)  # d of every roller
    here = rows.mode[:, w].roller % record.rollers
    cos_yaw, sin_yaw = np.cos(y[:, YAW]), np.sin(y[:, YAW])
    contact_d = to_rollers[np.arange(len(y)), here]
    along_axle = contacts.along_axle[:, None] * np.column_stack([-sin_yaw, cos_yaw])
    return {
        "spin_angle": y[:, at.spin_angle + w],
        "spin_rate": y[:, at.spin_rate + w],
        "spin_acceleration": slopes[:, at.spin_rate + w],
        "drive_torque": contacts.drive_torque,
        "normal_force": contacts.normal_force,
        "contact_angle": np.arctan2(contact_d[:, 0] * cos_yaw + contact_d[:, 1] * sin_yaw, -contact_d[:, 2]),
        "contact_roller": here,
        "contact_point": np.column_stack([y[:, [X, Y]] + along_axle, np.zeros(len(y))]),
        "slip_velocity": contacts.slip_velocity,
        "friction_force": contacts.friction_force,
        "contact_share": np.ones(len(y)),
        "servo_torque": contacts.servo_torque,
    } | {f"rollers/{path}": values for path, values in rollers(parameters, w, rows, slopes, to_rollers).items()}


def tracked_directions(parameters: Parameters, w: int, y: np.ndarray) -> np.ndarray:
    """Unit vectors d from the wheel centre to every roller centre, world axes, (T, N_r, 3).

    The implicit tracking has them as -rho: what it integrated is what it shows.
    """
    record, count, at = parameters.wheels[w], parameters.wheels[w].rollers, places(len(parameters.wheels))
    if parameters.machine.tracking == IMPLICIT:
        first = at.rho + 3 * parameters.sector.shape[1] * w
        return -y[:, first : first + 3 * count].reshape(len(y), count, 3)
    return roller_directions(roller_azimuths(record, y[:, at.spin_angle + w]), y[:, YAW])


def rollers(
    parameters: Parameters, w: int, rows: Rows, slopes: np.ndarray, directions: np.ndarray
) -> dict[str, np.ndarray]:
    """Rates of every roller, and the rigid motion of its centre O + R1 d with the wheel."""
    record, y, at = parameters.wheels[w], rows.y, places(len(parameters.wheels))
    spin_rate, yaw_rate = y[:, at.spin_rate + w], y[:, at.yaw_rate]
    axial_rate = rows.rates[:, w, : record.rollers].copy()
    axis_n = -record.cos_psi * np.sin(roller_azimuths(record, y[:, at.spin_angle + w]))
    centre = np.column_stack([y[:, X], y[:, Y], np.full(len(y), record.radius)])
    velocity = np.column_stack([y[:, at.velocity], y[:, at.velocity + 1], np.zeros(len(y))])
    acceleration = np.column_stack([slopes[:, at.velocity], slopes[:, at.velocity + 1], np.zeros(len(y))])
    k = np.column_stack([-np.sin(y[:, YAW]), np.cos(y[:, YAW]), np.zeros(len(y))])
    k_rate = -yaw_rate[:, None] * np.column_stack([k[:, 1], -k[:, 0], k[:, 2]])  # k' = -theta' h
    up = np.array([0.0, 0.0, 1.0])
    w_wheel = spin_rate[:, None] * k + yaw_rate[:, None] * up
    w_rate = slopes[:, at.spin_rate + w, None] * k + spin_rate[:, None] * k_rate + slopes[:, at.yaw_rate, None] * up
    arms = record.roller_distance * directions
    around = np.cross(w_wheel[:, None], arms)
    return {
        "axial_rate": axial_rate,
        "joint_rate": axial_rate - (spin_rate * record.sin_psi)[:, None] - yaw_rate[:, None] * axis_n,
        "center_position": centre[:, None] + arms,
        "center_velocity": velocity[:, None] + around,
        "center_acceleration": acceleration[:, None]
        + np.cross(w_rate[:, None], arms)
        + np.cross(w_wheel[:, None], around),
    }
