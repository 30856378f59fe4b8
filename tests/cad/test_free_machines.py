"""MJCF of machines free in space, simulated by MuJoCo: springs, rockers, rows and rubber are those of the scene.

Measured values stand beside the bounds.
"""

from pathlib import Path

import numpy as np
import pytest
import tomlkit
from commands import command
from free_machines import STIFFNESS, free, whole_mass
from machines import machine, scene
from oracle.spatial.states import SCENES
from scenes import REFERENCE, of_wheels

import omnisim
from omnisim.cad import mesh
from omnisim.cad.mjcf import mjcf
from omnisim.cad.robot_description import bodies, text
from omnisim.cad.rubber import inverse_masses
from omnisim.scene.scene import parse

FLYING = {"position": [0.1, 0.2], "height": 0.5, "roll_deg": 5.0, "pitch_deg": -8.0, "yaw_deg": 30.0,
          "velocity": [0.3, -0.2], "vertical_velocity": 0.4, "yaw_rate": 1.5, "pitch_rate": -0.7,
          "roll_rate": 0.9}  # fmt: skip
TRIANGLE = tuple((0.2 * np.cos(angle), 0.2 * np.sin(angle)) for angle in np.radians([60.0, 180.0, 300.0]))
TORQUES = (0.1, -0.2, 0.3, 0.05)  # N m


@pytest.fixture
def mujoco():
    return pytest.importorskip("mujoco", reason="needs MuJoCo")


def flying(name):
    """A scene of the oracle in the air, every wheel and roller turning."""
    data = tomlkit.parse(tomlkit.dumps(SCENES[name])).unwrap() | {"initial": FLYING}
    data["time"] = {"end": 1e-3, "step": 1e-4, "output_interval": 1e-3}
    for wheel, torque in zip(data["wheels"], TORQUES, strict=False):
        wheel |= {"spin_rate": 3.0, "roller_rates": -20.0}
        wheel["drive"] = {"kind": "torque", "times": [0.0, 1.0], "torque": [torque, torque]}
    return parse(tomlkit.dumps(data))


def started(mujoco, folder, config, resolution=(9, 16)):
    """MuJoCo's model and its data at the start; resolution: of the hulls that touch."""
    names = {wheel.type: f"{wheel.type}.stl" for wheel in config.wheels}
    for kind, name in names.items():
        for which in ("drawn", "touching"):
            mesh.write(mesh.roller(config.wheel_types[kind], *resolution), folder / f"{which}_{name}", "")
    meshes = ({kind: f"{which}_{name}" for kind, name in names.items()} for which in ("drawn", "touching"))
    (folder / "machine.xml").write_text(text(mjcf(config, "machine", *meshes)))
    model = mujoco.MjModel.from_xml_path(str(folder / "machine.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


@pytest.mark.parametrize(("name", "bound"), [
    ("mecanum_springs", 1e-12),  # measured 1e-14, relative
    ("double_row", 1e-12),  # 1e-15
    ("rockers", 1e-6),  # 4e-8: rockers that weigh 1 mg
])  # fmt: skip
def test_in_the_air_all_accelerates_as_in_omnisim(mujoco, tmp_path, name, bound):
    """Springs with preload and damping, rows, rockers, gravity along a slope, the start with all its rates."""
    case = flying(name)
    run = omnisim.simulate(case)
    _, data = started(mujoco, tmp_path, case.config)
    data.ctrl[:] = TORQUES[: len(data.ctrl)]
    mujoco.mj_forward(data.model, data)
    assert data.ncon == 0
    spins = np.array([data.joint(f"{wheel}_wheel_joint").qacc[0] for wheel in run.wheels])
    for found, expected in ((data.qpos[:3], run["body/position"][0]), (data.qvel[:3], run["body/velocity"][0]),
                            (data.qacc[:3], run["body/acceleration"][0]),
                            (spins, of_wheels(run, "spin_acceleration")[0])):  # fmt: skip
        assert np.abs(found - expected).max() < bound * max(1.0, np.abs(expected).max())
    for wheel in case.config.wheels:
        for number, centre in enumerate(run[f"wheels/{wheel.name}/rollers/center_position"][0]):
            found = data.body(f"{wheel.name}_roller_{number}").xpos
            np.testing.assert_allclose(found, centre, atol=1e-12)


@pytest.mark.parametrize("name", ["mecanum_springs", "double_row", "rockers", "unlike wheels"])
def test_inverse_masses_are_those_by_which_mujoco_scales_contacts(mujoco, tmp_path, name):
    config = flying(name).config
    model, _ = started(mujoco, tmp_path, config)
    for body, expected in inverse_masses(list(bodies(config))).items():
        assert abs(model.body(body).invweight0[0] / expected - 1.0) < 1e-10  # measured 2e-14


def test_a_machine_that_cannot_begin_there_is_one_line(folder):
    text = (REFERENCE / "spatial_mecanum_springs.toml").read_text()
    Path("low.toml").write_text(text.replace("height = -0.00024", "height = -0.5"))
    result = command("wheel", "low.toml", "-o", "low.xml")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1 and not Path("low.xml").exists()
    assert "initial.height = -0.5: wheel 'fl' begins below the ground" in result.stderr


def test_rubber_presses_as_the_scene_says(mujoco, tmp_path):
    """N = stiffness delta at the start, in the equilibrium that omnisim has found, and the machine stays there."""
    data = free(machine("omni", TRIANGLE, (150.0, 270.0, 30.0)), damping=300.0)
    data["friction"] = {"law": "regularized", "coefficient": 0.6, "slip_speed": 0.01}
    config, sag = scene(data).config, whole_mass(data) * 9.81 / (3.0 * STIFFNESS)
    model, state = started(mujoco, tmp_path, config, mesh.FINE)
    mujoco.mj_forward(model, state)
    force = np.zeros(6)
    assert state.ncon == 3
    for contact in range(3):
        mujoco.mj_contactForce(model, state, contact, force)
        assert abs(force[0] / (STIFFNESS * sag) - 1.0) < 3e-4  # measured 1e-4, the impedance
    assert abs(state.qpos[2] / -sag - 1.0) < 1e-10
    mujoco.mj_step(model, state, nstep=2000)
    assert abs(state.qpos[2] / -sag - 1.0) < 1e-2  # measured 2e-3: edges of facets


def test_mujoco_reads_rolling_resistance_of_rubber_in_its_pairs(mujoco, tmp_path):
    config = flying("rolling resistance on springs").config
    model, _ = started(mujoco, tmp_path, config)
    mu = config.friction.coefficient
    assert (model.pair_dim == 6).all() and len(model.pair_dim) == sum(config.type_of(w).rollers for w in config.wheels)
    np.testing.assert_array_equal(model.pair_friction, [[mu, mu, 0.0, 2e-3, 2e-3]] * len(model.pair_dim))
