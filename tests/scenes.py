"""Scenes that tests share: the reference cases, packaged ones, and random single-wheel states."""

import json
from pathlib import Path

import numpy as np

import omnisim
from omnisim.parameters import pack
from omnisim.start import begin

REFERENCE = Path(__file__).parent / "reference"
REFERENCE_CASES = ("testbench_psi0", "testbench_psi30")


def reference_scene(name, *overrides):
    return omnisim.load(REFERENCE / f"{name}.toml", overrides)


def reference_data(name):
    """Converged states of a reference case, good to 1e-10: arrays by key, those by wheel name for the only wheel."""
    data = json.loads((REFERENCE / f"{name}.json").read_text())
    flat = {key: value["wheel"] if isinstance(value, dict) else value for key, value in data.items()}
    return {key: value if isinstance(value, str) else np.array(value) for key, value in flat.items()}


def simulate(name, *overrides):
    """Trajectory of a reference case that must reach its end."""
    trajectory = omnisim.simulate(reference_scene(name, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


def final_state(trajectory):
    """Position, yaw and spin angle in the last row."""
    wheel = trajectory.wheels[0]
    angles = [trajectory["body/yaw"][-1], trajectory[f"wheels/{wheel}/spin_angle"][-1]]
    return np.concatenate([trajectory["body/position"][-1, :2], angles])


def packed(scene):
    """Parameters and a Run at t = 0 of a scene."""
    parameters = pack(scene.config)
    return parameters, begin(scene.config, parameters)


def wheel_record(radius=0.1, roller_distance=0.068, rollers=4, psi_deg=30.0):
    """Record of Parameters.wheels with this geometry."""
    scene = reference_scene(
        "testbench_psi30",
        f"wheel_types.omni.radius={radius!r}",
        f"wheel_types.omni.roller_distance={roller_distance!r}",
        f"wheel_types.omni.roller_count={rollers}",
        f"wheel_types.omni.roller_angle_deg={psi_deg!r}",
    )
    return pack(scene.config).wheels[0]
