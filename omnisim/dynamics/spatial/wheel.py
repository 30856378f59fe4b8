"""One wheel of a machine free in space: its contacts, its rollers, its axle, and what it hands to what carries it.

    sigma = phi' + w . k      absolute rate of the axle                   G = sum Ia p_i a_i, all rollers
    Ia p_i' = a_i . ((X_i - B_i) x F_i) + M_i (a_i . nu) + T_i             T bearing torque
    J_k sigma' = T_w - s sum Ia p_i'      T_w = tau + k . sum ((X - O) x F + M nu) - k . (w x G)

A rotor J_r turns with phi', not with sigma: sigma' takes the part J_k / (J_k + J_r) of the torque, and the rest leans
on what carries the wheel like the inertia J_k J_r / (J_k + J_r) about k, a constant part of its inertia. A wheel that
follows angles is the limit of an infinite rotor.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, combine, cross, dot, minus, plus, times
from omnisim.contact.frame import Slip
from omnisim.contact.rolling_resistance import rolling_moment, rolling_relaxation
from omnisim.contact.support import region_guard
from omnisim.dynamics.actuation import actuate, followed
from omnisim.dynamics.spatial.gaps import least_gap
from omnisim.dynamics.spatial.pose import add_push, mounted, outward, tangent_of, vector
from omnisim.dynamics.spatial.reaction import react
from omnisim.dynamics.spatial.records import BASE, SLOTS
from omnisim.dynamics.spatial.seen import standing_seen, touch_place, touching_seen
from omnisim.dynamics.spatial.touching import (
    joint_rate,
    rate_of_roller,
    roller_on,
    shape_of,
)
from omnisim.dynamics.state import places
from omnisim.dynamics.wheel import bearing_torque

ZERO = Vec3(0.0, 0.0, 0.0)


class Rollers(NamedTuple):
    """Of all rollers of a wheel: sum Ia p_i a_i (hub axes, N m s), sum Ia p_i' a_i (N m), heat of bearings (W)."""

    momentum: Vec3
    torque: Vec3
    bearing_loss: float


class Pressed(NamedTuple):
    """What the ground does to a wheel: force (N) and moment about O less sum Ia p_i' a_i of the rollers (N m) along hub
    axes, their sum Ia p_i a_i (N m s), heat of friction and of rubber, W."""

    force: Vec3
    moment: Vec3
    momentum: Vec3
    friction_loss: float
    contact_loss: float


@kernel
def push_wheel(parameters, stage, w, body):
    """Forces of wheel w on what carries it into `pushes`, rates of its rollers, and its axle as if its carrier did not
    turn faster; heat of friction and of rubber, and power of its drive, W."""
    at = places(parameters)
    wheel = parameters.wheels[w]
    space = parameters.space
    own = space.hubs[w]
    part = parameters.workspace.parts[w]
    y, dy = stage.y, stage.dy
    spin_rate = y[at.spin_rate + w]
    dy[at.spin_angle + w] = spin_rate
    demand, drive = actuate(parameters, stage, w, spin_rate)
    rollers = rollers_of(parameters, stage, w, body)
    pressed = press_wheel(parameters, stage, w, body, rollers)
    if parameters.machine.bearing_friction:
        dy[at.bearing_loss] += rollers.bearing_loss
    rate, own_momentum = vector(space.stands[w].rate, 0), pressed.momentum
    turning = drive + pressed.moment.y - cross(rate, own_momentum).y
    part.drive_torque, part.free_spin = drive, turning
    part.followed = followed(parameters, stage, w)
    about_k = own.coupled * turning
    if parameters.machine.follows and wheel.follows:
        about_k = wheel.axle_inertia * part.followed
    momentum = plus(own_momentum, Vec3(0.0, wheel.axle_inertia * (spin_rate + rate.y), 0.0))
    spun = Vec3(spin_rate * own_momentum.z, about_k, -spin_rate * own_momentum.x)
    moment = minus(pressed.moment, plus(spun, cross(rate, momentum)))
    hub = standing_seen(space.stands[w], body).hub  # read where it is asked for: kept, it would fill the registers
    axes = mounted(hub)
    force = outward(axes, pressed.force)
    moment = plus(outward(axes, moment), cross(hub.centre, force))
    push = space.pushes[BASE]
    if len(space.carriers) > 0:
        push = space.pushes[1 + own.carrier]
    add_push(push, moment, force)
    if stage.monitoring:
        stage.monitors[w].demand = demand
    return pressed.friction_loss, pressed.contact_loss, drive * spin_rate


@kernel
def rollers_of(parameters, stage, w, body):
    """The Rollers of wheel w without those that touch; the rates of these are set to what their bearings do."""
    wheel = parameters.wheels[w]
    if parameters.machine.bearing_friction:
        return rollers_in_bearings(parameters, stage, w, body)
    stand = standing_seen(parameters.space.stands[w], body)
    mode, dy = stage.mode[w], stage.dy
    for slot in range(SLOTS):
        dy[wheel.rates + slot] = 0.0
    across = -wheel.cos_psi * wheel.axial_inertia
    momentum = Vec3(
        across * (mode.air_cos * stand.cos + mode.air_sin * stand.sin),
        wheel.sin_psi * wheel.axial_inertia * mode.air_sum,
        across * (mode.air_sin * stand.cos - mode.air_cos * stand.sin),
    )
    return Rollers(momentum, ZERO, 0.0)


@outlined
def rollers_in_bearings(parameters, stage, w, body):
    """The same where bearings have friction: of all rollers, whose rates are states."""
    stand = standing_seen(parameters.space.stands[w], body)
    wheel = parameters.wheels[w]
    momentum, torque, loss = ZERO, ZERO, 0.0
    for i in range(wheel.rollers):
        roller = roller_on(parameters, w, i, stand)
        rate = stage.y[wheel.rates + i]
        joint = joint_rate(stand, roller, rate)
        friction = bearing_torque(wheel, joint)
        stage.dy[wheel.rates + i] = friction * wheel.axial_mobility
        momentum = plus(momentum, times(wheel.axial_inertia * rate, roller.axis))
        torque = plus(torque, times(friction, roller.axis))
        loss -= friction * joint
    return Rollers(momentum, torque, loss)


@kernel
def press_wheel(parameters, stage, w, body, rollers):
    """What the ground does to wheel w, a Pressed; rollers: its Rollers without those that touch."""
    wheel = parameters.wheels[w]
    machine = parameters.machine
    mode, y, dy = stage.mode[w], stage.y, stage.dy
    force, moment, heat, loss = ZERO, minus(ZERO, rollers.torque), 0.0, 0.0
    momentum = rollers.momentum
    for c in range(mode.contacts):
        place = rate_of_roller(parameters, mode, w, c)
        seen = parameters.space.touches[touch_place(w, c)]
        stand, touched = standing_seen(parameters.space.stands[w], body), touching_seen(seen)
        found = react(parameters, mode, w, c, stand, touched, y[place])
        remember(seen, found)  # not at the end of a step alone: what waits to be asked for fills the registers
        rolling = found.rolling + found.torque * touched.tilt
        if machine.rolling:
            resisting = resist(parameters, stage, w, c, body, found.normal_force)
            rolling += dot(touched.roller.axis, resisting)
            moment = plus(moment, resisting)
        dy[place] += rolling * wheel.axial_mobility
        axis = touched.roller.axis
        if mode.first[c] and not machine.bearing_friction:
            momentum = plus(momentum, times(wheel.axial_inertia * y[place], axis))
        force = plus(force, found.force)
        moment = plus(moment, minus(cross(touched.arm, found.force), times(rolling, axis)))
        if machine.patch_radius > 0.0:
            moment = plus(moment, times(found.torque, touched.normal))
        heat += found.heat
        loss += (found.normal_force - parameters.space.hubs[w].stiffness * touched.depth) * found.closing
    return Pressed(force, moment, momentum, heat, loss)


@outlined
def resist(parameters, stage, w, c, body, load):
    """Moment of rolling resistance at contact c of wheel w under this load (Vec3, N m, hub axes); its heat into dy."""
    wheel, mode, space = parameters.wheels[w], stage.mode[w], parameters.space
    stand, touched = standing_seen(space.stands[w], body), touching_seen(space.touches[touch_place(w, c)])
    rate = stage.y[rate_of_roller(parameters, mode, w, c)]
    turning = combine(joint_rate(stand, touched.roller, rate), touched.roller.axis, 1.0, stand.hub.rate, 0.0, ZERO)
    turning = plus(turning, Vec3(0.0, stand.spin_rate, 0.0))
    h, k = tangent_of(touched.normal)
    turn_h, turn_k = dot(turning, h), dot(turning, k)
    over_load = rolling_moment(wheel, turn_h, turn_k)
    moment = Slip(load * over_load.h, load * over_load.k)
    stage.dy[places(parameters).rolling_loss] -= moment.h * turn_h + moment.k * turn_k
    if stage.monitoring:
        seen = parameters.space.touches[touch_place(w, c)]
        seen.resistance[0], seen.resistance[1] = moment.h, moment.k
        stage.monitors[w].relaxing[c] = load * rolling_relaxation(wheel, turn_h, turn_k)
    return combine(moment.h, h, moment.k, k, 0.0, h)


@kernel
def remember(seen, found):
    """What is told of a Reaction, into its record TOUCH."""
    seen.press, seen.normal_force = found.press, found.normal_force
    seen.factor, seen.torque = found.factor, found.torque
    seen.slip[0], seen.slip[1] = found.slip.h, found.slip.k
    seen.force[0], seen.force[1] = found.friction.h, found.friction.k


@kernel
def monitor_wheel(parameters, stage, w, body):
    """What events want to know of wheel w."""
    space, mode, monitors = parameters.space, stage.mode[w], stage.monitors[w]
    load = 0.0
    for c in range(mode.contacts):
        seen = space.touches[touch_place(w, c)]
        monitors.depth[c], monitors.within[c] = seen.depth, seen.within
        monitors.press[c], monitors.load[c] = seen.press, seen.normal_force
        monitors.inside[c] = region_guard(shape_of(space, w, mode.meeting[c]), mode.region[c], seen.tilt)
        monitors.slip_square[c] = seen.slip[0] * seen.slip[0] + seen.slip[1] * seen.slip[1]
        monitors.factor[c] = seen.factor
        monitors.margin[c] = 0.0
        load += seen.normal_force
    monitors.normal_force = parameters.workspace.parts[w].normal_force = load
    monitors.gap = least_gap(parameters, mode, w, body)


@kernel
def spin_up(parameters, stage, w, hub_turning):
    """phi'' of wheel w from the acceleration of its carrier about k, rad/s^2."""
    wheel, part = parameters.wheels[w], parameters.workspace.parts[w]
    spin = (part.free_spin - wheel.axle_inertia * hub_turning) * wheel.spin_mobility
    stage.dy[places(parameters).spin_rate + w] = spin + part.followed


@kernel
def follow_angles(parameters, stage, w, hub_turning):
    """Torque of a drive that turns wheel w as a table of angles says, into its part; its power, W."""
    wheel, part = parameters.wheels[w], parameters.workspace.parts[w]
    if not wheel.follows:
        return 0.0
    part.drive_torque = wheel.axle_inertia * (part.followed + hub_turning) - part.free_spin
    return part.drive_torque * stage.y[places(parameters).spin_rate + w]
