"""What every bearing carries, recovered from a motion that is known: inverse dynamics, from the rollers inwards.

Positions and rates are in a row, accelerations in its derivative, and the forces of the floor in the workspace. Newton
and Euler for each roller give the force and the moment of its bearing, and for each disk, which the
rollers load, those of the axle. Axes of the results are fixed in what carries the bearing:

    roller    radial d (outwards), lateral a x d, axial a          axle    h, k, n of the wheel
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.contact.frame import axes, rate_change, rate_vector, spoke
from omnisim.dynamics.indices import carries, row_index
from omnisim.dynamics.multibody.elimination import UP, Wrench3, across_axis
from omnisim.dynamics.multibody.rigid_body import against_gravity, needed_wrench
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import acceleration_of, body_motion, wheel_motion, wheel_twist, world_frame
from omnisim.dynamics.wheel import azimuth_of

RADIAL, LATERAL, AXIAL = range(3)


class RollerMotion(NamedTuple):
    """Acceleration of a roller's centre (m/s^2) and its angular one (rad/s^2), world axes."""

    linear: Vec3
    angular: Vec3


@kernel
def mounting(wheel, frame, q):
    """Directions d, a x d and a of the roller at azimuth q (Vec3, world)."""
    cos_q, sin_q = cos_sin(q)
    d = spoke(frame, cos_q, sin_q)
    _, k, _ = axes(frame)
    axis = plus(times(wheel.cos_psi, cross(k, d)), times(wheel.sin_psi, k))
    return d, cross(axis, d), axis


@outlined
def recover(parameters, mode, w, y, dy, rates):
    """Force and moment of the joints of wheel w, from its motion and the floor's forces, into the workspace; rates
    (N,): absolute axial rates of its rollers, rad/s."""
    machine = parameters.machine
    wheel = parameters.wheels[w]
    workspace = parameters.workspace
    at = places(parameters)
    body = body_motion(parameters, y)
    part = parameters.workspace.parts[w]
    frame = world_frame(wheel, body)
    twist = wheel_twist(wheel, body.twist, y[at.spin_rate + w])
    h, k, up = axes(frame)
    motion = wheel_motion(wheel, body.twist, acceleration_of(parameters, body, dy), dy[at.spin_rate + w], 0.0)
    rate = rate_vector(frame, twist)
    bent = rate_change(frame, twist, motion)
    centre = plus(plus(times(motion.h, h), times(motion.k, k)), against_gravity(machine))  # with the weight
    across, axle = wheel.disk_inertia[0], wheel.disk_inertia[1]
    force, moment = needed_wrench(wheel.disk_mass, across, axle, k, rate, centre, bent)
    for i in range(wheel.rollers):
        d, _, axis = mounting(wheel, frame, azimuth_of(parameters, w, i, y[at.spin_angle + w]))
        rho = plus(times(wheel.roller_distance, d), times(parameters.roller_rows[row_index(wheel, i)].offset, k))
        joint = rates[i] - dot(rate, axis)
        rolling = dy[wheel.rates + i] if machine.every_rate else 0.0
        floor = Wrench3(Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0))
        for side in range(part.contacts):
            if carries(wheel, mode, side, i):
                contact = workspace.contacts[part.first + side]
                arm = minus(plus(times(contact.l, k), times(-wheel.radius, up)), rho)
                floor = on_roller(part, contact, arm, h, k)
                if not machine.every_rate:
                    rolling = dy[wheel.rates + side]
        moved = roller_motion(centre, bent, rate, axis, rho, joint, rolling)
        given = load_joint(workspace.joints[w, i + 1], wheel, axis, plus(rate, times(joint, axis)), moved, floor)
        force = plus(force, given.force)
        moment = plus(moment, plus(given.moment, cross(rho, given.force)))
    keep_joint(workspace.joints[w, 0], moment, force)


@kernel
def roller_motion(centre, bent, rate, axis, rho, joint, rolling):
    """The RollerMotion of a roller on a disk that turns at `rate`; centre, bent: linear (m/s^2) and angular
    acceleration (rad/s^2) of the disk, rho: from there to the roller's centre, joint: chi', rolling: p' (rad/s^2)."""
    linear = plus(centre, plus(cross(bent, rho), cross(rate, cross(rate, rho))))
    carried = across_axis(plus(bent, times(joint, cross(rate, axis))), axis)
    return RollerMotion(linear, plus(carried, times(rolling, axis)))


@kernel
def floor_force(part, contact, h, k):
    """Force (Vec3, N) and moment (N m) of the floor on a roller at a contact; part: of its wheel."""
    normal = contact.share * max(part.normal_force, 0.0) if part.loaded else 0.0
    along = plus(times(contact.force[0], h), times(contact.force[1], k))
    rolling = plus(times(contact.moment[0], h), times(contact.moment[1], k))
    return plus(along, times(normal, UP)), plus(times(contact.torque, UP), times(normal, rolling))


@kernel
def on_roller(part, contact, arm, h, k):
    """The same as a Wrench3 about the centre of the roller, from which the contact is at `arm`."""
    force, torque = floor_force(part, contact, h, k)
    return Wrench3(plus(cross(arm, force), torque), force)


@kernel
def load_joint(record, wheel, axis, rate, motion, floor):
    """The Wrench3 by which its bearing moves a roller that turns at `rate` and feels `floor`, also into a record JOINT;
    motion: its RollerMotion, with the weight in it."""
    force, moment = needed_wrench(
        wheel.roller_mass, wheel.transverse_inertia, wheel.axial_inertia, axis, rate, motion.linear, motion.angular
    )
    given = Wrench3(minus(moment, floor.moment), minus(force, floor.force))
    keep_joint(record, given.moment, given.force)
    return given


@kernel
def keep_joint(record, moment, force):
    """The moment (Vec3, N m) and the force (N) of a joint into a record JOINT."""
    record.moment[0], record.moment[1], record.moment[2] = moment.x, moment.y, moment.z
    record.force[0], record.force[1], record.force[2] = force.x, force.y, force.z


@kernel
def resolve_joints(parameters, w, y, found):
    """The joints of wheel w in the workspace along their own axes: found (N + 1, 2, 3), force (N) and moment (N m)."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    joints = parameters.workspace.joints
    frame = world_frame(wheel, body_motion(parameters, y))
    h, k, up = axes(frame)
    resolve(joints[w, 0], h, k, up, found[0])
    for i in range(wheel.rollers):
        d, lateral, axis = mounting(wheel, frame, azimuth_of(parameters, w, i, y[at.spin_angle + w]))
        resolve(joints[w, i + 1], d, lateral, axis, found[i + 1])


@kernel
def resolve(joint, first, second, third, found):
    """A record JOINT along three directions."""
    force = Vec3(joint.force[0], joint.force[1], joint.force[2])
    moment = Vec3(joint.moment[0], joint.moment[1], joint.moment[2])
    found[0, 0], found[0, 1], found[0, 2] = dot(force, first), dot(force, second), dot(force, third)
    found[1, 0], found[1, 1], found[1, 2] = dot(moment, first), dot(moment, second), dot(moment, third)
