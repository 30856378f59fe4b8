"""Accelerations of a machine free in space from the derivative of its state: of hubs, and of the slip at a contact."""

from omnisim.base.kernel import kernel
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, combine, cross, dot, minus, plus, times
from omnisim.contact.frame import Slip
from omnisim.dynamics.spatial.pose import body_of, hub_of, inward, mounted, stretch_of, tangent_of, turned, vector
from omnisim.dynamics.spatial.reaction import react
from omnisim.dynamics.spatial.running import running
from omnisim.dynamics.spatial.touching import disk_turning, rate_of_roller, standing, touching_at
from omnisim.dynamics.state import places


@kernel
def hub_acceleration(parameters, body, w, y, dy):
    """Acceleration of O, and of the turning of what carries wheel w, chassis axes."""
    at = places(parameters)
    space = parameters.space
    own = space.hubs[w]
    turning = vector(dy, at.rate)
    hub = hub_of(parameters, body, w, y)
    swept = cross(body.rate, cross(body.rate, hub.centre))
    linear = plus(inward(body.rotation, vector(dy, at.velocity)), plus(cross(turning, hub.centre), swept))
    if own.carrier < 0:
        return linear, turning
    j = own.carrier
    carrier = space.carriers[j]
    axis = vector(carrier.axis, 0)
    rate, bend = y[at.joint_rate + j], dy[at.joint_rate + j]
    along = axis
    if carrier.turns:
        cos, sin = cos_sin(y[at.joint + j])
        arm = turned(minus(vector(own.centre, 0), vector(carrier.point, 0)), axis, cos, sin)
        along = cross(axis, arm)
        linear = plus(linear, times(rate * rate, cross(axis, along)))
        turning = plus(turning, combine(bend, axis, rate, cross(body.rate, axis), 0.0, axis))
    linear = plus(linear, combine(bend, along, 2.0 * rate, cross(body.rate, along), 0.0, along))
    return linear, turning


@kernel
def slip_at(parameters, mode, w, c, y):
    """Slip velocity (Slip, m/s) at contact c of wheel w in state y."""
    stand = standing(parameters, w, body_of(parameters, y), y)
    touched = touching_at(parameters, mode, w, c, stand)
    return react(parameters, mode, w, c, stand, touched, y[rate_of_roller(parameters, mode, w, c)]).slip


@kernel
def slip_change(parameters, mode, w, c, place, y, dy):
    """v' (Slip, m/s^2) at contact c of wheel w by the derivative dy of the state: how it changes along h and k, which
    turn with the wheel and with the ground; place: its Standing and Touching.

    V = V_O + w_d x (X - O) + chi' a x (X - B), of which X moves through the roller: running.py.
    """
    at = places(parameters)
    stand, touched = place
    hub, roller, normal = stand.hub, touched.roller, touched.normal
    axes = mounted(hub)
    lifted, bending = hub_acceleration(parameters, stand.body, w, y, dy)
    lifted, bending = inward(axes, lifted), inward(axes, bending)
    axle = Vec3(0.0, 1.0, 0.0)
    rate = disk_turning(stand)
    bending = plus(bending, combine(dy[at.spin_rate + w], axle, stand.spin_rate, cross(hub.rate, axle), 0.0, axle))
    own = rate_of_roller(parameters, mode, w, c)
    joint = y[own] - dot(rate, roller.axis)
    joint_change = dy[own] - dot(bending, roller.axis)
    # X - B, and how it changes
    run = running(parameters, mode, w, c, place)
    axis_change = cross(rate, roller.axis)
    arm = plus(roller.centre, touched.lever)
    velocity = plus(hub.velocity, plus(cross(rate, arm), times(joint, cross(roller.axis, touched.lever))))
    deeper = -dot(velocity, normal)
    turned = combine(run.along, axis_change, run.deep, run.swing, 0.0, normal)
    lever_change = plus(turned, combine(run.along_rate, roller.axis, deeper + run.deep_rate, normal, 0.0, normal))
    arm_change = plus(cross(rate, roller.centre), lever_change)
    disk = plus(lifted, plus(cross(bending, arm), cross(rate, arm_change)))
    turning = plus(cross(axis_change, touched.lever), cross(roller.axis, lever_change))
    whole = plus(disk, combine(joint_change, cross(roller.axis, touched.lever), joint, turning, 0.0, turning))
    h, k = tangent_of(normal)
    turn = turning_of_tangents(hub.rate, normal, k, run.swing)
    return Slip(
        dot(whole, h) + turn * dot(velocity, k) + deeper * dot(run.swing, h),
        dot(whole, k) - turn * dot(velocity, h) + deeper * dot(run.swing, k),
    )


@kernel
def turning_of_tangents(rate, normal, k, swing):
    """Rate at which h and k (tangent_of) turn about the normal, rad/s; rate: of the hub, swing: of the normal (rad/s),
    all along the axes of the hub."""
    moved = plus(cross(normal, rate), swing)  # of the normal, seen from the hub
    return dot(rate, normal) + stretch_of(normal) * (k.x * moved.z - k.z * moved.x)
