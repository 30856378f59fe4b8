"""Carriers: what wheels stand on that moves in the chassis, by a coordinate s along a screw.

    suspension   slides along chassis z        rocker   turns about a line of the chassis

With its screw j (turning, velocity at C), its inertia I_j about C, and what else acts on it (moment about C, force; its
own motion among it) the accelerations of the chassis a = (w', A) and of all s follow from

    (I + sum I_j) a + sum I_j j s'' = sum of all pushes            j . I_j a + j . I_j j s'' = spring + j . push_j

a symmetric positive definite system of 6 + C equations.
"""

import math

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.dynamics.spatial.pose import product, put, put_at, turned, vector
from omnisim.dynamics.spatial.records import BASE
from omnisim.dynamics.state import places


@outlined
def accelerate_carried(parameters, stage, body):
    """Accelerations of C without that of gravity and of the turning (Vec3 each), and those of the carriers."""
    space = parameters.space
    at = places(parameters)
    own, balance, answer = space.body, space.balance, space.answer
    moment = vector(own.moment, 0)
    fill(balance, own, moment)
    centrifugal = cross(body.rate, cross(body.rate, moment))
    push = space.pushes[BASE]
    put(answer, vector(push, 0))
    put_at(answer, 3, minus(vector(push, 3), centrifugal))
    for j in range(len(space.carriers)):
        carry(parameters, stage, body, j)
    factorize(balance, len(answer))
    substitute(balance, len(answer), answer)
    for j in range(len(space.carriers)):
        stage.dy[at.joint + j] = stage.y[at.joint_rate + j]
        stage.dy[at.joint_rate + j] = answer[6 + j]
    return vector(answer, 3), vector(answer, 0)


@kernel
def fill(balance, own, moment):
    """The inertia about C of the chassis with what is fixed to it, a record BODY, on the left side."""
    for i in range(len(balance)):
        for j in range(len(balance)):
            balance[i, j] = 0.0
    for i in range(3):
        for j in range(3):
            balance[i, j] = own.inertia[i, j]
        balance[3 + i, 3 + i] = own.base_mass
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
    """Carrier j into the equations."""
    space = parameters.space
    at = places(parameters)
    carrier, motion, balance, answer = space.carriers[j], space.motions[j], space.balance, space.answer
    s, s_rate = stage.y[at.joint + j], stage.y[at.joint_rate + j]
    axis = vector(carrier.axis, 0)
    centre = place_carrier(carrier, motion, s)
    turning, at_origin, along, bend = Vec3(0.0, 0.0, 0.0), axis, axis, Vec3(0.0, 0.0, 0.0)
    if carrier.turns:
        point = vector(carrier.point, 0)
        turning, at_origin = axis, cross(point, axis)
        along = cross(axis, minus(centre, point))
        bend = times(s_rate * s_rate, cross(axis, along))
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
    put(motion.turning, turning)
    put(motion.at_origin, at_origin)
    # I_j j
    resisting = times(carrier.mass, along)
    turned_by = plus(product(motion.inertia, turning), cross(centre, resisting))
    add_carried(balance, motion, carrier.mass, centre)
    column = balance[6 + j]
    put(column, turned_by)
    put_at(column, 3, resisting)
    column[6 + j] = dot(turning, turned_by) + dot(at_origin, resisting)
    for i in range(6):
        balance[i, 6 + j] = column[i]
    spring = -(carrier.preload + carrier.stiffness * s + carrier.damping * s_rate)
    stage.dy[at.damper_loss] += carrier.damping * s_rate * s_rate
    put(answer, plus(vector(answer, 0), moment))
    put_at(answer, 3, plus(vector(answer, 3), force))
    answer[6 + j] = spring + dot(turning, moment) + dot(at_origin, force)


@kernel
def add_carried(balance, motion, mass, centre):
    """The inertia of a carrier about C, on the left side."""
    square = dot(centre, centre)
    c = (centre.x, centre.y, centre.z)
    for i in range(3):
        for k in range(3):
            balance[i, k] += motion.inertia[i, k] - mass * c[i] * c[k]
        balance[i, i] += mass * square
        balance[3 + i, 3 + i] += mass
    add_moment(balance, times(mass, centre))


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
def factorize(matrix, count):
    """L D L^T of the first `count` rows and columns of a symmetric positive definite matrix, in place: L below the
    diagonal, the reciprocals of D on it. The least of D."""
    least = math.inf
    for i in range(count):
        for k in range(i):
            total = matrix[i, k]
            for m in range(k):
                total -= matrix[i, m] * matrix[k, m]
            matrix[i, k] = total
        own = matrix[i, i]
        for k in range(i):
            total = matrix[i, k]
            matrix[i, k] = total * matrix[k, k]
            own -= total * matrix[i, k]
        matrix[i, i] = 1.0 / own
        least = min(least, own)
    return least


@kernel
def substitute(matrix, count, side):
    """Solve with these factors: the first `count` of `side` become the solution. L is read row by row both ways."""
    for i in range(1, count):
        total = side[i]
        for k in range(i):
            total -= matrix[i, k] * side[k]
        side[i] = total
    for i in range(count):
        side[i] *= matrix[i, i]
    for i in range(count - 1, 0, -1):
        found = side[i]
        for k in range(i):
            side[k] -= matrix[i, k] * found
