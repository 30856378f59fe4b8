"""Scenes that tests share: the reference cases, packaged ones, and random single-wheel states."""

import json
from pathlib import Path

import numpy as np

import omnisim
from omnisim.base.records import blank
from omnisim.base.status import EVENTS_PER_STEP
from omnisim.dynamics.packing import pack
from omnisim.march.event_log import EVENT
from omnisim.march.initial_state import begin
from omnisim.march.onset import stand

REFERENCE = Path(__file__).parents[1] / "reference"
REFERENCE_CASES = ("testbench_psi0", "testbench_psi30")
REFERENCE_MACHINES = ("kiwi", "mecanum")


def reference_scene(name, *overrides):
    return omnisim.load(REFERENCE / f"{name}.toml", overrides)


def reference_data(name):
    """Converged states of a reference case, good to 1e-10: arrays by key, as columns where there is one for each wheel.

    The only wheel has no column of its own. `exchange_wheels` names the wheels of a vehicle's exchanges.
    """
    data = json.loads((REFERENCE / f"{name}.json").read_text())
    wheels = [wheel.name for wheel in reference_scene(name).config.wheels]
    by_wheel = {key: [value[wheel] for wheel in wheels] for key, value in data.items() if isinstance(value, dict)}
    if len(wheels) == 1:
        data |= {key: values[0] for key, values in by_wheel.items()}
    else:
        data |= {key: np.transpose(values) for key, values in by_wheel.items()}
    if len(wheels) > 1 and "exchange_times" in data:
        data["exchange_times"], data["exchange_wheels"] = zip(*data["exchange_times"], strict=True)
    return {key: value if isinstance(value, str) else np.array(value) for key, value in data.items()}


def final_reference(name):
    """What `final_state` converges to."""
    data = reference_data(name)
    return np.array([*data["position"][-1], data["yaw"][-1], *np.atleast_1d(data["spin_angle"][-1])])


def simulate(name, *overrides):
    """Trajectory of a reference case that must reach its end."""
    trajectory = omnisim.simulate(reference_scene(name, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


def of_wheels(trajectory, path):
    """A dataset of every wheel, as columns."""
    return np.stack([trajectory[f"wheels/{wheel}/{path}"] for wheel in trajectory.wheels], axis=1)


def final_state(trajectory):
    """Position, yaw and spin angles in the last row."""
    spin_angles = of_wheels(trajectory, "spin_angle")[-1]
    return np.array([*trajectory["body/position"][-1, :2], trajectory["body/yaw"][-1], *spin_angles])


def packed(scene):
    """Parameters and a Run at t = 0 of a scene."""
    parameters = pack(scene.config)
    return parameters, begin(scene.config, parameters)


def standing(scene):
    """The same with the modes of t = 0 and their derivative."""
    parameters, run = packed(scene)
    stand(parameters, run, blank(EVENT, 4 * EVENTS_PER_STEP))
    return parameters, run


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
