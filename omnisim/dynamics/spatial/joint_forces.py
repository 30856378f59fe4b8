"""What every bearing of a machine free in space carries, recovered from a motion that is known: inverse dynamics.

Newton and Euler for each roller, then for each disk with what its rollers hand on, as of planar machines
(multibody/joint_forces.py), along hub axes:

    roller    force = m (B'' - g) - sum F              moment = (I w)' - sum ((X - B) x F + M nu)
    axle      force = m (O'' - g) + sum force_i        moment = (I w)' + sum (moment_i + (B_i - O) x force_i)

The disk is without the hub of a suspension, which is beyond the axle. Forces of the ground are those that the
right-hand side has left in `touches`.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, combine, cross, minus, plus, times
from omnisim.dynamics.multibody.elimination import Wrench3
from omnisim.dynamics.multibody.joint_forces import RollerMotion, keep_joint, load_joint, resolve, roller_motion
from omnisim.dynamics.multibody.rigid_body import needed_wrench
from omnisim.dynamics.spatial.acceleration import hub_acceleration
from omnisim.dynamics.spatial.pose import body_of, inward, mounted, tangent_of, vector
from omnisim.dynamics.spatial.records import SLOTS
from omnisim.dynamics.spatial.touching import joint_rate, roller_on, standing
from omnisim.dynamics.state import places

HEADING, AXLE, UP = Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0)


@outlined
def recover_in_space(parameters, mode, w, y, dy, rates):
    """Force and moment of the joints of wheel w along its hub axes, from its motion and what the ground does to it,
    into the workspace; rates (N,): absolute axial rates of its rollers, rad/s."""
    wheel, joints = parameters.wheels[w], parameters.workspace.joints
    stand = standing(parameters, w, body_of(parameters, y), y)
    rate = plus(stand.hub.rate, times(stand.spin_rate, AXLE))
    disk = disk_motion(parameters, w, stand, y, dy)
    across, along = wheel.disk_inertia[0], wheel.disk_inertia[1]
    force, moment = needed_wrench(wheel.disk_mass, across, along, AXLE, rate, disk.linear, disk.angular)
    for i in range(wheel.rollers):
        roller = roller_on(parameters, w, i, stand)
        joint = joint_rate(stand, roller, rates[i])
        rolling, ground = ground_on(parameters, mode, w, i, dy)
        moved = roller_motion(disk.linear, disk.angular, rate, roller.axis, roller.centre, joint, rolling)
        turning = plus(rate, times(joint, roller.axis))
        given = load_joint(joints[w, i + 1], wheel, roller.axis, turning, moved, ground)
        force = plus(force, given.force)
        moment = plus(moment, plus(given.moment, cross(roller.centre, given.force)))
    keep_joint(joints[w, 0], moment, force)


@kernel
def disk_motion(parameters, w, stand, y, dy):
    """Acceleration of O, with the weight in it, and of the turning of the disk of wheel w (RollerMotion, hub axes)."""
    axes = mounted(stand.hub)
    lifted, turning = hub_acceleration(parameters, stand.body, w, y, dy)
    linear = minus(lifted, inward(stand.body.rotation, vector(parameters.space.body.gravity, 0)))
    spin = dy[places(parameters).spin_rate + w]
    bent = combine(1.0, inward(axes, turning), spin, AXLE, stand.spin_rate, cross(stand.hub.rate, AXLE))
    return RollerMotion(inward(axes, linear), bent)


@kernel
def ground_on(parameters, mode, w, i, dy):
    """p' of roller i of wheel w (rad/s^2), and the Wrench3 of the ground on it about its centre, hub axes."""
    first, every = parameters.wheels[w].rates, parameters.machine.every_rate
    rolling = dy[first + i] if every else 0.0
    force = moment = Vec3(0.0, 0.0, 0.0)
    for c in range(mode.contacts):
        slot = mode.slot[c]
        if mode.roller[slot] == i:
            if not every:
                rolling = dy[first + slot]
            touch = parameters.space.touches[w * SLOTS + c]
            normal = vector(touch.normal, 0)
            h, k = tangent_of(normal)
            given = combine(touch.normal_force, normal, touch.force[0], h, touch.force[1], k)
            force = plus(force, given)
            about = combine(touch.torque, normal, touch.resistance[0], h, touch.resistance[1], k)
            moment = plus(moment, plus(cross(vector(touch.lever, 0), given), about))
    return rolling, Wrench3(moment, force)


@kernel
def mount_of(roller):
    """Directions d, a x d and a of a Roller (Vec3, hub axes)."""
    d = Vec3(roller.sin_q, 0.0, -roller.cos_q)
    return d, cross(roller.axis, d), roller.axis


@kernel
def resolve_in_space(parameters, w, y, found):
    """The joints of wheel w in the workspace along their own axes: found (N + 1, 2, 3), force (N) and moment (N m)."""
    joints = parameters.workspace.joints
    stand = standing(parameters, w, body_of(parameters, y), y)
    resolve(joints[w, 0], HEADING, AXLE, UP, found[0])
    for i in range(parameters.wheels[w].rollers):
        d, lateral, axis = mount_of(roller_on(parameters, w, i, stand))
        resolve(joints[w, i + 1], d, lateral, axis, found[i + 1])
