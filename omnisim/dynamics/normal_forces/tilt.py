"""Roll and pitch: two rows of moments about C, which whoever provides the normal forces has to balance.

    sum N D x n - z_C n x sum F + (r x f)_h + theta'' S + theta'^2 n x S
        = sum (tau - J_r phi'' - R F_h) k + (-J_k phi' theta' + sum Ia p' a_h + phi' G_n - theta' G_k) h

where J_k phi'' + sum Ia p' s + theta' G_h = tau - J_r phi'' - R F_h has been used (J_r: rotor of the motor). On an
inclined floor what of gravity lies along it acts at C, and gives no moment.
"""

from omnisim.base.kernel import kernel
from omnisim.contact.frame import Slip, frame_on_chassis, outward

TILT_Y, TILT_X = 3, 4  # rows of levers and pushes, about -y and about x, after x, y and yaw


@kernel
def set_tilt(machine, wheel, contact, spin_held):
    """The levers of a contact in the rows of tilt: about -y and about x."""
    axis_h, axis_k, axis_n = contact.axis[0], contact.axis[1], contact.axis[2]
    arm, spin = contact.arm, contact.spin
    rotor = rotor_part(wheel, spin_held)
    above = wheel.radius - machine.height
    height = machine.height
    h_h, h_k = -axis_h * arm[0], height - axis_h * arm[1]  # about h by F_h and F_k, and about k
    k_h, k_k = above + rotor * spin[0], rotor * spin[1]
    lever, twist = contact.lever, contact.twist
    lever[TILT_Y, 0], lever[TILT_X, 0] = tilt_rows(wheel, h_h, k_h)
    lever[TILT_Y, 1], lever[TILT_X, 1] = tilt_rows(wheel, h_k, k_k)
    if machine.patch_radius > 0.0:
        twist[TILT_Y], twist[TILT_X] = tilt_rows(wheel, -axis_n * axis_h, -rotor * axis_n * axis_k)
    if machine.rolling:
        resisting = contact.resisting
        about_h = contact.moment[0] - axis_h * contact.rolling
        resisting[TILT_Y], resisting[TILT_X] = tilt_rows(wheel, about_h, rotor * contact.turning)


@kernel
def tilt_rows(wheel, about_h, about_k):
    """A moment about a wheel's h and k in the rows of tilt: about -y and about x."""
    moment = outward(frame_on_chassis(wheel), Slip(about_h, about_k))
    return -moment.y, moment.x


@kernel
def rotor_part(wheel, spin_held):
    """Part of the torque on an axle that the chassis does not feel, 1: that which turns the rotor of its motor.

    Of a drive that follows angles all of it: the chassis feels what turns the disk as they say, J_k phi''.
    """
    return 0.0 if spin_held else wheel.rotor_part


@kernel
def place_load(wheel, workspace, w):
    """Where the load of wheel w acts: between its contacts as they share it."""
    part = workspace.parts[w]
    along = 0.0
    for c in range(part.first, part.first + part.contacts):
        along += workspace.contacts[c].share * workspace.contacts[c].l
    set_point(wheel, part, along)


@kernel
def set_point(wheel, part, along):
    """Where the load of a wheel acts: `along` from its centre, along the axle, m."""
    ahead, aside = wheel.offset[0], wheel.offset[1] + along
    part.point[0], part.point[1] = outward(frame_on_chassis(wheel), Slip(ahead, aside))


@kernel
def set_body_tilt(machine, loads, wrench, yaw_rate):
    """The rows of tilt of the machine without its wheels: the wrench, and the turning of S."""
    by_y, by_x = external_tilt(machine, wrench, yaw_rate)
    about_y, about_x = loads.tilt[0], loads.tilt[1]
    about_y[0], about_y[1], about_y[2], about_y[3] = 0.0, 0.0, -machine.moment[1], -by_y
    about_x[0], about_x[1], about_x[2], about_x[3] = 0.0, 0.0, machine.moment[0], -by_x


@kernel
def external_tilt(machine, wrench, yaw_rate):
    """The wrench and the turning of S in the rows of tilt: about -y and about x."""
    lever = machine.lever
    moment = machine.moment
    turning = yaw_rate * yaw_rate
    about_y = lever[2] * wrench.x - lever[0] * wrench.z + turning * moment[0]
    return -about_y, lever[1] * wrench.z - lever[2] * wrench.y - turning * moment[1]


@kernel
def tilt_holding(row, contact, i):
    """A row of tilt with a sticking contact; i: its row of the levers."""
    by_h = contact.lever[i, 0]
    by_k = contact.lever[i, 1]
    holding = contact.holding
    for j in range(3):
        row[j] += by_h * holding[0, j] + by_k * holding[1, j]
    row[3] -= by_h * holding[0, 3] + by_k * holding[1, 3]


@kernel
def tilt_of(machine, contact, force_h, force_k, torque, normal):
    """A contact's force (N) and torque (N m), and its rolling resistance by the normal force (N), in the rows of tilt:
    about -y and about x, N m."""
    lever = contact.lever
    y = lever[TILT_Y, 0] * force_h + lever[TILT_Y, 1] * force_k
    x = lever[TILT_X, 0] * force_h + lever[TILT_X, 1] * force_k
    if machine.patch_radius > 0.0:
        y, x = y + contact.twist[TILT_Y] * torque, x + contact.twist[TILT_X] * torque
    if machine.rolling:
        y, x = y + contact.resisting[TILT_Y] * normal, x + contact.resisting[TILT_X] * normal
    return y, x
