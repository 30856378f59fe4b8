"""What the tests of the oracle share: reference trajectories, and the power that the motion takes."""

import json
import tomllib
from pathlib import Path

import numpy as np

from oracle.machine import Machine, Reactions
from oracle.multibody import simulate
from oracle.vectors import OMEGA, ROTATION, VELOCITY

REFERENCE = Path(__file__).parents[1] / "reference"
# as good as the reference is; a row of testbench_psi0 lies 1 ms after an exchange, where roller rates change
# by 1700 rad/s^2
BOUNDS = {"position": 1e-10, "yaw": 1e-10, "spin_angle": 1e-10, "velocity": 5e-10, "yaw_rate": 5e-10}
BOUNDS |= {"spin_rate": 5e-10, "roller_axial_rate": 2e-8}


def load(name: str) -> tuple[dict, dict]:
    scene = tomllib.loads((REFERENCE / f"{name}.toml").read_text())
    return scene, json.loads((REFERENCE / f"{name}.json").read_text())


def agree(name: str, end: float) -> None:
    """The oracle follows the rows of a reference up to `end` and the exchanges before, of which there are some."""
    scene, reference = load(name)
    times = [time for time in reference["time"] if time <= end + 1e-9]
    motion = simulate(scene, times)
    wheels = motion.get("wheels", {"wheel": motion})
    for key in BOUNDS.keys() & reference.keys():
        expected, found = {"": reference[key]}, {"": motion}
        if isinstance(reference[key], dict):
            expected, found = reference[key], wheels
        for wheel, rows in expected.items():
            rows, of = rows[: len(times)], f"{key} {wheel}"
            np.testing.assert_allclose(found[wheel][key], rows, rtol=0, atol=BOUNDS[key], err_msg=of)
    for wheel, force in reference.get("normal_force_start", {}).items():
        assert abs(wheels[wheel]["normal_force"][0] - force) < 1e-9, wheel
    exchanges, expected = ([event if np.ndim(event) else (event, "wheel") for event in of["exchange_times"]]
                           for of in (motion, reference))  # fmt: skip
    expected = [(time, wheel) for time, wheel in expected if time < times[-1]]
    assert [wheel for _, wheel in exchanges] == [wheel for _, wheel in expected] != []
    found, expected = ([time for time, _ in events] for events in (exchanges, expected))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)
    assert motion["constraint_residual"].max() < 1e-10


def kinetic_rate(machine: Machine, bodies: np.ndarray, reactions: Reactions) -> float:
    """d/dt of the kinetic energy of all bodies: sum of m v . v' + w . I w'."""
    turned = bodies[:, ROTATION].reshape(-1, 3, 3)
    w, w_rate = bodies[:, None, OMEGA] @ turned, reactions.acceleration[:, None, 3:] @ turned
    travel = machine.mass * np.sum(bodies[:, VELOCITY] * reactions.acceleration[:, :3], axis=1)
    return float(np.sum(travel) + np.sum(machine.inertia[:, None] * w * w_rate))
