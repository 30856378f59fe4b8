"""The right-hand side y' = f(t, y): the three contact stages in order, then Newton and Euler.

    M V' = F + f                                                               F = (F_h, F_k) on the roller
    Ia p' = arm . F + M_n (a . n) + T                                          M_n contact torque, T bearing torque
    J_k phi'' + sum Ia p' s + theta' G_h = tau - R F_h                         G = sum Ia p_i a_i, all rollers
    I_z theta'' + sum Ia p' (a . n) - phi' G_h = -l F_h + M_n + yaw torque

summed over both contacts of a wheel that rests on two rollers; its spin is held (shared.py).
"""

import math
from typing import NamedTuple

from omnisim.contact.coulomb import SLIP, grip_force
from omnisim.contact.kinematics import Slip, inverse_mass, joint_rate, slip_acceleration
from omnisim.contact.reaction import COULOMB, friction
from omnisim.contact.tracking import IMPLICIT, Heading, rho_rate, roller_axis
from omnisim.kernel import kernel, outlined
from omnisim.multipliers import normal_force
from omnisim.shared import share_load
from omnisim.state import YAW, X, Y, places, rate_place
from omnisim.wheel import (
    ContactState,
    all_rollers,
    bearing_torque,
    contact_state,
    drive_torque,
    external_wrench,
    free_motion,
    rho_index,
    rho_of,
)


class Reaction(NamedTuple):
    """What the floor does to a wheel at one contact."""

    state: ContactState
    factor: float  # g in F = -g v, N s/m
    force: Slip  # friction on the roller, N
    torque: float  # M_n on the roller about the normal, N m
    margin: float  # coulomb: what is left of the cone while sticking, N; slip along its direction while creeping, m/s
    roller_torque: float  # on the roller about its axis, N m


@kernel
def rhs(parameters, mode, piece, t, y, dy, watch):
    """Write y' into `dy`, and what the events need to know of each contact into `watch`."""
    machine, wheels, at = parameters.machine, parameters.wheels, places(parameters)
    # Rates of positions first: the sine and cosine of the next stage can then start while the forces are computed.
    dy[X], dy[Y], dy[YAW] = y[at.velocity], y[at.velocity + 1], y[at.yaw_rate]
    for w in range(len(wheels)):
        dy[at.spin_angle + w] = y[at.spin_rate + w]
    heading = Heading(math.cos(y[YAW]), math.sin(y[YAW]))
    wrench = external_wrench(parameters, piece, t, heading)
    lift = normal_force(machine, len(wheels), wrench.z)
    normal = max(lift, 0.0)  # a wheel that is lifted has no friction; the march stops there
    force_h, force_k, moment, loss, drive_power, bearing_loss = 0.0, 0.0, wrench.yaw, 0.0, 0.0, 0.0
    for w in range(len(wheels)):
        wheel, seen = wheels[w], watch[w]
        torque = drive_torque(parameters, piece, t, w)
        state = contact_state(parameters, mode[w], w, 0, heading, y)
        rollers = all_rollers(parameters, mode[w], w, state.cos_q, state.sin_q, y)
        if machine.bearings:
            air_rates(parameters, mode[w], w, state, y, dy)
        else:
            dy[rate_place(parameters, mode[w].roller, w, 1)] = 0.0  # unless two rollers carry
        seen.normal_force, seen.share = lift, 1.0
        if mode[w].shared:
            share_load(parameters, mode[w], w, heading, normal, wrench, torque, y, seen)
        motion = free_motion(parameters, wheel, state, rollers, heading, wrench, torque)
        reaction = contact_reaction(parameters, mode[w], w, 0, state, motion, normal, seen.share)
        spin, yaw = contact_moments(wheel, reaction)
        force_h, force_k, loss = force_h + reaction.force.h, force_k + reaction.force.k, loss + friction_loss(reaction)
        rolling = motion.roller + reaction.roller_torque / wheel.axial_inertia
        dy[rate_place(parameters, mode[w].roller, w, 0)] = rolling
        observe_contact(seen, 0, reaction)
        if mode[w].shared:
            state = contact_state(parameters, mode[w], w, 1, heading, y)
            reaction = contact_reaction(parameters, mode[w], w, 1, state, motion, normal, 1.0 - seen.share)
            _, more_yaw = contact_moments(wheel, reaction)
            yaw += more_yaw
            force_h, force_k = force_h + reaction.force.h, force_k + reaction.force.k
            loss += friction_loss(reaction)
            rolling = free_motion(parameters, wheel, state, rollers, heading, wrench, torque).roller
            rolling += reaction.roller_torque / wheel.axial_inertia
            dy[rate_place(parameters, mode[w].roller, w, 1)] = rolling
            observe_contact(seen, 1, reaction)
            dy[at.spin_rate + w] = 0.0
        else:
            gyroscopic = y[at.yaw_rate] * rollers.g_h
            dy[at.spin_rate + w] = (torque - rollers.bearing_k - gyroscopic + spin) / wheel.axle_inertia
        moment += yaw - rollers.bearing_n + y[at.spin_rate + w] * rollers.g_h
        drive_power += torque * y[at.spin_rate + w]
        bearing_loss += rollers.bearing_loss
    dy[at.velocity] = (wrench.x + force_h * heading.cos - force_k * heading.sin) / machine.mass
    dy[at.velocity + 1] = (wrench.y + force_h * heading.sin + force_k * heading.cos) / machine.mass
    dy[at.yaw_rate] = moment / machine.yaw_inertia
    dy[at.friction_loss], dy[at.drive_work] = loss, drive_power
    dy[at.wrench_work] = wrench.x * y[at.velocity] + wrench.y * y[at.velocity + 1] + wrench.yaw * y[at.yaw_rate]
    if machine.bearings:
        dy[at.bearing_loss] = bearing_loss
    if machine.tracking == IMPLICIT:
        rho_rates(parameters, heading, y, dy)


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
def contact_reaction(parameters, mode, w, side, state, motion, normal, share):
    """What the floor does to a contact of wheel w that carries `share` of the normal force (N): a Reaction.

    state: ContactState; motion: Motion of the wheel without contact forces.
    """
    machine, wheel = parameters.machine, parameters.wheels[w]
    factor, torque = friction(machine, mode.saturated[side], normal, state.slip, state.turn)
    factor, torque = share * factor, share * torque
    force, margin = Slip(-factor * state.slip.h, -factor * state.slip.k), 0.0
    if machine.law == COULOMB and mode.grip[side] != SLIP:
        if mode.shared:
            solved = parameters.room.contacts[2 * w + side].force
            force = Slip(solved[0], solved[1])
        else:
            a = inverse_mass(machine, wheel, state.axis, state.contact)
            b = slip_acceleration(wheel, state, motion)
            force, margin = grip_force(mode.grip[side], a, b, machine.friction * normal, state.slip)
    roller_torque = state.contact.arm_h * force.h + state.contact.arm_k * force.k + torque * state.axis.n
    return Reaction(state, factor, force, torque, margin, roller_torque)


@kernel
def contact_moments(wheel, reaction):
    """What a contact does to J_k phi'' and to I_z theta'', N m."""
    axis, force, roller_torque = reaction.state.axis, reaction.force, reaction.roller_torque
    spin = -wheel.radius * force.h - roller_torque * axis.k
    return spin, -reaction.state.contact.l * force.h - roller_torque * axis.n + reaction.torque


@kernel
def friction_loss(reaction):
    """-F . v - M_n w_n, W."""
    state = reaction.state
    return -reaction.force.h * state.slip.h - reaction.force.k * state.slip.k - reaction.torque * state.turn


@kernel
def observe_contact(watch, side, reaction):
    """By-products of the right-hand side that events are decided on."""
    slip = reaction.state.slip
    watch.slip_square[side] = slip.h * slip.h + slip.k * slip.k
    watch.factor[side], watch.margin[side] = reaction.factor, reaction.margin


@kernel
def rho_rates(parameters, heading, y, dy):
    """rho' of every roller: the implicit tracking integrates it for those in the air as well."""
    at = places(parameters)
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        angle = wheel.phase - y[at.spin_angle + w]
        cos_0, sin_0 = math.cos(angle), math.sin(angle)
        for i in range(wheel.rollers):
            cos_i, sin_i = parameters.sector[w, i, 0], parameters.sector[w, i, 1]
            axis = roller_axis(wheel, cos_0 * cos_i - sin_0 * sin_i, sin_0 * cos_i + cos_0 * sin_i)
            rate = rho_rate(heading, axis, y[at.spin_rate + w], y[at.yaw_rate], rho_of(parameters, y, w, i))
            j = rho_index(parameters, w, i)
            dy[j], dy[j + 1], dy[j + 2] = rate.x, rate.y, rate.z
