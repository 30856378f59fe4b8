"""What the floor carries: heave, roll and pitch of the machine, by a load that lies on a plane over the chassis.

Three wheels: any load; more: a rigid chassis on equal springs. With the equations of planar_body.py six linear
equations:

    unknowns   A_x, A_y (of C along chassis axes), theta''      b_0, b_1, b_2:   N_w = b_0 + b_1 x_w + b_2 y_w

    rows       M A = sum F + f + M g_t                          sum N = M g - f_z
               I_z theta'' = sum lever . F + ...                tilt about y and x, below

    tilt       sum N D x n - z_C n x sum F + (r x f)_h + theta'' S + theta'^2 n x S
                   = sum (tau - J_r phi'' - R F_h) k + (-J_k phi' theta' + sum Ia p' a_h + phi' G_n - theta' G_k) h

where J_k phi'' + sum Ia p' s + theta' G_h = tau - J_r phi'' - R F_h has been used (J_r: rotor of the motor). With
upright = "servo" the load is known and tilt is the servo's. On an inclined floor g is what of gravity is normal to it;
what lies along it, g_t, acts at C, about which the moments are taken.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel, merged
from omnisim.contact.friction import VISCOUS
from omnisim.dynamics.parameters import CONTACTS
from omnisim.dynamics.planar_body import (
    Acceleration,
    balanced_equations,
    held_equations,
    holds,
    inverse,
    push_of,
    yielding,
)

TILT_Y, TILT_X = 3, 4  # rows of levers and pushes, about -y and about x, after x, y and yaw
LEAST_REGULAR = 1e-2  # determinant of the loads over that without friction, below which friction jams


class ByLoad(NamedTuple):
    """What the loads b_0, b_1 and b_2 do to a row."""

    one: float
    x: float
    y: float


class Pushes(NamedTuple):
    """What they do to the equations of the body."""

    x: ByLoad
    y: ByLoad
    yaw: ByLoad


class Tilt(NamedTuple):
    """A row of tilt: by the acceleration (x, y, yaw), by the loads, and its right side; SI."""

    x: float
    y: float
    yaw: float
    loads: ByLoad
    right: float


class LoadedPlaces(NamedTuple):
    """Sums of 1, x, y, x^2, x y and y^2 over the loaded wheels, m."""

    count: float  # type: ignore[assignment]  # in the place of tuple.count
    x: float
    y: float
    xx: float
    xy: float
    yy: float


@kernel
def set_tilt(machine, wheel, contact, spin_held):
    """The levers of a contact in the rows of tilt: about -y and about x."""
    axis_h, axis_k, axis_n = contact.axis[0], contact.axis[1], contact.axis[2]
    arm, spin = contact.arm, contact.spin
    rotor = rotor_part(wheel, spin_held)
    above, height = wheel.radius - machine.height, machine.height
    h_h, h_k = -axis_h * arm[0], height - axis_h * arm[1]  # about h by F_h and F_k, and about k
    k_h, k_k = above + rotor * spin[0], rotor * spin[1]
    lever, twist = contact.lever, contact.twist
    lever[TILT_Y, 0], lever[TILT_X, 0] = tilt_rows(wheel, h_h, k_h)
    lever[TILT_Y, 1], lever[TILT_X, 1] = tilt_rows(wheel, h_k, k_k)
    if machine.patch_radius > 0.0:
        twist[TILT_Y], twist[TILT_X] = tilt_rows(wheel, -axis_n * axis_h, -rotor * axis_n * axis_k)


@kernel
def tilt_rows(wheel, about_h, about_k):
    """A moment about a wheel's h and k in the rows of tilt: about -y and about x."""
    cos, sin = wheel.cos_heading, wheel.sin_heading
    return -(about_h * sin + about_k * cos), about_h * cos - about_k * sin


@kernel
def rotor_part(wheel, spin_held):
    """Part of the torque on an axle that turns the rotor of its motor, 1."""
    return 0.0 if spin_held else wheel.rotor_inertia * wheel.spin_mobility


@kernel
def place_load(wheel, workspace, w):
    """Where the load of wheel w acts: between its contacts as they share it."""
    part, along = workspace.parts[w], 0.0
    for c in range(part.first, part.first + part.contacts):
        along += workspace.contacts[c].share * workspace.contacts[c].l
    set_point(wheel, part, along)


@kernel
def set_point(wheel, part, along):
    """Where the load of a wheel acts: `along` from its centre, along the axle, m."""
    ahead, aside = wheel.offset[0], wheel.offset[1] + along
    part.point[0] = ahead * wheel.cos_heading - aside * wheel.sin_heading
    part.point[1] = ahead * wheel.sin_heading + aside * wheel.cos_heading


@kernel
def set_body_tilt(machine, loads, wrench, yaw_rate):
    """The rows of tilt of the machine without its wheels: the wrench, and the turning of S."""
    by_y, by_x = external_tilt(machine, wrench, yaw_rate)
    about_y, about_x = loads.tilt[0], loads.tilt[1]
    about_y[0], about_y[1], about_y[2], about_y[3] = 0.0, 0.0, -machine.moment[1], -by_y
    about_x[0], about_x[1], about_x[2], about_x[3] = 0.0, 0.0, machine.moment[0], -by_x


@kernel
def held_body(machine, loads, contact, equations):
    """BodyEquations with a sticking contact, which goes into the rows of tilt as well."""
    if machine.upright == CONTACTS:
        tilt_holding(loads.tilt[0], contact, TILT_Y)
        tilt_holding(loads.tilt[1], contact, TILT_X)
    return held_equations(contact, equations)


@kernel
def tilt_holding(row, contact, i):
    """A row of tilt with a sticking contact; i: its row of the levers."""
    by_h, by_k, holding = contact.lever[i, 0], contact.lever[i, 1], contact.holding
    for j in range(3):
        row[j] += by_h * holding[0, j] + by_k * holding[1, j]
    row[3] -= by_h * holding[0, 3] + by_k * holding[1, 3]


@kernel
def external_tilt(machine, wrench, yaw_rate):
    """The wrench and the turning of S in the rows of tilt: about -y and about x."""
    lever, moment, turning = machine.lever, machine.moment, yaw_rate * yaw_rate
    about_y = lever[2] * wrench.x - lever[0] * wrench.z + turning * moment[0]
    return -about_y, lever[1] * wrench.z - lever[2] * wrench.y - turning * moment[1]


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
def solve(machine, workspace, load, equations, pushing):
    """The Acceleration of the body, its Mobility, and how regular the loads are; normal forces into the workspace.

    load: M g - f_z, N; plane: what is known at once; pushing: whether some contact pushes by a load that is known, or
    without. Regular: the determinant of the equations of the loads over that without friction.
    """
    if pushing:
        equations = balanced_equations(machine, workspace, equations)
    mobility = inverse(machine, equations)
    motion = yielding(mobility, equations.x, equations.y, equations.yaw)
    if machine.upright != CONTACTS:
        return motion, mobility, 1.0
    return share_out(machine, workspace, load, mobility, motion)


@merged
def share_out(machine, workspace, load, mobility, motion):
    """What `solve` returns when the contacts carry roll and pitch; motion: the Acceleration without the loads."""
    pushes, about_y, about_x, places = carry(machine, workspace)
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
    for w in range(len(workspace.parts)):
        part = workspace.parts[w]
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
def carry(machine, workspace):
    """What the loads do to the body: Pushes, the rows of Tilt about -y and about x, and the LoadedPlaces."""
    nothing, tilt = ByLoad(0.0, 0.0, 0.0), workspace.loads.tilt
    push_x, push_y, push_yaw = nothing, nothing, nothing
    about_y = Tilt(tilt[0, 0], tilt[0, 1], tilt[0, 2], nothing, tilt[0, 3])
    about_x = Tilt(tilt[1, 0], tilt[1, 1], tilt[1, 2], nothing, tilt[1, 3])
    count, s_x, s_y, s_xx, s_xy, s_yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for w in range(len(workspace.parts)):
        part = workspace.parts[w]
        about_y, about_x = resisted(about_y, part.tilt[0]), resisted(about_x, part.tilt[1])
        if not part.loaded:
            continue
        x, y = part.point[0], part.point[1]
        count, s_x, s_y = count + 1.0, s_x + x, s_y + y
        s_xx, s_xy, s_yy = s_xx + x * x, s_xy + x * y, s_yy + y * y
        if part.slides:
            push = part.push
            push_x, push_y = loaded(push_x, push[0], x, y), loaded(push_y, push[1], x, y)
            push_yaw = loaded(push_yaw, push[2], x, y)
            about_y, about_x = pressed(about_y, push[TILT_Y], x, y), pressed(about_x, push[TILT_X], x, y)
            continue
        for c in range(part.first, part.first + part.contacts):
            contact = workspace.contacts[c]
            if part.contacts == 2:
                by_y, by_x = tilt_of(machine, contact, contact.force[0], contact.force[1], contact.torque)
                about_y, about_x = resisted(about_y, by_y), resisted(about_x, by_x)
            elif workspace.resting is None or not holds(part, contact):
                force_h, force_k, torque = contact.unit[0], contact.unit[1], contact.unit_torque
                along_x, along_y, turn = push_of(machine, contact, force_h, force_k, torque)
                by_y, by_x = tilt_of(machine, contact, force_h, force_k, torque)
                push_x, push_y = loaded(push_x, along_x, x, y), loaded(push_y, along_y, x, y)
                push_yaw = loaded(push_yaw, turn, x, y)
                about_y, about_x = pressed(about_y, by_y, x, y), pressed(about_x, by_x, x, y)
                if machine.law == VISCOUS:
                    by_y, by_x = tilt_of(machine, contact, contact.constant[0], contact.constant[1], 0.0)
                    about_y, about_x = resisted(about_y, by_y), resisted(about_x, by_x)
    return (
        Pushes(push_x, push_y, push_yaw),
        standing(about_y, s_x, s_xx, s_xy),
        standing(about_x, s_y, s_xy, s_yy),
        LoadedPlaces(count, s_x, s_y, s_xx, s_xy, s_yy),
    )


@kernel
def loaded(by_load, push, x, y):
    """A ByLoad with one more push by the load at x, y (m)."""
    return ByLoad(by_load.one + push, by_load.x + push * x, by_load.y + push * y)


@kernel
def pressed(row, push, x, y):
    """A Tilt with one more push by the load at x, y (m)."""
    return Tilt(row.x, row.y, row.yaw, loaded(row.loads, push, x, y), row.right)


@kernel
def standing(row, one, x, y):
    """A Tilt with the loads themselves; one, x, y: sums of their levers, and of those times their places."""
    loads = row.loads
    return Tilt(row.x, row.y, row.yaw, ByLoad(loads.one + one, loads.x + x, loads.y + y), row.right)


@kernel
def resisted(row, moment):
    """A Tilt with one more moment that does not depend on the unknowns, N m."""
    return Tilt(row.x, row.y, row.yaw, row.loads, row.right - moment)


@kernel
def servo(machine, wheels, workspace, wrench, yaw_rate, yaw_acceleration):
    """Torque about chassis x and y that keeps the body upright, N m: what its moment equation lacks."""
    about_y, about_x = external_tilt(machine, wrench, yaw_rate)
    about_y, about_x = about_y - machine.moment[1] * yaw_acceleration, about_x + machine.moment[0] * yaw_acceleration
    for w in range(len(workspace.parts)):
        part = workspace.parts[w]
        about_y, about_x = about_y + part.tilt[0], about_x + part.tilt[1]
        if not part.loaded:
            continue
        place_load(wheels[w], workspace, w)
        about_y += part.normal_force * part.point[0]
        about_x += part.normal_force * part.point[1]
        for c in range(part.first, part.first + part.contacts):
            contact = workspace.contacts[c]
            set_tilt(machine, wheels[w], contact, part.contacts == 2)
            more_y, more_x = tilt_of(machine, contact, contact.force[0], contact.force[1], contact.torque)
            about_y, about_x = about_y + more_y, about_x + more_x
    return -about_x, about_y
