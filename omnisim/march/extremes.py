"""Extremes of the march: the largest and the smallest between two rows, of every accepted state and of every event.

A peak that lies between two rows of output is in no row: loads change within the exchange of two rollers, slip begins
and ends within milliseconds. So each row has, beside its own values, those of the interval that it ends, both ends
included. Lengths are compared by their squares.
"""

import math

import numpy as np

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import plus
from omnisim.dynamics.bearing_loads import load_bearings, moving
from omnisim.dynamics.indices import contact_count
from omnisim.dynamics.joint_loads import LEAST_AXIAL, MOST_AXIAL, RADIAL_SQUARE, TILTING_SQUARE
from omnisim.dynamics.spatial.bearing_loads import recover_in_space
from omnisim.dynamics.spatial.pose import body_of, vector
from omnisim.dynamics.spatial.pose import outward as spatial_outward
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.state import YAW, X, Y, places
from omnisim.dynamics.twist import body_motion
from omnisim.march.roller_exchange import release_rollers
from omnisim.march.spatial_contacts import release

LEAST, MOST = range(2)
OF_WHEELS = ("normal_force", "drive_torque", "drive_power")
OF_MOTORS = ("voltage", "current", "electrical_power")
LENGTHS = {"friction_force": "friction_square", "slip_velocity": "slip_square"}
POSITION_SQUARE, LEAST_YAW, MOST_YAW = range(3)


@kernel
def begin_interval(parameters, run, rows, row):
    """The interval that ends with `row` begins with the state as it is, of which the workspace has the forces."""
    if row == len(rows.extremes):
        return
    for w in range(len(run.mode)):
        seen = rows.extremes[row, w]
        seen.friction_square = seen.slip_square = 0.0
        begin_pair(seen.normal_force)
        begin_pair(seen.drive_torque)
        begin_pair(seen.drive_power)
        begin_pair(seen.voltage)
        begin_pair(seen.current)
        begin_pair(seen.electrical_power)
    if len(rows.bearing_extremes):
        for w in range(len(run.mode)):
            found = rows.bearing_extremes[row, w]
            for joint in range(found.shape[1]):
                found[RADIAL_SQUARE, joint] = found[TILTING_SQUARE, joint] = 0.0
                found[LEAST_AXIAL, joint], found[MOST_AXIAL, joint] = math.inf, -math.inf
    if len(rows.odometry_extremes):
        rows.odometry_extremes[row, POSITION_SQUARE] = 0.0
        begin_pair(rows.odometry_extremes[row, LEAST_YAW : MOST_YAW + 1])
    follow_again(parameters, run, rows, row)


@kernel
def begin_pair(pair):
    pair[LEAST], pair[MOST] = math.inf, -math.inf


@kernel
def widen(pair, value):
    """Let a pair of the smallest and the largest value take in one more."""
    if value < pair[LEAST]:
        pair[LEAST] = value
    if value > pair[MOST]:
        pair[MOST] = value


@kernel
def follow(parameters, run, rows, row):
    """Take in the state as it is into the interval that ends with `row`; the workspace has its forces."""
    workspace = parameters.workspace
    spin_rate = places(parameters).spin_rate
    for w in range(len(run.mode)):
        part = workspace.parts[w]
        seen = rows.extremes[row, w]
        if parameters.space is not None:
            widen(seen.normal_force, part.normal_force)
        else:
            widen(seen.normal_force, max(part.normal_force, 0.0) if part.loaded else 0.0)
        widen(seen.drive_torque, part.drive_torque)
        widen(seen.drive_power, part.drive_torque * run.y[spin_rate + w])
        if parameters.machine.motors:
            widen(seen.voltage, part.voltage)
            widen(seen.current, part.current)
            widen(seen.electrical_power, part.voltage * part.current)
        if parameters.space is not None:
            for c in range(run.mode[w].contacts):
                touch = parameters.space.touches[w * SLOTS + c]
                follow_slip(seen, touch.force, touch.slip)
        else:
            for side in range(contact_count(run.mode[w])):
                contact = workspace.contacts[part.first + side]
                follow_slip(seen, contact.force, contact.slip)
    if len(rows.odometry_extremes):
        follow_odometry(parameters, run.y, rows.odometry_extremes[row])
    if len(rows.bearing_extremes):
        follow_bearings(parameters, run, rows.bearing_extremes[row])


@kernel
def follow_slip(seen, force, slip):
    """Take in friction and slip at a contact."""
    seen.friction_square = max(seen.friction_square, force[0] * force[0] + force[1] * force[1])
    seen.slip_square = max(seen.slip_square, slip[0] * slip[0] + slip[1] * slip[1])


@outlined
def follow_again(parameters, run, rows, row):
    """The same, compiled once for all uses but the ends of steps."""
    follow(parameters, run, rows, row)


@kernel
def follow_odometry(parameters, y, found):
    """The error of the pose that the wheels report: found (3,), its length squared and its least and most yaw."""
    machine = parameters.machine
    at = places(parameters)
    reported = machine.odometry_yaw
    for w in range(len(parameters.wheels)):
        reported += parameters.wheels[w].odometry[2] * y[at.spin_angle + w]
    if parameters.space is not None:
        body = body_of(parameters, y)
        origin = plus(body.position, spatial_outward(body.rotation, vector(parameters.space.body.origin, 0)))
        x, y_error = origin.x - y[at.odometry], origin.y - y[at.odometry + 1]
        turned = reported - math.atan2(body.rotation.x.y, body.rotation.x.x)
        yaw = turned - 2.0 * math.pi * round(turned / (2.0 * math.pi))
    else:
        cos, sin = cos_sin(y[YAW])
        x = y[X] - machine.centre[0] * cos + machine.centre[1] * sin - y[at.odometry]
        y_error = y[Y] - machine.centre[0] * sin - machine.centre[1] * cos - y[at.odometry + 1]
        yaw = reported - y[YAW]
    found[POSITION_SQUARE] = max(found[POSITION_SQUARE], x * x + y_error * y_error)
    widen(found[LEAST_YAW : MOST_YAW + 1], yaw)


@outlined
def follow_bearings(parameters, run, found):
    """The loads of every bearing into found (W, 4, N + 1): across its axis and along it, N, and tilting, N m."""
    if parameters.space is None:
        body = body_motion(parameters, run.y)
        machine = moving(parameters, body, run.y, run.slopes[0])
    for w in range(len(run.mode)):
        if parameters.space is not None:
            release(parameters, run, w)
            recover_in_space(parameters, run.mode[w], w, run.y, run.slopes[0], run.rates[w], found[w])
        else:
            release_rollers(parameters, run, w)
            load_bearings(parameters, run.mode[w], w, machine, run.rates[w], found[w])


def extremes_of(quantity: str, extremes: np.ndarray) -> dict[str, np.ndarray]:
    """The datasets (T, W) of all wheels, by group of the file, from their extremes (T, W), an array that is none of
    records, which are slow."""
    if quantity in LENGTHS:
        return {"interval_max": np.sqrt(extremes[LENGTHS[quantity]])}
    return {"interval_max": extremes[quantity][..., MOST], "interval_min": extremes[quantity][..., LEAST]}


def bearing_extremes(found: np.ndarray, rollers: int, chassis: bool) -> dict[str, np.ndarray]:
    """Datasets of what the bearings of one wheel carry, by path with {} for its name, from (T, 4, N + 1) of its joints;
    chassis: whether it has an axle."""
    rows = {"rollers/": found[..., 1 : rollers + 1]} | ({"": found[..., 0]} if chassis else {})
    datasets = {}
    for folder, loads in rows.items():
        path = f"wheels/{{}}/{folder}bearing"
        datasets[f"interval_max/{path}_radial_force"] = np.sqrt(loads[:, RADIAL_SQUARE])
        datasets[f"interval_max/{path}_axial_force"] = loads[:, MOST_AXIAL]
        datasets[f"interval_min/{path}_axial_force"] = loads[:, LEAST_AXIAL]
        datasets[f"interval_max/{path}_tilting_moment"] = np.sqrt(loads[:, TILTING_SQUARE])
    return datasets


def odometry_extremes(found: np.ndarray) -> dict[str, np.ndarray]:
    """Datasets of the error of the odometry, by path, from (T, 3)."""
    return {
        "interval_max/odometry/position_error": np.sqrt(found[:, POSITION_SQUARE]),
        "interval_max/odometry/yaw_error": found[:, MOST_YAW],
        "interval_min/odometry/yaw_error": found[:, LEAST_YAW],
    }
