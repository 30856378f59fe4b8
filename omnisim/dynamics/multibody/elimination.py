"""Elimination along the tree: rollers onto their wheel, wheels onto the chassis.

Every body has its Newton-Euler equations, every revolute joint five multipliers: the force and the moment by which it
holds what it carries. With the joint's own acceleration eliminated, what hangs on a joint resists like one body
(Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 7):

    roller   moment = It (1 - a a) (alpha + w x a chi') + w_r x J w_r + T a - (1 - a a) torque
             force  = m (a_r - g) - f                      g: gravity, downwards
    wheel    moment = A alpha + lift x a_O + torque + A k phi''      phi'' = (tau - k . the rest) / (k . A k + J_r)
             force  = m a_O + alpha x lift + force + phi'' k x lift

with A about O: that of the disk and, of each roller, It (1 - a a) + m (rho^2 - rho rho). No matrix is larger than
3 x 3, and the work is that of one pass over the bodies in and one back.
"""

import math
from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.base.vector import Vec3, cross, dot, minus, plus, times
from omnisim.dynamics.indices import body_place
from omnisim.dynamics.multibody.rigid_body import (
    against_gravity,
    gyroscopic,
    rigid_body,
    second_axis,
    third_axis,
)
from omnisim.dynamics.wheel import bearing_torque

UP = Vec3(0.0, 0.0, 1.0)


class Inertia(NamedTuple):
    """A symmetric tensor, world axes, kg m^2."""

    xx: float
    xy: float
    xz: float
    yy: float
    yz: float
    zz: float


class Articulated(NamedTuple):
    """A wheel with its rollers, as its axle feels it; about the wheel centre O, world axes, SI."""

    axle: Vec3
    inertia: Inertia
    lift: Vec3  # sum m rho
    mass: float
    spin_inertia: float  # k . A k, and the rotor
    torque: Vec3  # of motion and weight
    force: Vec3


class Wrench3(NamedTuple):
    """Moment (N m) and force (N), world axes."""

    moment: Vec3
    force: Vec3


@kernel
def axial(across, along, axis):
    """The Inertia of a body of revolution: `across` its unit axis, and `along` it."""
    more = along - across
    return Inertia(
        across + more * axis.x * axis.x,
        more * axis.x * axis.y,
        more * axis.x * axis.z,
        across + more * axis.y * axis.y,
        more * axis.y * axis.z,
        across + more * axis.z * axis.z,
    )


@kernel
def added(a, b):
    return Inertia(a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz)


@kernel
def at_point(mass, rho):
    """The Inertia of a mass at rho: m (rho^2 - rho rho)."""
    x, y, z = rho.x, rho.y, rho.z
    return Inertia(
        mass * (y * y + z * z),
        -mass * x * y,
        -mass * x * z,
        mass * (x * x + z * z),
        -mass * y * z,
        mass * (x * x + y * y),
    )


@kernel
def turned_by(inertia, v):
    """The product of an Inertia and a vector."""
    return Vec3(
        inertia.xx * v.x + inertia.xy * v.y + inertia.xz * v.z,
        inertia.xy * v.x + inertia.yy * v.y + inertia.yz * v.z,
        inertia.xz * v.x + inertia.yz * v.y + inertia.zz * v.z,
    )


@kernel
def across_axis(v, axis):
    """What of v is not along the unit vector `axis`."""
    return minus(v, times(dot(v, axis), axis))


@kernel
def articulate(parameters, w, y):
    """Wheel w with its rollers eliminated: Articulated, and what their bearings lose, W."""
    wheel = parameters.wheels[w]
    lifted = against_gravity(parameters.machine)
    disk = rigid_body(y, body_place(parameters, w, 0))
    loss = 0.0
    axle = second_axis(disk.rotation)
    across, along = (wheel.disk_inertia[0], wheel.disk_inertia[1])
    inertia = axial(across, along, axle)
    mass = wheel.disk_mass
    lift = Vec3(0.0, 0.0, 0.0)
    torque = gyroscopic(across, along, axle, disk.rate)
    force = times(wheel.disk_mass, lifted)
    for i in range(wheel.rollers):
        roller = rigid_body(y, body_place(parameters, w, i + 1))
        axis = third_axis(roller.rotation)
        rho = minus(roller.position, disk.position)
        joint = dot(minus(roller.rate, disk.rate), axis)
        friction = bearing_torque(wheel, joint)
        loss -= friction * joint
        swept = plus(cross(disk.rate, cross(disk.rate, rho)), lifted)
        pull = times(wheel.roller_mass, swept)
        moment = plus(
            times(wheel.transverse_inertia * joint, cross(disk.rate, axis)),
            gyroscopic(wheel.transverse_inertia, wheel.axial_inertia, axis, roller.rate),
        )
        torque = plus(torque, plus(plus(moment, times(friction, axis)), cross(rho, pull)))
        force = plus(force, pull)
        lift = plus(lift, times(wheel.roller_mass, rho))
        inertia = added(inertia, added(axial(wheel.transverse_inertia, 0.0, axis), at_point(wheel.roller_mass, rho)))
        mass += wheel.roller_mass
    spin_inertia = math.inf if wheel.follows else dot(axle, turned_by(inertia, axle)) + wheel.rotor_inertia
    return Articulated(axle, inertia, lift, mass, spin_inertia, torque, force), loss


@kernel
def resistance(art, angular, acceleration):
    """The Wrench3 that accelerates a wheel's disk (rad/s^2) and centre (m/s^2) while its spin is not accelerated."""
    return Wrench3(
        plus(turned_by(art.inertia, angular), cross(art.lift, acceleration)),
        plus(times(art.mass, acceleration), cross(angular, art.lift)),
    )


@kernel
def transmitted(art, needed, drive, held):
    """Acceleration of the spin, and the Wrench3 of the axle on the wheel, where `needed` is without that acceleration,
    or with that which a table of angles asks for: to all else such a spin is of infinite inertia.

    drive: torque on the disk about k, N m; held: the spin is, by two rollers on the floor.
    """
    lacking = drive - dot(art.axle, needed.moment)
    if held:
        return 0.0, Wrench3(plus(needed.moment, times(lacking, art.axle)), needed.force)
    spin = lacking / art.spin_inertia
    return spin, Wrench3(
        plus(needed.moment, times(spin, turned_by(art.inertia, art.axle))),
        plus(needed.force, times(spin, cross(art.axle, art.lift))),
    )


@kernel
def handed_on(axis, rho, arm, force, torque):
    """What a roller hands on to its wheel of a force (Vec3, N) at `arm` from its centre and a torque (about O)."""
    turned = across_axis(plus(cross(arm, force), torque), axis)
    return Wrench3(plus(turned, cross(rho, force)), force)
