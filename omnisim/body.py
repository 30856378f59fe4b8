"""The machine as one body: six equations of Newton and Euler for its acceleration and the floor's load.

The floor leaves the body three accelerations in the plane and takes heave, roll and pitch, for a load that lies on a
plane over the chassis (three wheels: any load; more: a rigid chassis on equal springs):

    unknowns   A_x, A_y (of C along chassis axes), theta''      b_0, b_1, b_2:   N_w = b_0 + b_1 x_w + b_2 y_w

    rows       M A = sum F + f                                  sum N = M g - f_z
               I_z theta'' = sum lever . F + ...                tilt about y and x, below

    tilt       sum N D x n - z_C n x sum F + (r x f)_h + theta'' S + theta'^2 n x S
                   = sum (tau - J_r phi'' - R F_h) k + (-J_k phi' theta' + sum Ia p' a_h + phi' G_n - theta' G_k) h

where J_k phi'' + sum Ia p' s + theta' G_h = tau - J_r phi'' - R F_h has been used (J_r: rotor of the motor). All forces
are linear in the unknowns: sliding friction by N, and a sticking contact gives as far as its spin and roller do,
F = -E (b + J X). With upright = "servo" the load is known and tilt is the servo's.
"""

from typing import NamedTuple

from omnisim.contact.kinematics import holding_mass
from omnisim.contact.reaction import VISCOUS
from omnisim.kernel import kernel, merged
from omnisim.parameters import CONTACTS

TILT_Y, TILT_X = 3, 4  # rows of levers, about -y and about x, after x, y and yaw
LEAST_REGULAR = 1e-2  # determinant of the loads over that without friction, below which friction jams


class Acceleration(NamedTuple):
    """Of C along the chassis axes (m/s^2) and of the yaw (rad/s^2)."""

    x: float
    y: float
    yaw: float


class Plane(NamedTuple):
    """The plane rows: what resists the acceleration, a symmetric matrix over (x, y, yaw), and what drives it; SI."""

    xx: float
    xy: float
    xw: float
    yy: float
    yw: float
    ww: float
    x: float
    y: float
    yaw: float


class Mobility(NamedTuple):
    """The inverse of that matrix: acceleration by forces and a moment on the body."""

    coupled: bool  # or diagonal
    xx: float
    xy: float
    xw: float
    yy: float
    yw: float
    ww: float


class ByLoad(NamedTuple):
    """What the loads b_0, b_1 and b_2 do to a row."""

    one: float
    x: float
    y: float


class Pushes(NamedTuple):
    """What they do to the rows of the plane."""

    x: ByLoad
    y: ByLoad
    yaw: ByLoad


class Held(NamedTuple):
    """A row of tilt without the loads: by the acceleration (x, y, yaw), and its right side; SI."""

    x: float
    y: float
    yaw: float
    right: float


class Tilt(NamedTuple):
    """A row of tilt: by the acceleration (x, y, yaw), by the loads, and its right side; SI."""

    x: float
    y: float
    yaw: float
    loads: ByLoad
    right: float


class LoadedPlaces(NamedTuple):
    """Sums of 1, x, y, x^2, x y and y^2 over the loaded wheels, m."""

    count: float
    x: float
    y: float
    xx: float
    xy: float
    yy: float


@kernel
def set_contact(contact, state, j, spin_held):
    """Kinematics of a contact from its ContactState and Jacobian."""
    axis, slip = state.axis, state.slip
    contact.axis[0], contact.axis[1], contact.axis[2] = axis.h, axis.k, axis.n
    contact.l, contact.turn, contact.share = state.contact.l, state.turn, 0.5 if spin_held else 1.0
    contact.slip[0], contact.slip[1] = slip.h, slip.k
    contact.arm[0], contact.arm[1] = j.roller_h, j.roller_k
    contact.spin[0], contact.spin[1] = j.spin_h, j.spin_k


@kernel
def set_lever(wheel, contact, axis, j):
    """The levers of a contact in the rows x, y and yaw."""
    lever, cos, sin = contact.lever, wheel.cos_heading, wheel.sin_heading
    lever[0, 0], lever[0, 1], lever[1, 0], lever[1, 1] = cos, -sin, sin, cos
    lever[2, 0], lever[2, 1] = j.yaw_h, j.yaw_k
    contact.twist[2] = 1.0 - axis.n * axis.n


@kernel
def set_tilt(machine, wheel, contact, spin_held):
    """The levers of a contact in the rows of tilt: about -y and about x."""
    axis_h, axis_k, axis_n = contact.axis[0], contact.axis[1], contact.axis[2]
    arm, spin = contact.arm, contact.spin
    cos, sin, rotor = wheel.cos_heading, wheel.sin_heading, rotor_part(wheel, spin_held)
    above, height = wheel.radius - machine.height, machine.height
    h_h, h_k = -axis_h * arm[0], height - axis_h * arm[1]  # about h by F_h and F_k, and about k
    k_h, k_k = above + rotor * spin[0], rotor * spin[1]
    lever = contact.lever
    lever[TILT_Y, 0], lever[TILT_Y, 1] = -(h_h * sin + k_h * cos), -(h_k * sin + k_k * cos)
    lever[TILT_X, 0], lever[TILT_X, 1] = h_h * cos - k_h * sin, h_k * cos - k_k * sin
    if machine.patch_radius > 0.0:
        h_n, k_n = -axis_n * axis_h, -rotor * axis_n * axis_k
        contact.twist[TILT_Y], contact.twist[TILT_X] = -(h_n * sin + k_n * cos), h_n * cos - k_n * sin


@kernel
def rotor_part(wheel, spin_held):
    """Part of the torque on an axle that turns the rotor of its motor, 1."""
    return 0.0 if spin_held else wheel.rotor_inertia * wheel.spin_mobility


@kernel
def set_held(machine, wheel, contact, axis, j, bias):
    """What a sticking contact adds to the balance; bias (Slip): its slip acceleration without it, or its slip."""
    contact.mass[0], contact.mass[1], contact.mass[2] = holding_mass(machine, wheel, axis, j)
    contact.bias[0], contact.bias[1] = bias.h, bias.k


@kernel
def free_rate(contact, motion):
    """Slip acceleration (h, k) of a contact without its own force, m/s^2: b + J X; motion: X, the Acceleration."""
    lever, bias = contact.lever, contact.bias
    return (
        bias[0] + lever[0, 0] * motion.x + lever[1, 0] * motion.y + lever[2, 0] * motion.yaw,
        bias[1] + lever[0, 1] * motion.x + lever[1, 1] * motion.y + lever[2, 1] * motion.yaw,
    )


@kernel
def holding_force(contact, motion):
    """F = -E (b + J X) along h and k of a sticking contact, N."""
    rate_h, rate_k = free_rate(contact, motion)
    mass = contact.mass
    return -mass[0] * rate_h - mass[1] * rate_k, -mass[1] * rate_h - mass[2] * rate_k


@kernel
def place_load(wheel, room, w):
    """Where the load of wheel w acts: between its contacts as they share it."""
    part, along = room.parts[w], wheel.offset[1]
    for c in range(2 * w, 2 * w + part.contacts):
        along += room.contacts[c].share * room.contacts[c].l
    part.point[0] = wheel.offset[0] * wheel.cos_heading - along * wheel.sin_heading
    part.point[1] = wheel.offset[0] * wheel.sin_heading + along * wheel.cos_heading


@kernel
def heading_moment(wheel, rollers, spin_rate, yaw_rate):
    """Moment of a wheel on the body about its heading, without its contacts, N m."""
    gyroscopic = wheel.axle_inertia * spin_rate * yaw_rate - spin_rate * rollers.g_n + yaw_rate * rollers.g_k
    return gyroscopic - rollers.bearing_h


@kernel
def wheel_tilt(wheel, part):
    """The moment of a wheel without its contacts in the rows of tilt: about -y and about x."""
    about_h = part.heading_moment
    about_k = rotor_part(wheel, part.contacts == 2) * part.free_spin - part.drive_torque
    cos, sin = wheel.cos_heading, wheel.sin_heading
    return -(about_h * sin + about_k * cos), about_h * cos - about_k * sin


@kernel
def external_tilt(machine, wrench, yaw_rate):
    """The wrench and the turning of S in the rows of tilt: about -y and about x."""
    lever, moment, turning = machine.lever, machine.moment, yaw_rate * yaw_rate
    about_y = lever[2] * wrench.x - lever[0] * wrench.z + turning * moment[0]
    return -about_y, lever[1] * wrench.z - lever[2] * wrench.y - turning * moment[1]


@kernel
def push_of(machine, contact, force_h, force_k, torque):
    """A contact's force (N) and torque (N m) in the rows x, y and yaw."""
    lever = contact.lever
    x = lever[0, 0] * force_h + lever[0, 1] * force_k
    y = lever[1, 0] * force_h + lever[1, 1] * force_k
    yaw = lever[2, 0] * force_h + lever[2, 1] * force_k
    if machine.patch_radius > 0.0:
        yaw += contact.twist[2] * torque
    return x, y, yaw


@kernel
def tilt_of(machine, contact, force_h, force_k, torque):
    """The same in the rows of tilt."""
    lever = contact.lever
    y = lever[TILT_Y, 0] * force_h + lever[TILT_Y, 1] * force_k
    x = lever[TILT_X, 0] * force_h + lever[TILT_X, 1] * force_k
    if machine.patch_radius > 0.0:
        y, x = y + contact.twist[TILT_Y] * torque, x + contact.twist[TILT_X] * torque
    return y, x


@kernel
def holds(part, contact):
    """Whether a contact sticks and its force follows from the acceleration of the body."""
    return contact.rest and not part.sought


@kernel
def free_plane(machine, x, y, yaw):
    """The Plane of a machine under a force (x, y) and a moment alone."""
    return Plane(machine.mass, 0.0, 0.0, machine.mass, 0.0, machine.yaw_inertia, x, y, yaw)


@kernel
def pushed_plane(plane, x, y, yaw):
    """A Plane with one more force and moment."""
    return Plane(plane.xx, plane.xy, plane.xw, plane.yy, plane.yw, plane.ww, plane.x + x, plane.y + y, plane.yaw + yaw)


@kernel
def plane_balance(machine, room, plane):
    """A Plane with the contacts that wait for it, with their loads where they are known."""
    carried = machine.upright == CONTACTS
    xx, xy, xw, yy, yw, ww, x, y, yaw = plane
    for w in range(len(room.parts)):
        part = room.parts[w]
        if part.known:
            continue
        if not part.loaded:
            continue
        for c in range(2 * w, 2 * w + part.contacts):
            contact, torque = room.contacts[c], 0.0
            if carried and part.contacts == 1 and not contact.rest and machine.law != VISCOUS:
                continue  # all of its friction waits for its load
            if part.contacts == 2:
                force_h, force_k, torque = contact.force[0], contact.force[1], contact.torque
            elif holds(part, contact):
                force_h, force_k = holding_force(contact, Acceleration(0.0, 0.0, 0.0))
                e, lever = contact.mass, contact.lever
                x_h, x_k = e[0] * lever[0, 0] + e[1] * lever[0, 1], e[1] * lever[0, 0] + e[2] * lever[0, 1]
                y_h, y_k = e[0] * lever[1, 0] + e[1] * lever[1, 1], e[1] * lever[1, 0] + e[2] * lever[1, 1]
                w_h, w_k = e[0] * lever[2, 0] + e[1] * lever[2, 1], e[1] * lever[2, 0] + e[2] * lever[2, 1]
                xx, xy = xx + lever[0, 0] * x_h + lever[0, 1] * x_k, xy + lever[0, 0] * y_h + lever[0, 1] * y_k
                xw, yy = xw + lever[0, 0] * w_h + lever[0, 1] * w_k, yy + lever[1, 0] * y_h + lever[1, 1] * y_k
                yw, ww = yw + lever[1, 0] * w_h + lever[1, 1] * w_k, ww + lever[2, 0] * w_h + lever[2, 1] * w_k
            else:
                normal = 0.0 if carried else part.normal_force
                force_h = contact.constant[0] + contact.unit[0] * normal
                force_k = contact.constant[1] + contact.unit[1] * normal
                torque = contact.unit_torque * normal
            push_x, push_y, push_yaw = push_of(machine, contact, force_h, force_k, torque)
            x, y, yaw = x + push_x, y + push_y, yaw + push_yaw
    return Plane(xx, xy, xw, yy, yw, ww, x, y, yaw)


@kernel
def inverse(machine, plane):
    """The Mobility of a Plane; diagonal unless some contact holds the body."""
    xx, xy, xw, yy, yw, ww = plane.xx, plane.xy, plane.xw, plane.yy, plane.yw, plane.ww
    if plane.xx == machine.mass:
        return Mobility(False, machine.mobility, 0.0, 0.0, machine.mobility, 0.0, machine.yaw_mobility)
    c_xx, c_xy, c_xw = yy * ww - yw * yw, xw * yw - xy * ww, xy * yw - xw * yy
    scale = 1.0 / (xx * c_xx + xy * c_xy + xw * c_xw)
    return Mobility(
        True, c_xx * scale, c_xy * scale, c_xw * scale,
        (xx * ww - xw * xw) * scale, (xy * xw - xx * yw) * scale, (xx * yy - xy * xy) * scale,
    )  # fmt: skip


@kernel
def yielding(mobility, x, y, yaw):
    """Acceleration of the body by the force (x, y) and the moment yaw."""
    if not mobility.coupled:
        return Acceleration(mobility.xx * x, mobility.yy * y, mobility.ww * yaw)
    return Acceleration(
        mobility.xx * x + mobility.xy * y + mobility.xw * yaw,
        mobility.xy * x + mobility.yy * y + mobility.yw * yaw,
        mobility.xw * x + mobility.yw * y + mobility.ww * yaw,
    )


@kernel
def solve(machine, wheels, room, load, plane, pushing):
    """The Acceleration of the body, its Mobility, and how regular the loads are; normal forces into the room.

    load: M g - f_z, N; plane: what is known at once; pushing: whether some contact pushes without its load. Regular:
    the determinant of the equations of the loads over that without friction.
    """
    if pushing:
        plane = plane_balance(machine, room, plane)
    mobility = inverse(machine, plane)
    motion = yielding(mobility, plane.x, plane.y, plane.yaw)
    if machine.upright != CONTACTS:
        return motion, mobility, 1.0
    return share_out(machine, wheels, room, load, mobility, motion)


@merged
def share_out(machine, wheels, room, load, mobility, motion):
    """What `solve` returns when the contacts carry roll and pitch; motion: the Acceleration without the loads."""
    pushes, about_y, about_x, places = carry(machine, wheels, room)
    by_0 = yielding(mobility, pushes.x.one, pushes.y.one, pushes.yaw.one)  # the acceleration by b_0, b_1 and b_2
    by_1 = yielding(mobility, pushes.x.x, pushes.y.x, pushes.yaw.x)
    by_2 = yielding(mobility, pushes.x.y, pushes.y.y, pushes.yaw.y)
    share = 1.0 / places.count
    x, y, mean = places.x * share, places.y * share, load * share
    a_1, a_2, a = reduced(about_y, by_0, by_1, by_2, motion, x, y, mean)
    c_1, c_2, c = reduced(about_x, by_0, by_1, by_2, motion, x, y, mean)
    determinant = a_1 * c_2 - a_2 * c_1
    scale = 1.0 / determinant
    b_1, b_2 = (a * c_2 - a_2 * c) * scale, (a_1 * c - a * c_1) * scale
    b_0 = mean - x * b_1 - y * b_2
    for w in range(len(room.parts)):
        part = room.parts[w]
        part.normal_force = b_0 + b_1 * part.point[0] + b_2 * part.point[1]
    xx, xy, yy = places.xx - x * places.x, places.xy - x * places.y, places.yy - y * places.y
    total = Acceleration(
        motion.x + by_0.x * b_0 + by_1.x * b_1 + by_2.x * b_2,
        motion.y + by_0.y * b_0 + by_1.y * b_1 + by_2.y * b_2,
        motion.yaw + by_0.yaw * b_0 + by_1.yaw * b_1 + by_2.yaw * b_2,
    )
    return total, mobility, determinant / (xx * yy - xy * xy)


@kernel
def reduced(row, by_0, by_1, by_2, motion, x, y, mean):
    """A Tilt without the acceleration and b_0: by b_1, by b_2, and its right side.

    x, y: mean place of the loaded wheels, m; mean: their mean load, N.
    """
    first = row.loads.one + row.x * by_0.x + row.y * by_0.y + row.yaw * by_0.yaw
    second = row.loads.x + row.x * by_1.x + row.y * by_1.y + row.yaw * by_1.yaw
    third = row.loads.y + row.x * by_2.x + row.y * by_2.y + row.yaw * by_2.yaw
    right = row.right - row.x * motion.x - row.y * motion.y - row.yaw * motion.yaw
    return second - first * x, third - first * y, right - first * mean


@kernel
def carry(machine, wheels, room):
    """What the loads do to the body: Pushes, the rows of Tilt about -y and about x, and the LoadedPlaces."""
    nothing, external = ByLoad(0.0, 0.0, 0.0), room.loads.external
    push_x, push_y, push_yaw, about_y, about_x = nothing, nothing, nothing, nothing, nothing
    right_y, right_x = external_tilt(machine, external, external.yaw_rate)
    held_y, held_x = Held(0.0, 0.0, -machine.moment[1], -right_y), Held(0.0, 0.0, machine.moment[0], -right_x)
    count, s_x, s_y, s_xx, s_xy, s_yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for w in range(len(room.parts)):
        part = room.parts[w]
        right_y, right_x = wheel_tilt(wheels[w], part)
        held_y, held_x = resisted(held_y, right_y), resisted(held_x, right_x)
        if not part.loaded:
            continue
        x, y = part.point[0], part.point[1]
        count, s_x, s_y = count + 1.0, s_x + x, s_y + y
        s_xx, s_xy, s_yy = s_xx + x * x, s_xy + x * y, s_yy + y * y
        for c in range(2 * w, 2 * w + part.contacts):
            contact = room.contacts[c]
            if part.contacts == 2:
                right_y, right_x = tilt_of(machine, contact, contact.force[0], contact.force[1], contact.torque)
                held_y, held_x = resisted(held_y, right_y), resisted(held_x, right_x)
            elif holds(part, contact):
                held_y, held_x = held(held_y, contact, TILT_Y), held(held_x, contact, TILT_X)
            else:
                force_h, force_k, torque = contact.unit[0], contact.unit[1], contact.unit_torque
                along_x, along_y, turn = push_of(machine, contact, force_h, force_k, torque)
                lever_y, lever_x = tilt_of(machine, contact, force_h, force_k, torque)
                push_x, push_y = loaded(push_x, along_x, x, y), loaded(push_y, along_y, x, y)
                push_yaw = loaded(push_yaw, turn, x, y)
                about_y, about_x = loaded(about_y, lever_y, x, y), loaded(about_x, lever_x, x, y)
                if machine.law == VISCOUS:
                    right_y, right_x = tilt_of(machine, contact, contact.constant[0], contact.constant[1], 0.0)
                    held_y, held_x = resisted(held_y, right_y), resisted(held_x, right_x)
    about_y = ByLoad(about_y.one + s_x, about_y.x + s_xx, about_y.y + s_xy)  # the loads themselves
    about_x = ByLoad(about_x.one + s_y, about_x.x + s_xy, about_x.y + s_yy)
    return (
        Pushes(push_x, push_y, push_yaw),
        Tilt(held_y.x, held_y.y, held_y.yaw, about_y, held_y.right),
        Tilt(held_x.x, held_x.y, held_x.yaw, about_x, held_x.right),
        LoadedPlaces(count, s_x, s_y, s_xx, s_xy, s_yy),
    )


@kernel
def loaded(by_load, push, x, y):
    """A ByLoad with one more push by the load at x, y (m)."""
    return ByLoad(by_load.one + push, by_load.x + push * x, by_load.y + push * y)


@kernel
def resisted(row, moment):
    """A Held with one more moment that does not depend on the unknowns, N m."""
    return Held(row.x, row.y, row.yaw, row.right - moment)


@kernel
def held(row, contact, i):
    """A Held with a sticking contact; i: its row of the levers."""
    lever, e = contact.lever, contact.mass
    force_h, force_k = holding_force(contact, Acceleration(0.0, 0.0, 0.0))
    along_h, along_k = lever[i, 0], lever[i, 1]
    e_h, e_k = e[0] * along_h + e[1] * along_k, e[1] * along_h + e[2] * along_k
    return Held(
        row.x - lever[0, 0] * e_h - lever[0, 1] * e_k,
        row.y - lever[1, 0] * e_h - lever[1, 1] * e_k,
        row.yaw - lever[2, 0] * e_h - lever[2, 1] * e_k,
        row.right - along_h * force_h - along_k * force_k,
    )


@kernel
def servo(machine, wheels, room, wrench, yaw_rate, yaw_acceleration):
    """Torque about chassis x and y that keeps the body upright, N m: what its moment equation lacks."""
    about_y, about_x = external_tilt(machine, wrench, yaw_rate)
    about_y, about_x = about_y - machine.moment[1] * yaw_acceleration, about_x + machine.moment[0] * yaw_acceleration
    for w in range(len(room.parts)):
        part = room.parts[w]
        more_y, more_x = wheel_tilt(wheels[w], part)
        about_y, about_x = about_y + more_y, about_x + more_x
        if not part.loaded:
            continue
        place_load(wheels[w], room, w)
        about_y += part.normal_force * part.point[0]
        about_x += part.normal_force * part.point[1]
        for c in range(2 * w, 2 * w + part.contacts):
            contact = room.contacts[c]
            set_tilt(machine, wheels[w], contact, part.contacts == 2)
            more_y, more_x = tilt_of(machine, contact, contact.force[0], contact.force[1], contact.torque)
            about_y, about_x = about_y + more_y, about_x + more_x
    return -about_x, about_y
