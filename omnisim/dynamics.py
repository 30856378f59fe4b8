"""The right-hand side y' = f(t, y): the three contact stages for every wheel, then Newton and Euler.

    M V' = sum F + f                                                           F = (F_h, F_k) on the roller
    Ia p' = arm . F + M_n (a . n) + T                                          M_n contact torque, T bearing torque
    (J_k + J_r) phi'' + sum Ia p' s + theta' G_h = tau - R F_h                 G = sum Ia p_i a_i, all rollers
    I_z theta'' = sum (lever . F + M_n (1 - (a . n)^2) + phi' G_h) + yaw torque

Each wheel first finds what is at its contacts (`observe_wheel`). A sliding contact whose load is known has its force at
once; the others wait in the room until their forces are found together (body.py, coupled.py) and each wheel takes its
share (`move_wheel`).
"""

import math

from omnisim.body import (
    Acceleration,
    free_plane,
    holding_force,
    place_load,
    pushed_plane,
    set_contact,
    set_held,
    set_lever,
    set_tilt,
    solve,
    wheel_moments,
)
from omnisim.contact.coulomb import CREEP, SLIP, STICK
from omnisim.contact.kinematics import (
    Jacobian,
    Motion,
    Slip,
    joint_rate,
    slip_acceleration,
    slip_jacobian,
)
from omnisim.contact.reaction import COULOMB, VISCOUS, friction
from omnisim.contact.tracking import IMPLICIT, Axis, rho_rate, roller_axis
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
    external = room.loads.external
    external.x, external.y, external.z, external.yaw_rate = wrench.x, wrench.y, wrench.z, body.yaw_rate
    load, waiting, sought = machine.mass * machine.gravity - wrench.z, 0, 0
    plane = free_plane(machine, wrench.x, wrench.y, wrench.yaw)
    heat, power = 0.0, 0.0  # of friction and of the drives, W
    if machine.bearings:
        dy[at.bearing_loss] = 0.0
    for w in range(len(wheels)):
        share = load / len(wheels)
        plane, loss, work = observe_wheel(parameters, mode[w], piece, t, w, body, share, plane, y, dy, watch[w])
        heat, power = heat + loss, power + work
        waiting += 1 - room.parts[w].known
        sought += room.parts[w].sought
    if waiting == 0:
        acceleration = Acceleration(plane.x / machine.mass, plane.y / machine.mass, plane.yaw / machine.yaw_inertia)
    else:
        if sought:
            acceleration, regular = settle_forces(machine, wheels, room, load, plane)
        else:
            acceleration, _, regular = solve(machine, wheels, room, load, plane)
        for w in range(len(wheels)):
            watch[w].regular = regular
            if not room.parts[w].known:
                heat += move_wheel(parameters, mode[w], w, acceleration, y, dy, watch[w])
    dy[at.friction_loss], dy[at.drive_work] = heat, power
    dy[at.velocity] = acceleration.x * body.cos - acceleration.y * body.sin
    dy[at.velocity + 1] = acceleration.x * body.sin + acceleration.y * body.cos
    dy[at.yaw_rate] = acceleration.yaw
    dy[at.wrench_work] = wrench.x * body.x + wrench.y * body.y + wrench.yaw * body.yaw_rate
    if machine.odometry:
        odometry_rates(parameters, y, dy)
    if machine.tracking == IMPLICIT:
        rho_rates(parameters, body, y, dy)


@merged
def observe_wheel(parameters, mode, piece, t, w, body, load, plane, y, dy, watch):
    """What wheel w does to the body (the Plane with it), or what it finds at its contacts, into the room.

    load: of the wheel, N, unless the contacts carry roll and pitch.
    """
    machine, wheel, room, at = parameters.machine, parameters.wheels[w], parameters.room, places(parameters)
    part, spin_rate = room.parts[w], y[at.spin_rate + w]
    state = contact_state(parameters, mode, w, 0, body, y)
    rollers = all_rollers(parameters, mode, w, state.cos_q, state.sin_q, y)
    command = drive_command(parameters, piece, t, w, y)
    drive = drive_torque(wheel, mode.drive, command, spin_rate)
    free_spin = drive - rollers.bearing_k - body.yaw_rate * rollers.g_h
    yaw_moment, heading_moment = wheel_moments(wheel, rollers, spin_rate, body.yaw_rate)
    part.drive_torque, part.free_spin, part.heading_moment = drive, free_spin, heading_moment
    part.contacts, part.loaded, part.normal_force = 1 + mode.shared, mode.loaded, load
    watch.command, watch.normal_force, watch.regular, watch.share, watch.share_margin = command, load, 1.0, 1.0, 0.0
    plane = pushed_plane(plane, 0.0, 0.0, yaw_moment)
    power = drive * spin_rate
    if machine.integrals:
        dy[at.integral + w] = integral_rate(parameters, piece, t, w, mode, command, spin_rate)
    if machine.bearings:
        dy[at.bearing_loss] += rollers.bearing_loss
        air_rates(parameters, mode, w, state, y, dy)
    else:
        for side in range(2):
            dy[rate_place(parameters, mode.roller, w, side)] = 0.0
    part.known = machine.upright != CONTACTS and mode.grip[0] == SLIP and not mode.shared
    part.sought = not part.known and mode.loaded and (mode.shared or mode.grip[0] == CREEP)
    if part.known:
        plane, heat = slide(parameters, mode, w, state, free_spin, max(load, 0.0), plane, dy, watch)
        return plane, heat, power
    observe_contact(parameters, mode, w, 0, body, state)
    if mode.shared:
        observe_contact(parameters, mode, w, 1, body, contact_state(parameters, mode, w, 1, body, y))
    if machine.upright == CONTACTS:
        place_load(wheel, room, w)
    return plane, 0.0, power


@kernel
def slide(parameters, mode, w, state, free_spin, load, plane, dy, watch):
    """The sliding contact of a wheel under a known load, N: its force, the rates that follow, the Plane with it."""
    machine, wheel, contact = parameters.machine, parameters.wheels[w], parameters.room.contacts[2 * w]
    axis, slip, j = state.axis, state.slip, slip_jacobian(wheel, state.axis, state.contact)
    set_contact(contact, state, j, False)
    factor, torque = friction(machine, mode.saturated[0], load, slip, state.turn)
    force = Slip(-factor * slip.h, -factor * slip.k)
    contact.force[0], contact.force[1], contact.torque = force.h, force.k, torque
    rolling, spin, loss = yield_to(axis, j, slip, state.turn, force, torque)
    dy[rate_place(parameters, mode.roller, w, 0)] += rolling * wheel.axial_mobility
    dy[places(parameters).spin_rate + w] = (free_spin + spin) * wheel.spin_mobility
    watch.slip_square[0], watch.factor[0], watch.margin[0] = slip.h * slip.h + slip.k * slip.k, factor, 0.0
    cos, sin = wheel.cos_heading, wheel.sin_heading
    yaw = j.yaw_h * force.h + j.yaw_k * force.k + (1.0 - axis.n * axis.n) * torque
    return pushed_plane(plane, cos * force.h - sin * force.k, sin * force.h + cos * force.k, yaw), loss


@kernel
def yield_to(axis, j, slip, turn, force, torque):
    """What a contact's force (N) and torque (N m) do: torque on the roller and on the spin (N m), and heat (W)."""
    return (
        j.roller_h * force.h + j.roller_k * force.k + torque * axis.n,
        j.spin_h * force.h + j.spin_k * force.k - axis.k * axis.n * torque,
        -(force.h * slip.h + force.k * slip.k + torque * turn),
    )


@kernel
def observe_contact(parameters, mode, w, side, body, state):
    """A contact of wheel w and its friction by the load, into the room; state: its ContactState."""
    machine, wheel, contact = parameters.machine, parameters.wheels[w], parameters.room.contacts[2 * w + side]
    slip, j = state.slip, slip_jacobian(wheel, state.axis, state.contact)
    set_contact(contact, state, j, mode.shared)
    set_lever(wheel, contact, state.axis, j)
    if machine.upright == CONTACTS:
        set_tilt(machine, wheel, contact, mode.shared)
    contact.rest = machine.law == COULOMB and mode.grip[side] != SLIP
    if contact.rest:
        spin = 0.0 if mode.shared else parameters.room.parts[w].free_spin * wheel.spin_mobility
        roller = bearing_torque(wheel, state.joint) * wheel.axial_mobility if machine.bearings else 0.0
        centre = centre_acceleration(wheel, body, 0.0, 0.0, 0.0)
        bias = slip_acceleration(wheel, state, Motion(centre.h, centre.k, spin, 0.0, roller))
        set_held(machine, wheel, contact, state.axis, j, bias)
        if mode.grip[side] == STICK and not mode.shared:  # its force is what holds it
            contact.factor = contact.torque = 0.0
            return
    factor, torque = friction(machine, mode.saturated[side], 1.0, slip, state.turn)
    unit, constant = (0.0, factor) if machine.law == VISCOUS else (factor, 0.0)
    contact.unit[0], contact.unit[1], contact.unit_torque = -unit * slip.h, -unit * slip.k, torque
    contact.constant[0], contact.constant[1] = -constant * slip.h, -constant * slip.k
    contact.factor = factor
    if contact.rest:
        creep = contact.creep  # where the last search ended is the best place to begin, if it is of this creeping
        if not creep[0] * mode.creep[0] + creep[1] * mode.creep[1] > NEARLY:
            creep[0], creep[1] = mode.creep[0], mode.creep[1]
        contact.turned = 0.0
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
        force, slip = Slip(contact.force[0], contact.force[1]), Slip(contact.slip[0], contact.slip[1])
        axis = Axis(contact.axis[0], contact.axis[1], contact.axis[2])
        j = Jacobian(contact.spin[0], contact.spin[1], 0.0, 0.0, contact.arm[0], contact.arm[1])
        rolling, turning, heat = yield_to(axis, j, slip, contact.turn, force, contact.torque)
        dy[rate_place(parameters, mode.roller, w, side)] += rolling * wheel.axial_mobility
        spin, loss = spin + turning, loss + heat
        watch.slip_square[side] = slip.h * slip.h + slip.k * slip.k
        watch.factor[side] = contact.factor * (contact.share * part.loaded if machine.law == VISCOUS else load)
        watch.margin[side] = 0.0
        if contact.rest and not mode.shared:
            size = math.sqrt(force.h * force.h + force.k * force.k)
            watch.margin[side] = machine.friction * normal - size
            if part.sought:  # slip along the direction in which it creeps
                watch.margin[side] = contact.creep[0] * slip.h + contact.creep[1] * slip.k
    dy[at.spin_rate + w] = 0.0 if mode.shared else spin * wheel.spin_mobility
    watch.normal_force = part.normal_force
    if mode.shared:
        watch.share, watch.share_margin = room.contacts[2 * w].share, part.share_margin
    return loss


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
        dy[first + i] = bearing_torque(wheel, joint) * wheel.axial_mobility


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
