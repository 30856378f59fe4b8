"""Multipliers of the constraints: the floor's normal force and the servo's torque."""

from omnisim.kernel import kernel


@kernel
def normal_force(machine, wheels, force_z):
    """N of each wheel, N, when the servo carries roll and pitch: (M g - f_z) / W.

    Negative when the external force lifts the wheel: the march stops before it is used.
    """
    return (machine.mass * machine.gravity - force_z) / wheels


@kernel
def servo_torque(wheel, rollers, spin_rate, yaw_rate):
    """lambda of a bare wheel, N m: the torque about h = k x n that keeps the wheel upright, from its moment balance.

    lambda = -J_k phi' theta' + sum Ia p_i' a_h + phi' G_n - theta' G_k - sum (l N + R F_k), of which this is what does
    not come from the contacts.
    """
    gyroscopic = -wheel.axle_inertia * spin_rate * yaw_rate + spin_rate * rollers.g_n - yaw_rate * rollers.g_k
    return gyroscopic + rollers.bearing_h


@kernel
def servo_load(wheel, reaction, normal):
    """Share of a contact with the normal force `normal` (N) in lambda, N m."""
    load = -reaction.state.contact.l * normal - wheel.radius * reaction.force.k
    return reaction.roller_torque * reaction.state.axis.h + load
