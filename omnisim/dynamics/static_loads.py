"""The machine at rest: what each wheel carries."""

import math

import numpy as np

from omnisim.dynamics.parameters import SERVO, Parameters


def static_loads(parameters: Parameters, lift: float = 0.0, yaw: float = 0.0) -> np.ndarray:
    """Normal forces (W,) at standstill, N, under a force `lift` (N) away from the floor at the common centre of mass C;
    yaw (rad): of the machine, which tells its wheels uphill from those downhill."""
    machine = parameters.machine
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    x, y = machine.mass * np.asarray(machine.downhill)
    return loads_under(parameters, machine.mass * machine.gravity - lift, (x * cos + y * sin, y * cos - x * sin))


def loads_under(parameters: Parameters, load: float, push: tuple[float, float]) -> np.ndarray:
    """Normal forces (W,), N, of a machine at rest under a force at C: `load` (N) onto the floor, `push` (N) along it in
    chassis axes, which friction holds.

    Each acts below the middle of the wheel's rows, the mean of where rollers touch. Contacts that carry roll and pitch
    have loads on a plane over the chassis that balance about C; wheels that it would pull down are off the floor.
    """
    machine, wheels = parameters.machine, parameters.wheels
    load = max(load, 0.0)
    if machine.upright == SERVO:
        return np.full(len(wheels), load / len(wheels))
    places = np.column_stack([np.ones(len(wheels)), *centres(parameters)])
    loads = np.zeros(len(wheels))
    standing = np.arange(len(wheels))
    while True:
        on = places[standing]
        plane = np.linalg.pinv(on.T @ on) @ (load, machine.height * push[0], machine.height * push[1])
        if (on @ plane >= 0.0).all() or len(standing) <= 3:
            loads[standing] = np.maximum(on @ plane, 0.0)
            return loads
        standing = np.delete(standing, np.argmin(on @ plane))


def centres(parameters: Parameters) -> np.ndarray:
    """The middle of each wheel's rows from C, chassis axes (2, W), m."""
    wheels, offsets = parameters.wheels, parameters.roller_rows.offset
    heading = np.array([wheels.cos_heading, wheels.sin_heading])
    along, across = wheels.offset.T
    across = across + [offsets[wheel.row : wheel.row + wheel.rows].mean() for wheel in wheels]
    return along * heading + across * np.array([-heading[1], heading[0]])
