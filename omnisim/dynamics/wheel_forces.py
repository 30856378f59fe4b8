"""One wheel in the right-hand side: its friction, and the rates of its spin and rollers that follow.

Wheels that slide on one roller go a shorter way, sliding_wheel.py.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.contact.frame import Axis, Slip
from omnisim.contact.friction import friction
from omnisim.contact.kinematics import Jacobian, joint_rate, slip_acceleration, slip_jacobian, streaming
from omnisim.contact.rolling_resistance import rolling_moment, rolling_relaxation
from omnisim.contact.set_valued import SLIP, STICK
from omnisim.contact.tracking import roller_axis
from omnisim.dynamics.actuation import actuate, follow_angles, followed
from omnisim.dynamics.contact_forces import seek
from omnisim.dynamics.indices import contact_count, rate_place, roller_of, sector_of
from omnisim.dynamics.normal_forces.solution import held_body
from omnisim.dynamics.normal_forces.tilt import place_load, rotor_part, set_tilt, tilt_rows
from omnisim.dynamics.planar_body import (
    hold_against_rolling,
    holding_force,
    holds,
    pushed_equations,
    set_contact,
    set_holding,
    set_lever,
)
from omnisim.dynamics.state import TOUCHING, places
from omnisim.dynamics.twist import Acceleration, wheel_motion
from omnisim.dynamics.wheel import (
    FreeWheel,
    all_rollers,
    bearing_torque,
    contact_state,
)

NEARLY = 0.99  # cosine between two directions of creeping


@kernel
def free_wheel(parameters, stage, w, body):
    """Wheel w without the forces at its contacts: a FreeWheel, and the rates that follow from it alone."""
    machine = parameters.machine
    at = places(parameters)
    mode = stage.mode[w]
    y = stage.y
    dy = stage.dy
    spin_rate = y[at.spin_rate + w]
    dy[at.spin_angle + w] = spin_rate  # first: the sine and cosine of the next stage wait for it
    state = contact_state(parameters, mode, w, 0, body, y)
    rollers = all_rollers(parameters, mode, w, state, y)
    demand, drive = actuate(parameters, stage, w, spin_rate)
    if machine.bearing_friction:
        dy[at.bearing_loss] += rollers.bearing_loss
        air_rates(parameters, mode, w, state, y, dy)
    else:
        for side in range(TOUCHING):
            dy[rate_place(parameters, mode, w, side)] = 0.0
    spin = drive - rollers.bearing_k - body.twist.yaw * rollers.g_h
    yaw_moment = spin_rate * rollers.g_h - rollers.bearing_n
    return FreeWheel(state, rollers, demand, drive, spin, yaw_moment)


@kernel
def set_part(parameters, stage, w, free, body, load):
    """A FreeWheel into its part of the workspace."""
    part = parameters.workspace.parts[w]
    wheel = parameters.wheels[w]
    mode = stage.mode[w]
    state = free.state
    rollers = free.rollers
    part.drive_torque, part.free_spin = free.drive, free.spin
    part.followed = followed(parameters, stage, w)
    part.contacts = contact_count(mode)
    part.loaded = mode.loaded
    part.normal_force = load
    gyroscopic = wheel.axle_inertia * state.twist.spin * body.twist.yaw
    gyroscopic += body.twist.yaw * rollers.g_k - state.twist.spin * rollers.g_n
    about_k = rotor_part(wheel, mode.shared) * free.spin - free.drive - wheel.axle_inertia * part.followed
    part.tilt[0], part.tilt[1] = tilt_rows(wheel, gyroscopic - rollers.bearing_h, about_k)


@kernel
def monitor_wheel(free, load, monitors):
    """What events want to know of a wheel, unless its contacts tell more."""
    monitors.demand = free.demand
    monitors.normal_force = load
    monitors.regular = 1.0
    monitors.share, monitors.share_margin = 1.0, 0.0


@kernel
def observe_wheel(parameters, stage, w, body, load, equations, weighing):
    """What a wheel finds at its contacts, into the workspace; the BodyEquations with its own moment, and the power of
    its drive.

    load: of the wheel, N, unless the contacts carry roll and pitch; weighing: whether loads are sought.
    """
    part = parameters.workspace.parts[w]
    mode = stage.mode[w]
    free = free_wheel(parameters, stage, w, body)
    set_part(parameters, stage, w, free, body, load)
    if stage.monitoring:
        monitor_wheel(free, load, stage.monitors[w])
    seek(parameters.workspace, part, mode)
    observe_contact(parameters, mode, w, 0, body, free.state, weighing)
    if mode.shared:
        observe_contact(parameters, mode, w, 1, body, contact_state(parameters, mode, w, 1, body, stage.y), weighing)
    if weighing:
        place_load(parameters.wheels[w], parameters.workspace, w)
    if parameters.workspace.resting is not None and holds(part, parameters.workspace.contacts[part.first]):
        equations = held_body(
            parameters.workspace.loads, parameters.workspace.contacts[part.first], equations, weighing
        )
    return pushed_equations(equations, 0.0, 0.0, free.yaw_moment), free.drive * free.state.twist.spin


@kernel
def yield_to(j, slip, force):
    """What a contact's force (N) does: torque on the roller and on the spin (N m), and heat (W)."""
    return (
        j.roller_h * force.h + j.roller_k * force.k,
        j.spin_h * force.h + j.spin_k * force.k,
        -(force.h * slip.h + force.k * slip.k),
    )


@kernel
def twist(axis, turn, torque, rolling, spin, heat):
    """The same with the contact torque (N m); turn: of the roller about the normal, rad/s."""
    return rolling + torque * axis.n, spin - axis.k * axis.n * torque, heat - torque * turn


@kernel
def observe_contact(parameters, mode, w, side, body, state, weighing):
    """A contact of wheel w and its friction by the load, into the workspace; state: its ContactState."""
    machine = parameters.machine
    wheel = parameters.wheels[w]
    contact = parameters.workspace.contacts[wheel.contacts + side]
    j = slip_jacobian(wheel, state.axis, state.contact)
    set_contact(contact, state, j, mode.shared)
    if machine.rolling:
        set_resistance(wheel, contact, state)
    set_lever(wheel, contact, state.axis, j)
    if weighing:
        set_tilt(machine, wheel, contact, mode.shared)
    find_friction(parameters, mode, w, side, body, state, j)


@outlined
def set_resistance(wheel, contact, state):
    """Rolling resistance by the normal force at a ContactState, into the workspace: the roller turns along the floor
    with (chi' a_h, phi' + chi' a_k), and hands on what of the moment is not about its axis."""
    axis = state.axis
    turn_h, turn_k = state.joint * axis.h, state.twist.spin + state.joint * axis.k
    moment = rolling_moment(wheel, turn_h, turn_k)
    rolling = moment.h * axis.h + moment.k * axis.k
    contact.moment[0], contact.moment[1] = moment.h, moment.k
    contact.rolling, contact.turning = rolling, moment.k - axis.k * rolling
    contact.resisting[2] = -axis.n * rolling
    contact.rolling_heat = -(moment.h * turn_h + moment.k * turn_k)
    contact.relaxing = rolling_relaxation(wheel, turn_h, turn_k)


@kernel
def find_friction(parameters, mode, w, side, body, state, j):
    """Friction by the load at a contact of wheel w, and how it holds if it rests, into the workspace; j: its
    Jacobian."""
    machine = parameters.machine
    wheel = parameters.wheels[w]
    contact = parameters.workspace.contacts[wheel.contacts + side]
    slip = state.slip
    contact.rest = parameters.workspace.resting is not None and mode.grip[side] != SLIP
    if parameters.workspace.resting is not None and contact.rest:
        part = parameters.workspace.parts[w]
        spin = 0.0 if mode.shared else part.free_spin * wheel.spin_mobility + part.followed
        roller = bearing_torque(wheel, state.joint) * wheel.axial_mobility if machine.bearing_friction else 0.0
        still = Acceleration(0.0, 0.0, 0.0)
        bias = slip_acceleration(wheel, state, wheel_motion(wheel, body.twist, still, spin, roller))
        if parameters.space is None and mode.grip[side] == STICK and not mode.shared:
            bias = Slip(bias.h - mode.easing[0], bias.k - mode.easing[1])
        contact.bias[0], contact.bias[1] = bias.h, bias.k
        if mode.grip[side] == STICK and not mode.shared:  # its force is what holds it
            set_holding(machine, wheel, contact, state.axis, j, bias)
            contact.factor = contact.torque = 0.0
            if machine.rolling:
                hold_against_rolling(machine, wheel, contact, state.axis, j)
            return
    stream = streaming(wheel, state) if machine.brush else slip
    factor, torque = friction(machine, mode.saturated[side], 1.0, slip, state.turn, stream)
    contact.factor, contact.unit_torque = factor, torque
    if machine.viscous:  # knows no load
        contact.unit[0], contact.unit[1] = 0.0, 0.0
        contact.constant[0], contact.constant[1] = -factor * slip.h, -factor * slip.k
    else:
        contact.unit[0], contact.unit[1] = -factor * slip.h, -factor * slip.k
    if parameters.workspace.resting is not None and contact.rest:
        creep = contact.creep  # where the last search ended is the best place to begin, if it is of this creeping
        begun = mode.creep[side]
        if not creep[0] * begun[0] + creep[1] * begun[1] > NEARLY:
            creep[0], creep[1] = begun[0], begun[1]
        contact.turned = 0.0
        contact.unit[0], contact.unit[1] = -machine.friction * creep[0], -machine.friction * creep[1]


@kernel
def move_wheel(parameters, stage, w, acceleration):
    """Forces on wheel w from the body's acceleration and the loads, and the rates that follow; its heat, and the power
    of a drive that follows angles, W."""
    machine = parameters.machine
    wheel = parameters.wheels[w]
    workspace = parameters.workspace
    at = places(parameters)
    part = workspace.parts[w]
    mode = stage.mode[w]
    dy = stage.dy
    spin = part.free_spin
    loss = 0.0
    for side in range(part.contacts):
        contact = workspace.contacts[part.first + side]
        react(parameters, stage, w, side, acceleration)
        force, slip = Slip(contact.force[0], contact.force[1]), Slip(contact.slip[0], contact.slip[1])
        j = Jacobian(contact.spin[0], contact.spin[1], 0.0, 0.0, contact.arm[0], contact.arm[1])
        rolling, turning, heat = yield_to(j, slip, force)
        if machine.patch_radius > 0.0:
            axis = Axis(contact.axis[0], contact.axis[1], contact.axis[2])
            rolling, turning, heat = twist(axis, contact.turn, contact.torque, rolling, turning, heat)
        if machine.rolling:
            rolling, turning = rolling + contact.pressed * contact.rolling, turning + contact.pressed * contact.turning
            dy[at.rolling_loss] += contact.pressed * contact.rolling_heat
        dy[rate_place(parameters, mode, w, side)] += rolling * wheel.axial_mobility
        spin, loss = spin + turning, loss + heat
    dy[at.spin_rate + w] = 0.0 if mode.shared else spin * wheel.spin_mobility
    if stage.monitoring:
        monitor_loads(mode, part, workspace.contacts[part.first], stage.monitors[w])
    return loss, follow_angles(parameters, stage, w, spin) if machine.follows else 0.0


@kernel
def react(parameters, stage, w, side, acceleration):
    """Force at a contact of wheel w from the body's acceleration and the loads, into the workspace; if `monitoring`,
    what events want to know of it."""
    machine = parameters.machine
    workspace = parameters.workspace
    mode = stage.mode[w]
    part = workspace.parts[w]
    contact = workspace.contacts[part.first + side]
    normal = load = max(part.normal_force, 0.0) if part.loaded else 0.0
    if not part.loaded:
        contact.force[0], contact.force[1], contact.torque = 0.0, 0.0, 0.0
    elif part.contacts == 2:
        load = contact.share * normal
    elif parameters.workspace.resting is not None and holds(part, contact):
        contact.force[0], contact.force[1] = holding_force(contact, acceleration)
        if machine.rolling:
            contact.force[0] += contact.unit[0] * normal
            contact.force[1] += contact.unit[1] * normal
    else:
        contact.force[0] = contact.constant[0] + contact.unit[0] * normal
        contact.force[1] = contact.constant[1] + contact.unit[1] * normal
        if machine.patch_radius > 0.0:
            contact.torque = contact.unit_torque * normal
    contact.pressed = load
    if not stage.monitoring:
        return
    if machine.rolling:
        stage.monitors[w].relaxing[side] = load * contact.relaxing
    force = contact.force
    slip = contact.slip
    monitors = stage.monitors[w]
    monitors.slip_square[side] = slip[0] * slip[0] + slip[1] * slip[1]
    monitors.factor[side] = contact.factor * (contact.share * part.loaded if machine.viscous else load)
    monitors.margin[side] = 0.0
    if parameters.workspace.resting is not None and contact.rest and not mode.shared:
        monitors.margin[side] = machine.friction * normal - math.sqrt(force[0] * force[0] + force[1] * force[1])
        if part.sought:  # slip along the direction in which it creeps
            monitors.margin[side] = contact.creep[0] * slip[0] + contact.creep[1] * slip[1]


@kernel
def monitor_loads(mode, part, contact, monitors):
    """What events want to know of the load of a wheel; contact: its first."""
    monitors.normal_force = part.normal_force
    if mode.shared:
        monitors.share, monitors.share_margin = contact.share, part.share_margin


@outlined
def air_rates(parameters, mode, w, state, y, dy):
    """p' of the rollers of wheel w as if all were in the air, where their bearings have friction."""
    wheel = parameters.wheels[w]
    first = wheel.rates
    here = roller_of(mode, 0)
    for i in range(wheel.rollers):
        sector = sector_of(parameters, w, i, here)
        cos_i = state.cos_q * sector[0] - state.sin_q * sector[1]
        sin_i = state.sin_q * sector[0] + state.cos_q * sector[1]
        joint = joint_rate(roller_axis(wheel, cos_i, sin_i), y[first + i], state.twist)
        dy[first + i] = bearing_torque(wheel, joint) * wheel.axial_mobility
