"""What every bearing carries, recovered from a motion that is known: inverse dynamics.

Positions and rates are in a row, accelerations in its derivative, and the forces of the floor in the workspace. Newton
and Euler for each roller give the force and the moment of its bearing, and for each wheel those of its axle. With B the
centre of a roller, a its axis, p its absolute axial rate, O the wheel's centre, w the disk's angular velocity, X where
the floor touches, M its moment:

    roller    force = m (B'' - g) - sum F        moment = It (w' - (w' . a) a) + (Ia p - It w . a) w x a + Ia p' a
                                                          - sum ((X - B) x F + M)
    axle      force = M_w (O'' + G o k - g) - sum F
              moment = (J w)' + M_w o k x (O'' - g) + w x H + sum Ia p' a - sum ((X - O) x F + M)

The disk and its rollers are one body that has its inertia J about O (dynamics/inertia.py), of revolution since every
row has three rollers or more, evenly spread, and its centre of mass at o k, beside the spins of the rollers,
H = sum Ia p a. Axes of the results are fixed in what carries the bearing, and those of a roller make its inertia three
numbers:

    roller    radial d (outwards), lateral a x d, axial a          axle    h, k, n of the wheel

All rollers are alike but for their place and rates, so first each is taken to be in the air, several at once in vector
registers; then the floor is added where it touches. What moves one in the air is linear in its place B on the disk,
r = R (sin q h - cos q n) + offset k:

    B'' - g = O'' - g + G r        G r = w' x r + w x (w x r)
"""

from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec2, Vec3, combine, cross, minus, plus, times
from omnisim.contact.frame import tangential
from omnisim.dynamics.multibody.elimination import Wrench3
from omnisim.dynamics.multibody.joint_forces import floor_force, resolve_joints
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import Acceleration, Twist, wheel_motion
from omnisim.dynamics.wheel import azimuth

AXLE = Vec3(0.0, 1.0, 0.0)
AXIAL, ROLLER_AXIAL = 1, 2  # which direction is along the bearing, of an axle and of a roller


class Moving(NamedTuple):
    """An upright machine: its Twist, its Acceleration with the weight along its slope in it, state and derivative."""

    twist: Twist
    felt: Acceleration
    y: np.ndarray
    dy: np.ndarray


class DiskMotion(NamedTuple):
    """Angular velocity of a disk (rad/s), acceleration of O with the weight in it (m/s^2), and angular acceleration
    (rad/s^2), along h, k and n; cosine and sine of the angle by which the places of its rollers are turned."""

    rate: Vec3
    linear: Vec3
    angular: Vec3
    cos: float
    sin: float


class Added(NamedTuple):
    """G: accelerations of points of the disk 1 m ahead, aside and outwards of O, beside that of O, 1/s^2."""

    h: Vec3
    k: Vec3
    n: Vec3


class Carried(NamedTuple):
    """What moves rollers in the air, along h, k and n, N: a roller at O (`centre`), and what is added by R along h and
    n; of an offset along k by its length, N/m."""

    centre: Vec3
    ahead: Vec3
    outwards: Vec3
    sideways: Vec3


class Mounting(NamedTuple):
    """Where a roller is on its disk: cosine and sine of its azimuth, and how far its row is along the axle, m."""

    cos_q: float
    sin_q: float
    offset: float


@kernel
def moving(parameters, body, y, dy):
    """How an upright machine moves in state y, with its derivative and its Body (Moving)."""
    at, machine = places(parameters), parameters.machine
    linear = Vec2(dy[at.velocity] - machine.downhill[0], dy[at.velocity + 1] - machine.downhill[1])
    along = tangential(body.frame, linear)
    return Moving(body.twist, Acceleration(along.h, along.k, dy[at.yaw_rate]), y, dy)


@kernel
def load_bearings(parameters, mode, w, machine, rates, found):
    """Force and moment of the bearings of wheel w, of a machine that stands upright: found (2, 3, N + 1), of the axle
    first, N and N m. machine: how it moves (Moving); rates (N,): absolute axial rates of the rollers, rad/s."""
    if parameters.workspace.articulated is not None:  # then they are multipliers, and known
        resolve_joints(parameters, w, machine.y, found)
    else:
        recover(parameters, mode, w, machine, rates, found)


@outlined
def recover(parameters, mode, w, machine, rates, found):
    """The same from the motion and the floor's forces."""
    every, wheel, sector = parameters.machine.every_rate, parameters.wheels[w], parameters.sector[w]
    disk = disk_motion(parameters, mode, w, machine)
    axle = load_in_air(wheel, sector, disk, rates, every, machine.dy, found)
    part = parameters.workspace.parts[w]
    for side in range(part.contacts):
        i = mode.index[side]
        mounting = mounted_at(sector, i, disk)
        contact = parameters.workspace.contacts[part.first + side]
        force, torque = floor_force(part, contact)
        floor = Wrench3(plus(cross(Vec3(0.0, contact.l, -wheel.radius), force), torque), force)
        rolling = 0.0 if every else machine.dy[wheel.rates + side]
        axle = load_by_floor(wheel, mounting, floor, rolling, axle, i, found)
    keep(found, 0, axle)


@kernel
def disk_motion(parameters, mode, w, machine):
    """The DiskMotion of wheel w, upright."""
    wheel, at = parameters.wheels[w], places(parameters)
    spin, bent, yaw_rate = machine.y[at.spin_rate + w], machine.dy[at.spin_rate + w], machine.twist.yaw
    motion = wheel_motion(wheel, machine.twist, machine.felt, bent, 0.0)
    touching = parameters.sector[w, 0, mode.index[0]], parameters.sector[w, 1, mode.index[0]]
    row = parameters.roller_rows[mode.row[0]]
    cos_q, sin_q = cos_sin(azimuth(wheel, row, mode.roller, machine.y[at.spin_angle + w]))  # so its angle is small
    return DiskMotion(
        Vec3(0.0, spin, yaw_rate),
        Vec3(motion.h, motion.k, parameters.machine.gravity),
        Vec3(-yaw_rate * spin, bent, motion.yaw),  # k turns with the yaw
        cos_q * touching[0] + sin_q * touching[1],
        sin_q * touching[0] - cos_q * touching[1],
    )


@kernel
def load_in_air(wheel, placed, disk, rates, every, dy, found):
    """The bearings of rollers that nothing touches, into found (2, 3, N + 1), and the Wrench3 of their axle along h, k
    and n. placed (3, N): cosine and sine of the angles of rollers on the disk, and offsets, m. every: whether their
    rates are states; else they keep them."""
    carried = carried_by(wheel, disk)
    for i in range(wheel.rollers):
        keep(found, i + 1, roller_in_air(wheel, mounted_at(placed, i, disk), disk, carried, rates[i]))
    rate, angular, more = disk.rate, disk.angular, wheel.axle_inertia - wheel.diameter_inertia
    gyroscopic = more * rate.y
    moment = Vec3(
        wheel.diameter_inertia * angular.x - gyroscopic * rate.z,
        wheel.axle_inertia * angular.y,
        wheel.diameter_inertia * angular.z + gyroscopic * rate.x,
    )
    moment = plus(moment, cross(rate, spins(wheel, placed, disk, rates, 0)))
    if every:
        for i in range(wheel.rollers):
            found[1, ROLLER_AXIAL, i + 1] = wheel.axial_inertia * dy[wheel.rates + i]
        moment = plus(moment, spins(wheel, placed, disk, dy, wheel.rates))
    aside = wheel.mass * wheel.shift
    about = Vec3(aside * disk.linear.z, 0.0, -aside * disk.linear.x)
    return Wrench3(plus(moment, about), combine(wheel.mass, disk.linear, aside, added(disk).k, 0.0, disk.linear))


@kernel
def spins(wheel, placed, disk, values, first):
    """Sum Ia p a over the rollers along h, k and n (Vec3), p from values[first] on."""
    cos, sin, all_of_them = 0.0, 0.0, 0.0
    for i in range(wheel.rollers):
        value = values[first + i]
        cos += value * placed[0, i]
        sin += value * placed[1, i]
        all_of_them += value
    across, along = wheel.axial_inertia * wheel.cos_psi, wheel.axial_inertia * wheel.sin_psi
    ahead, outwards = disk.cos * cos - disk.sin * sin, disk.sin * cos + disk.cos * sin
    return Vec3(-across * ahead, along * all_of_them, -across * outwards)


@kernel
def load_by_floor(wheel, mounting, floor, rolling, axle, i, found):
    """The bearing of roller i with what the floor does to it (a Wrench3 about O along h, k and n); so with its axle,
    which is returned. rolling: p' by it, rad/s^2."""
    spun = wheel.axial_inertia * rolling
    force = own(wheel, mounting, floor.force)
    moment = own(wheel, mounting, minus(floor.moment, cross(centre_of(wheel, mounting), floor.force)))
    found[0, 0, i + 1] -= force.x
    found[0, 1, i + 1] -= force.y
    found[0, 2, i + 1] -= force.z
    found[1, 0, i + 1] -= moment.x
    found[1, 1, i + 1] -= moment.y
    found[1, 2, i + 1] += spun - moment.z
    turned = minus(times(spun, axis_of(wheel, mounting)), floor.moment)
    return Wrench3(plus(axle.moment, turned), minus(axle.force, floor.force))


@kernel
def mounted_at(placed, i, disk):
    """The Mounting of roller i by where rollers are placed (3, N)."""
    return Mounting(
        disk.cos * placed[0, i] - disk.sin * placed[1, i],
        disk.sin * placed[0, i] + disk.cos * placed[1, i],
        placed[2, i],
    )


@kernel
def own(wheel, mounting, vector):
    """A vector along h, k and n, along d, a x d and a of a roller (Vec3)."""
    ahead = -mounting.cos_q * vector.x - mounting.sin_q * vector.z  # along k x d
    return Vec3(
        mounting.sin_q * vector.x - mounting.cos_q * vector.z,
        wheel.sin_psi * ahead - wheel.cos_psi * vector.y,
        wheel.cos_psi * ahead + wheel.sin_psi * vector.y,
    )


@kernel
def axis_of(wheel, mounting):
    """a of a roller along h, k and n (Vec3)."""
    return Vec3(-wheel.cos_psi * mounting.cos_q, wheel.sin_psi, -wheel.cos_psi * mounting.sin_q)


@kernel
def centre_of(wheel, mounting):
    """B from O along h, k and n (Vec3, m)."""
    distance = wheel.roller_distance
    return Vec3(distance * mounting.sin_q, mounting.offset, -distance * mounting.cos_q)


@kernel
def carried_by(wheel, disk):
    """What moves the rollers of a disk in the air (Carried)."""
    distance, mass, by = wheel.roller_distance, wheel.roller_mass, added(disk)
    return Carried(
        times(mass, disk.linear), times(mass * distance, by.h), times(mass * distance, by.n), times(mass, by.k)
    )


@kernel
def added(disk):
    """G by its columns (Added)."""
    w, bent = disk.rate, disk.angular
    hh, kk, nn, hk, hn, kn = w.x * w.x, w.y * w.y, w.z * w.z, w.x * w.y, w.x * w.z, w.y * w.z
    return Added(
        Vec3(-kk - nn, hk + bent.z, hn - bent.y),
        Vec3(hk - bent.z, -hh - nn, kn + bent.x),
        Vec3(hn + bent.y, kn - bent.x, -hh - kk),
    )


@kernel
def roller_in_air(wheel, mounting, disk, carried, axial_rate):
    """The Wrench3 by which its bearing moves a roller that keeps this absolute axial rate (rad/s), along d, a x d and
    a."""
    rate, bent = own(wheel, mounting, disk.rate), own(wheel, mounting, disk.angular)
    aside = plus(carried.centre, times(mounting.offset, carried.sideways))
    force = combine(1.0, aside, mounting.sin_q, carried.ahead, -mounting.cos_q, carried.outwards)
    across = wheel.transverse_inertia
    faster = wheel.axial_inertia * axial_rate - across * rate.z
    moment = Vec3(across * bent.x + faster * rate.y, across * bent.y - faster * rate.x, 0.0)
    return Wrench3(moment, own(wheel, mounting, force))


@kernel
def keep(found, joint, wrench):
    """A Wrench3 into found (2, 3, N + 1) as that of a joint: force, N, and moment, N m."""
    force, moment = wrench.force, wrench.moment
    found[0, 0, joint], found[0, 1, joint], found[0, 2, joint] = force.x, force.y, force.z
    found[1, 0, joint], found[1, 1, joint], found[1, 2, joint] = moment.x, moment.y, moment.z
