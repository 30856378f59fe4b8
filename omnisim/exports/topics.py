"""A run as ROS 2 messages, topic by topic.

Frames are the links of the URDF, in `world`; `odom` is the same frame, since the odometry of a machine begins at its
true pose. Stamps are simulated time. Units and axes as REP 103 has them, frames as REP 105.
"""

from typing import Any, NamedTuple

import numpy as np

from omnisim.dynamics.packing import odometry_of
from omnisim.exports.arrows import Scales
from omnisim.exports.frames import Frames, Joint, Pose, Twist, Z, about
from omnisim.exports.markers import contact_markers, machine_markers
from omnisim.exports.messages import WORLD, Messages, header, nanoseconds, once, ros, rows, stamp, times, vectors

ODOM = "odom"
DEBUG, INFO, WARN, ERROR = 10, 20, 30, 40  # levels of a Log
LEVELS = {"stick": INFO, "slip": INFO, "lift_off": WARN, "touch_down": WARN, "stop": ERROR}
UNTOLD = np.zeros(36)  # covariances: there are none


class Topic(NamedTuple):
    """A topic, the type of its messages, and what was said on it; latched: kept for those who listen later."""

    name: str
    type: str
    messages: Messages
    latched: bool = False


def topics(frames: Frames, lengths: Scales, description: str) -> list[Topic]:
    """All of a run; description: of the machine, a URDF. Of what happens at one instant, first topics come first."""
    run = frames.trajectory
    found = [
        Topic("/robot_description", "std_msgs/msg/String", once(ros("String")(description)), latched=True),
        Topic("/tf_static", "tf2_msgs/msg/TFMessage", once(ros("TFMessage")([odom_in_world()])), latched=True),
        Topic("/machine_markers", "visualization_msgs/msg/MarkerArray", machine_markers(frames), latched=True),
        Topic("/tf", "tf2_msgs/msg/TFMessage", transforms(frames)),
        Topic("/joint_states", "sensor_msgs/msg/JointState", joint_states(frames)),
        Topic("/ground_truth", "nav_msgs/msg/Odometry", ground_truth(frames)),
        Topic("/contact_markers", "visualization_msgs/msg/MarkerArray", contact_markers(frames, lengths)),
        Topic("/events", "rcl_interfaces/msg/Log", events(frames)),
    ]
    if "odometry/position" in run:
        found.insert(-2, Topic("/odom", "nav_msgs/msg/Odometry", odometry(frames)))
    return found


# --- the machine ----------------------------------------------------------------------------------


def odom_in_world() -> Any:
    still = Pose(np.zeros((1, 3)), about(Z, np.zeros(1)))
    return ros("TransformStamped")(header(0, WORLD), ODOM, ros("Transform")(*next(rows(still, "Vector3"))))


def transforms(frames: Frames) -> Messages:
    """Of all bodies, each in its parent."""
    stamped, transform, message = ros("TransformStamped"), ros("Transform"), ros("TFMessage")
    links = [(body.parent or WORLD, body.name) for body in frames.bodies]
    poses = zip(*(rows(frames.poses[child], "Vector3") for _, child in links), strict=True)
    for time, row in zip(times(frames), poses, strict=True):
        heads = {parent: header(time, parent) for parent, _ in links}
        yield time, message([
            stamped(heads[parent], child, transform(*pose)) for (parent, child), pose in zip(links, row, strict=True)
        ])  # fmt: skip


def joint_states(frames: Frames) -> Messages:
    """Of all joints, named as in the URDF."""
    state, joints = ros("JointState"), frames.joints
    names = [body.joint for body in frames.bodies if body.name in joints]
    parts = (np.stack([joint[part] for joint in joints.values()], axis=1) for part in range(len(Joint._fields)))
    for time, *values in zip(times(frames), *parts, strict=True):
        yield time, state(header(time, ""), names, *values)


# --- where it is ----------------------------------------------------------------------------------


def ground_truth(frames: Frames) -> Messages:
    return odometries(frames, WORLD, frames.base, frames.base_twist)


def odometry(frames: Frames) -> Messages:
    """As ideal wheels without slip tell it."""
    run = frames.trajectory
    x, y = run["odometry/position"].T
    level = np.zeros(len(x))
    twist_of = odometry_of(frames.config)
    assert twist_of is not None  # else it had none
    ahead, left, yaw_rate = twist_of @ np.array([run[f"wheels/{wheel}/spin_rate"] for wheel in run.wheels])
    twist = Twist(np.column_stack([ahead, left, level]), yaw_rate[:, None] * Z)
    return odometries(frames, ODOM, Pose(np.column_stack([x, y, level]), about(Z, run["odometry/yaw"])), twist)


def odometries(frames: Frames, frame: str, pose: Pose, twist: Twist) -> Messages:
    message, with_pose, with_twist = ros("Odometry"), ros("PoseWithCovariance"), ros("TwistWithCovariance")
    placed, moving = ros("Pose"), ros("Twist")
    parts = zip(times(frames), rows(pose, "Point"), vectors(twist.linear), vectors(twist.angular), strict=True)
    for time, there, linear, angular in parts:
        found = with_pose(placed(*there), UNTOLD), with_twist(moving(linear, angular), UNTOLD)
        yield time, message(header(time, frame), frames.root, *found)


# --- what happens ---------------------------------------------------------------------------------


def events(frames: Frames) -> Messages:
    """Named by the wheel. What ends a run before its time is an error; exchanges, of which there are many, are told to
    those who look for bugs."""
    run, log = frames.trajectory, ros("Log")
    columns = (run[f"events/{name}"].tolist() for name in ("time", "kind", "wheel", "roller_from", "roller_to"))
    for seconds, kind, wheel, first, second in zip(*columns, strict=True):
        time = nanoseconds(seconds)
        level = LEVELS.get(kind, DEBUG)
        said = f"{kind}: {run.attributes['status']}" if kind == "stop" else told(kind, first, second)
        yield time, log(stamp(time), level, wheel or "omnisim", said, "", "", 0)


def told(kind: str, first: int, second: int) -> str:
    """An event with its rollers, -1 where none is meant."""
    rollers = [f"{word} {roller}" for word, roller in (("from roller", first), ("to roller", second)) if roller >= 0]
    return " ".join([kind, *rollers])
