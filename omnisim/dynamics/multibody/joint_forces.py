"""What the joints of bodies carry: force and moment by which each moves the body beyond it, as the right-hand side of
all bodies finds them, along world axes, and along their own for those who look (bearing_loads.py)."""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, combine, cross, dot, minus, plus, times
from omnisim.contact.frame import axes, spoke
from omnisim.dynamics.joint_loads import AXIAL, ROLLER_AXIAL, enter
from omnisim.dynamics.multibody.elimination import UP, Wrench3, across_axis
from omnisim.dynamics.multibody.rigid_body import needed_wrench
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import body_motion, world_frame
from omnisim.dynamics.wheel import azimuth_of


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


@kernel
def roller_motion(centre, bent, rate, axis, rho, joint, rolling):
    """The RollerMotion of a roller on a disk that turns at `rate`; centre, bent: linear (m/s^2) and angular
    acceleration (rad/s^2) of the disk, rho: from there to the roller's centre, joint: chi', rolling: p' (rad/s^2)."""
    linear = plus(centre, plus(cross(bent, rho), cross(rate, cross(rate, rho))))
    carried = across_axis(plus(bent, times(joint, cross(rate, axis))), axis)
    return RollerMotion(linear, plus(carried, times(rolling, axis)))


@kernel
def floor_force(part, contact):
    """Force (Vec3, N) and moment (N m) of the floor on a roller at a contact, along h, k and n; part: of its wheel."""
    normal = contact.share * max(part.normal_force, 0.0) if part.loaded else 0.0
    moment = Vec3(normal * contact.moment[0], normal * contact.moment[1], contact.torque)
    return Vec3(contact.force[0], contact.force[1], normal), moment


@kernel
def floor_along(part, contact, h, k):
    """The same along world axes, by h and k there."""
    force, moment = floor_force(part, contact)
    return combine(force.x, h, force.y, k, force.z, UP), combine(moment.x, h, moment.y, k, moment.z, UP)


@kernel
def on_roller(part, contact, arm, h, k):
    """The same as a Wrench3 about the centre of the roller, from which the contact is at `arm`."""
    force, torque = floor_along(part, contact, h, k)
    return Wrench3(plus(cross(arm, force), torque), force)


@kernel
def load_joint(record, wheel, axis, rate, motion, floor):
    """What moves a roller that turns at `rate` and feels `floor`, into the record JOINT of its bearing; motion: its
    RollerMotion, with the weight in it."""
    force, moment = needed_wrench(
        wheel.roller_mass, wheel.transverse_inertia, wheel.axial_inertia, axis, rate, motion.linear, motion.angular
    )
    keep_joint(record, minus(moment, floor.moment), minus(force, floor.force))


@kernel
def keep_joint(record, moment, force):
    """The moment (Vec3, N m) and the force (N) of a joint into a record JOINT."""
    record.moment[0], record.moment[1], record.moment[2] = moment.x, moment.y, moment.z
    record.force[0], record.force[1], record.force[2] = force.x, force.y, force.z


@kernel
def resolve_joints(parameters, w, y, found):
    """The joints of wheel w in the workspace along their own axes, of its axle first, into found (joint_loads.py)."""
    wheel = parameters.wheels[w]
    at = places(parameters)
    joints = parameters.workspace.joints
    frame = world_frame(wheel, body_motion(parameters, y))
    h, k, up = axes(frame)
    enter(found, 0, AXIAL, resolved(joints[w, 0], h, k, up))
    for i in range(wheel.rollers):
        d, lateral, axis = mounting(wheel, frame, azimuth_of(parameters, w, i, y[at.spin_angle + w]))
        enter(found, i + 1, ROLLER_AXIAL, resolved(joints[w, i + 1], d, lateral, axis))


@kernel
def resolved(record, first, second, third):
    """The Wrench3 of a record JOINT along three directions."""
    moment, force = vector(record.moment), vector(record.force)
    return Wrench3(
        Vec3(dot(moment, first), dot(moment, second), dot(moment, third)),
        Vec3(dot(force, first), dot(force, second), dot(force, third)),
    )


@kernel
def vector(values):
    return Vec3(values[0], values[1], values[2])
