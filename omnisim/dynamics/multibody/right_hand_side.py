"""The right-hand side of the multibody formulation: every body, every joint, every multiplier.

What the elimination along the tree (elimination.py) leaves are the equations of the chassis: its acceleration, and what
the floor carries. They have the form of those of planar_body.py and normal_forces, with numbers that follow from
the bodies as they stand and move, and so the same reaction stage finds loads and friction. Then the accelerations go
back along the tree, and with them the force and the moment of every joint.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.contact.frame import Axis, Slip, WheelTwist, frame_along
from omnisim.contact.kinematics import Jacobian
from omnisim.contact.tracking import explicit_contact, implicit_contact
from omnisim.dynamics.actuation import actuate, follow_angles, followed, rest_motors
from omnisim.dynamics.contact_forces import find_forces, seek
from omnisim.dynamics.indices import body_place, carries, contact_count
from omnisim.dynamics.multibody.chassis import (
    Balance,
    chassis_balance,
    chassis_of,
    equations_of,
    joined,
    resisting,
    set_tilt_rows,
)
from omnisim.dynamics.multibody.elimination import (
    UP,
    Articulated,
    Inertia,
    Wrench3,
    articulate,
    handed_on,
    resistance,
    transmitted,
)
from omnisim.dynamics.multibody.joint_forces import (
    RollerMotion,
    floor_along,
    keep_joint,
    load_joint,
    on_roller,
    roller_motion,
)
from omnisim.dynamics.multibody.rigid_body import (
    against_gravity,
    rate_states,
    rigid_body,
    second_axis,
    store_vector,
    third_axis,
    vector_at,
)
from omnisim.dynamics.normal_forces.servo import find_servo
from omnisim.dynamics.normal_forces.solution import given_load, held_body, loads_known
from omnisim.dynamics.normal_forces.tilt import TILT_X, TILT_Y, place_load
from omnisim.dynamics.planar_body import holds, set_contact
from omnisim.dynamics.state import YAW, X, Y, places
from omnisim.dynamics.twist import Body, Twist, power_of
from omnisim.dynamics.wheel import ContactState, bearing_torque, external_wrench, on_row, rho_of
from omnisim.dynamics.wheel_forces import find_friction, monitor_loads, react, set_resistance


class Place(NamedTuple):
    """A contact: its roller's axis and centre from O, where it is from the roller's centre, and h, k of its wheel."""

    axis: Vec3
    rho: Vec3
    arm: Vec3
    h: Vec3
    k: Vec3


@outlined
def multibody_rhs(parameters, stage):
    """Write y' of a Stage, and if `monitoring` what events and observers want to know, as `rhs` does."""
    machine = parameters.machine
    wheels = parameters.wheels
    workspace = parameters.workspace
    at = places(parameters)
    mode, y, dy = stage.mode, stage.y, stage.dy
    carrier = chassis_of(parameters, y)
    rate = carrier.body.rate
    twist = Twist(dot(carrier.velocity, carrier.x), dot(carrier.velocity, carrier.y), rate.z)
    body = Body(frame_along(carrier.x), twist)
    wrench = external_wrench(parameters, stage.piece, stage.t, body)
    dy[X], dy[Y], dy[YAW] = carrier.velocity.x, carrier.velocity.y, rate.z
    if machine.motors:
        rest_motors(parameters, dy)
    if machine.rolling:
        dy[at.rolling_loss] = 0.0
    balance = chassis_balance(machine, carrier, wrench)
    heat, power, sought, bearing_loss = 0.0, 0.0, 0, 0.0
    for w in range(len(wheels)):
        own, work, loss = join_wheel(parameters, stage, w, carrier)
        balance = joined(balance, own)
        power = power + work
        bearing_loss = bearing_loss + loss
    load = -balance.known.z
    equations = equations_of(balance)
    set_tilt_rows(balance, workspace.loads.tilt)
    weighing = not loads_known(machine)
    pushing = not weighing or machine.viscous == 1
    for w in range(len(wheels)):
        part = workspace.parts[w]
        part.normal_force = given_load(machine, load, len(wheels))
        for side in range(part.contacts):
            meet(parameters, mode[w], w, side, carrier, body, y)
        place_load(wheels[w], workspace, w)
        sought += part.sought
        pushing = pushing or mode[w].shared == 1
        if workspace.resting is not None and holds(part, workspace.contacts[part.first]):
            equations = held_body(workspace.loads, workspace.contacts[part.first], equations, weighing)
    acceleration, regular = find_forces(parameters, load, equations, weighing, pushing, sought)
    angular = times(acceleration.yaw, UP)
    linear = plus(times(acceleration.x, carrier.x), times(acceleration.y, carrier.y))
    for w in range(len(wheels)):
        part = workspace.parts[w]
        for side in range(part.contacts):
            contact = workspace.contacts[part.first + side]
            react(parameters, stage, w, side, acceleration)
            heat -= contact.force[0] * contact.slip[0] + contact.force[1] * contact.slip[1]
            heat -= contact.torque * contact.turn
            if machine.rolling:
                dy[at.rolling_loss] += contact.pressed * contact.rolling_heat
        if stage.monitoring:
            monitors = stage.monitors[w]
            monitors.regular = regular
            monitors.demand = part.demand
            monitors.share, monitors.share_margin = 1.0, 0.0
            monitor_loads(mode[w], part, workspace.contacts[part.first], monitors)
        power = power + move_bodies(parameters, stage, w, carrier, linear, angular)
    reference = plus(linear, plus(cross(angular, carrier.arm), cross(rate, cross(rate, carrier.arm))))
    rate_states(dy, body_place(parameters, -1, 0), carrier.body, reference, angular)
    dy[at.drift], dy[at.drift + 1] = 0.0, 0.0
    dy[at.velocity], dy[at.velocity + 1], dy[at.yaw_rate] = linear.x, linear.y, acceleration.yaw
    dy[at.friction_loss], dy[at.drive_work] = heat, power
    dy[at.wrench_work] = power_of(wrench, twist)
    if machine.bearing_friction:
        dy[at.bearing_loss] = bearing_loss
    if stage.monitoring and loads_known(machine):
        find_servo(machine, workspace, acceleration)


@kernel
def join_wheel(parameters, stage, w, carrier):
    """A wheel eliminated onto the chassis, without its contacts: the Balance that the chassis feels of it, power of its
    drive and loss of its bearings (W)."""
    workspace = parameters.workspace
    at = places(parameters)
    mode = stage.mode[w]
    y = stage.y
    dy = stage.dy
    art, loss = articulate(parameters, w, y)
    disk = rigid_body(y, body_place(parameters, w, 0))
    arm = minus(disk.position, carrier.centre)
    held = mode.shared == 1
    spin_rate = dot(minus(disk.rate, carrier.body.rate), art.axle)
    demand, drive = actuate(parameters, stage, w, spin_rate)
    dy[at.spin_angle + w] = spin_rate
    nothing = Vec3(0.0, 0.0, 0.0)
    _, along_x = transmitted(art, resistance(art, nothing, carrier.x), 0.0, held)
    _, along_y = transmitted(art, resistance(art, nothing, carrier.y), 0.0, held)
    _, turning = transmitted(art, resistance(art, UP, cross(UP, arm)), 0.0, held)
    asked = followed(parameters, stage, w)
    needed = moving(art, carrier.body.rate, spin_rate, arm, nothing, nothing, asked)
    _, free = transmitted(art, needed, drive, held)
    part = workspace.parts[w]
    part.followed = asked
    part.slides = 0
    part.contacts = contact_count(mode)
    part.loaded = mode.loaded
    seek(workspace, part, mode)
    part.demand = demand
    part.drive_torque = drive
    part.free_spin = drive - dot(art.axle, needed.moment)
    part.tilt[0], part.tilt[1] = 0.0, 0.0  # it is in the rows of all
    keep_articulated(workspace.articulated[w], art, drive)
    balance = Balance(
        resisting(carrier, arm, along_x),
        resisting(carrier, arm, along_y),
        resisting(carrier, arm, turning),
        resisting(carrier, arm, free),
    )
    return balance, drive * spin_rate, loss


@kernel
def moving(art, rate, spin_rate, arm, angular, linear, spin):
    """The Wrench3 that a wheel needs as it moves with this acceleration of its spin: rate, angular and linear
    acceleration of the chassis (of C) in world axes; arm: O from C."""
    bent = plus(angular, plus(times(spin_rate, cross(rate, art.axle)), times(spin, art.axle)))
    centre = plus(linear, plus(cross(angular, arm), cross(rate, cross(rate, arm))))
    needed = resistance(art, bent, centre)
    return Wrench3(plus(needed.moment, art.torque), plus(needed.force, art.force))


@kernel
def keep_articulated(record, art, drive):
    """An Articulated and the torque of the drive into a record, for the way back along the tree."""
    store_vector(record.axle, 0, art.axle)
    store_vector(record.lift, 0, art.lift)
    store_vector(record.torque, 0, art.torque)
    store_vector(record.force, 0, art.force)
    inertia, tensor = record.inertia, art.inertia
    inertia[0], inertia[1], inertia[2] = tensor.xx, tensor.xy, tensor.xz
    inertia[3], inertia[4], inertia[5] = tensor.yy, tensor.yz, tensor.zz
    record.mass = art.mass
    record.spin_inertia = art.spin_inertia
    record.drive = drive


@kernel
def kept_articulated(record):
    """The Articulated of a record."""
    i = record.inertia
    return Articulated(
        vector_at(record.axle, 0),
        Inertia(i[0], i[1], i[2], i[3], i[4], i[5]),
        vector_at(record.lift, 0),
        record.mass,
        record.spin_inertia,
        vector_at(record.torque, 0),
        vector_at(record.force, 0),
    )


@kernel
def place_of(parameters, mode, w, side, y, l):
    """The Place of a contact of wheel w that is l (m) along the axle from the foot of its centre."""
    wheel = parameters.wheels[w]
    index = mode.index[side]
    disk = rigid_body(y, body_place(parameters, w, 0))
    roller = rigid_body(y, body_place(parameters, w, index + 1))
    k = second_axis(disk.rotation)
    rho = minus(roller.position, disk.position)
    h = cross(k, UP)
    arm = minus(plus(times(l, k), times(-wheel.radius, UP)), rho)
    return Place(third_axis(roller.rotation), rho, arm, h, k)


@kernel
def meet(parameters, mode, w, side, carrier, body, y):
    """A contact of wheel w from the bodies as they stand, and its friction by the load, into the workspace."""
    wheel = parameters.wheels[w]
    workspace = parameters.workspace
    index = mode.index[side]
    disk = rigid_body(y, body_place(parameters, w, 0))
    roller = rigid_body(y, body_place(parameters, w, index + 1))
    at_centre = place_of(parameters, mode, w, side, y, 0.0)
    h, k, a, rho = at_centre.h, at_centre.k, at_centre.axis, at_centre.rho
    cos_q, sin_q = -rho.z / wheel.roller_distance, dot(rho, h) / wheel.roller_distance
    axis = Axis(dot(a, h), dot(a, k), a.z)
    if parameters.machine.implicit_tracking:
        touch = implicit_contact(wheel, frame_along(h), axis, rho_of(parameters, y, w, index))
    else:
        touch = explicit_contact(wheel, cos_q, sin_q)
    touch = on_row(touch, parameters.roller_rows[mode.row[side]])
    point = place_of(parameters, mode, w, side, y, touch.l)
    moved = plus(roller.velocity, cross(roller.rate, point.arm))
    joint = dot(minus(roller.rate, disk.rate), a)
    spin_rate = dot(minus(disk.rate, carrier.body.rate), k)
    state = ContactState(
        axis,
        touch,
        cos_q,
        sin_q,
        WheelTwist(dot(disk.velocity, h), dot(disk.velocity, k), spin_rate, body.twist.yaw),
        joint,
        Slip(dot(moved, h), dot(moved, k)),
        roller.rate.z,
    )
    art = kept_articulated(workspace.articulated[w])
    held = mode.shared == 1
    nothing = Vec3(0.0, 0.0, 0.0)
    arm = minus(disk.position, carrier.centre)
    by_h = handed_on(a, rho, point.arm, h, nothing)
    by_k = handed_on(a, rho, point.arm, k, nothing)
    by_n = handed_on(a, rho, point.arm, nothing, UP)
    j = Jacobian(
        dot(k, by_h.moment), dot(k, by_k.moment), 0.0, 0.0,
        dot(a, cross(point.arm, h)), dot(a, cross(point.arm, k)),
    )  # fmt: skip
    contact = workspace.contacts[wheel.contacts + side]
    set_contact(contact, state, j, mode.shared)
    set_lever_column(contact.lever, 0, felt_from_floor(carrier, arm, art, by_h, held))
    set_lever_column(contact.lever, 1, felt_from_floor(carrier, arm, art, by_k, held))
    rows = felt_from_floor(carrier, arm, art, by_n, held)
    twist = contact.twist
    twist[2], twist[TILT_Y], twist[TILT_X] = rows.yaw, rows.tilt_y, rows.tilt_x
    if parameters.machine.rolling:
        set_resistance(wheel, contact, state)
        moment = plus(times(contact.moment[0], h), times(contact.moment[1], k))
        rows = felt_from_floor(carrier, arm, art, handed_on(a, rho, point.arm, nothing, moment), held)
        resisting = contact.resisting
        resisting[2], resisting[TILT_Y], resisting[TILT_X] = rows.yaw, rows.tilt_y, rows.tilt_x
    find_friction(parameters, mode, w, side, body, state, j)


@kernel
def set_lever_column(lever, i, rows):
    lever[0, i], lever[1, i], lever[2, i] = rows.x, rows.y, rows.yaw
    lever[TILT_Y, i], lever[TILT_X, i] = rows.tilt_y, rows.tilt_x


@kernel
def felt_from_floor(carrier, arm, art, given, held):
    """The GeneralizedForce in which the chassis feels a Wrench3 that the floor gives to a wheel."""
    _, through = transmitted(art, Wrench3(times(-1.0, given.moment), times(-1.0, given.force)), 0.0, held)
    return resisting(carrier, arm, through)


@kernel
def move_bodies(parameters, stage, w, carrier, linear, angular):
    """Accelerations of the bodies of a wheel, and what its joints carry, from those of the chassis (of C); the power of
    a drive that follows angles, W."""
    machine = parameters.machine
    wheel = parameters.wheels[w]
    workspace = parameters.workspace
    at = places(parameters)
    mode = stage.mode[w]
    y = stage.y
    dy = stage.dy
    part = workspace.parts[w]
    art = kept_articulated(workspace.articulated[w])
    rate = carrier.body.rate
    disk = rigid_body(y, body_place(parameters, w, 0))
    arm = minus(disk.position, carrier.centre)
    spin_rate = dot(minus(disk.rate, rate), art.axle)
    needed = moving(art, rate, spin_rate, arm, angular, linear, part.followed)
    for side in range(part.contacts):
        contact = workspace.contacts[part.first + side]
        point = place_of(parameters, mode, w, side, y, contact.l)
        force, torque = floor_along(part, contact, point.h, point.k)
        given = handed_on(point.axis, point.rho, point.arm, force, torque)
        needed = Wrench3(minus(needed.moment, given.moment), minus(needed.force, given.force))
    spin, axle = transmitted(art, needed, workspace.articulated[w].drive, mode.shared == 1)
    spin += part.followed
    dy[at.spin_rate + w] = spin
    bent = plus(angular, plus(times(spin_rate, cross(rate, art.axle)), times(spin, art.axle)))
    centre = plus(linear, plus(cross(angular, arm), cross(rate, cross(rate, arm))))
    rate_states(dy, body_place(parameters, w, 0), disk, centre, bent)
    keep_joint(workspace.joints[w, 0], axle.moment, axle.force)
    for i in range(wheel.rollers):
        first = body_place(parameters, w, i + 1)
        roller = rigid_body(y, first)
        axis = third_axis(roller.rotation)
        rho = minus(roller.position, disk.position)
        joint = dot(minus(roller.rate, disk.rate), axis)
        floor = Wrench3(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0))
        for side in range(part.contacts):
            if carries(wheel, mode, side, i):
                contact = workspace.contacts[part.first + side]
                point = place_of(parameters, mode, w, side, y, contact.l)
                floor = on_roller(part, contact, point.arm, point.h, point.k)
        rolling = (dot(axis, floor.moment) + bearing_torque(wheel, joint)) * wheel.axial_mobility
        motion = roller_motion(centre, bent, disk.rate, axis, rho, joint, rolling)
        rate_states(dy, first, roller, motion.linear, motion.angular)
        dy[wheel.rates + i] = rolling
        lifted = RollerMotion(plus(motion.linear, against_gravity(machine)), motion.angular)
        load_joint(workspace.joints[w, i + 1], wheel, axis, roller.rate, lifted, floor)
    turned = wheel.axle_inertia * part.followed - dot(art.axle, needed.moment)  # by all but the drive
    return follow_angles(parameters, stage, w, turned)
