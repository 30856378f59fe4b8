"""One wheel at an instant: where it touches and how fast, what its rollers do to it, and its motion without friction.

    G = sum Ia p_i a_i    momentum of all rollers about their axes        T_i    bearing torque on roller i about a_i

A roller in the air keeps its absolute axial rate p exactly as long as its bearing is frictionless. Together they act
on the wheel through G, whose share from the air is fixed in the wheel and known from three sums, so a step costs the
same whatever N_r is.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec2, Vec3
from omnisim.contact.frame import Axis, Slip, WheelTwist, tangential, turn_rate
from omnisim.contact.kinematics import joint_rate, slip_velocity
from omnisim.contact.tracking import (
    Contact,
    explicit_contact,
    implicit_contact,
    roller_axis,
)
from omnisim.dynamics.indices import rate_place, rho_place, roller_of, row_index, sector_of
from omnisim.dynamics.parameters import FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import Wrench, wheel_twist, world_frame


class ContactState(NamedTuple):
    """Where a contact of a wheel is and how fast it moves."""

    axis: Axis
    contact: Contact
    cos_q: float
    sin_q: float
    twist: WheelTwist
    joint: float  # chi', rad/s
    slip: Slip
    turn: float  # angular velocity of the roller about the normal, rad/s


class Rollers(NamedTuple):
    """What all rollers of a wheel do to it, along h, k and n: G (N m s), and sum T_i a_i of their bearings (N m)."""

    g_h: float
    g_k: float
    g_n: float
    bearing_h: float
    bearing_k: float
    bearing_n: float
    bearing_loss: float  # W


class FreeWheel(NamedTuple):
    """A wheel without the forces at its contacts; torques in N m."""

    state: ContactState  # of contact 0
    rollers: Rollers
    demand: float  # of its drive, torque (N m) or voltage (V)
    drive: float  # tau on the disk about k
    spin: float  # J phi'', or what there is of it where the drive follows angles
    yaw_moment: float  # on the body about the vertical


@kernel
def external_wrench(parameters, piece, t, body):
    """The scene's wrench at time t on the current piece of the tables."""
    if not parameters.machine.pushed:
        return Wrench(0.0, 0.0, 0.0, 0.0)
    elapsed = t - parameters.starts[piece]
    channels = parameters.inputs[piece]
    lever = parameters.machine.lever
    x = channels[FORCE_X, 0] + channels[FORCE_X, 1] * elapsed
    y = channels[FORCE_Y, 0] + channels[FORCE_Y, 1] * elapsed
    z = channels[FORCE_Z, 0] + channels[FORCE_Z, 1] * elapsed
    yaw = channels[YAW_TORQUE, 0] + channels[YAW_TORQUE, 1] * elapsed
    if not parameters.machine.body_frame:
        x, y = tangential(body.frame, Vec2(x, y))
    return Wrench(x, y, z, yaw + lever[0] * y - lever[1] * x)


@kernel
def azimuth(wheel, row, roller, spin_angle):
    """q of a roller (counted on through every turn) on a row, a record ROLLER_ROW, rad."""
    return row.phase + 2.0 * wheel.alpha * roller - spin_angle


@kernel
def azimuth_of(parameters, w, roller, spin_angle):
    """The same of any roller of wheel w, whichever row it is on."""
    wheel = parameters.wheels[w]
    return azimuth(wheel, parameters.roller_rows[row_index(wheel, roller)], roller, spin_angle)


@kernel
def roller_end(wheel, roller, direction):
    """Spin angle at which a roller ends, for spin of the sense `direction`, rad: one number for both neighbours."""
    return wheel.phase + wheel.alpha * (2 * roller + direction)


@kernel
def contact_state(parameters, mode, w, side, body, y):
    """Tracking and kinematics of a contact of wheel w: a ContactState."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    row = parameters.roller_rows[mode.row[side]]
    roller = roller_of(mode, side)
    roller_rate = y[rate_place(parameters, mode, w, side)]
    q = azimuth(wheel, row, roller, y[at.spin_angle + w])
    cos_q, sin_q = cos_sin(q)
    axis = roller_axis(wheel, cos_q, sin_q)
    if parameters.machine.implicit_tracking:
        rho = rho_of(parameters, y, w, mode.index[side])
        contact = implicit_contact(wheel, world_frame(wheel, body), axis, rho)
    else:
        contact = explicit_contact(wheel, cos_q, sin_q)
    contact = on_row(contact, row)
    twist = wheel_twist(wheel, body.twist, y[at.spin_rate + w])
    joint = joint_rate(axis, roller_rate, twist)
    slip = slip_velocity(wheel, contact, twist, joint)
    return ContactState(axis, contact, cos_q, sin_q, twist, joint, slip, turn_rate(axis, twist, joint))


@kernel
def on_row(contact, row):
    """The Contact of a wheel from that of a roller that stands in its middle: `row` has its offset along the axle."""
    return Contact(contact.l + row.offset, contact.arm_h, contact.arm_k)


@kernel
def all_rollers(parameters, mode, w, state, y):
    """The Rollers of wheel w; state: the ContactState of contact 0."""
    if parameters.machine.bearing_friction:
        return bearing_rollers(parameters, mode, w, state, y)
    g = spin_momentum(parameters, mode, w, state.cos_q, state.sin_q, y)
    return Rollers(g.x, g.y, g.z, 0.0, 0.0, 0.0, 0.0)


@kernel
def spin_momentum(parameters, mode, w, cos_q, sin_q, y):
    """G of rollers without friction in their bearings, along h, k and n (Vec3, N m s); cos_q, sin_q: of contact 0."""
    wheel = parameters.wheels[w]
    across = -wheel.cos_psi * wheel.axial_inertia
    along = wheel.axial_inertia * wheel.sin_psi
    rate = y[rate_place(parameters, mode, w, 0)]
    cos_sum = mode.air_cos + rate
    sin_sum = mode.air_sin
    total = mode.air_sum + rate
    if mode.shared:  # contact 1 stands 2 alpha behind
        rate = y[rate_place(parameters, mode, w, 1)]
        angle = -2.0 * wheel.alpha
        cos_sum = cos_sum + rate * math.cos(angle)
        sin_sum = sin_sum + rate * math.sin(angle)
        total = total + rate
    return Vec3(
        across * (cos_q * cos_sum - sin_q * sin_sum), along * total, across * (sin_q * cos_sum + cos_q * sin_sum)
    )


@outlined
def bearing_rollers(parameters, mode, w, state, y):
    """The same when every roller's rate is a state, with the friction of their bearings."""
    wheel = parameters.wheels[w]
    here = roller_of(mode, 0)
    cos_q, sin_q = state.cos_q, state.sin_q
    g_h, g_k, g_n, bearing_h, bearing_k, bearing_n, loss = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(wheel.rollers):
        sector = sector_of(parameters, w, i, here)
        axis = roller_axis(wheel, cos_q * sector[0] - sin_q * sector[1], sin_q * sector[0] + cos_q * sector[1])
        rate = y[wheel.rates + i]
        momentum = wheel.axial_inertia * rate
        g_h, g_k, g_n = g_h + momentum * axis.h, g_k + momentum * axis.k, g_n + momentum * axis.n
        joint = joint_rate(axis, rate, state.twist)
        torque = bearing_torque(wheel, joint)
        bearing_h += torque * axis.h
        bearing_k += torque * axis.k
        bearing_n += torque * axis.n
        loss -= torque * joint
    return Rollers(g_h, g_k, g_n, bearing_h, bearing_k, bearing_n, loss)


@kernel
def bearing_torque(wheel, joint):
    """T on a roller about its axis, N m, from its rate chi' = `joint` in the bearing: viscous and Coulomb.

    The Coulomb torque changes its sign over `bearing_rate`, smoothly.
    """
    reversal = math.sqrt(joint * joint + wheel.bearing_rate * wheel.bearing_rate)
    return -(wheel.bearing_viscosity + wheel.bearing_torque / reversal) * joint


@kernel
def rho_of(parameters, y, w, roller):
    """rho of a roller (0..N_r-1) of wheel w (Vec3)."""
    at = rho_place(parameters, w, roller)
    return Vec3(y[at], y[at + 1], y[at + 2])
