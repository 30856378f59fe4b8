"""Upright by its contacts, rigid: wheels carry roll and pitch by loads that lie on a plane over the chassis.

Three wheels: any load; more: a rigid chassis on equal springs. With the equations of planar_body.py six linear
equations:

    unknowns   A_x, A_y (of C along chassis axes), theta''      b_0, b_1, b_2:   N_w = b_0 + b_1 x_w + b_2 y_w

    rows       M A = sum F + f + M g_t                          sum N = M g - f_z
               I_z theta'' = sum lever . F + ...                roll and pitch, tilt.py

On an inclined floor g is what of gravity is normal to it; what lies along it, g_t, acts at C.
"""

from typing import NamedTuple

from omnisim.base.kernel import kernel
from omnisim.dynamics.normal_forces.tilt import TILT_X, TILT_Y, tilt_of
from omnisim.dynamics.planar_body import holds, push_of, yielding
from omnisim.dynamics.twist import Acceleration

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


class Carried(NamedTuple):
    """What wheels carry: their Pushes by the loads, the rows of Tilt about -y and about x without the loads themselves,
    and the LoadedPlaces."""

    pushes: Pushes
    about_y: Tilt
    about_x: Tilt
    places: LoadedPlaces


@kernel
def share_out(workspace, load, mobility, motion, carried):
    """Normal forces into the workspace; the Acceleration with them, and how regular the loads are.

    load: of all wheels, N; motion: the Acceleration without loads; carried: by all wheels. Regular: the determinant of
    the equations of the loads over that without friction.
    """
    pushes, places = carried.pushes, carried.places
    about_y = standing(carried.about_y, places.x, places.xx, places.xy)
    about_x = standing(carried.about_x, places.y, places.xy, places.yy)
    by_0 = yielding(mobility, pushes.x.one, pushes.y.one, pushes.yaw.one)  # the acceleration by b_0, b_1 and b_2
    by_1 = yielding(mobility, pushes.x.x, pushes.y.x, pushes.yaw.x)
    by_2 = yielding(mobility, pushes.x.y, pushes.y.y, pushes.yaw.y)
    share = 1.0 / places.count
    x = places.x * share
    y = places.y * share
    mean = load * share
    a_1, a_2, a = reduced(about_y, (by_0, by_1, by_2), motion, x, y, mean)
    c_1, c_2, c = reduced(about_x, (by_0, by_1, by_2), motion, x, y, mean)
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
    return total, determinant / (xx * yy - xy * xy)


@kernel
def reduced(row, by, motion, x, y, mean):
    """A Tilt without the acceleration and b_0: by b_1, by b_2, and its right side.

    by: the Accelerations by b_0, b_1 and b_2; motion: that without loads; x, y: mean place of the loaded wheels, m;
    mean: their mean load, N.
    """
    by_0, by_1, by_2 = by
    first = row.loads.one + row.x * by_0.x + row.y * by_0.y + row.yaw * by_0.yaw
    second = row.loads.x + row.x * by_1.x + row.y * by_1.y + row.yaw * by_1.yaw
    third = row.loads.y + row.x * by_2.x + row.y * by_2.y + row.yaw * by_2.yaw
    right = row.right - row.x * motion.x - row.y * motion.y - row.yaw * motion.yaw
    return second - first * x, third - first * y, right - first * mean


@kernel
def nothing_carried(workspace):
    """What is Carried without any wheel."""
    nothing, tilt = ByLoad(0.0, 0.0, 0.0), workspace.loads.tilt
    about_y = Tilt(tilt[0, 0], tilt[0, 1], tilt[0, 2], nothing, tilt[0, 3])
    about_x = Tilt(tilt[1, 0], tilt[1, 1], tilt[1, 2], nothing, tilt[1, 3])
    return Carried(Pushes(nothing, nothing, nothing), about_y, about_x, LoadedPlaces(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


@kernel
def carry(machine, workspace, carried, sought):
    """What is Carried by more wheels: those whose forces are sought (1), or all others (0)."""
    pushes, about_y, about_x, places = carried
    push_x, push_y, push_yaw = pushes
    count, s_x, s_y, s_xx, s_xy, s_yy = places
    for w in range(len(workspace.parts)):
        part = workspace.parts[w]
        if part.sought != sought:
            continue
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
                force, torque, normal = contact.force, contact.torque, contact.pressed
                by_y, by_x = tilt_of(machine, contact, force[0], force[1], torque, normal)
                about_y, about_x = resisted(about_y, by_y), resisted(about_x, by_x)
            elif workspace.resting is None or not holds(part, contact) or machine.rolling:
                force_h = contact.unit[0]
                force_k = contact.unit[1]
                torque = contact.unit_torque
                along_x, along_y, turn = push_of(machine, contact, force_h, force_k, torque, 1.0)
                by_y, by_x = tilt_of(machine, contact, force_h, force_k, torque, 1.0)
                push_x, push_y = loaded(push_x, along_x, x, y), loaded(push_y, along_y, x, y)
                push_yaw = loaded(push_yaw, turn, x, y)
                about_y, about_x = pressed(about_y, by_y, x, y), pressed(about_x, by_x, x, y)
                if machine.viscous:
                    by_y, by_x = tilt_of(machine, contact, contact.constant[0], contact.constant[1], 0.0, 0.0)
                    about_y, about_x = resisted(about_y, by_y), resisted(about_x, by_x)
    return Carried(Pushes(push_x, push_y, push_yaw), about_y, about_x, LoadedPlaces(count, s_x, s_y, s_xx, s_xy, s_yy))


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
