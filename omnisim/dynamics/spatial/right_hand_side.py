"""The right-hand side of a machine free in space: Newton and Euler for the chassis and for what moves in it.

    m A + w' x S = sum F + m g + f - w x (w x S)                            A: acceleration of C, along chassis axes
    S x A + I w' = sum X x F + r_c x f - w x (I w) - sum_w [moments of its axle and rollers]

I, constant without carriers, leaves out J_k (wheel.py). A carrier j moves with s along the screw (turning; velocity at
C) = s_j; with I_j its own inertia about C it is eliminated (Featherstone, Rigid Body Dynamics Algorithms, 2008):

    s'' = (spring - s_j . (rest_j + I_j a)) / s_j . I_j s_j        on C:    I_j - I_j s_j (I_j s_j)^T / s_j . I_j s_j
"""

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, combine, cross, dot, minus, plus, times
from omnisim.dynamics.actuation import rest_motors
from omnisim.dynamics.parameters import FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE
from omnisim.dynamics.spatial.pose import body_of, inward, orientation_rate, outward, turned, vector
from omnisim.dynamics.spatial.records import BASE, POSITION
from omnisim.dynamics.spatial.wheel import add_push, push_wheel, put, spin_up
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
    rest(parameters, stage, body)
    dy[at.wrench_work] = push_body(parameters, stage, body)
    heat, loss, power = 0.0, 0.0, 0.0
    for w in range(len(parameters.wheels)):
        friction, rubber, drive = push_wheel(parameters, stage, w, body)
        heat, loss, power = heat + friction, loss + rubber, power + drive
    if space.carriers is None:
        linear, angular = accelerate(space.body, space.pushes[BASE])
    else:
        linear, angular = accelerate_all(parameters, stage, body)
    gravity = vector(space.body.gravity, 0)
    moved = plus(gravity, outward(body.rotation, linear))
    put3(dy, at.velocity, moved)
    put3(dy, at.rate, angular)
    for w in range(len(parameters.wheels)):
        power += spin_up(parameters, stage, w, turning_of(parameters, stage, w, body, angular))
    dy[at.friction_loss], dy[at.contact_loss], dy[at.drive_work] = heat, loss, power


@kernel
def put3(array, place, v):
    array[place], array[place + 1], array[place + 2] = v.x, v.y, v.z


@kernel
def rest(parameters, stage, body):
    """What all pushes begin with."""
    space = parameters.space
    at = places(parameters)
    for j in range(len(space.pushes)):
        for i in range(6):
            space.pushes[j, i] = 0.0
    stage.dy[at.damper_loss] = 0.0
    if parameters.machine.bearing_friction:
        stage.dy[at.bearing_loss] = 0.0
    if parameters.machine.motors:
        rest_motors(parameters, stage.dy)


@kernel
def push_body(parameters, stage, body):
    """The wrench of the scene, and what the chassis does to itself by turning: moment and force into `pushes`; the
    power of the wrench, W."""
    space = parameters.space
    push = space.pushes[BASE]
    turning = cross(body.rate, product(space.body.inner_inertia, body.rate))
    add_push(push, times(-1.0, turning), Vec3(0.0, 0.0, 0.0))
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
def product(matrix, v):
    """A 3 x 3 array times a Vec3."""
    return Vec3(
        matrix[0, 0] * v.x + matrix[0, 1] * v.y + matrix[0, 2] * v.z,
        matrix[1, 0] * v.x + matrix[1, 1] * v.y + matrix[1, 2] * v.z,
        matrix[2, 0] * v.x + matrix[2, 1] * v.y + matrix[2, 2] * v.z,
    )


@kernel
def accelerate(body, push):
    """Acceleration of C without that of gravity, and of the turning, where nothing moves in the chassis."""
    return times(body.mobility, vector(push, 3)), product(body.turning, vector(push, 0))


@kernel
def turning_of(parameters, stage, w, body, angular):
    """Acceleration of what carries wheel w, about k, rad/s^2."""
    space = parameters.space
    k = vector(space.hubs[w].k, 0)
    if space.carriers is not None and space.hubs[w].carrier >= 0:
        j = space.hubs[w].carrier
        carrier = space.carriers[j]
        if carrier.turns:
            at = places(parameters)
            axis = vector(carrier.axis, 0)
            k = turned(k, axis, space.motions[j].cos, space.motions[j].sin)
            relative = combine(
                stage.dy[at.joint_rate + j], axis, stage.y[at.joint_rate + j], cross(body.rate, axis), 1.0, angular
            )
            return dot(k, relative)
    return dot(k, angular)


@outlined
def accelerate_all(parameters, stage, body):
    """The same where carriers move, and their own accelerations."""
    space = parameters.space
    at = places(parameters)
    own = space.body
    balance = space.balance
    moment = vector(own.moment, 0)
    fill(balance, own.inertia, own.base_mass, moment)
    centrifugal = cross(body.rate, cross(body.rate, moment))
    base = space.pushes[BASE]
    for i in range(3):
        balance[i, 6], balance[3 + i, 6] = base[i], base[3 + i]
    take(balance, 1.0, Vec3(0.0, 0.0, 0.0), times(-1.0, centrifugal))
    for j in range(len(space.carriers)):
        carry(parameters, stage, body, j)
    solve(balance)
    angular = Vec3(balance[0, 6], balance[1, 6], balance[2, 6])
    linear = Vec3(balance[3, 6], balance[4, 6], balance[5, 6])
    for j in range(len(space.carriers)):
        motion = space.motions[j]
        acceleration = motion.free
        for i in range(6):
            acceleration -= motion.across[i] * balance[i, 6]
        stage.dy[at.joint + j] = stage.y[at.joint_rate + j]
        stage.dy[at.joint_rate + j] = acceleration * motion.mobility
    return linear, angular


@kernel
def take(balance, factor, moment, force):
    """Add a moment and a force to the right side."""
    balance[0, 6] += factor * moment.x
    balance[1, 6] += factor * moment.y
    balance[2, 6] += factor * moment.z
    balance[3, 6] += factor * force.x
    balance[4, 6] += factor * force.y
    balance[5, 6] += factor * force.z


@kernel
def fill(balance, inertia, mass, moment):
    """The 6 x 6 inertia about C of a body with this inertia there, this mass and first moment, on the left side."""
    for i in range(6):
        for j in range(6):
            balance[i, j] = 0.0
    for i in range(3):
        for j in range(3):
            balance[i, j] += inertia[i, j]
        balance[3 + i, 3 + i] += mass
    add_moment(balance, moment)


@kernel
def add_moment(balance, moment):
    """A first moment S on the left side: S x A in the rows of the moment, w' x S in those of the force."""
    balance[0, 4] -= moment.z
    balance[0, 5] += moment.y
    balance[1, 3] += moment.z
    balance[1, 5] -= moment.x
    balance[2, 3] -= moment.y
    balance[2, 4] += moment.x
    balance[4, 0] -= moment.z
    balance[5, 0] += moment.y
    balance[3, 1] += moment.z
    balance[5, 1] -= moment.x
    balance[3, 2] -= moment.y
    balance[4, 2] += moment.x


@kernel
def carry(parameters, stage, body, j):
    """Eliminate carrier j: what it is and does to the chassis into `balance`, what its s'' takes into `motions`."""
    space = parameters.space
    at = places(parameters)
    carrier, motion, balance = space.carriers[j], space.motions[j], space.balance
    s, s_rate = stage.y[at.joint + j], stage.y[at.joint_rate + j]
    axis = vector(carrier.axis, 0)
    centre = place_carrier(carrier, motion, s)
    if carrier.turns:
        point = vector(carrier.point, 0)
        turning, at_origin = axis, cross(point, axis)
        along = cross(axis, minus(centre, point))
        bend = times(s_rate * s_rate, cross(axis, along))
    else:
        turning, at_origin = Vec3(0.0, 0.0, 0.0), axis
        along, bend = axis, Vec3(0.0, 0.0, 0.0)
    rate = plus(body.rate, times(s_rate, turning))
    swept = plus(cross(body.rate, cross(body.rate, centre)), times(2.0 * s_rate, cross(body.rate, along)))
    lifted = times(carrier.mass, plus(swept, bend))
    gyration = plus(
        product(motion.inertia, times(s_rate, cross(body.rate, turning))),
        cross(rate, product(motion.inner_inertia, rate)),
    )
    push = space.pushes[1 + j]
    moment = minus(vector(push, 0), plus(gyration, cross(centre, lifted)))
    force = minus(vector(push, 3), lifted)
    # I_j s, and s itself
    resisting = times(carrier.mass, along)
    turned_by = plus(product(motion.inertia, turning), cross(centre, resisting))
    put(motion.across, turned_by)
    put3(motion.across, 3, resisting)
    put(motion.along, turning)
    put3(motion.along, 3, at_origin)
    motion.mobility = 1.0 / (dot(turning, turned_by) + dot(at_origin, resisting))
    spring = -(carrier.preload + carrier.stiffness * s + carrier.damping * s_rate)
    motion.free = spring + dot(turning, moment) + dot(at_origin, force)
    stage.dy[at.damper_loss] += carrier.damping * s_rate * s_rate
    add_carried(balance, motion, carrier.mass, centre)
    given = -motion.free * motion.mobility
    take(balance, 1.0, moment, force)
    take(balance, given, turned_by, resisting)


@kernel
def add_carried(balance, motion, mass, centre):
    """The inertia of a carrier about C, less what gives way along its s, to the left side."""
    square = dot(centre, centre)
    c = (centre.x, centre.y, centre.z)
    for i in range(3):
        for k in range(3):
            balance[i, k] += motion.inertia[i, k] - mass * c[i] * c[k]
        balance[i, i] += mass * square
        balance[3 + i, 3 + i] += mass
    add_moment(balance, times(mass, centre))
    for i in range(6):
        for k in range(6):
            balance[i, k] -= motion.across[i] * motion.across[k] * motion.mobility


@kernel
def place_carrier(carrier, motion, s):
    """Centre of mass of a carrier (Vec3) at s; its inertia about that into `motions`."""
    centre = vector(carrier.centre, 0)
    axis = vector(carrier.axis, 0)
    if not carrier.turns:
        for i in range(3):
            for k in range(3):
                motion.inertia[i, k], motion.inner_inertia[i, k] = carrier.inertia[i, k], carrier.inner_inertia[i, k]
        return plus(centre, times(s, axis))
    motion.cos, motion.sin = cos_sin(s)
    turn_tensor(carrier.inertia, motion.inertia, axis, motion.cos, motion.sin)
    turn_tensor(carrier.inner_inertia, motion.inner_inertia, axis, motion.cos, motion.sin)
    point = vector(carrier.point, 0)
    return plus(point, turned(minus(centre, point), axis, motion.cos, motion.sin))


@kernel
def turn_tensor(tensor, out, axis, cos, sin):
    """R T R^T of a 3 x 3 tensor for the turn R about a unit axis."""
    x = turned(Vec3(1.0, 0.0, 0.0), axis, cos, sin)
    y = turned(Vec3(0.0, 1.0, 0.0), axis, cos, sin)
    z = turned(Vec3(0.0, 0.0, 1.0), axis, cos, sin)
    columns = (x, y, z)
    for i in range(3):
        for k in range(3):
            out[i, k] = 0.0
    for a in range(3):
        for b in range(3):
            u, v = columns[a], columns[b]
            value = tensor[a, b]
            out[0, 0] += value * u.x * v.x
            out[0, 1] += value * u.x * v.y
            out[0, 2] += value * u.x * v.z
            out[1, 0] += value * u.y * v.x
            out[1, 1] += value * u.y * v.y
            out[1, 2] += value * u.y * v.z
            out[2, 0] += value * u.z * v.x
            out[2, 1] += value * u.z * v.y
            out[2, 2] += value * u.z * v.z


@kernel
def solve(balance):
    """Gauss's elimination on a symmetric positive definite (6, 7): the solution in the last column."""
    for i in range(6):
        pivot = 1.0 / balance[i, i]
        for r in range(i + 1, 6):
            factor = balance[r, i] * pivot
            for c in range(i, 7):
                balance[r, c] -= factor * balance[i, c]
    for i in range(5, -1, -1):
        total = balance[i, 6]
        for c in range(i + 1, 6):
            total -= balance[i, c] * balance[c, 6]
        balance[i, 6] = total / balance[i, i]
