"""The elimination along the tree against one dense solve of all bodies and multipliers at once.

States of a run of the multibody formulation go into the oracle as they stand: accelerations of every body, normal
forces, servo torques, and the force and the moment of every joint must come out the same. Measured values stand beside
the bounds.
"""

import tomllib

import numpy as np
import pytest

import omnisim
from omnisim.contact.set_valued import STICK
from omnisim.dynamics.multibody.residuals import matrices
from omnisim.dynamics.state import BODY_STATES, Stage, places_in
from omnisim.march.runge_kutta import evaluate
from omnisim.run.loop import Loop
from oracle.cases import REFERENCE
from oracle.machine import Machine
from oracle.scenes import BARE_ROWS, ROWS
from oracle.states import Given
from oracle.vectors import AXIS, OMEGA, UP, VELOCITY

HERE = REFERENCE.parent / "oracle"
PUSH = "wrench={times=[0.0], force=[[1.0, -2.0, 3.0]], yaw_torque=[0.1]}"
SLOPE = "floor={slope_deg=12.0, uphill_deg=70.0}"
AT_REST = ["initial={yaw_deg=25.0}", *(f"wheels.{name}.spin_rate=0.0" for name in ("front", "left", "right"))]
SCENES = {
    "bare wheel": (REFERENCE / "testbench_psi30.toml", [PUSH]),
    "kiwi": (REFERENCE / "kiwi.toml", []),
    "mecanum": (REFERENCE / "mecanum.toml", []),
    "mecanum on a servo": (REFERENCE / "mecanum.toml", ["scene.upright=servo"]),
    "skew machine": (HERE / "skew.toml", []),
    "viscous": (REFERENCE / "kiwi.toml", ["friction={law='viscous', viscosity=5.0}"]),
    "bare wheel on a slope": (REFERENCE / "testbench_psi30.toml", [PUSH, SLOPE]),
    "skew machine on a slope": (HERE / "skew.toml", [SLOPE]),
    "mecanum on a servo and a slope": (REFERENCE / "mecanum.toml", ["scene.upright=servo", SLOPE]),
    "sticking on a slope": (HERE / "skew.toml", ["friction={law='coulomb', coefficient=0.9}", *AT_REST, SLOPE]),
    "skew machine on rows": (HERE / "skew.toml", [*ROWS, SLOPE]),
    "skew machine on rows and a servo": (HERE / "skew.toml", [*ROWS, "scene.upright=servo"]),
    "bare wheel on two rows": (REFERENCE / "testbench_psi30.toml", [*BARE_ROWS, PUSH]),
    "sticking on rows": (
        HERE / "skew.toml", [*ROWS, "friction={law='coulomb', coefficient=0.9}", *AT_REST, SLOPE]
    ),
    "sticking": (HERE / "skew.toml", ["friction={law='coulomb', coefficient=0.9}", *AT_REST]),
}  # fmt: skip


def slip_rate(wheel, roller: int, bodies: np.ndarray, accelerations: np.ndarray) -> np.ndarray:
    """Rate of the slip velocity (2,) of a roller on the floor, by a central difference: m/s^2."""
    body, acceleration = (of[wheel.rollers.start + roller % wheel.count] for of in (bodies, accelerations))
    slips = []
    for step in (-1e-5, 1e-5):
        axis = body[AXIS] + step * np.cross(body[OMEGA], body[AXIS])
        p, _ = wheel.lowest_point(axis / np.linalg.norm(axis))
        rate = body[OMEGA] + step * acceleration[3:]
        slips.append(body[VELOCITY] + step * acceleration[:3] + np.cross(rate, p))
    return (slips[1] - slips[0])[:2] / 2e-5


def bodies_of(y: np.ndarray, parameters, chassis: bool) -> np.ndarray:
    """The bodies of a state as the oracle has them: rotation matrices whose second column is y, k or a."""
    at, (wheels, _, most) = places_in(parameters), parameters.sector.shape
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
    sticks = scene.config.friction.law == "coulomb"
    kind = Given if sticks else Machine
    chassis, oracle, loop = scene.config.chassis is not None, kind(tomllib.loads(scene.text)), Loop(scene)
    parameters, run, found = loop.parameters, loop.run, []
    for _ in range(4):
        assert loop.advance(0.02)  # to the next row
        dy, piece = np.zeros_like(run.y), run.clock.piece
        evaluate(parameters, Stage(run.mode, piece, loop.time, run.y, dy, run.monitors, True))
        bodies, workspace = bodies_of(run.y, parameters, chassis), parameters.workspace
        mode = oracle.mode(loop.time, [int(one.roller) for one in run.mode])
        if sticks:
            assert (run.mode.grip[:, 0] == STICK).all()
            oracle.forces = [
                force[0] * np.cross(bodies[wheel.disk, AXIS], UP) + force[1] * bodies[wheel.disk, AXIS]
                for wheel, force in zip(oracle.wheels, workspace.contacts.force[::2], strict=True)
            ]
        rates = bodies_of(dy, parameters, chassis)
        joints = [
            np.concatenate([workspace.joints[w, i].force, workspace.joints[w, i].moment])
            for w, rollers in enumerate(parameters.wheels.rollers.tolist())
            for i in range(0 if chassis else 1, rollers + 1)
        ]
        ours = rates[:, 12:], workspace.parts.normal_force.copy(), workspace.loads.servo.copy(), np.array(joints)
        energies = loop.trajectory()["energy/kinetic"][-1], oracle.kinetic_energy(bodies)
        theirs = oracle.solve(loop.time, bodies, mode)
        left = [slip_rate(*of, bodies, theirs.acceleration) for of in zip(oracle.wheels, mode.contacts, strict=True)]
        found.append((ours, theirs, energies, left if sticks else []))
    return found


def test_every_body_has_the_acceleration_of_the_dense_solution(solutions):
    for (accelerations, *_), oracle, *_ in solutions:
        scale = np.abs(oracle.acceleration).max()
        assert np.abs(accelerations - oracle.acceleration).max() < 1e-10 * scale  # measured: 6e-12


def test_the_floor_carries_what_the_dense_solution_says(solutions):
    for (_, normal, servo, _), oracle, *_ in solutions:
        assert np.abs(normal - oracle.normal_force).max() < 1e-13 * np.abs(normal).max()  # measured: 5e-15
        if len(oracle.servo_torque):
            assert np.abs(servo[: len(oracle.servo_torque)] - oracle.servo_torque).max() < 1e-12  # N m; measured: 1e-14


def test_every_joint_carries_its_multipliers(solutions):
    for (*_, joints), oracle, *_ in solutions:
        scale = np.abs(oracle.joints).max()
        assert np.abs(joints - oracle.joints).max() < 1e-13 * scale  # measured: 5e-15


def test_the_energy_that_is_written_is_that_of_all_bodies(solutions):
    for _, _, (written, of_bodies), _ in solutions:
        assert abs(written - of_bodies) < 1e-14 * of_bodies  # measured: 4e-16


def test_sticking_forces_hold_the_slip_of_the_dense_solution(solutions):
    """Rollers that stick: under their forces the bodies of the dense solution have no slip acceleration left."""
    for *_, left in solutions:
        assert np.abs(left).max(initial=0.0) < 1e-8  # m/s^2; measured: 1.1e-9, of the difference
