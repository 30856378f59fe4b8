"""The chassis, root of the tree: the equations that are left when every wheel has been eliminated onto it."""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.dynamics.indices import body_place
from omnisim.dynamics.multibody.elimination import UP, Wrench3
from omnisim.dynamics.multibody.rigid_body import (
    RigidBody,
    against_gravity,
    first_axis,
    rigid_body,
    second_axis,
    third_axis,
)
from omnisim.dynamics.planar_body import BodyEquations


class Carrier(NamedTuple):
    """The chassis, with C, its axes and where its centre of mass is from C; world axes."""

    body: RigidBody
    x: Vec3
    y: Vec3
    z: Vec3
    arm: Vec3
    centre: Vec3
    velocity: Vec3  # of C


class GeneralizedForce(NamedTuple):
    """A wrench on the chassis about C in the rows x, y, yaw, of roll and pitch, and along the vertical."""

    x: float
    y: float
    yaw: float
    tilt_y: float
    tilt_x: float
    z: float


class Balance(NamedTuple):
    """The equations of the chassis: what it feels of unit accelerations along x, y and about n, and without any."""

    x: GeneralizedForce
    y: GeneralizedForce
    yaw: GeneralizedForce
    known: GeneralizedForce


@kernel
def chassis_of(parameters, y):
    """The Carrier in state y."""
    machine = parameters.machine
    body = rigid_body(y, body_place(parameters, -1, 0))
    x, y_axis, z = first_axis(body.rotation), second_axis(body.rotation), third_axis(body.rotation)
    lever = machine.lever
    arm = plus(plus(times(lever[0], x), times(lever[1], y_axis)), times(lever[2], z))
    velocity = minus(body.velocity, cross(body.rate, arm))
    return Carrier(body, x, y_axis, z, arm, minus(body.position, arm), velocity)


@kernel
def chassis_balance(machine, carrier, wrench):
    """The Balance of the chassis without its wheels; wrench: the external one."""
    mass = machine.chassis_mass
    inertia = machine.chassis_inertia
    rate = carrier.body.rate
    a, b, c = inertia[0], inertia[1], inertia[2]
    about_n = plus(
        plus(times(a * carrier.x.z, carrier.x), times(b * carrier.y.z, carrier.y)), times(c * carrier.z.z, carrier.z)
    )
    momentum = plus(
        plus(times(a * dot(rate, carrier.x), carrier.x), times(b * dot(rate, carrier.y), carrier.y)),
        times(c * dot(rate, carrier.z), carrier.z),
    )
    nothing = Vec3(0.0, 0.0, 0.0)
    arm = carrier.arm
    x = resisting(carrier, arm, Wrench3(nothing, times(mass, carrier.x)))
    y = resisting(carrier, arm, Wrench3(nothing, times(mass, carrier.y)))
    yaw = resisting(carrier, arm, Wrench3(about_n, times(mass, cross(UP, arm))))
    swept = plus(cross(rate, cross(rate, arm)), against_gravity(machine))
    known = resisting(carrier, arm, Wrench3(cross(rate, momentum), times(mass, swept)))
    lever = machine.lever
    about_x, about_y = lever[1] * wrench.z - lever[2] * wrench.y, lever[2] * wrench.x - lever[0] * wrench.z
    return Balance(
        x, y, yaw, together(known, GeneralizedForce(wrench.x, wrench.y, wrench.yaw, -about_y, about_x, wrench.z))
    )


@kernel
def resisting(carrier, arm, wrench):
    """The GeneralizedForce of a wrench that the chassis gives at `arm` from C: on itself it has the other sign."""
    moment = plus(wrench.moment, cross(arm, wrench.force))
    force = wrench.force
    about_x, about_y = dot(moment, carrier.x), dot(moment, carrier.y)
    return GeneralizedForce(-dot(force, carrier.x), -dot(force, carrier.y), -moment.z, about_y, -about_x, -force.z)


@kernel
def together(a, b):
    """Sum of two GeneralizedForces."""
    return GeneralizedForce(a.x + b.x, a.y + b.y, a.yaw + b.yaw, a.tilt_y + b.tilt_y, a.tilt_x + b.tilt_x, a.z + b.z)


@kernel
def joined(a, b):
    """Two Balances as one."""
    return Balance(together(a.x, b.x), together(a.y, b.y), together(a.yaw, b.yaw), together(a.known, b.known))


@kernel
def equations_of(balance):
    """The BodyEquations of a Balance, as planar_body.py has it."""
    x, y, yaw, known = balance
    return BodyEquations(-x.x, -x.y, -x.yaw, -y.y, -y.yaw, -yaw.yaw, known.x, known.y, known.yaw)


@kernel
def set_tilt_rows(balance, tilt):
    """The rows of tilt of a Balance into those of the workspace, as normal_forces/tilt.py has them."""
    x, y, yaw, known = balance
    set_row(tilt[0], x.tilt_y, y.tilt_y, yaw.tilt_y, -known.tilt_y)
    set_row(tilt[1], x.tilt_x, y.tilt_x, yaw.tilt_x, -known.tilt_x)


@kernel
def set_row(row, x, y, yaw, right):
    row[0], row[1], row[2], row[3] = x, y, yaw, right
