"""Machines free in space for tests: scenes of machines.py whose rollers are of rubber."""

import copy

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
