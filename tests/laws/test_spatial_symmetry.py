"""Symmetries of space for machines free in it: what is turned or mirrored whole moves turned or mirrored."""

import numpy as np
import pytest
from free_machines import rotations
from helpers.stages import either
from machines import mirrored, rotated, rotation, run, tables
from scenes import of_wheels, reference_scene

TURN_DEG = 73.0
TIME = {"end": 0.6, "step": 5e-5, "output_interval": 0.02}
TILTED = {"height": 0.03, "roll_deg": 4.0, "pitch_deg": -3.0, "roll_rate": 0.5, "pitch_rate": 0.3}
NAMES = ("kiwi_slope", "mecanum_springs", "double_row", "tumbling", "creeping")


def told(name: str) -> dict:
    """A reference case, shorter; one that falls aslant over bumps; one whose rubber creeps."""
    source = {"tumbling": "mecanum_springs", "creeping": "kiwi_slope"}.get(name, name)
    data = tables(reference_scene(f"spatial_{source}")) | {"time": TIME}
    if name == "creeping":
        data["friction"] |= {"law": "brush", "creep_stiffness": 5.0}
    if name == "tumbling":
        data["initial"] |= TILTED
        data["time"] = TIME | {"step": 1e-5}
    return data


@pytest.fixture(scope="module", params=either(NAMES, ["mecanum_springs", "creeping"]))
def scene(request):
    data = told(request.param)
    return data, run(data)


def same_motion(one, other, matrix):
    """Whether the motion of `other` is that of `one` through an orthogonal `matrix` (3, 3)."""
    sense = np.linalg.det(matrix)
    inner = matrix if sense < 0.0 else np.eye(3)  # a mirror turns the chassis inside out too
    pairs = [
        (one["body/position"] @ matrix.T, other["body/position"], 1e-14),
        (one["body/velocity"] @ matrix.T, other["body/velocity"], 1e-13),
        (sense * one["body/angular_velocity"] @ matrix.T, other["body/angular_velocity"], 1e-13),
        (matrix @ rotations(one) @ inner, rotations(other), 1e-14),
        (of_wheels(one, "spin_angle"), of_wheels(other, "spin_angle"), 1e-14),
        (of_wheels(one, "normal_force"), of_wheels(other, "normal_force"), 1e-11),
        (of_wheels(one, "friction_force") * [1.0, sense], of_wheels(other, "friction_force"), 1e-11),
        (sense * of_wheels(one, "rollers/axial_rate"), of_wheels(other, "rollers/axial_rate"), 1e-11),
    ]
    for number, (expected, found, bound) in enumerate(pairs):
        assert np.abs(found - expected).max() <= bound * max(1.0, np.abs(expected).max()), number
    assert sorted(one["events/kind"]) == sorted(other["events/kind"])


def test_a_machine_in_a_mirror_moves_as_its_mirror_image(scene):
    """Measured: motion to 1e-15, rates to 3e-15, forces to 3e-13; on a level floor to the last bit."""
    data, motion = scene
    same_motion(motion, run(mirrored(data)), np.diag([1.0, -1.0, 1.0]))


def test_a_turn_of_the_world_turns_the_motion(scene):
    """Measured: the same."""
    data, motion = scene
    turn = np.eye(3)
    turn[:2, :2] = rotation(np.radians(TURN_DEG))
    same_motion(motion, run(rotated(data, TURN_DEG)), turn)
