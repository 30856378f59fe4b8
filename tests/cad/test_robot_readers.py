"""URDF and MJCF of a machine, read by others: the scene's bodies in the scene's places, and the same in both."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
import tomlkit
from commands import command
from helpers.stages import either
from machines import mirrored, scene, tables
from oracle.spatial.states import SCENES as FREE_SCENES
from robot_readers import by_urdf_parser_py, by_xml, by_yourdfpy, poses, yourdfpy_robot
from scipy.spatial.transform import Rotation

import omnisim
from omnisim.base.files import write_whole
from omnisim.cad.geometry import few_spheres, of_type
from omnisim.cad.robot_files import robot_files
from omnisim.scene.scene import parse

READERS = (by_yourdfpy, by_urdf_parser_py)
SCENES = ("skew", "youbot", "kiwi", "six_rollers")
FREE = ("unlike wheels", "rockers")  # in space: springs, rows and barrels; rockers


def skew():
    """Two wheel types, wheels at odd headings, phases and spin angles, a centre of mass off the middle, bearings."""
    data = mirrored(tables("mixed"))
    for number, wheel in enumerate(data["wheels"]):
        wheel |= {"heading_deg": 25.0 * number - 30.0, "phase_deg": 7.0 + number}
        wheel |= {"spin_angle_deg": 50.0 - 33.0 * number, "spin_rate": 3.0 - number, "roller_rates": 0.5 + number}
    data["chassis"]["center_of_mass"] = [0.02, -0.01, 0.09]
    data["wheel_types"]["omni"]["roller"] |= {"bearing_torque": 1e-4, "bearing_viscosity": 2e-7}
    data["time"] |= {"end": 0.2, "output_interval": 0.05}
    data["initial"] = {"position": [0.3, -0.2], "yaw_deg": 20.0, "velocity": [0.2, 0.1], "yaw_rate": 0.7}
    return scene(data)


def machine(name):
    if name in FREE:
        return parse(tomlkit.dumps(FREE_SCENES[name]), overrides=["initial.height=0.1"])
    return skew() if name == "skew" else omnisim.load(name)


def exported(folder, config, suffix):
    write_whole(robot_files(config, folder / f"machine{suffix}"), overwrite=True)
    return folder / f"machine{suffix}"


def angles(links, seed=1):
    """A position for every joint, rad."""
    draw = np.random.default_rng(seed)
    return {link.joint: draw.uniform(-3.0, 3.0) for link in links.values() if link.joint}


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("read", READERS)
def test_a_urdf_reader_finds_every_mass_inertia_and_joint_of_the_scene(tmp_path, read, name):
    config = machine(name).config
    links = read(exported(tmp_path, config, ".urdf"))
    if config.chassis:
        body = links.pop("chassis")
        assert (body.mass, body.parent) == (config.chassis.mass, None)
        np.testing.assert_array_equal(body.centre, config.chassis.center_of_mass)
        np.testing.assert_array_equal(body.inertia, np.diag(config.chassis.inertia))
    for wheel in config.wheels:
        kind = config.type_of(wheel)
        disk, across = links.pop(f"{wheel.name}_wheel"), kind.disk.inertia_diameter
        assert disk.mass == kind.disk.mass
        np.testing.assert_array_equal(disk.inertia, np.diag([across, kind.disk.inertia_axle, across]))
        hung = ("chassis", f"{wheel.name}_wheel_joint") if config.chassis else (None, None)
        assert (disk.parent, disk.joint) == hung
        for number in range(kind.roller_count):
            roller, across = links.pop(f"{wheel.name}_roller_{number}"), kind.roller.inertia_transverse
            assert roller.mass == kind.roller.mass
            np.testing.assert_array_equal(roller.inertia, np.diag([across, across, kind.roller.inertia_axial]))
            assert (roller.parent, roller.joint) == (f"{wheel.name}_wheel", f"{wheel.name}_roller_{number}_joint")
    assert not links


@pytest.mark.parametrize("name", [*SCENES, *FREE])
def test_mjcf_and_urdf_of_a_machine_agree_body_by_body(tmp_path, name):
    config = machine(name).config
    bodies = by_xml(exported(tmp_path, config, ".xml"))
    positions = angles(bodies)
    expected = poses(bodies, positions)
    for read in READERS:
        links = read(exported(tmp_path, config, ".urdf"))
        assert list(links) == list(bodies)
        found = poses(links, positions)
        for body, link in links.items():
            same = bodies[body]
            assert (link.mass, link.parent, link.joint) == (same.mass, same.parent, same.joint)
            np.testing.assert_array_equal(link.centre, same.centre)
            np.testing.assert_array_equal(link.inertia, same.inertia)
            np.testing.assert_allclose(found[body], expected[body], atol=1e-14)  # measured 3e-16 and 0


@pytest.mark.parametrize("name", either(["skew", "six_rollers", *FREE], ["rockers"]))
def test_mujoco_finds_the_same_machine_in_both_files(tmp_path, name):
    """Told to keep bodies that do not move, as it does by itself in an MJCF."""
    mujoco, config = pytest.importorskip("mujoco", reason="needs MuJoCo"), machine(name).config
    tree = ElementTree.parse(exported(tmp_path, config, ".urdf"))
    ElementTree.SubElement(ElementTree.SubElement(tree.getroot(), "mujoco"), "compiler", fusestatic="false")
    tree.write(tmp_path / "kept.urdf")
    models = [mujoco.MjModel.from_xml_path(str(tmp_path / "kept.urdf"))]
    models.append(mujoco.MjModel.from_xml_path(str(exported(tmp_path, config, ".xml"))))
    names = [models[1].body(number).name for number in range(1, models[1].nbody)]
    positions = angles(by_xml(tmp_path / "machine.xml"))
    seen = []
    for model in models:
        data = mujoco.MjData(model)
        for joint, angle in positions.items():
            data.joint(joint).qpos = angle
        mujoco.mj_kinematics(model, data)
        assert [model.body(number).name for number in range(1, model.nbody)] == names
        root = data.body(names[0]).xpos
        seen.append([(model.body(body).mass[0], moments(mujoco, model, body), data.body(body).xpos - root,
                      data.body(body).xmat) for body in names])  # fmt: skip
    for body, of_urdf, of_mjcf in zip(names, *seen, strict=True):
        for found, same in zip(of_urdf, of_mjcf, strict=True):
            np.testing.assert_allclose(found, same, rtol=1e-12, atol=1e-14, err_msg=body)


def moments(mujoco, model, body):
    """Inertia (3, 3) about the centre of mass in the body's axes, kg m^2."""
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.body(body).iquat)
    turn = turn.reshape(3, 3)
    return turn @ np.diag(model.body(body).inertia) @ turn.T


def test_rollers_of_a_urdf_are_where_omnisim_has_them_on_the_way(tmp_path):
    """Joints at the spin angles of a run, the root at the pose of its body."""
    case = skew()
    run = omnisim.simulate(case)
    assert run.complete
    robot = yourdfpy_robot(exported(tmp_path, case.config, ".urdf"), load_meshes=False)
    spin = {wheel.name: run[f"wheels/{wheel.name}/spin_angle"] for wheel in case.config.wheels}
    assert spin["front_left"][0] == np.radians(50.0) and abs(spin["front_left"][-1] - spin["front_left"][0]) > 0.1
    for row, yaw in enumerate(run["body/yaw"]):
        robot.update_cfg({f"{name}_wheel_joint": angle[row] for name, angle in spin.items()})
        turn, origin = Rotation.from_euler("z", yaw).as_matrix(), run["body/position"][row]
        for wheel in case.config.wheels:
            centres = run[f"wheels/{wheel.name}/rollers/center_position"][row]
            axes = roller_axes(case.config.type_of(wheel), wheel, yaw, spin[wheel.name][row])
            for number, (centre, axis) in enumerate(zip(centres, axes, strict=True)):
                found = robot.get_transform(f"{wheel.name}_roller_{number}")
                np.testing.assert_allclose(turn @ found[:3, 3] + origin, centre, atol=1e-9)  # measured 1.2e-16
                np.testing.assert_allclose(turn @ found[:3, 2], axis, atol=1e-9)  # measured 4.5e-16


def roller_axes(kind, wheel, yaw, spin):
    """a = c t + s k with t = -cos q h - sin q n, world axes (N_r, 3)."""
    q = np.radians(wheel.phase_deg) + 2.0 * np.pi * np.arange(kind.roller_count) / kind.roller_count - spin
    psi, heading = np.radians(kind.roller_angle_deg), yaw + np.radians(wheel.heading_deg)
    psi = -psi if wheel.mirrored else psi
    h, k = ([np.cos(x), np.sin(x), 0.0] for x in (heading, heading + 0.5 * np.pi))
    t = -np.outer(np.cos(q), h) - np.outer(np.sin(q), [0.0, 0.0, 1.0])
    return np.cos(psi) * t + np.sin(psi) * np.array(k)


# --- shapes ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("package", [(), ("--package", "my_robot")])
def test_both_readers_find_one_small_mesh_by_wheel_type_and_a_few_spheres_by_roller(tmp_path, monkeypatch, package):
    """Of a ROS package with description and meshes in a folder of it."""
    folder = tmp_path / "my_robot" / "urdf"
    folder.mkdir(parents=True)
    monkeypatch.chdir(folder)
    assert command("wheel", "mixed", "-o", "machine.urdf", *package).exit_code == 0
    config = omnisim.load("mixed").config
    sizes = {file.name: file.stat().st_size for file in folder.glob("*.stl")}
    assert set(sizes) == {"machine_mecanum_roller.stl", "machine_omni_roller.stl"}
    assert max(sizes.values()) < 300e3  # measured 211284 bytes

    def handler(fname):
        return str(tmp_path / fname.removeprefix("package://")) if package else str(folder / fname)

    robot = yourdfpy_robot(folder / "machine.urdf", filename_handler=handler, build_collision_scene_graph=True,
                           load_collision_meshes=True)  # fmt: skip
    rollers = {f"{wheel.name}_roller_{i}": config.type_of(wheel) for wheel in config.wheels
               for i in range(config.type_of(wheel).roller_count)}  # fmt: skip
    drawn = [shape for name, shape in robot.scene.geometry.items() if name.startswith("machine_")]
    assert len(drawn) == len(rollers) and {len(shape.faces) for shape in drawn} == {4224}
    reader = pytest.importorskip("urdf_parser_py.urdf", reason="needs urdf_parser_py").URDF
    links = reader.from_xml_file(str(folder / "machine.urdf")).link_map
    for name, kind in rollers.items():
        assert handler(links[name].visual.geometry.filename) in map(str, folder.glob("*.stl"))
        spheres = few_spheres(of_type(kind))
        assert [part.geometry.radius for part in links[name].collisions] == spheres.radii.tolist()
        assert [part.origin.xyz for part in links[name].collisions] == [[0.0, 0.0, z] for z in spheres.places]
        assert [part.geometry.sphere.radius for part in robot.link_map[name].collisions] == spheres.radii.tolist()


def test_a_chassis_of_known_size_is_drawn_as_its_box_at_its_centre_of_mass(tmp_path):
    data = tables("mixed")
    data["chassis"] = {"mass": 8.0, "size": [0.4, 0.3, 0.1], "ground_clearance": 0.03}
    config = scene(data).config
    link = yourdfpy_robot(exported(tmp_path, config, ".urdf"), load_meshes=False).link_map["chassis"]
    assert link.visuals[0].geometry.box.size.tolist() == [0.4, 0.3, 0.1]
    np.testing.assert_array_equal(link.visuals[0].origin[:3, 3], config.chassis.center_of_mass)
    assert link.inertial.inertia[2, 2] == pytest.approx(8.0 / 12.0 * (0.4**2 + 0.3**2), rel=1e-12)
    box = ElementTree.parse(exported(tmp_path, config, ".xml")).find(".//geom[@type='box']")
    assert box.get("size") == "0.2 0.15 0.05"


@pytest.mark.parametrize("name", [*SCENES, *FREE])
def test_names_in_a_urdf_are_met_once_and_nothing_in_it_is_unknown(tmp_path, name, capsys):
    """urdf_parser_py says on stderr what it does not know; a link and a joint of one name are an error in SDF."""
    path = exported(tmp_path, machine(name).config, ".urdf")
    links = by_urdf_parser_py(path)
    names = [*links, *(link.joint for link in links.values() if link.joint)]
    assert len(set(names)) == len(names)
    assert capsys.readouterr().err == ""


def test_springs_of_suspensions_stand_in_both_files(tmp_path):
    """Stiffness, damping, and where each is relaxed: in words of MuJoCo, and of Gazebo as a reader of ROS finds it."""
    reader = pytest.importorskip("urdf_parser_py.urdf", reason="needs urdf_parser_py").URDF
    config = machine("unlike wheels").config
    robot = reader.from_xml_file(str(exported(tmp_path, config, ".urdf")))
    told = {part.get("reference"): {one.tag: float(one.text) for one in part} for part in robot.gazebos}
    slides = ElementTree.parse(exported(tmp_path, config, ".xml")).findall(".//joint[@type='slide']")
    sprung = {f"{wheel.name}_hub_joint": wheel.suspension for wheel in config.wheels if wheel.suspension}
    assert set(told) == set(sprung) == {joint.get("name") for joint in slides} and len(sprung) == 2
    for joint in slides:
        spring = sprung[joint.get("name")]
        relaxed = -spring.preload / spring.stiffness
        assert told[joint.get("name")] == {"springStiffness": spring.stiffness, "springReference": relaxed}
        found = [float(joint.get(key)) for key in ("stiffness", "springref", "damping")]
        assert found == [spring.stiffness, relaxed, spring.damping]
        assert robot.joint_map[joint.get("name")].dynamics.damping == spring.damping


@pytest.mark.long
def test_no_text_that_an_export_writes_has_a_number_with_its_type(folder):
    case = skew()
    (folder / "skew.toml").write_text(case.text)
    assert command("run", "skew.toml", "-o", "skew.h5", "--quiet").exit_code == 0
    assert command("export", "skew.h5", "table.csv").exit_code == 0
    outputs = [("skew.toml", "machine.urdf"), ("skew.toml", "machine.xml"), ("skew.toml", "wheel.obj")]
    outputs += [("skew.toml", "wheel.svg")]
    for source, output in outputs:
        assert command("wheel", source, "-o", output).exit_code == 0
    written = {path.name: path.read_text() for path in folder.iterdir() if path.suffix not in (".h5", ".stl")}
    assert set(written) == {"skew.toml", "table.csv", "table.events.csv", *(output for _, output in outputs)}
    said = "".join(command(*arguments).stdout for arguments in (("info", "skew.h5"), ("wheel", "skew.toml")))
    for name, text in (written | {"said": said}).items():
        assert not re.search(r"np\.|numpy\.|float64|\b(nan|inf)\b", text), name
