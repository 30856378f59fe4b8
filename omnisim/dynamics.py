"""The right-hand side y' = f(t, y): the three contact stages for every wheel, then Newton and Euler.

    M V' = sum F + f                                                           F = (F_h, F_k) on the roller
    Ia p' = arm . F + M_n (a . n) + T                                          M_n contact torque, T bearing torque
    (J_k + J_r) phi'' + sum Ia p' s + theta' G_h = tau - R F_h                 G = sum Ia p_i a_i, all rollers
    I_z theta'' = sum (lever . F + M_n (1 - (a . n)^2) + phi' G_h) + yaw torque

First what each wheel finds at its contacts goes into the room (`observe_wheel`), then the forces are found together
(body.py, coupled.py), then each wheel takes its share (`move_wheel`).
"""

import math

from omnisim.body import holding_force, place_load, set_contact, set_held, set_moment, set_tilt, solve
from omnisim.contact.coulomb import SLIP, STICK
from omnisim.contact.kinematics import Motion, joint_rate, slip_acceleration, spin_inertia
from omnisim.contact.reaction import COULOMB, VISCOUS, friction
from omnisim.contact.tracking import IMPLICIT, rho_rate, roller_axis
from omnisim.coupled import settle_forces
from omnisim.kernel import kernel, merged, outlined
from omnisim.parameters import CONTACTS
from omnisim.state import YAW, X, Y, places, rate_place
from omnisim.wheel import (
    all_rollers,
    bearing_torque,
    body_motion,
    centre_acceleration,
    contact_state,
    drive_command,
    drive_input,
    drive_torque,
    external_wrench,
    rho_index,
    rho_of,
    world_heading,
)

NEARLY = 0.99  # cosine between two directions of creeping


@kernel
def rhs(parameters, mode, piece, t, y, dy, watch):
    """Write y' into `dy`, and what the events need to know of each wheel into `watch`."""
    machine, wheels, room, at = parameters.machine, parameters.wheels, parameters.room, places(parameters)
    # Rates of positions first: the sine and cosine of the next stage can then start while the forces are computed.
    dy[X], dy[Y], dy[YAW] = y[at.velocity], y[at.velocity + 1], y[at.yaw_rate]
    for w in range(len(wheels)):
        dy[at.spin_angle + w] = y[at.spin_rate + w]
    body = body_motion(parameters, y)
    wrench = external_wrench(parameters, piece, t, body)
    external = room.external
    external.x, external.y, external.z, external.yaw = wrench.x, wrench.y, wrench.z, wrench.yaw
    external.yaw_rate = body.yaw_rate
    load, sought = machine.mass * machine.gravity - wrench.z, 0
    dy[at.friction_loss] = dy[at.drive_work] = 0.0
    if machine.bearings:
        dy[at.bearing_loss] = 0.0
    for w in range(len(wheels)):
        room.parts[w].normal_force = load / len(wheels)  # unless the contacts carry roll and pitch
        sought += observe_wheel(parameters, mode[w], piece, t, w, body, y, dy, watch[w])
    if sought:
        acceleration, regular = settle_forces(machine, wheels, room, load)
    else:
        acceleration, _, regular = solve(machine, wheels, room, load)
    for w in range(len(wheels)):
        watch[w].regular = regular
        move_wheel(parameters, mode[w], w, acceleration, y, dy, watch[w])
    dy[at.velocity] = acceleration.x * body.cos - acceleration.y * body.sin
    dy[at.velocity + 1] = acceleration.x * body.sin + acceleration.y * body.cos
    dy[at.yaw_rate] = acceleration.yaw
    dy[at.wrench_work] = wrench.x * body.x + wrench.y * body.y + wrench.yaw * body.yaw_rate
    if machine.odometry:
        odometry_rates(parameters, y, dy)
    if machine.tracking == IMPLICIT:
        rho_rates(parameters, body, y, dy)


@merged
def observe_wheel(parameters, mode, piece, t, w, body, y, dy, watch):
    """What wheel w finds at its contacts, into the room; whether its forces must be sought."""
    machine, wheel, room, at = parameters.machine, parameters.wheels[w], parameters.room, places(parameters)
    part, spin_rate = room.parts[w], y[at.spin_rate + w]
    state = contact_state(parameters, mode, w, 0, body, y)
    rollers = all_rollers(parameters, mode, w, state.cos_q, state.sin_q, y)
    watch.command = drive_command(parameters, piece, t, w, y)
    part.drive_torque = drive_torque(wheel, mode.drive, watch.command, spin_rate)
    part.free_spin = part.drive_torque - rollers.bearing_k - body.yaw_rate * rollers.g_h
    set_moment(wheel, part, rollers, spin_rate, body.yaw_rate)
    part.contacts, part.loaded = 1 + mode.shared, mode.loaded
    part.sought = mode.loaded and (mode.shared or (mode.grip[0] != SLIP and mode.grip[0] != STICK))
    dy[at.drive_work] += part.drive_torque * spin_rate
    if machine.integrals:
        dy[at.integral + w] = integral_rate(parameters, piece, t, w, mode, watch.command, spin_rate)
    if machine.bearings:
        dy[at.bearing_loss] += rollers.bearing_loss
        air_rates(parameters, mode, w, state, y, dy)
    else:
        for side in range(2):
            dy[rate_place(parameters, mode.roller, w, side)] = 0.0
    observe_contact(parameters, mode, w, 0, body, state)
    if mode.shared:
        observe_contact(parameters, mode, w, 1, body, contact_state(parameters, mode, w, 1, body, y))
    if machine.upright == CONTACTS:
        place_load(wheel, room, w)
    return part.sought


@kernel
def observe_contact(parameters, mode, w, side, body, state):
    """A contact of wheel w and its friction by the load, into the room; state: its ContactState."""
    machine, wheel, contact = parameters.machine, parameters.wheels[w], parameters.room.contacts[2 * w + side]
    slip = state.slip
    set_contact(wheel, contact, state, mode.shared)
    if machine.upright == CONTACTS:
        set_tilt(machine, wheel, contact, mode.shared)
    factor, torque = friction(machine, mode.saturated[side], 1.0, slip, state.turn)
    unit, constant = (0.0, factor) if machine.law == VISCOUS else (factor, 0.0)
    contact.unit[0], contact.unit[1], contact.unit_torque = -unit * slip.h, -unit * slip.k, torque
    contact.constant[0], contact.constant[1] = -constant * slip.h, -constant * slip.k
    contact.factor = factor
    contact.rest = machine.law == COULOMB and mode.grip[side] != SLIP
    if contact.rest:
        spin = 0.0 if mode.shared else parameters.room.parts[w].free_spin / spin_inertia(wheel)
        roller = bearing_torque(wheel, state.joint) / wheel.axial_inertia if machine.bearings else 0.0
        centre = centre_acceleration(wheel, body, 0.0, 0.0, 0.0)
        bias = slip_acceleration(wheel, state, Motion(centre.h, centre.k, spin, 0.0, roller))
        set_held(machine, wheel, contact, state, bias)
        creep = contact.creep  # where the last search ended is the best place to begin, if it is of this creeping
        if not creep[0] * mode.creep[0] + creep[1] * mode.creep[1] > NEARLY:
            creep[0], creep[1] = mode.creep[0], mode.creep[1]
        contact.unit[0], contact.unit[1] = -machine.friction * creep[0], -machine.friction * creep[1]


@merged
def move_wheel(parameters, mode, w, acceleration, y, dy, watch):
    """Forces on wheel w from the body's acceleration and the loads, and the rates that follow."""
    machine, wheel, room, at = parameters.machine, parameters.wheels[w], parameters.room, places(parameters)
    part = room.parts[w]
    normal = max(part.normal_force, 0.0) if part.loaded else 0.0
    spin, loss = part.free_spin, 0.0
    for side in range(part.contacts):
        contact, load = room.contacts[2 * w + side], normal
        if not part.loaded:
            contact.force[0], contact.force[1], contact.torque = 0.0, 0.0, 0.0
        elif part.contacts == 2:
            load = contact.share * normal
        elif contact.rest and not part.sought:
            contact.force[0], contact.force[1] = holding_force(contact, acceleration)
        else:
            contact.force[0] = contact.constant[0] + contact.unit[0] * normal
            contact.force[1] = contact.constant[1] + contact.unit[1] * normal
            contact.torque = contact.unit_torque * normal
        force_h, force_k, slip = contact.force[0], contact.force[1], contact.slip
        rolling = contact.arm[0] * force_h + contact.arm[1] * force_k + contact.torque * contact.axis[2]
        dy[rate_place(parameters, mode.roller, w, side)] += rolling / wheel.axial_inertia
        spin += contact.spin[0] * force_h + contact.spin[1] * force_k
        spin -= contact.axis[1] * contact.axis[2] * contact.torque
        loss -= force_h * slip[0] + force_k * slip[1] + contact.torque * contact.turn
        watch.slip_square[side] = slip[0] * slip[0] + slip[1] * slip[1]
        watch.factor[side] = contact.factor * (contact.share * part.loaded if machine.law == VISCOUS else load)
        watch.margin[side] = 0.0
        if contact.rest and not mode.shared:
            size = math.sqrt(force_h * force_h + force_k * force_k)
            watch.margin[side] = machine.friction * normal - size
            if part.sought:  # slip along the direction in which it creeps
                watch.margin[side] = contact.creep[0] * slip[0] + contact.creep[1] * slip[1]
    dy[at.spin_rate + w] = 0.0 if mode.shared else spin / spin_inertia(wheel)
    dy[at.friction_loss] += loss
    watch.normal_force, watch.share, watch.share_margin = part.normal_force, 1.0, 0.0
    if mode.shared:
        watch.share, watch.share_margin = room.contacts[2 * w].share, part.share_margin


@outlined
def air_rates(parameters, mode, w, state, y, dy):
    """p' of the rollers of wheel w as if all were in the air, where their bearings have friction."""
    wheel, at = parameters.wheels[w], places(parameters)
    first, here = at.roller_rate + parameters.machine.slots * w, mode.roller % wheel.rollers
    for i in range(wheel.rollers):
        sector = parameters.sector[w, (i - here) % wheel.rollers]
        cos_i = state.cos_q * sector[0] - state.sin_q * sector[1]
        sin_i = state.sin_q * sector[0] + state.cos_q * sector[1]
        joint = joint_rate(roller_axis(wheel, cos_i, sin_i), y[first + i], state.spin_rate, state.yaw_rate)
        dy[first + i] = bearing_torque(wheel, joint) / wheel.axial_inertia


@kernel
def integral_rate(parameters, piece, t, w, mode, command, spin_rate):
    """Rate of the integrated error of a drive, rad/s: its error, and back from what the limit cuts off its torque."""
    wheel = parameters.wheels[w]
    if wheel.drive_integral == 0.0:
        return 0.0
    error = drive_input(parameters, piece, t, w) - spin_rate
    return error if mode.drive == 0 else error + (mode.drive * wheel.drive_limit - command) / wheel.drive_gain


@kernel
def odometry_rates(parameters, y, dy):
    """Velocity of the chassis origin as the ideal wheels tell it, in a world that their own yaw tells."""
    at, yaw, x_rate, y_rate = places(parameters), parameters.machine.odometry_yaw, 0.0, 0.0
    for w in range(len(parameters.wheels)):
        twist = parameters.wheels[w].odometry
        yaw += twist[2] * y[at.spin_angle + w]
        x_rate += twist[0] * y[at.spin_rate + w]
        y_rate += twist[1] * y[at.spin_rate + w]
    cos, sin = math.cos(yaw), math.sin(yaw)
    dy[at.odometry], dy[at.odometry + 1] = x_rate * cos - y_rate * sin, x_rate * sin + y_rate * cos


@kernel
def rho_rates(parameters, body, y, dy):
    """rho' of every roller: the implicit tracking integrates it for those in the air as well."""
    at = places(parameters)
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        heading = world_heading(wheel, body)
        angle = wheel.phase - y[at.spin_angle + w]
        cos_0, sin_0 = math.cos(angle), math.sin(angle)
        for i in range(wheel.rollers):
            cos_i, sin_i = parameters.sector[w, i, 0], parameters.sector[w, i, 1]
            axis = roller_axis(wheel, cos_0 * cos_i - sin_0 * sin_i, sin_0 * cos_i + cos_0 * sin_i)
            rate = rho_rate(heading, axis, y[at.spin_rate + w], y[at.yaw_rate], rho_of(parameters, y, w, i))
            j = rho_index(parameters, w, i)
            dy[j], dy[j + 1], dy[j + 2] = rate.x, rate.y, rate.z
