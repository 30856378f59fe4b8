"""The machine at rest: what each wheel carries."""

import numpy as np

from omnisim.parameters import CONTACTS, Parameters


def static_loads(parameters: Parameters, lift: float = 0.0) -> np.ndarray:
    """Normal forces (W,) at standstill, N, under a vertical force `lift` (N, upwards) at the common centre of mass C.

    Each acts below the wheel centre, the mean of where rollers touch. Contacts that carry roll and pitch have loads on
    a plane over the chassis that balance about C; wheels that it would pull down are off the floor.
    """
    machine, wheels = parameters.machine, parameters.wheels
    load = max(machine.mass * machine.gravity - lift, 0.0)
    if machine.upright != CONTACTS:
        return np.full(len(wheels), load / len(wheels))
    heading = np.array([wheels.cos_heading, wheels.sin_heading])
    along, across = wheels.offset.T  # of the wheel centres from C along h and k
    x, y = along * heading + across * np.array([-heading[1], heading[0]])
    places, loads = np.column_stack([np.ones(len(wheels)), x, y]), np.zeros(len(wheels))
    standing = np.arange(len(wheels))
    while True:
        on = places[standing]
        plane = np.linalg.pinv(on.T @ on) @ (load, 0.0, 0.0)
        if (on @ plane >= 0.0).all() or len(standing) <= 3:
            loads[standing] = np.maximum(on @ plane, 0.0)
            return loads
        standing = np.delete(standing, np.argmin(on @ plane))
