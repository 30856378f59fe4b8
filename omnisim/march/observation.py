"""The instants that a march has recorded, looked at again: forces, contacts and rollers, which a row does not hold."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.calls import direct
from omnisim.base.kernel import kernel
from omnisim.base.records import blank
from omnisim.base.vector import Vec3, combine, cross
from omnisim.contact.frame import axes, rate_change, rate_vector, spoke, tangential
from omnisim.contact.kinematics import joint_rate
from omnisim.contact.tracking import roller_axis
from omnisim.dynamics.bearing_loads import load_bearings, moving
from omnisim.dynamics.indices import row_index
from omnisim.dynamics.normal_forces.servo import find_servo, set_all_tilt
from omnisim.dynamics.normal_forces.solution import loads_known
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.records import SPATIAL_MONITORS
from omnisim.dynamics.state import MONITORS, Recording, Stage, X, Y, places
from omnisim.dynamics.twist import Acceleration, acceleration_of, body_motion, wheel_motion, wheel_twist, world_frame
from omnisim.dynamics.wheel import (
    azimuth,
    external_wrench,
    rho_of,
)
from omnisim.march.creeping import search_anew
from omnisim.march.runge_kutta import evaluate
from omnisim.march.spatial_observation import observe_in_space

OBSERVED_WHEEL = np.dtype(
    [
        ("normal_force", np.float64),  # N
        ("drive_torque", np.float64),  # N m
        ("voltage", np.float64),  # of the motor, V
        ("current", np.float64),  # A
        ("share", np.float64),  # of the roller ahead while two carry the load, 1
        ("contact_torque", np.float64),  # on the roller about the normal, N m
        ("roller", np.int64),  # in contact, 0..N-1; -1 in the air
        ("angle", np.float64),  # its q, rad
        ("point", np.float64, (3,)),  # world, m
        ("slip_velocity", np.float64, (2,)),  # h, k, m/s
        ("friction_force", np.float64, (2,)),  # on the roller, N
        ("travel", np.float64),  # of a carrier, m or rad
        ("travel_rate", np.float64),
    ]
)


class Observed(NamedTuple):
    """What `observe` finds in T rows of W wheels of at most N rollers.

    slopes (T, n): y'; servo (T, 2): torque about chassis x and y, N m; wheels (T, W): records OBSERVED_WHEEL;
    joint_rate (T, W, N), rad/s; motion (3, T, W, N, 3): position, velocity and acceleration of every roller centre,
    world axes; bearing_loads (T, W, 2, 3, N + 1): force (N) and moment (N m) of the axles of each wheel and its
    rollers, along their own directions; energies (T, 3): kinetic, of gravity and elastic, J, of a machine free in
    space. Rates and motion of rollers, or bearing loads, have no rows if nobody asks for them.
    """

    slopes: np.ndarray
    servo: np.ndarray
    wheels: np.recarray
    joint_rate: np.ndarray
    motion: np.ndarray
    bearing_loads: np.ndarray
    energies: np.ndarray


@kernel
def observe(parameters, rows, times, monitors, observed):
    """Evaluate every row."""
    at = places(parameters)
    workspace = parameters.workspace
    for row in range(len(times)):
        y, mode, slopes = rows.y[row], rows.mode[row], observed.slopes[row]
        search_anew(workspace)
        evaluate(parameters, Stage(mode, rows.piece[row], times[row], y, slopes, monitors, True))
        body = body_motion(parameters, y)
        wrench = external_wrench(parameters, rows.piece[row], times[row], body)
        turning = slopes[at.yaw_rate]
        if loads_known(parameters.machine):
            if workspace.articulated is None:  # else the right-hand side has found it
                set_all_tilt(parameters.machine, parameters.wheels, workspace, wrench, body.twist.yaw)
                find_servo(parameters.machine, workspace, Acceleration(0.0, 0.0, turning))
            observed.servo[row, 0], observed.servo[row, 1] = workspace.loads.servo[0], workspace.loads.servo[1]
        for w in range(len(parameters.wheels)):
            wheel = parameters.wheels[w]
            seen = observed.wheels[row, w]
            part = workspace.parts[w]
            contact = workspace.contacts[part.first]
            frame = world_frame(wheel, body)
            seen.normal_force = max(part.normal_force, 0.0) if part.loaded else 0.0
            seen.drive_torque, seen.share, seen.contact_torque = part.drive_torque, contact.share, contact.torque
            seen.voltage, seen.current = part.voltage, part.current
            seen.roller = mode[w].index[0]
            seen.angle = contact_angle(parameters, mode[w], w, frame, y)
            along = wheel.offset[0]
            across = wheel.offset[1] + contact.l
            h, k, _ = axes(frame)
            seen.point[0] = y[X] + along * h.x + across * k.x
            seen.point[1] = y[Y] + along * h.y + across * k.y
            for i in range(2):
                seen.slip_velocity[i], seen.friction_force[i] = contact.slip[i], contact.force[i]
            if len(observed.joint_rate):
                observe_rollers(parameters, rows, row, w, body, observed)
            if len(observed.bearing_loads):
                machine = moving(parameters, body, y, slopes)
                load_bearings(parameters, mode[w], w, machine, rows.rates[row, w], observed.bearing_loads[row, w])


@kernel
def contact_angle(parameters, mode, w, frame, y):
    """q of the roller in contact, rad: from the spin angle, or from the rho that the implicit tracking integrated."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    if parameters.machine.implicit_tracking:
        rho = rho_of(parameters, y, w, mode.index[0])
        return math.atan2(-tangential(frame, rho).h, rho.z)
    return azimuth(wheel, parameters.roller_rows[mode.row[0]], mode.roller, y[at.spin_angle + w])


@kernel
def observe_rollers(parameters, rows, row, w, body, observed):
    """Joint rates of the rollers of wheel w, and the rigid motion of their centres O + R1 d with the wheel."""
    wheel = parameters.wheels[w]
    y = rows.y[row]
    dy = observed.slopes[row]
    at = places(parameters)
    frame = world_frame(wheel, body)
    twist = wheel_twist(wheel, body.twist, y[at.spin_rate + w])
    motion = wheel_motion(wheel, body.twist, acceleration_of(parameters, body, dy), dy[at.spin_rate + w], 0.0)
    h, k, up = axes(frame)
    rate = rate_vector(frame, twist)
    rate_rate = rate_change(frame, twist, motion)
    centre = combine(wheel.offset[0], h, wheel.offset[1], k, 1.0, Vec3(y[X], y[Y], wheel.radius))
    velocity, acceleration = combine(twist.h, h, twist.k, k, 0.0, up), combine(motion.h, h, motion.k, k, 0.0, up)
    for i in range(wheel.rollers):
        own = parameters.roller_rows[row_index(wheel, i)]
        q = azimuth(wheel, own, i, y[at.spin_angle + w])
        axis = roller_axis(wheel, math.cos(q), math.sin(q))
        observed.joint_rate[row, w, i] = joint_rate(axis, rows.rates[row, w, i], twist)
        if parameters.machine.implicit_tracking:  # what it integrated is what it shows
            d = combine(-1.0, rho_of(parameters, y, w, i), 0.0, up, 0.0, up)
        else:
            d = spoke(frame, math.cos(q), math.sin(q))
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
        servo=np.zeros((count, 2)),
        wheels=blank(OBSERVED_WHEEL, count, wheels),
        joint_rate=np.empty((count, wheels, rollers)),
        motion=np.empty((3, count, wheels, rollers, 3)),
        bearing_loads=np.zeros((count if bearing_loads else 0, wheels, 2, 3, rollers + 1)),
        energies=np.zeros((0 if parameters.space is None else count, 3)),
    )
    if parameters.space is not None:
        direct(observe_in_space, parameters, rows, times, blank(SPATIAL_MONITORS, wheels), observed)
        return observed
    direct(observe, parameters, rows, times, blank(MONITORS, wheels), observed)
    return observed
