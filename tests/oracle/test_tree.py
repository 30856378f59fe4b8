"""The elimination along the tree against one dense solve of all bodies and multipliers at once.

States of a run of the multibody formulation go into the oracle as they stand: accelerations of every body, normal
forces, servo torques, and the force and the moment of every joint must come out the same. Measured values stand beside
the bounds.
"""

import tomllib

import numpy as np
import pytest

import omnisim
from omnisim.constraints import matrices
from omnisim.loop import Loop
from omnisim.runge_kutta import evaluate
from omnisim.state import BODY_STATES, places_in
from oracle.cases import REFERENCE
from oracle.machine import Machine

HERE = REFERENCE.parent / "oracle"
PUSH = "wrench={times=[0.0], force=[[1.0, -2.0, 3.0]], yaw_torque=[0.1]}"
SCENES = {
    "bare wheel": (REFERENCE / "testbench_psi30.toml", [PUSH]),
    "kiwi": (REFERENCE / "kiwi.toml", []),
    "mecanum": (REFERENCE / "mecanum.toml", []),
    "mecanum on a servo": (REFERENCE / "mecanum.toml", ["scene.upright=servo"]),
    "skew machine": (HERE / "skew.toml", []),
    "viscous": (REFERENCE / "kiwi.toml", ["friction={law='viscous', viscosity=5.0}"]),
}  # fmt: skip


def bodies_of(y: np.ndarray, parameters, chassis: bool) -> np.ndarray:
    """The bodies of a state as the oracle has them: rotation matrices whose second column is y, k or a."""
    at, (wheels, most) = places_in(parameters), parameters.sector.shape[:2]
    states = y[at.bodies : at.drift].reshape(-1, BODY_STATES)
    turned = matrices(states[:, 3:7])
    kept = [0] if chassis else []
    for w, rollers in zip(range(wheels), parameters.wheels.rollers.tolist(), strict=True):
        disk = 1 + w * (most + 1)
        own = range(disk + 1, disk + 1 + rollers)
        turned[own] = turned[own][:, :, [1, 2, 0]]  # z of a roller is its axis
        kept += [disk, *own]
    return np.concatenate([states[:, :3], turned.reshape(-1, 9), states[:, 7:]], axis=1)[kept]


@pytest.fixture(scope="module", params=SCENES)
def solutions(request):
    """Of a scene, at several instants: the bodies' accelerations (B, 6), normal forces, servo torques and wrenches of
    the joints (J, 6) as omnisim finds them, and the oracle's Reactions."""
    path, overrides = SCENES[request.param]
    scene = omnisim.load(
        path, [*overrides, "solver.formulation=multibody", "time={end=1.0, step=2e-5, output_interval=0.02}"]
    )
    chassis, oracle, loop = scene.config.chassis is not None, Machine(tomllib.loads(scene.text)), Loop(scene)
    parameters, run, found = loop.parameters, loop.run, []
    for _ in range(4):
        assert loop.advance(0.02)  # to the next row
        dy, piece = np.zeros_like(run.y), int(run.clock.piece)
        evaluate(parameters, run.mode, piece, loop.time, run.y, dy, run.watch)
        bodies, room = bodies_of(run.y, parameters, chassis), parameters.room
        mode = oracle.mode(loop.time, [int(one.roller) for one in run.mode])
        rates = bodies_of(dy, parameters, chassis)
        joints = [
            np.concatenate([room.joints[w, i].force, room.joints[w, i].moment])
            for w, rollers in enumerate(parameters.wheels.rollers.tolist())
            for i in range(0 if chassis else 1, rollers + 1)
        ]
        ours = rates[:, 12:], room.parts.normal_force.copy(), room.loads.servo.copy(), np.array(joints)
        energies = loop.trajectory()["energy/kinetic"][-1], oracle.kinetic_energy(bodies)
        found.append((ours, oracle.solve(loop.time, bodies, mode), energies))
    return found


def test_every_body_has_the_acceleration_of_the_dense_solution(solutions):
    for (accelerations, *_), oracle, _ in solutions:
        scale = np.abs(oracle.acceleration).max()
        assert np.abs(accelerations - oracle.acceleration).max() < 1e-10 * scale  # measured: 6e-12


def test_the_floor_carries_what_the_dense_solution_says(solutions):
    for (_, normal, servo, _), oracle, _ in solutions:
        assert np.abs(normal - oracle.normal_force).max() < 1e-13 * np.abs(normal).max()  # measured: 5e-15
        if len(oracle.servo_torque):
            assert np.abs(servo[: len(oracle.servo_torque)] - oracle.servo_torque).max() < 1e-12  # N m; measured: 1e-14


def test_every_joint_carries_its_multipliers(solutions):
    for (*_, joints), oracle, _ in solutions:
        scale = np.abs(oracle.joints).max()
        assert np.abs(joints - oracle.joints).max() < 1e-13 * scale  # measured: 5e-15


def test_the_energy_that_is_written_is_that_of_all_bodies(solutions):
    for *_, (written, of_bodies) in solutions:
        assert abs(written - of_bodies) < 1e-14 * of_bodies  # measured: 4e-16
