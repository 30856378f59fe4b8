"""Where everything is: transforms, joints, odometry and URDF of a recording are those of the trajectory, told anew.

Measured values stand beside the bounds.
"""

import math
from urllib.parse import unquote
from xml.etree import ElementTree

import numpy as np
import pytest
from recorded_machines import MACHINES, UPRIGHT
from recordings import in_world, matrices
from robot_readers import transform, values
from scipy.spatial.transform import Rotation

from omnisim.scene.ideal_kinematics import wheel_rows

pytest.importorskip("mcap", reason="needs mcap")
pytest.importorskip("rosbags", reason="needs rosbags")


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
