"""Upright by a servo: it takes roll and pitch by a torque of its own, and every wheel carries the same load.

N_w = (M g - f_z) / W          torque: what the rows of tilt lack
"""

from omnisim.base.kernel import kernel
from omnisim.dynamics.normal_forces.tilt import place_load, set_body_tilt, set_tilt, tilt_of


@kernel
def equal_load(load, wheels):
    """N of each of so many wheels; load: of all, N."""
    return load / wheels


@kernel
def find_servo(machine, workspace, motion):
    """The torque about chassis x and y that keeps the body upright, N m, into the workspace: what the rows of tilt
    lack with all forces and the Acceleration `motion` in them."""
    tilt = workspace.loads.tilt
    about_y = tilt[0, 0] * motion.x + tilt[0, 1] * motion.y + tilt[0, 2] * motion.yaw - tilt[0, 3]
    about_x = tilt[1, 0] * motion.x + tilt[1, 1] * motion.y + tilt[1, 2] * motion.yaw - tilt[1, 3]
    for w in range(len(workspace.parts)):
        part = workspace.parts[w]
        about_y, about_x = about_y + part.tilt[0], about_x + part.tilt[1]
        if not part.loaded:
            continue
        about_y += part.normal_force * part.point[0]
        about_x += part.normal_force * part.point[1]
        for c in range(part.first, part.first + part.contacts):
            contact = workspace.contacts[c]
            force, torque, normal = contact.force, contact.torque, contact.pressed
            more_y, more_x = tilt_of(machine, contact, force[0], force[1], torque, normal)
            about_y, about_x = about_y + more_y, about_x + more_x
    workspace.loads.servo[0], workspace.loads.servo[1] = -about_x, about_y


@kernel
def set_all_tilt(machine, wheels, workspace, wrench, yaw_rate):
    """The rows of tilt of the reduced formulation with those of its contacts, which the motion under known loads does
    not need."""
    set_body_tilt(machine, workspace.loads, wrench, yaw_rate)
    for w in range(len(wheels)):
        part = workspace.parts[w]
        place_load(wheels[w], workspace, w)
        for c in range(part.first, part.first + part.contacts):
            set_tilt(machine, wheels[w], workspace.contacts[c], part.contacts == 2)
