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

from omnisim.contact.kinematics import holding_mass, slip_jacobian
from omnisim.kernel import kernel
from omnisim.parameters import CONTACTS

TILT_Y, TILT_X = 3, 4  # rows of levers after x, y and yaw; in the balance they follow heave
LEAST_REGULAR = 1e-2  # determinant of the loads over that without friction, below which friction jams


class Acceleration(NamedTuple):
    """Of C along the chassis axes (m/s^2) and of the yaw (rad/s^2)."""

    x: float
    y: float
    yaw: float


@kernel
def set_contact(machine, wheel, contact, state, spin_held):
    """Kinematics of a contact from its ContactState; its levers in the rows x, y, yaw, tilt about -y and about x."""
    axis, slip, j = state.axis, state.slip, slip_jacobian(wheel, state.axis, state.contact)
    contact.axis[0], contact.axis[1], contact.axis[2] = axis.h, axis.k, axis.n
    contact.l, contact.turn, contact.share = state.contact.l, state.turn, 0.5 if spin_held else 1.0
    contact.slip[0], contact.slip[1] = slip.h, slip.k
    contact.arm[0], contact.arm[1] = j.roller_h, j.roller_k
    contact.spin[0], contact.spin[1] = j.spin_h, j.spin_k
    lever, twist, cos, sin = contact.lever, contact.twist, wheel.cos_heading, wheel.sin_heading
    lever[0, 0], lever[0, 1] = cos, -sin
    lever[1, 0], lever[1, 1] = sin, cos
    lever[2, 0], lever[2, 1] = j.yaw_h, j.yaw_k
    rotor = 0.0 if spin_held else wheel.rotor_inertia / (wheel.axle_inertia + wheel.rotor_inertia)
    above, height = wheel.radius - machine.height, machine.height
    h_h, h_k = -axis.h * j.roller_h, height - axis.h * j.roller_k  # about h by F_h and F_k, and about k
    k_h, k_k = above + rotor * j.spin_h, rotor * j.spin_k
    lever[TILT_Y, 0], lever[TILT_Y, 1] = -(h_h * sin + k_h * cos), -(h_k * sin + k_k * cos)
    lever[TILT_X, 0], lever[TILT_X, 1] = h_h * cos - k_h * sin, h_k * cos - k_k * sin
    if machine.patch_radius > 0.0:
        about_h, about_k = -axis.n * axis.h, -rotor * axis.n * axis.k
        twist[2] = 1.0 - axis.n * axis.n
        twist[TILT_Y], twist[TILT_X] = -(about_h * sin + about_k * cos), about_h * cos - about_k * sin


@kernel
def set_held(machine, wheel, contact, state, bias):
    """What a sticking contact adds to the balance; bias (Slip): its slip acceleration without it, or its slip."""
    j = slip_jacobian(wheel, state.axis, state.contact)
    contact.mass[0], contact.mass[1], contact.mass[2] = holding_mass(machine, wheel, state.axis, j)
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
def set_moment(wheel, part, rollers, spin_rate, yaw_rate, spin_held):
    """What a wheel does to the body without its contacts, in the rows of the levers."""
    cos, sin = wheel.cos_heading, wheel.sin_heading
    rotor = 0.0 if spin_held else wheel.rotor_inertia / (wheel.axle_inertia + wheel.rotor_inertia)
    about_h = (
        wheel.axle_inertia * spin_rate * yaw_rate - rollers.bearing_h - spin_rate * rollers.g_n + yaw_rate * rollers.g_k
    )
    about_k = rotor * part.free_spin - part.drive_torque
    part.moment[2] = spin_rate * rollers.g_h - rollers.bearing_n
    part.moment[TILT_Y], part.moment[TILT_X] = -(about_h * sin + about_k * cos), about_h * cos - about_k * sin


@kernel
def set_external(machine, external, wrench, yaw_rate):
    """The wrench and the turning of S in the rows of the levers: (5,)."""
    lever, moment, turning = machine.lever, machine.moment, yaw_rate * yaw_rate
    external[0], external[1], external[2] = wrench.x, wrench.y, wrench.yaw
    external[TILT_Y] = -(lever[2] * wrench.x - lever[0] * wrench.z + turning * moment[0])
    external[TILT_X] = lever[1] * wrench.z - lever[2] * wrench.y - turning * moment[1]


@kernel
def assemble(machine, room, load):
    """Write the equations of the body into the room; load: M g - f_z, N."""
    balance, parts, carried = room.balance, room.parts, machine.upright == CONTACTS
    rows = 5 if carried else 3
    for i in range(6):
        for j in range(7):
            balance[i, j] = 0.0
    balance[0, 0] = balance[1, 1] = machine.mass
    balance[2, 2] = machine.yaw_inertia
    balance[3, 6] = load
    balance[1 + TILT_Y, 2], balance[1 + TILT_X, 2] = -machine.moment[1], machine.moment[0]
    for i in range(rows):
        add_known(balance, i, room.external[i])
    for w in range(len(parts)):
        part = parts[w]
        for i in range(2, rows):
            add_known(balance, i, part.moment[i])
        if not part.loaded:
            continue
        if carried:
            add_load(balance, part)
        for c in range(2 * w, 2 * w + part.contacts):
            contact = room.contacts[c]
            if part.contacts == 2:
                for i in range(rows):
                    add_known(balance, i, moment_of(contact, i, contact.force[0], contact.force[1], contact.torque))
            elif contact.rest and not part.sought:
                add_held(balance, contact, rows)
            else:
                add_sliding(balance, part, contact, rows, carried)


@kernel
def add_load(balance, part):
    """The normal force of a wheel in heave and tilt."""
    x, y = part.point[0], part.point[1]
    balance[3, 3] += 1.0
    balance[3, 4] += x
    balance[3, 5] += y
    balance[4, 3] += x
    balance[4, 4] += x * x
    balance[4, 5] += x * y
    balance[5, 3] += y
    balance[5, 4] += x * y
    balance[5, 5] += y * y


@kernel
def add_known(balance, row, value):
    """A force or moment on the body that is known: x, y and yaw have it on the right, tilt on the left."""
    if row < 3:
        balance[row, 6] += value
    else:
        balance[row + 1, 6] -= value


@kernel
def moment_of(contact, row, force_h, force_k, torque):
    """A contact's force (N) and torque (N m) in a row of the levers."""
    return contact.lever[row, 0] * force_h + contact.lever[row, 1] * force_k + contact.twist[row] * torque


@kernel
def add_sliding(balance, part, contact, rows, carried):
    """Friction constant + unit N of a contact that carries its wheel alone."""
    for i in range(rows):
        by_load = moment_of(contact, i, contact.unit[0], contact.unit[1], contact.unit_torque)
        known = contact.lever[i, 0] * contact.constant[0] + contact.lever[i, 1] * contact.constant[1]
        if not carried:
            known += by_load * part.normal_force
        add_known(balance, i, known)
        if carried:
            row, sign = (i, -1.0) if i < 3 else (i + 1, 1.0)
            balance[row, 3] += sign * by_load
            balance[row, 4] += sign * by_load * part.point[0]
            balance[row, 5] += sign * by_load * part.point[1]


@kernel
def add_held(balance, contact, rows):
    """Friction -E (b + J X) of a contact that sticks; J is the transpose of the first three rows of the levers."""
    mass, lever, bias = contact.mass, contact.lever, contact.bias
    force_h = mass[0] * bias[0] + mass[1] * bias[1]
    force_k = mass[1] * bias[0] + mass[2] * bias[1]
    for i in range(rows):
        add_known(balance, i, -lever[i, 0] * force_h - lever[i, 1] * force_k)
    for j in range(3):
        by_h = mass[0] * lever[j, 0] + mass[1] * lever[j, 1]
        by_k = mass[1] * lever[j, 0] + mass[2] * lever[j, 1]
        for i in range(rows):
            row, sign = (i, 1.0) if i < 3 else (i + 1, -1.0)
            balance[row, j] += sign * (lever[i, 0] * by_h + lever[i, 1] * by_k)


@kernel
def solve(machine, room):
    """The Acceleration of the body, normal forces into the room, and the determinant of the loads over that without
    friction.

    Gauss without pivoting: the plane part is symmetric and positive definite, so are the loads but for friction.
    """
    balance, parts = room.balance, room.parts
    if machine.upright != CONTACTS:
        eliminate(balance, 3, 7)
        return plane(balance), 1.0
    eliminate(balance, 6, 7)
    first = 1.0 / balance[3, 3]
    for i in range(4, 6):
        factor = balance[i, 3] * first
        for j in range(4, 7):
            balance[i, j] -= factor * balance[3, j]
    determinant = balance[4, 4] * balance[5, 5] - balance[4, 5] * balance[5, 4]
    b_1 = (balance[4, 6] * balance[5, 5] - balance[4, 5] * balance[5, 6]) / determinant
    b_2 = (balance[4, 4] * balance[5, 6] - balance[4, 6] * balance[5, 4]) / determinant
    b_0 = (balance[3, 6] - balance[3, 4] * b_1 - balance[3, 5] * b_2) * first
    xx, xy, yy = 0.0, 0.0, 0.0
    for w in range(len(parts)):
        part = parts[w]
        part.normal_force = b_0 + b_1 * part.point[0] + b_2 * part.point[1]
        if part.loaded:
            x, y = part.point[0] - balance[3, 4] * first, part.point[1] - balance[3, 5] * first
            xx, xy, yy = xx + x * x, xy + x * y, yy + y * y
    for i in range(3):
        balance[i, 6] -= balance[i, 3] * b_0 + balance[i, 4] * b_1 + balance[i, 5] * b_2
    return plane(balance), determinant / (xx * yy - xy * xy)


@kernel
def eliminate(balance, rows, columns):
    """Take the plane accelerations out of the rows below each of theirs."""
    for k in range(3):
        inverse = 1.0 / balance[k, k]
        for i in range(k + 1, rows):
            factor = balance[i, k] * inverse
            if factor != 0.0:
                for j in range(k + 1, columns):
                    balance[i, j] -= factor * balance[k, j]


@kernel
def plane(balance):
    """The Acceleration, from the eliminated rows and what stands on their right."""
    yaw = balance[2, 6] / balance[2, 2]
    y = (balance[1, 6] - balance[1, 2] * yaw) / balance[1, 1]
    return Acceleration((balance[0, 6] - balance[0, 1] * y - balance[0, 2] * yaw) / balance[0, 0], y, yaw)


@kernel
def servo(machine, room, yaw_acceleration):
    """Torque about chassis x and y that keeps the body upright, N m: what its moment equation lacks."""
    about_y = room.external[TILT_Y] - machine.moment[1] * yaw_acceleration
    about_x = room.external[TILT_X] + machine.moment[0] * yaw_acceleration
    for w in range(len(room.parts)):
        part = room.parts[w]
        about_y, about_x = about_y + part.moment[TILT_Y], about_x + part.moment[TILT_X]
        if part.loaded:
            about_y += part.normal_force * part.point[0]
            about_x += part.normal_force * part.point[1]
            for c in range(2 * w, 2 * w + part.contacts):
                contact = room.contacts[c]
                about_y += moment_of(contact, TILT_Y, contact.force[0], contact.force[1], contact.torque)
                about_x += moment_of(contact, TILT_X, contact.force[0], contact.force[1], contact.torque)
    return -about_x, about_y
