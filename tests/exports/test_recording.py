"""An MCAP file is the run: read by others, every transform, joint, force and event is what the trajectory holds.

Measured values stand beside the bounds.
"""

import math
from functools import cache
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
import tomlkit
from commands import command, refused
from oracle.spatial.states import SCENES as FREE
from recordings import by_mcap, by_rosbags, in_world, matrices, plain, records
from robot_readers import transform, values
from scipy.spatial.transform import Rotation
from synthetic import synthetic_trajectory

import omnisim
from omnisim.cad.mesh import roller
from omnisim.dynamics.ground import floor_of_scene
from omnisim.exports.formats import write
from omnisim.pictures.ground import heights
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.scene import parse

pytest.importorskip("mcap", reason="needs mcap")
pytest.importorskip("rosbags", reason="needs rosbags")

SHORT = ["time.end=0.03", "time.output_interval=0.01"]
TURNING = ["initial.position=[0.3, -0.2]", "initial.yaw_deg=20.0", "initial.velocity=[0.2, 0.1]",
           "initial.yaw_rate=0.7", "wheels.front_left.heading_deg=12.0", "wheels.rear_right.phase_deg=7.0"]  # fmt: skip
FALLING = ["initial.height=0.1", "initial.roll_deg=8.0", "initial.pitch_deg=-5.0"]
ON_A_BUMP = ["initial.position=[0.1, 0.0]", "initial.height=0.0"]
MACHINES = {
    "mecanum": lambda: omnisim.load("youbot", [*SHORT, *TURNING]),
    "omni": lambda: omnisim.load("kiwi", [*SHORT, "wheels.left.spin_rate=3.0"]),
    "bare wheel": lambda: omnisim.load("six_rollers", SHORT),
    "falling": lambda: parse(tomlkit.dumps(FREE["unlike wheels"]), overrides=[*SHORT, *FALLING]),
    "slope": lambda: parse(tomlkit.dumps(FREE["kiwi_slope"]), overrides=SHORT),
    "rockers": lambda: parse(tomlkit.dumps(FREE["rockers"]), overrides=SHORT),
    "bumps": lambda: parse(tomlkit.dumps(FREE["mecanum_bump"]), overrides=[*SHORT, *ON_A_BUMP]),
}
UPRIGHT = ("mecanum", "omni", "bare wheel")


@cache
def run_of(name):
    return omnisim.simulate(MACHINES[name]())


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Run, scene, file and messages of a machine, each made once."""

    @cache
    def found(name):
        run = run_of(name)
        path, *beside = write(run, tmp_path_factory.mktemp("a recording") / "of a run.mcap")
        assert [other.suffix for other in beside] == [".urdf"] + [".stl"] * (len(beside) - 1)
        return run, MACHINES[name]().config, path, by_rosbags(path, "ROS2_HUMBLE")

    return found


# --- the file -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mecanum", "bare wheel"])
def test_three_readers_find_the_same_messages(recorded, name):
    """Types of Humble and of Jazzy, and the definitions in the file alone; all floats are 64 bits but colours."""
    _, _, path, messages = recorded(name)
    jazzy, alone = by_rosbags(path, "ROS2_JAZZY"), by_mcap(path)
    for topic, said in messages.items():
        assert (
            [one[:2] for one in said] == [one[:2] for one in jazzy[topic]] == [one[:2] for one in alone.get(topic, [])]
        )
        for one, other, third in zip(said, jazzy[topic], alone.get(topic, []), strict=True):
            assert plain(one.message) == plain(other.message) == plain(third.message)


def test_checksums_indexes_and_summary_are_those_of_the_records(recorded):
    _, _, path, messages = recorded("mecanum")
    found = records(path)
    assert (found[0].profile, found[0].library) == ("ros2", f"omnisim {omnisim.__version__}")
    channels = {record.topic: record for record in found if type(record).__name__ == "Channel"}
    schemas = {record.id: record for record in found if type(record).__name__ == "Schema"}
    assert set(channels) == set(messages)
    for channel in channels.values():
        assert (channel.message_encoding, schemas[channel.schema_id].encoding) == ("cdr", "ros2msg")


def test_a_flipped_bit_is_noticed(recorded, tmp_path):
    _, _, path, _ = recorded("mecanum")
    image = bytearray(path.read_bytes())
    image[len(image) // 3] ^= 1
    (tmp_path / "damaged.mcap").write_bytes(image)
    with pytest.raises(Exception, match=r"(?i)crc|decompress|corrupt"):
        by_mcap(tmp_path / "damaged.mcap")


def test_rosbag2_is_told_which_topics_to_keep_for_those_who_come_later(recorded):
    from rosbags.highlevel import AnyReader

    with AnyReader([recorded("mecanum")[2]]) as reader:
        qos = {connection.topic: connection.ext.offered_qos_profiles for connection in reader.connections}
    kept = {topic for topic, found in qos.items() if found and found[0].durability.name == "TRANSIENT_LOCAL"}
    assert kept == {"/robot_description", "/tf_static", "/machine_markers"}
    assert not any(qos[topic] for topic in set(qos) - kept)


def test_the_same_run_is_the_same_file(recorded):
    run, _, path, _ = recorded("omni")
    before = path.read_bytes()
    write(run, path, overwrite=True)
    assert path.read_bytes() == before


# --- where everything is --------------------------------------------------------------------------


@pytest.mark.parametrize("name", MACHINES)
def test_the_root_is_where_the_body_is(recorded, name):
    """Numbers of the trajectory, to the last bit; yaw as far as half angles hold it."""
    run, config, _, messages = recorded(name)
    root = "chassis" if config.chassis else f"{config.wheels[0].name}_wheel"
    assert len(messages["/tf"]) == len(messages["/ground_truth"]) == len(run.time)
    for row, ((time, _, message), truth) in enumerate(zip(messages["/tf"], messages["/ground_truth"], strict=True)):
        assert time == round(run.time[row] * 1e9) == truth.time
        stamped, pose = message.transforms[0], truth.message.pose.pose
        assert (stamped.header.frame_id, stamped.child_frame_id) == ("world", root)
        assert (truth.message.header.frame_id, truth.message.child_frame_id) == ("world", root)
        for place, turn in (
            (stamped.transform.translation, stamped.transform.rotation),
            (pose.position, pose.orientation),
        ):
            assert [place.x, place.y, place.z] == run["body/position"][row].tolist()
            quaternion = [turn.w, turn.x, turn.y, turn.z]
            if "body/orientation" in run:
                assert quaternion == run["body/orientation"][row].tolist()
            elif config.chassis:
                assert turn.x == turn.y == 0.0
                assert abs(2.0 * math.atan2(turn.z, turn.w) - run["body/yaw"][row]) < 1e-15  # measured 6e-17


@pytest.mark.parametrize("name", MACHINES)
def test_the_chain_of_frames_ends_at_the_rollers(recorded, name):
    """World, machine, wheel, roller: the centres that the trajectory has."""
    run, config, _, messages = recorded(name)
    for row, said in enumerate(messages["/tf"]):
        placed = in_world(matrices(said.message.transforms))
        for wheel in config.wheels:
            for number, centre in enumerate(run[f"wheels/{wheel.name}/rollers/center_position"][row]):
                found = placed[f"{wheel.name}_roller_{number}"][:3, 3]
                np.testing.assert_allclose(found, centre, rtol=0.0, atol=1e-12)  # measured 1e-16


@pytest.mark.parametrize("name", [*UPRIGHT, "slope"])
def test_the_chain_of_frames_gives_the_contact_point(recorded, name):
    """The lowest point of the exact profile from the centre and the axis of the roller's frame alone, at any tilt:

    sin q = -a_n / c, h_q = R - R1 / cos q, u = R1 tan q / c + h_q c sin q, r = h_q sqrt(1 - c^2 sin^2 q); rubber is
    pressed in below the floor, straight down.
    """
    run, config, _, messages = recorded(name)
    for row, said in enumerate(messages["/tf"]):
        placed = in_world(matrices(said.message.transforms))
        for wheel in config.wheels:
            kind, path = config.type_of(wheel), f"wheels/{wheel.name}"
            frame = placed[f"{wheel.name}_roller_{run[f'{path}/contact_roller'][row]}"]
            centre, axis, c = frame[:3, 3], frame[:3, 2], math.cos(math.radians(kind.roller_angle_deg))
            q = math.asin(-axis[2] / c)
            h = kind.radius - kind.roller_distance / math.cos(q)
            u = kind.roller_distance * math.tan(q) / c + h * c * math.sin(q)
            up = np.array([0.0, 0.0, 1.0]) - axis[2] * axis
            lowest = centre + u * axis - h * math.sqrt(1.0 - (c * math.sin(q)) ** 2) * up / np.linalg.norm(up)
            assert -1e-3 < lowest[2] < 1e-12
            point = [*lowest[:2], 0.0]
            np.testing.assert_allclose(point, run[f"{path}/contact_point"][row], rtol=0.0, atol=1e-12)  # measured 1e-16


def moved(joint, position):
    """From the child of a joint of a URDF to its parent (4, 4), as the format has it."""
    origin, axis = joint.find("origin"), values(joint.find("axis"), "xyz")
    way = np.eye(4)
    if joint.get("type") == "prismatic":
        way[:3, 3] = position * axis
    else:
        way[:3, :3] = Rotation.from_rotvec(position * axis).as_matrix()
    return transform(values(origin, "xyz"), values(origin, "rpy")) @ way


@pytest.mark.parametrize("name", MACHINES)
def test_the_urdf_at_the_joint_states_is_what_the_transforms_say(recorded, name):
    """Links, joints and frames have the same names; the file beside it is the same but for the way to meshes."""
    run, config, path, messages = recorded(name)
    description = messages["/robot_description"][0].message.data
    beside = path.with_suffix(".urdf").read_text()
    assert unquote(description).replace(f"file://{path.parent}/", "") == beside
    tree = ElementTree.fromstring(description)
    meshes = {mesh.get("filename") for mesh in tree.iter("mesh")}
    assert meshes == {file.as_uri() for file in path.parent.glob("*.stl")}
    joints = {joint.get("name"): joint for joint in tree.iter("joint")}
    ends = {name: tuple(joint.find(end).get("link") for end in ("parent", "child")) for name, joint in joints.items()}
    for row, (states, said) in enumerate(zip(messages["/joint_states"], messages["/tf"], strict=True)):
        state, found = states.message, matrices(said.message.transforms)
        assert sorted(state.name) == sorted(joints) and states.time == said.time
        assert {child: parent for child, (parent, _) in found.items()} == {
            "chassis" if config.chassis else f"{config.wheels[0].name}_wheel": "world"
        } | {child: parent for parent, child in ends.values()}
        for joint, position in zip(state.name, state.position, strict=True):
            expected = moved(joints[joint], position)
            np.testing.assert_allclose(found[ends[joint][1]][1], expected, rtol=0.0, atol=1e-14)  # measured 6e-16
        values = dict(zip(state.name, zip(state.position, state.velocity, state.effort, strict=True), strict=True))
        for wheel in config.wheels:
            part = f"wheels/{wheel.name}"
            if config.chassis:
                spin = (run[f"{part}/{key}"][row] for key in ("spin_angle", "spin_rate", "drive_torque"))
                assert values[f"{wheel.name}_wheel_joint"] == tuple(spin)
            for number, rate in enumerate(run[f"{part}/rollers/joint_rate"][row]):
                assert values[f"{wheel.name}_roller_{number}_joint"][1] == rate
            if wheel.suspension is not None:
                travel = (run[f"{part}/{key}"][row] for key in ("suspension_travel", "suspension_rate"))
                assert values[f"{wheel.name}_hub_joint"] == (*travel, 0.0)


@pytest.mark.parametrize("name", MACHINES)
def test_the_truth_has_the_velocities_of_the_run(recorded, name):
    """Along the axes of the root, as nav_msgs/Odometry wants them."""
    run, config, _, messages = recorded(name)
    for row, truth in enumerate(messages["/ground_truth"]):
        pose, twist = truth.message.pose.pose, truth.message.twist.twist
        q = pose.orientation
        turn = Rotation.from_quat([q.x, q.y, q.z, q.w])
        linear = turn.apply([twist.linear.x, twist.linear.y, twist.linear.z])
        np.testing.assert_allclose(linear, run["body/velocity"][row], rtol=0.0, atol=1e-14)  # measured 1e-16
        rate = (
            run["body/angular_velocity"][row]
            if "body/angular_velocity" in run
            else [0.0, 0.0, run["body/yaw_rate"][row]]
        )
        if not config.chassis:
            yaw, spin = run["body/yaw"][row], run[f"wheels/{run.wheels[0]}/spin_rate"][row]
            rate = np.add(rate, [-spin * math.sin(yaw), spin * math.cos(yaw), 0.0])
        angular = turn.apply([twist.angular.x, twist.angular.y, twist.angular.z])
        np.testing.assert_allclose(angular, rate, rtol=0.0, atol=1e-13)  # measured 2e-15


@pytest.mark.parametrize("name", ["mecanum", "omni", "rockers"])
def test_odometry_is_that_of_the_run(recorded, name):
    run, config, _, messages = recorded(name)
    for row, said in enumerate(messages["/odom"]):
        pose, twist = said.message.pose.pose, said.message.twist.twist
        assert (said.message.header.frame_id, said.message.child_frame_id) == ("odom", "chassis")
        assert [pose.position.x, pose.position.y] == run["odometry/position"][row].tolist()
        assert abs(2.0 * math.atan2(pose.orientation.z, pose.orientation.w) - run["odometry/yaw"][row]) < 1e-15
        if name == "omni":  # three wheels tell the twist, and it them
            spins = [run[f"wheels/{wheel}/spin_rate"][row] for wheel in run.wheels]
            told = wheel_rows(config) @ [twist.linear.x, twist.linear.y, twist.angular.z]
            np.testing.assert_allclose(told, spins, rtol=0.0, atol=1e-12)  # measured 4e-16
    (static,) = messages["/tf_static"]
    ((parent, matrix),) = matrices(static.message.transforms).values()
    assert parent == "world" and (matrix == np.eye(4)).all()


def test_a_wheel_without_a_machine_has_no_odometry(recorded):
    assert "/odom" not in recorded("bare wheel")[3]


# --- what happens ---------------------------------------------------------------------------------


def markers_by_row(messages):
    """{(kind, wheel): marker} of every row."""
    return [
        {(marker.ns, marker.text): marker for marker in said.message.markers} for said in messages["/contact_markers"]
    ]


def arrow(marker):
    tail, tip = (np.array([point.x, point.y, point.z]) for point in marker.points)
    return tail, tip - tail


def scales_of(path):
    told = {record.name: record.metadata for record in records(path) if type(record).__name__ == "Metadata"}["omnisim"]
    return {"normal": float(told["m_per_N"]), "friction": float(told["m_per_N"]), "slip": float(told["m_per_m/s"])}


@pytest.mark.parametrize("name", UPRIGHT)
def test_arrows_are_the_forces_and_the_slip_at_the_contact_points(recorded, name):
    run, config, path, messages = recorded(name)
    lengths, shown = scales_of(path), 0
    for row, markers in enumerate(markers_by_row(messages)):
        assert len(markers) == 3 * len(run.wheels)
        for wheel in config.wheels:
            heading = run["body/yaw"][row] + math.radians(wheel.heading_deg)
            cos, sin = math.cos(heading), math.sin(heading)
            h, k = np.array([cos, sin, 0.0]), np.array([-sin, cos, 0.0])
            part = f"wheels/{wheel.name}"
            friction, slip = (run[f"{part}/{key}"][row] for key in ("friction_force", "slip_velocity"))
            expected = {
                "normal": [0.0, 0.0, run[f"{part}/normal_force"][row]],
                "friction": friction[0] * h + friction[1] * k,
                "slip": slip[0] * h + slip[1] * k,
            }
            for kind, vector in expected.items():
                marker = markers[kind, wheel.name]
                assert (marker.header.frame_id, marker.frame_locked, marker.lifetime.sec) == ("world", False, 0)
                if marker.action == 2:
                    assert np.linalg.norm(vector) * lengths[kind] <= 0.01 * config.type_of(wheel).radius
                    continue
                tail, way = arrow(marker)
                shown += 1
                assert tail.tolist() == run[f"{part}/contact_point"][row].tolist()
                np.testing.assert_allclose(
                    way, lengths[kind] * np.array(vector), rtol=0.0, atol=1e-15
                )  # measured 5e-17
                assert np.linalg.norm(way) <= 1.7 * config.type_of(wheel).radius + 1e-15 or kind == "friction"
    assert shown > len(run.time)


@pytest.mark.parametrize("name", ["mecanum", "bare wheel", "rockers"])
def test_the_machine_is_drawn_without_any_file(recorded, name):
    """Rollers as triangles on their exact surface, each in its own frame."""
    _, config, _, messages = recorded(name)
    drawn = {marker.header.frame_id: marker for marker in messages["/machine_markers"][0].message.markers}
    assert all(marker.frame_locked for marker in drawn.values())
    assert set(drawn) <= {stamped.child_frame_id for stamped in messages["/tf"][0].message.transforms}
    if config.chassis:
        assert drawn["chassis"].type == 1
    for wheel in config.wheels:
        assert drawn[f"{wheel.name}_wheel"].type == 3
        profile = roller(config.type_of(wheel), 9, 16).vertices
        for number in range(config.type_of(wheel).rollers):
            points = [[point.x, point.y, point.z] for point in drawn[f"{wheel.name}_roller_{number}"].points]
            assert drawn[f"{wheel.name}_roller_{number}"].type == 11 and len(points) % 3 == 0
            np.testing.assert_array_equal(np.unique(points, axis=0), np.unique(profile, axis=0))


def test_a_wheel_in_the_air_has_no_arrows(recorded):
    run, _, _, messages = recorded("falling")
    assert all(run[f"wheels/{wheel}/contact_roller"].max() == -1 for wheel in run.wheels)
    for markers in markers_by_row(messages):
        assert all((marker.action, marker.points) == (2, []) for marker in markers.values())


@pytest.mark.parametrize(("name", "least"), [("bumps", 1e-2), ("rockers", 5e-4)])
def test_on_uneven_ground_loads_stand_on_it_and_the_rest_lies_along_it(recorded, name, least):
    """h = axle x n, k = n x h; normals by differences of heights, twice as coarse as those of the export."""
    run, config, path, messages = recorded(name)
    floor, step, steep, lengths = floor_of_scene(config), 2e-5, 0.0, scales_of(path)
    for row, (markers, said) in enumerate(zip(markers_by_row(messages), messages["/tf"], strict=True)):
        placed = in_world(matrices(said.message.transforms))
        for wheel in run.wheels:
            if markers["normal", wheel].action == 2:
                continue
            tail, _ = arrow(markers["normal", wheel])
            x, y = tail[0] + step * np.array([1, -1, 0, 0]), tail[1] + step * np.array([0, 0, 1, -1])
            east, west, north, south = heights(floor, x, y)
            up = np.array([west - east, south - north, 2.0 * step])
            up /= np.linalg.norm(up)
            ahead = np.cross(placed[f"{wheel}_wheel"][:3, 1], up)
            ahead /= np.linalg.norm(ahead)
            steep = max(steep, math.hypot(up[0], up[1]))
            expected = {"normal": run[f"wheels/{wheel}/normal_force"][row] * up}
            for kind, key in (("friction", "friction_force"), ("slip", "slip_velocity")):
                h, k = run[f"wheels/{wheel}/{key}"][row]
                expected[kind] = h * ahead + k * np.cross(up, ahead)
            for kind, vector in expected.items():
                if markers[kind, wheel].action == 0:
                    tail, way = arrow(markers[kind, wheel])
                    assert tail.tolist() == run[f"wheels/{wheel}/contact_point"][row].tolist()
                    error = np.linalg.norm(way - lengths[kind] * vector)
                    assert error < 1e-8 * np.linalg.norm(way)  # measured 4e-10
    assert steep > least


def test_events_are_a_log_with_levels(recorded):
    run, _, _, messages = recorded("mecanum")
    assert len(messages["/events"]) == len(run["events/time"]) > 1
    rows = zip(*(run[f"events/{key}"].tolist() for key in ("time", "kind", "wheel", "roller_to")), strict=True)
    for (time, _, log), (seconds, kind, wheel, second) in zip(messages["/events"], rows, strict=True):
        assert time == round(seconds * 1e9) == log.stamp.sec * 10**9 + log.stamp.nanosec
        assert log.name == wheel and log.msg.split()[0] == kind
        assert log.level == {"exchange": 10, "stick": 20, "slip": 20}[kind]
        assert kind != "exchange" or log.msg.endswith(f"to roller {second}")


def test_a_run_that_stops_early_says_so_and_has_its_rows(tmp_path):
    run = omnisim.simulate(parse(tomlkit.dumps(FREE["short shapes"]), overrides=SHORT))
    path = write(run, tmp_path / "run.mcap")[0]
    messages = by_rosbags(path, "ROS2_JAZZY")
    assert not run.complete
    last = messages["/events"][-1].message
    assert (last.level, last.msg) == (40, f"stop: {run.attributes['status']}")
    assert len(messages["/tf"]) == len(run.time)


# --- the command ----------------------------------------------------------------------------------


def test_the_command_writes_the_recording_the_urdf_and_the_meshes(folder):
    run_of("omni").save("kiwi.h5")
    result = command("export", "kiwi.h5", "kiwi.mcap")
    names = ["kiwi.mcap", "kiwi.urdf", "kiwi_omni_roller.stl"]
    assert result.exit_code == 0 and all(name in result.stdout for name in names), result.stderr
    assert sorted(path.name for path in folder.iterdir()) == sorted(["kiwi.h5", *names])
    refused(command("export", "kiwi.h5", "kiwi.mcap"), "kiwi.mcap: exists already; --force")
    for name in names[:2]:
        (folder / name).unlink()
    assert command("export", "kiwi.h5", "kiwi.mcap").exit_code == 0  # the mesh is that of the same wheel, and stays
    for name in names[:2]:
        (folder / name).unlink()
    (folder / names[2]).write_text("precious")
    refused(command("export", "kiwi.h5", "kiwi.mcap"), f"{names[2]}: exists already; --force")
    assert (folder / names[2]).read_text() == "precious" and not (folder / names[0]).exists()
    assert command("export", "kiwi.h5", "kiwi.mcap", "--force").exit_code == 0
    assert (folder / names[2]).stat().st_size > 1e5


def test_a_scene_that_cannot_be_read_is_told_and_nothing_written(folder):
    synthetic_trajectory().save("made.h5")
    result = command("export", "made.h5", "made.mcap")
    assert result.exit_code == 2 and result.stderr.startswith("Error: made.h5: scene of the file:1: time: missing")
    assert [path.name for path in folder.iterdir()] == ["made.h5"]


def test_a_run_goes_into_a_recording_at_once(folder):
    result = command("run", "kiwi", "-o", "kiwi.mcap", "--set", "time.end=0.02")
    assert result.exit_code == 0, result.stderr
    assert (folder / "kiwi.urdf").exists() and len(by_rosbags(folder / "kiwi.mcap", "ROS2_HUMBLE")["/tf"]) == 2
