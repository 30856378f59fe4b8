"""Energy of a machine free in space by its state."""

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.dynamics.spatial.carriers import place_carrier
from omnisim.dynamics.spatial.pose import body_of, hub_of, product, vector
from omnisim.dynamics.spatial.records import POSITION
from omnisim.dynamics.spatial.touching import standing, touching_at
from omnisim.dynamics.state import places


@kernel
def motion_energy(parameters, y, rates):
    """Kinetic energy of all bodies, J; rates (W, N): absolute axial rates of all rollers as they are now, rad/s.

    Chassis and carriers as rigid bodies, without what turns about axles: sum J_k sigma^2 / 2 + J_r phi'^2 / 2 +
    Ia p^2 / 2.
    """
    space = parameters.space
    at = places(parameters)
    body = body_of(parameters, y)
    own = space.body
    double = own.base_mass * dot(body.velocity, body.velocity)
    double += dot(body.rate, product(own.inner_inertia, body.rate))
    double += 2.0 * dot(body.velocity, cross(body.rate, vector(own.moment, 0)))
    if len(space.carriers) > 0:
        for j in range(len(space.carriers)):
            double += carrier_energy(space, at, body, j, y)
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        hub = hub_of(parameters, body, w, y)
        spin_rate = y[at.spin_rate + w]
        sigma = spin_rate + hub.rate.y
        double += wheel.axle_inertia * sigma * sigma + wheel.rotor_inertia * spin_rate * spin_rate
        squares = 0.0
        for i in range(wheel.rollers):
            squares += rates[w, i] * rates[w, i]
        double += wheel.axial_inertia * squares
    return 0.5 * double


@kernel
def carrier_energy(space, at, body, j, y):
    """Twice the kinetic energy of carrier j with its wheels, J."""
    carrier, motion = space.carriers[j], space.motions[j]
    rate = y[at.joint_rate + j]
    centre = place_carrier(carrier, motion, y[at.joint + j])
    axis = vector(carrier.axis, 0)
    along, turning = axis, body.rate
    if carrier.turns:
        along = cross(axis, minus(centre, vector(carrier.point, 0)))
        turning = plus(body.rate, times(rate, axis))
    velocity = plus(plus(body.velocity, cross(body.rate, centre)), times(rate, along))
    return carrier.mass * dot(velocity, velocity) + dot(turning, product(motion.inner_inertia, turning))


@kernel
def weight_energy(parameters, y):
    """Of all bodies in gravity, J: -M g . r from the world's origin."""
    space = parameters.space
    body = body_of(parameters, y)
    gravity = vector(space.body.gravity, 0)
    energy = -space.body.mass * dot(gravity, vector(y, POSITION))
    if len(space.carriers) > 0:
        down = Vec3(dot(body.rotation.x, gravity), dot(body.rotation.y, gravity), dot(body.rotation.z, gravity))
        energy -= dot(down, vector(space.body.moment, 0))
        for j in range(len(space.carriers)):
            carrier = space.carriers[j]
            centre = place_carrier(carrier, space.motions[j], y[places(parameters).joint + j])
            energy -= carrier.mass * dot(down, centre)
    return energy


@kernel
def spring_energy(parameters, mode, y):
    """Of rubber and springs, J; mode (W,): which rollers touch."""
    space = parameters.space
    at = places(parameters)
    body = body_of(parameters, y)
    energy = 0.0
    for w in range(len(parameters.wheels)):
        stand = standing(parameters, w, body, y)
        for c in range(mode[w].contacts):
            touched = touching_at(parameters, mode[w], w, c, stand)
            energy += 0.5 * space.hubs[w].stiffness * touched.depth * touched.depth
    if len(space.carriers) > 0:
        for j in range(len(space.carriers)):
            carrier, s = space.carriers[j], y[at.joint + j]
            energy += (carrier.preload + 0.5 * carrier.stiffness * s) * s
    return energy


@kernel
def stored_energy(parameters, mode, y):
    """In gravity, rubber and springs, J."""
    return weight_energy(parameters, y) + spring_energy(parameters, mode, y)
