"""What every bearing carries, recovered from a motion that is known: inverse dynamics, from the rollers inwards.

Positions and rates are in a row, accelerations in its derivative, and the forces of the floor in the workspace. Newton
and Euler for each roller give the force and the moment of its bearing, and for each disk, which the rollers load, those
of the axle. With B the centre of a roller, O that of the disk, X where the floor touches, M its moment:

    roller    force = m (B'' - g) - sum F              moment = (I w)' - sum ((X - B) x F + M)
    axle      force = m (O'' - g) + sum force_i        moment = (I w)' + sum (moment_i + (B_i - O) x force_i)

Axes of the results are fixed in what carries the bearing, and those of a roller make its inertia three numbers:

    roller    radial d (outwards), lateral a x d, axial a          axle    h, k, n of the wheel

All rollers are alike but for their place and rates, so first each is taken to be in the air; then the floor is added
where it touches. What moves one in the air is linear in its place B on the disk, r = R (sin q h - cos q n) + offset k:

    B'' - g = O'' - g + G r        G r = w' x r + w x (w x r)
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel, outlined
from omnisim.base.trigonometry import cos_sin
from omnisim.base.vector import Vec2, Vec3, combine, cross, minus, plus, times
from omnisim.contact.frame import tangential
from omnisim.dynamics.indices import roller_index, roller_of
from omnisim.dynamics.multibody.elimination import Wrench3
from omnisim.dynamics.multibody.joint_forces import floor_force, resolve_joints
from omnisim.dynamics.multibody.rigid_body import needed_wrench
from omnisim.dynamics.state import places
from omnisim.dynamics.twist import acceleration_of, body_motion, wheel_motion, wheel_twist, world_frame

HEADING, AXLE, OUTWARDS = Vec3(1.0, 0.0, 0.0), Vec3(0.0, 1.0, 0.0), Vec3(0.0, 0.0, 1.0)
AXIAL, ROLLER_AXIAL = 1, 2  # which direction is along the bearing, of an axle and of a roller


class DiskMotion(NamedTuple):
    """Angular velocity of a disk (rad/s), acceleration of O with the weight in it (m/s^2), and angular acceleration
    (rad/s^2), along h, k and n."""

    rate: Vec3
    linear: Vec3
    angular: Vec3


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
def load_bearings(parameters, mode, w, y, dy, rates, found):
    """Force and moment of the bearings of wheel w, of a machine that stands upright: found (N + 1, 2, 3), of the axle
    first, N and N m; rates (N,): absolute axial rates of its rollers, rad/s."""
    if parameters.workspace.articulated is not None:  # then they are multipliers, and known
        resolve_joints(parameters, w, y, found)
    else:
        recover(parameters, mode, w, y, dy, rates, found)


@outlined
def recover(parameters, mode, w, y, dy, rates, found):
    """The same from the motion and the floor's forces."""
    machine, wheel, workspace = parameters.machine, parameters.wheels[w], parameters.workspace
    at = places(parameters)
    disk = disk_motion(parameters, w, y, dy)
    carried = carried_by(wheel, disk)
    axle = disk_load(wheel, disk)
    cos, sin = cos_sin(wheel.phase - y[at.spin_angle + w])
    row = 0
    for i in range(wheel.rollers):
        sector, offset = parameters.sector[w, i], parameters.roller_rows[wheel.row + row].offset
        mounting = Mounting(cos * sector[0] - sin * sector[1], sin * sector[0] + cos * sector[1], offset)
        rolling = dy[wheel.rates + i] if machine.every_rate else 0.0
        given, force = load_in_air(wheel, mounting, disk, carried, rates[i], rolling)
        keep(found[i + 1], given)
        axle = on_axle(wheel, mounting, axle, given.moment, force)
        row = row + 1 if row + 1 < wheel.rows else 0
    part = workspace.parts[w]
    for side in range(part.contacts):
        i = roller_index(wheel, roller_of(mode, side))
        sector, offset = parameters.sector[w, i], parameters.roller_rows[mode.row[side]].offset
        mounting = Mounting(cos * sector[0] - sin * sector[1], sin * sector[0] + cos * sector[1], offset)
        contact = workspace.contacts[part.first + side]
        force, torque = floor_force(part, contact, HEADING, AXLE)
        arm = minus(Vec3(0.0, contact.l, -wheel.radius), centre_of(wheel, mounting))
        rolling = 0.0 if machine.every_rate else dy[wheel.rates + side]
        more = load_of_floor(wheel, mounting, Wrench3(plus(cross(arm, force), torque), force), rolling)
        add(found[i + 1], more)
        axle = on_axle(wheel, mounting, axle, more.moment, of_disk(wheel, mounting, more.force))
    keep(found[0], axle)


@kernel
def disk_motion(parameters, w, y, dy):
    """The DiskMotion of wheel w, upright."""
    machine, wheel = parameters.machine, parameters.wheels[w]
    place = places(parameters).spin_rate + w
    body = body_motion(parameters, y)
    twist = wheel_twist(wheel, body.twist, y[place])
    motion = wheel_motion(wheel, body.twist, acceleration_of(parameters, body, dy), dy[place], 0.0)
    along = tangential(world_frame(wheel, body), Vec2(machine.downhill[0], machine.downhill[1]))
    return DiskMotion(
        Vec3(0.0, twist.spin, twist.yaw),
        Vec3(motion.h - along.h, motion.k - along.k, machine.gravity),
        Vec3(-twist.yaw * twist.spin, motion.spin, motion.yaw),  # k turns with the yaw
    )


@kernel
def disk_load(wheel, disk):
    """The Wrench3 that moves a disk without rollers, along h, k and n."""
    across, along = wheel.disk_inertia[0], wheel.disk_inertia[1]
    force, moment = needed_wrench(wheel.disk_mass, across, along, AXLE, disk.rate, disk.linear, disk.angular)
    return Wrench3(moment, force)


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
def of_disk(wheel, mounting, vector):
    """A vector along d, a x d and a of a roller, along h, k and n (Vec3)."""
    ahead = wheel.sin_psi * vector.y + wheel.cos_psi * vector.z
    return Vec3(
        mounting.sin_q * vector.x - mounting.cos_q * ahead,
        wheel.sin_psi * vector.z - wheel.cos_psi * vector.y,
        -mounting.cos_q * vector.x - mounting.sin_q * ahead,
    )


@kernel
def centre_of(wheel, mounting):
    """B from O along h, k and n (Vec3, m)."""
    distance = wheel.roller_distance
    return Vec3(distance * mounting.sin_q, mounting.offset, -distance * mounting.cos_q)


@kernel
def carried_by(wheel, disk):
    """What moves the rollers of a disk in the air (Carried)."""
    distance, mass = wheel.roller_distance, wheel.roller_mass
    return Carried(
        times(mass, disk.linear),
        times(mass * distance, added(disk, HEADING)),
        times(mass * distance, added(disk, OUTWARDS)),
        times(mass, added(disk, AXLE)),
    )


@kernel
def added(disk, place):
    """Acceleration of a point of the disk beside that of O, by its place from there (Vec3)."""
    return plus(cross(disk.angular, place), cross(disk.rate, cross(disk.rate, place)))


@kernel
def load_in_air(wheel, mounting, disk, carried, axial_rate, rolling):
    """The Wrench3 by which its bearing moves a roller of this absolute axial rate (rad/s) that nothing else touches,
    along d, a x d and a; and its force along h, k and n. rolling: p', rad/s^2."""
    rate, bent = own(wheel, mounting, disk.rate), own(wheel, mounting, disk.angular)
    aside = plus(carried.centre, times(mounting.offset, carried.sideways))
    force = combine(1.0, aside, mounting.sin_q, carried.ahead, -mounting.cos_q, carried.outwards)
    across, along = wheel.transverse_inertia, wheel.axial_inertia
    # in its bearing it turns with chi' = p - w . a, which turns what it has across its axis: w' + chi' w x a
    faster = along * axial_rate - across * rate.z
    moment = Vec3(across * bent.x + faster * rate.y, across * bent.y - faster * rate.x, along * rolling)
    return Wrench3(moment, own(wheel, mounting, force)), force


@kernel
def load_of_floor(wheel, mounting, floor, rolling):
    """The Wrench3 by which the bearing resists what the floor does to a roller (about B, along h, k and n), along d,
    a x d and a; rolling: p' by it, rad/s^2."""
    force, moment = own(wheel, mounting, floor.force), own(wheel, mounting, floor.moment)
    return Wrench3(Vec3(-moment.x, -moment.y, wheel.axial_inertia * rolling - moment.z), times(-1.0, force))


@kernel
def on_axle(wheel, mounting, axle, moment, force):
    """The Wrench3 of an axle about O with what moves one of its rollers: a moment along d, a x d and a, a force along
    h, k and n."""
    about = plus(of_disk(wheel, mounting, moment), cross(centre_of(wheel, mounting), force))
    return Wrench3(plus(axle.moment, about), plus(axle.force, force))


@kernel
def keep(found, wrench):
    """A Wrench3 into found (2, 3): force, N, and moment, N m."""
    force, moment = wrench.force, wrench.moment
    found[0, 0], found[0, 1], found[0, 2] = force.x, force.y, force.z
    found[1, 0], found[1, 1], found[1, 2] = moment.x, moment.y, moment.z


@kernel
def add(found, wrench):
    """The same beside what is there."""
    force, moment = wrench.force, wrench.moment
    found[0, 0], found[0, 1], found[0, 2] = found[0, 0] + force.x, found[0, 1] + force.y, found[0, 2] + force.z
    found[1, 0], found[1, 1], found[1, 2] = found[1, 0] + moment.x, found[1, 1] + moment.y, found[1, 2] + moment.z
