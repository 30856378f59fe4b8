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

All rollers are alike but for their place and rates, so all are loaded at once in vector registers: as if they were in
the air and kept their rates, and beside that (`beside`) by the floor where it touches, and by p'. What moves one in the
air is linear in its place B on the disk, r = R d + offset k:

    B'' - g = O'' - g + G r        G r = w' x r + w x (w x r)

Vectors of a disk are along h', k and n': h and n turned about k with the places of its rollers, which so are constant.
"""

from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec2, Vec3, combine, cross, minus, plus, times
from omnisim.contact.frame import tangential
from omnisim.dynamics.joint_loads import AXIAL, ROLLER_AXIAL, enter
from omnisim.dynamics.multibody.elimination import Wrench3
from omnisim.dynamics.multibody.joint_forces import floor_force, resolve_joints
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import Acceleration, Twist, wheel_motion
from omnisim.dynamics.wheel import azimuth, spin_momentum

AXLE = Vec3(0.0, 1.0, 0.0)
NOTHING = Vec3(0.0, 0.0, 0.0)


class Moving(NamedTuple):
    """An upright machine: its Twist, its Acceleration with the weight along its slope in it, state and derivative."""

    twist: Twist
    felt: Acceleration
    y: np.ndarray
    dy: np.ndarray


class DiskMotion(NamedTuple):
    """Angular velocity of a disk (rad/s), acceleration of O with the weight in it (m/s^2), and angular acceleration
    (rad/s^2), along h', k and n'; cosine and sine of the angle of these."""

    rate: Vec3
    linear: Vec3
    angular: Vec3
    cos: float
    sin: float


class Added(NamedTuple):
    """G: accelerations of points of the disk 1 m along h', k and n' from O, beside that of O, 1/s^2."""

    h: Vec3
    k: Vec3
    n: Vec3


class Carried(NamedTuple):
    """What moves rollers in the air, along h', k and n', N: a roller at O (`centre`), and what is added by R along h'
    and n'; of an offset along k by its length, N/m."""

    centre: Vec3
    ahead: Vec3
    outwards: Vec3
    sideways: Vec3


class Mounting(NamedTuple):
    """Where a roller is on its disk: cosine and sine of its azimuth q, d = h' sin q - n' cos q, and how far its row is
    along the axle, m."""

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
    """Force and moment of the bearings of wheel w, of a machine that stands upright, of the axle first, into found
    (joint_loads.py). machine: how it moves (Moving); rates (N,): absolute axial rates of the rollers, rad/s."""
    if parameters.workspace.articulated is not None:  # then they are multipliers, and known
        resolve_joints(parameters, w, machine.y, found)
    else:
        recover(parameters, mode, w, machine, rates, found)


@outlined
def recover(parameters, mode, w, machine, rates, found):
    """The same from the motion and the floor's forces."""
    every, wheel, placed = parameters.machine.every_rate, parameters.wheels[w], parameters.sector[w]
    row, spin_angle = parameters.roller_rows[mode.row[0]], machine.y[places(parameters).spin_angle + w]
    cos_q, sin_q = cos_sin(azimuth(wheel, row, mode.roller, spin_angle))  # of what touches, so its angle is small
    disk = disk_motion(parameters, mode, w, machine, cos_q, sin_q)
    beside = parameters.workspace.beside
    if every:
        spin, spun = spins(wheel, placed, rates, 0), spin_up(wheel, placed, machine.dy, beside)
    else:
        spin, spun = there(spin_momentum(parameters, mode, w, cos_q, sin_q, machine.y), disk.cos, disk.sin), NOTHING
    axle, part = Wrench3(NOTHING, NOTHING), parameters.workspace.parts[w]
    for side in range(part.contacts):
        i = mode.index[side]
        contact = parameters.workspace.contacts[part.first + side]
        force, torque = floor_force(part, contact)
        moment = plus(cross(Vec3(0.0, contact.l, -wheel.radius), force), torque)
        floor = Wrench3(there(moment, disk.cos, disk.sin), there(force, disk.cos, disk.sin))
        rolling = 0.0 if every else machine.dy[wheel.rates + side]
        axle = load_by_floor(wheel, mounted_at(placed, i), floor, rolling, axle, i, beside)
    load_rollers(wheel, placed, disk, rates, beside, found)
    enter(found, 0, AXIAL, load_axle(wheel, disk, spin, spun, axle))
    for side in range(part.contacts):
        unload(beside, mode.index[side])


@kernel
def disk_motion(parameters, mode, w, machine, cos_q, sin_q):
    """The DiskMotion of wheel w, upright; cos_q, sin_q: of contact 0."""
    wheel, at = parameters.wheels[w], places(parameters)
    spin, bent, yaw_rate = machine.y[at.spin_rate + w], machine.dy[at.spin_rate + w], machine.twist.yaw
    motion = wheel_motion(wheel, machine.twist, machine.felt, bent, 0.0)
    touching = mounted_at(parameters.sector[w], mode.index[0])
    return turned(
        Vec3(0.0, spin, yaw_rate),
        Vec3(motion.h, motion.k, parameters.machine.gravity),
        Vec3(-yaw_rate * spin, bent, motion.yaw),  # k turns with the yaw
        cos_q * touching.cos_q + sin_q * touching.sin_q,
        sin_q * touching.cos_q - cos_q * touching.sin_q,
    )


@kernel
def turned(rate, linear, angular, cos, sin):
    """A DiskMotion by what it is along h, k and n, and the angle by which the places of its rollers are turned."""
    return DiskMotion(there(rate, cos, sin), there(linear, cos, sin), there(angular, cos, sin), cos, sin)


@kernel
def there(vector, cos, sin):
    """A vector along h, k and n, along h', k and n' (Vec3)."""
    return Vec3(cos * vector.x + sin * vector.z, vector.y, cos * vector.z - sin * vector.x)


@kernel
def back(vector, disk):
    """A vector along h', k and n', along h, k and n (Vec3)."""
    return there(vector, disk.cos, -disk.sin)


@kernel
def unload(beside, i):
    """Nothing loads roller i `beside` any more."""
    for direction in range(3):
        beside[0, direction, i] = beside[1, direction, i] = 0.0


@kernel
def load_axle(wheel, disk, spin, spun, axle):
    """The Wrench3 of an axle along h, k and n. All else along h', k and n'; axle: that of the floor and of p' by it;
    spin, spun: sum Ia p a of all rollers (N m s), and sum Ia p' a of what the floor does not do (N m)."""
    rate, angular, more = disk.rate, disk.angular, wheel.axle_inertia - wheel.diameter_inertia
    gyroscopic = more * rate.y
    moment = Vec3(
        wheel.diameter_inertia * angular.x - gyroscopic * rate.z,
        wheel.axle_inertia * angular.y,
        wheel.diameter_inertia * angular.z + gyroscopic * rate.x,
    )
    aside = wheel.mass * wheel.shift
    about = Vec3(aside * disk.linear.z, 0.0, -aside * disk.linear.x)
    moment = plus(plus(moment, about), plus(spun, cross(rate, spin)))
    force = combine(wheel.mass, disk.linear, aside, added(disk).k, 0.0, disk.linear)
    return Wrench3(back(plus(axle.moment, moment), disk), back(plus(axle.force, force), disk))


@kernel
def spin_up(wheel, placed, dy, beside):
    """p' of all rollers, whose rates are states, begins what loads them `beside`; sum Ia p' a (Vec3, N m)."""
    for i in range(wheel.rollers):
        beside[1, ROLLER_AXIAL, i] = wheel.axial_inertia * dy[wheel.rates + i]
    return spins(wheel, placed, dy, wheel.rates)


@kernel
def spins(wheel, placed, values, first):
    """Sum Ia p a over the rollers along h', k and n' (Vec3), p from values[first] on."""
    cos, sin, all_of_them = 0.0, 0.0, 0.0
    for i in range(wheel.rollers):
        value = values[first + i]
        cos += value * placed[0, i]
        sin += value * placed[1, i]
        all_of_them += value
    across, along = wheel.axial_inertia * wheel.cos_psi, wheel.axial_inertia * wheel.sin_psi
    return Vec3(-across * cos, along * all_of_them, -across * sin)


@kernel
def load_by_floor(wheel, mounting, floor, rolling, axle, i, beside):
    """What the floor does to roller i (a Wrench3 about O), and p' by it (rad/s^2), into what loads it `beside`, and
    into the load of its axle, which is returned; along h', k and n'."""
    spun = wheel.axial_inertia * rolling
    about = minus(floor.moment, cross(centre_of(wheel, mounting), floor.force))
    force, moment = own(wheel, mounting, floor.force), own(wheel, mounting, about)
    beside[0, 0, i] -= force.x
    beside[0, 1, i] -= force.y
    beside[0, 2, i] -= force.z
    beside[1, 0, i] -= moment.x
    beside[1, 1, i] -= moment.y
    beside[1, 2, i] += spun - moment.z
    turning = minus(times(spun, axis_of(wheel, mounting)), floor.moment)
    return Wrench3(plus(axle.moment, turning), minus(axle.force, floor.force))


@kernel
def mounted_at(placed, i):
    """The Mounting of roller i by where rollers are placed (3, N)."""
    return Mounting(placed[0, i], placed[1, i], placed[2, i])


@kernel
def own(wheel, mounting, vector):
    """A vector along h', k and n', along d, a x d and a of a roller (Vec3)."""
    ahead = -mounting.cos_q * vector.x - mounting.sin_q * vector.z  # along k x d
    return Vec3(
        mounting.sin_q * vector.x - mounting.cos_q * vector.z,
        wheel.sin_psi * ahead - wheel.cos_psi * vector.y,
        wheel.cos_psi * ahead + wheel.sin_psi * vector.y,
    )


@kernel
def axis_of(wheel, mounting):
    """a of a roller along h', k and n' (Vec3)."""
    return Vec3(-wheel.cos_psi * mounting.cos_q, wheel.sin_psi, -wheel.cos_psi * mounting.sin_q)


@kernel
def centre_of(wheel, mounting):
    """B from O along h', k and n' (Vec3, m)."""
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
def load_rollers(wheel, placed, disk, rates, beside, found):
    """The bearings of all rollers into found, as in the air at these rates and by what loads them `beside`, (2, 3, N):
    force, N, and moment, N m, along their own directions."""
    carried = carried_by(wheel, disk)
    for i in range(wheel.rollers):
        air = roller_in_air(wheel, mounted_at(placed, i), disk, carried, rates[i])
        force = plus(air.force, Vec3(beside[0, 0, i], beside[0, 1, i], beside[0, 2, i]))
        moment = plus(air.moment, Vec3(beside[1, 0, i], beside[1, 1, i], beside[1, 2, i]))
        enter(found, i + 1, ROLLER_AXIAL, Wrench3(moment, force))


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
