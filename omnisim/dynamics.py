"""The right-hand side y' = f(t, y): the three contact stages in order, then Newton and Euler.

    M V' = F + f                                                               F = (F_h, F_k) on the roller
    Ia p' = arm . F                                                            only the roller in contact
    J_k phi'' + Ia p' s + theta' G_h = tau - R F_h                             G = sum Ia p_i a_i, all rollers
    I_z theta'' + Ia p' (a . n) - phi' G_h = -l F_h + yaw torque

A roller in the air keeps its absolute axial rate p exactly. Together they act on the wheel through G, whose share
from the air is fixed in the wheel and known from three sums, so a step costs the same whatever N_r is.
"""

import math
from typing import NamedTuple

from omnisim.contact.coulomb import SLIP, grip_force
from omnisim.contact.kinematics import Free, Slip, inverse_mass, joint_rate, slip_bias, slip_velocity
from omnisim.contact.reaction import COULOMB, friction_factor
from omnisim.contact.tracking import (
    IMPLICIT,
    Axis,
    Contact,
    Heading,
    explicit_contact,
    implicit_contact,
    rho_rate,
    roller_axis,
)
from omnisim.kernel import kernel
from omnisim.multipliers import normal_force
from omnisim.parameters import DRIVE, FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE
from omnisim.state import YAW, X, Y, places
from omnisim.vector import Vec3


class Wrench(NamedTuple):
    """External force (world axes, N) and yaw torque (N m) on the wheel centre."""

    x: float
    y: float
    z: float
    yaw: float


class ContactState(NamedTuple):
    """Where the contact of a wheel is and how fast it moves."""

    axis: Axis
    contact: Contact
    cos_q: float
    sin_q: float
    velocity: Slip  # of the wheel centre
    joint: float  # chi', rad/s
    slip: Slip
    spin_rate: float
    yaw_rate: float
    g_h: float  # momentum of all rollers about their axes, N m s
    g_k: float
    g_n: float


class Reaction(NamedTuple):
    """What the floor does to a wheel."""

    state: ContactState
    factor: float  # g in F = -g v, N s/m
    force: Slip  # friction on the roller, N
    margin: float  # coulomb: what is left of the cone while sticking, N; slip along its direction while creeping, m/s
    roller_torque: float  # Ia p', N m


@kernel
def rhs(parameters, mode, piece, t, y, dy, watch):
    """Write y' into `dy`, and what the events need to know of each contact into `watch`."""
    machine, wheels = parameters.machine, parameters.wheels
    at = places(len(wheels))
    # Rates of positions first: the sine and cosine of the next stage can then start while the forces are computed.
    dy[X], dy[Y], dy[YAW] = y[at.velocity], y[at.velocity + 1], y[at.yaw_rate]
    for w in range(len(wheels)):
        dy[at.spin_angle + w] = y[at.spin_rate + w]
    heading = Heading(math.cos(y[YAW]), math.sin(y[YAW]))
    wrench = external_wrench(parameters, piece, t, heading)
    lift = normal_force(machine, len(wheels), wrench.z)
    normal = max(lift, 0.0)  # a wheel that is lifted has no friction; the march stops there
    force_x, force_y, moment, loss, drive_power = wrench.x, wrench.y, wrench.yaw, 0.0, 0.0
    for w in range(len(wheels)):
        torque = drive_torque(parameters, piece, t, w)
        reaction = contact_reaction(parameters, mode[w], w, heading, normal, wrench, torque, y)
        dy[at.spin_rate + w] = spin_acceleration(wheels[w], reaction, torque, y[at.yaw_rate])
        dy[at.roller_rate + w] = reaction.roller_torque / wheels[w].axial_inertia
        force_x += reaction.force.h * heading.cos - reaction.force.k * heading.sin
        force_y += reaction.force.h * heading.sin + reaction.force.k * heading.cos
        moment += yaw_moment(reaction, y[at.spin_rate + w])
        loss -= reaction.force.h * reaction.state.slip.h + reaction.force.k * reaction.state.slip.k
        drive_power += torque * y[at.spin_rate + w]
        observe_contact(watch[w], reaction, lift)
    dy[at.velocity], dy[at.velocity + 1] = force_x / machine.mass, force_y / machine.mass
    dy[at.yaw_rate] = moment / machine.yaw_inertia
    dy[at.friction_loss], dy[at.drive_work] = loss, drive_power
    dy[at.wrench_work] = wrench.x * y[at.velocity] + wrench.y * y[at.velocity + 1] + wrench.yaw * y[at.yaw_rate]
    if machine.tracking == IMPLICIT:
        rho_rates(parameters, heading, y, dy)


@kernel
def external_wrench(parameters, piece, t, heading):
    """The scene's wrench at time t on the current piece of the tables, in world axes."""
    elapsed, channels = t - parameters.starts[piece], parameters.inputs[piece]
    x = channels[FORCE_X, 0] + channels[FORCE_X, 1] * elapsed
    y = channels[FORCE_Y, 0] + channels[FORCE_Y, 1] * elapsed
    z = channels[FORCE_Z, 0] + channels[FORCE_Z, 1] * elapsed
    yaw = channels[YAW_TORQUE, 0] + channels[YAW_TORQUE, 1] * elapsed
    if parameters.machine.body_frame:
        x, y = x * heading.cos - y * heading.sin, x * heading.sin + y * heading.cos
    return Wrench(x, y, z, yaw)


@kernel
def drive_torque(parameters, piece, t, w):
    """tau of wheel w on the disk about k, N m."""
    value, slope = parameters.inputs[piece, DRIVE + w, 0], parameters.inputs[piece, DRIVE + w, 1]
    return value + slope * (t - parameters.starts[piece])


@kernel
def contact_state(parameters, mode, w, heading, y):
    """Tracking and kinematics of wheel w: a ContactState."""
    machine, wheel, at = parameters.machine, parameters.wheels[w], places(len(parameters.wheels))
    spin_rate, roller_rate, yaw_rate = y[at.spin_rate + w], y[at.roller_rate + w], y[at.yaw_rate]
    q = azimuth(wheel, mode.roller, y[at.spin_angle + w])
    cos_q, sin_q = math.cos(q), math.sin(q)
    axis = roller_axis(wheel, cos_q, sin_q)
    if machine.tracking == IMPLICIT:
        contact = implicit_contact(wheel, heading, axis, rho_of(parameters, y, w, mode.roller % wheel.rollers))
    else:
        contact = explicit_contact(wheel, cos_q, sin_q)
    velocity = Slip(
        y[at.velocity] * heading.cos + y[at.velocity + 1] * heading.sin,
        y[at.velocity + 1] * heading.cos - y[at.velocity] * heading.sin,
    )
    joint = joint_rate(axis, roller_rate, spin_rate, yaw_rate)
    slip = slip_velocity(wheel, contact, velocity.h, velocity.k, spin_rate, yaw_rate, joint)
    cos_sum, sin_sum = mode.air_cos + roller_rate, mode.air_sin
    across = -wheel.cos_psi * wheel.axial_inertia
    g_h = across * (cos_q * cos_sum - sin_q * sin_sum)
    g_n = across * (sin_q * cos_sum + cos_q * sin_sum)
    g_k = wheel.axial_inertia * wheel.sin_psi * (mode.air_sum + roller_rate)
    return ContactState(axis, contact, cos_q, sin_q, velocity, joint, slip, spin_rate, yaw_rate, g_h, g_k, g_n)


@kernel
def contact_equation(machine, wheel, state, heading, wrench, torque):
    """A and b of the slip acceleration v' = A F + b, at a ContactState under an external wrench and drive torque."""
    free = Free(
        (wrench.x * heading.cos + wrench.y * heading.sin) / machine.mass,
        (wrench.y * heading.cos - wrench.x * heading.sin) / machine.mass,
        (torque - state.yaw_rate * state.g_h) / wheel.axle_inertia,
        (wrench.yaw + state.spin_rate * state.g_h) / machine.yaw_inertia,
    )
    return inverse_mass(machine, wheel, state.axis, state.contact), slip_bias(wheel, state, free)


@kernel
def contact_reaction(parameters, mode, w, heading, normal, wrench, torque, y):
    """What the floor does to wheel w with normal force `normal` (N) and drive `torque` (N m): a Reaction."""
    machine, wheel = parameters.machine, parameters.wheels[w]
    state = contact_state(parameters, mode, w, heading, y)
    factor = friction_factor(machine, mode.saturated, normal, state.slip)
    force, margin = Slip(-factor * state.slip.h, -factor * state.slip.k), 0.0
    if machine.law == COULOMB and mode.grip != SLIP:
        a, b = contact_equation(machine, wheel, state, heading, wrench, torque)
        force, margin = grip_force(mode.grip, a, b, machine.friction * normal, state.slip)
    roller_torque = state.contact.arm_h * force.h + state.contact.arm_k * force.k
    return Reaction(state, factor, force, margin, roller_torque)


@kernel
def azimuth(wheel, roller, spin_angle):
    """q of a roller (counted on through every turn), rad."""
    return wheel.phase + 2.0 * wheel.alpha * roller - spin_angle


@kernel
def spin_acceleration(wheel, reaction, torque, yaw_rate):
    """phi'', rad/s^2."""
    driven = torque - wheel.radius * reaction.force.h
    return (
        driven - reaction.roller_torque * reaction.state.axis.k - yaw_rate * reaction.state.g_h
    ) / wheel.axle_inertia


@kernel
def yaw_moment(reaction, spin_rate):
    """Share of a wheel in I_z theta'', N m."""
    gyroscopic = spin_rate * reaction.state.g_h - reaction.roller_torque * reaction.state.axis.n
    return gyroscopic - reaction.state.contact.l * reaction.force.h


@kernel
def observe_contact(watch, reaction, normal):
    """By-products of the right-hand side that events are decided on."""
    watch.normal_force = normal
    watch.slip_square = reaction.state.slip.h * reaction.state.slip.h + reaction.state.slip.k * reaction.state.slip.k
    watch.factor = reaction.factor
    watch.margin = reaction.margin


@kernel
def rho_of(parameters, y, w, roller):
    """rho of a roller (0..N_r-1) of wheel w (Vec3)."""
    at = rho_index(parameters, w, roller)
    return Vec3(y[at], y[at + 1], y[at + 2])


@kernel
def rho_index(parameters, w, roller):
    """Where rho of a roller stands in the state: all rho follow one another, wheel by wheel."""
    wheels, rollers = parameters.sector.shape[0], parameters.sector.shape[1]
    return places(wheels).rho + 3 * (w * rollers + roller)


@kernel
def rho_rates(parameters, heading, y, dy):
    """rho' of every roller: the implicit tracking integrates it for those in the air as well."""
    for w in range(len(parameters.wheels)):
        wheel, at = parameters.wheels[w], places(len(parameters.wheels))
        angle = wheel.phase - y[at.spin_angle + w]
        cos_0, sin_0 = math.cos(angle), math.sin(angle)
        for i in range(wheel.rollers):
            cos_i, sin_i = parameters.sector[w, i, 0], parameters.sector[w, i, 1]
            axis = roller_axis(wheel, cos_0 * cos_i - sin_0 * sin_i, sin_0 * cos_i + cos_0 * sin_i)
            rate = rho_rate(heading, axis, y[at.spin_rate + w], y[at.yaw_rate], rho_of(parameters, y, w, i))
            j = rho_index(parameters, w, i)
            dy[j], dy[j + 1], dy[j + 2] = rate.x, rate.y, rate.z
