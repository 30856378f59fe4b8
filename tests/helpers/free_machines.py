"""Machines free in space for tests: scenes of machines.py whose rollers are of rubber."""

import copy

import numpy as np
from machines import CHASSIS, wheel_mass

STIFFNESS = 2e5  # N/m


def free(data: dict, stiffness: float = STIFFNESS, damping: float = 0.0) -> dict:
    """A scene of machines.py, free in space, with this rubber on all its wheels."""
    data = copy.deepcopy(data)
    data["scene"] = data.get("scene", {}) | {"upright": "free"}
    for kind in data["wheel_types"].values():
        kind["contact"] = {"stiffness": float(stiffness), "damping": float(damping)}
    return data


def whole_mass(data: dict) -> float:
    """Of a machine of `machine`, kg."""
    return data.get("chassis", CHASSIS)["mass"] + sum(wheel_mass(wheel["type"]) for wheel in data["wheels"])


def rotations(motion) -> np.ndarray:
    """(T, 3, 3): chassis axes as columns."""
    w, x, y, z = motion["body/orientation"].T
    columns = [
        [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
        [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
        [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(columns), -1, 0).swapaxes(1, 2)
