"""Machines for tests: scenes as dictionaries to change, their mirror images, and random ones."""

import json
import tomllib

import numpy as np
from scenes import REFERENCE

import omnisim
from omnisim.scene import Scene, packaged_scenes, parse

TYPES = {
    "mecanum": {
        "radius": 0.0475, "roller_distance": 0.036, "roller_count": 6, "roller_angle_deg": 45.0,
        "disk": {"mass": 0.4, "inertia_axle": 4.2e-4, "inertia_diameter": 2.4e-4},
        "roller": {"mass": 0.05, "inertia_axial": 3.1e-6, "inertia_transverse": 1.2e-5},
    },
    "omni": {
        "radius": 0.0625, "roller_distance": 0.053, "roller_count": 10, "roller_angle_deg": 0.0,
        "disk": {"mass": 0.3, "inertia_axle": 3.75e-4, "inertia_diameter": 2.1e-4},
        "roller": {"mass": 0.02, "inertia_axial": 7.6e-7, "inertia_transverse": 2.4e-6},
    },
}  # fmt: skip


def tables(name: str) -> dict:
    """A packaged scene, or else a reference case, as a dictionary."""
    text = omnisim.load(name).text if name in packaged_scenes() else (REFERENCE / f"{name}.toml").read_text()
    return tomllib.loads(text)


def scene(data: dict, *overrides: str) -> Scene:
    return parse("\n".join(f"{key} = {toml(value)}" for key, value in data.items()), overrides=overrides)


def toml(value) -> str:
    """A value as TOML on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(map(toml, value)) + "]"
    return repr(float(value)) if isinstance(value, float) else json.dumps(value)


def run(data: dict, *overrides: str):
    """Trajectory of a scene that must reach its end."""
    trajectory = omnisim.simulate(scene(data, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory
