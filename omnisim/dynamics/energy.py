"""Energy of a machine by its state, alike for one state in a march and, in NumPy, for T of them as columns (n, T)."""

from omnisim.base.kernel import kernel
from omnisim.dynamics.state import X, Y


@kernel
def kinetic_energy(parameters, at, y, rates):
    """Of all bodies, J; at: Places of the state; rates (W, N) or (W, N, T): absolute axial rates of all rollers as they
    are now, rad/s.

    M V^2 / 2 + I_z theta'^2 / 2 + sum (J_k + J_r) phi'^2 / 2 + sum Ia p^2 / 2.
    """
    machine = parameters.machine
    spins = 0.0
    rollers = 0.0
    body = machine.mass * (y[at.velocity] ** 2 + y[at.velocity + 1] ** 2) + machine.yaw_inertia * y[at.yaw_rate] ** 2
    for w in range(len(parameters.wheels)):
        wheel = parameters.wheels[w]
        squares = 0.0
        for i in range(wheel.rollers):
            squares = squares + rates[w, i] ** 2
        spins = spins + (wheel.axle_inertia + wheel.rotor_inertia) * y[at.spin_rate + w] ** 2
        rollers = rollers + wheel.axial_inertia * squares
    return 0.5 * (body + spins + rollers)


@kernel
def potential_energy(machine, y):
    """Of all bodies in gravity, J: -M g . r_C from the world's origin, the constant part included."""
    along = machine.downhill[0] * y[X] + machine.downhill[1] * y[Y]
    return machine.mass * (machine.gravity * machine.height - along)
