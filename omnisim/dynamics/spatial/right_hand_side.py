"""The right-hand side of a machine free in space: Newton and Euler for the chassis and for what moves in it.

    m A + w' x S = sum F + m g + f - w x (w x S)                            A: acceleration of C, along chassis axes
    S x A + I w' = sum X x F + r_c x f - w x (I w) - sum_w [moments of its axle and rollers]

I, constant without carriers, leaves out J_k (wheel.py). A carrier j moves with s along the screw (turning; velocity at
C) = s_j: see carriers.py.
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.vector import Vec3, combine, cross, dot, plus, times
from omnisim.dynamics.actuation import rest_motors
from omnisim.dynamics.parameters import FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE
from omnisim.dynamics.spatial.carriers import accelerate_carried
from omnisim.dynamics.spatial.holding import hold
from omnisim.dynamics.spatial.pose import (
    add_push,
    body_of,
    inward,
    orientation_rate,
    outward,
    product,
    put,
    put_at,
    turned,
    vector,
)
from omnisim.dynamics.spatial.records import BASE, POSITION
from omnisim.dynamics.spatial.seen import look_at_all
from omnisim.dynamics.spatial.wheel import follow_angles, monitor_wheel, push_wheel, spin_up
from omnisim.dynamics.state import places


@kernel
def spatial_rhs(parameters, stage):
    """Write y' of a Stage, without odometry; if it is `monitoring`, what events and observers want to know."""
    space = parameters.space
    at = places(parameters)
    y, dy = stage.y, stage.dy
    for j in range(3):
        dy[POSITION + j] = y[at.velocity + j]
    body = body_of(parameters, y)
    orientation_rate(y, body.rate, dy)
    look_at_all(parameters, stage.mode, body, y)
    rest(parameters, stage, body)
    dy[at.wrench_work] = push_body(parameters, stage, body)
    heat, loss, power = 0.0, 0.0, 0.0
    for w in range(len(parameters.wheels)):
        friction, rubber, drive = push_wheel(parameters, stage, w, body)
        heat, loss, power = heat + friction, loss + rubber, power + drive
    if stage.monitoring:
        for w in range(len(parameters.wheels)):
            monitor_wheel(parameters, stage, w, body)
    if len(space.carriers) == 0:
        linear, angular = accelerate(space.body, space.pushes[BASE])
    else:
        linear, angular = accelerate_carried(parameters, stage, body)
    gravity = vector(space.body.gravity, 0)
    moved = plus(gravity, outward(body.rotation, linear))
    put_at(dy, at.velocity, moved)
    put_at(dy, at.rate, angular)
    for w in range(len(parameters.wheels)):
        spin_up(parameters, stage, w, turning_of(parameters, stage, w, body))
    if parameters.workspace.resting is not None:
        heat += hold(parameters, stage, body)
        for w in range(len(parameters.wheels)):
            spin_up(parameters, stage, w, turning_of(parameters, stage, w, body))
    if parameters.machine.follows:
        for w in range(len(parameters.wheels)):
            power += follow_angles(parameters, stage, w, turning_of(parameters, stage, w, body))
    dy[at.friction_loss], dy[at.contact_loss], dy[at.drive_work] = heat, loss, power


@kernel
def rest(parameters, stage, body):
    """What pushes on carriers and losses begin with."""
    space = parameters.space
    at = places(parameters)
    for j in range(1, len(space.pushes)):
        for i in range(6):
            space.pushes[j, i] = 0.0
    stage.dy[at.damper_loss] = 0.0
    if parameters.machine.bearing_friction:
        stage.dy[at.bearing_loss] = 0.0
    if parameters.machine.rolling:
        stage.dy[at.rolling_loss] = 0.0
    if parameters.machine.motors:
        rest_motors(parameters, stage.dy)


@kernel
def push_body(parameters, stage, body):
    """What the push on the chassis begins with: the wrench of the scene, and what it does to itself by turning; the
    power of the wrench, W."""
    space = parameters.space
    push = space.pushes[BASE]
    put(push, cross(product(space.body.inner_inertia, body.rate), body.rate))
    put_at(push, 3, Vec3(0.0, 0.0, 0.0))
    if not parameters.machine.pushed:
        return 0.0
    elapsed = stage.t - parameters.starts[stage.piece]
    channels = parameters.inputs[stage.piece]
    force = Vec3(
        channels[FORCE_X, 0] + channels[FORCE_X, 1] * elapsed,
        channels[FORCE_Y, 0] + channels[FORCE_Y, 1] * elapsed,
        channels[FORCE_Z, 0] + channels[FORCE_Z, 1] * elapsed,
    )
    moment = Vec3(0.0, 0.0, channels[YAW_TORQUE, 0] + channels[YAW_TORQUE, 1] * elapsed)
    if not parameters.machine.body_frame:
        force, moment = inward(body.rotation, force), inward(body.rotation, moment)
    point = vector(space.body.chassis, 0)
    velocity = plus(body.velocity, cross(body.rate, point))
    power = dot(force, velocity) + dot(moment, body.rate)
    add_push(push, plus(moment, cross(point, force)), force)
    return power


@kernel
def accelerate(body, push):
    """Acceleration of C without that of gravity, and of the turning, where nothing moves in the chassis."""
    return times(body.mobility, vector(push, 3)), product(body.turning, vector(push, 0))


@kernel
def turning_of(parameters, stage, w, body):
    """Acceleration of what carries wheel w, about k, rad/s^2."""
    space = parameters.space
    own = space.hubs[w]
    angular = vector(stage.dy, places(parameters).rate)
    if own.carrier >= 0:
        j = own.carrier
        place = places(parameters).joint_rate + j
        return carried_turning(
            own, space.carriers[j], space.motions[j], body.rate, angular, stage.y[place], stage.dy[place]
        )
    return dot(vector(own.k, 0), angular)


@outlined
def carried_turning(own, carrier, motion, rate, angular, s_rate, s_bend):
    """The same on a carrier that moves with s' and s''; rate and angular: of the chassis."""
    k = vector(own.k, 0)
    if not carrier.turns:
        return dot(k, angular)
    axis = vector(carrier.axis, 0)
    relative = combine(s_bend, axis, s_rate, cross(rate, axis), 1.0, angular)
    return dot(turned(k, axis, motion.cos, motion.sin), relative)
