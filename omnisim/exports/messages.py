"""Messages of ROS 2 Humble by name, and their smallest parts.

Of common_interfaces, geometry2 and rcl_interfaces; Jazzy and Kilted have the same fields, so the same bytes.
"""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from omnisim.exports.frames import Frames, Pose
from omnisim.results.tables import extra

WORLD = "world"  # the frame whose axes are those of trajectories
NANOSECONDS = 1e9
Messages = Iterator[tuple[int, Any]]  # times (ns), in order, and messages


@cache
def store() -> Any:
    """The types of ROS 2 Humble."""
    with extra("mcap"):
        from rosbags.typesys import Stores, get_typestore
    return get_typestore(Stores.ROS2_HUMBLE)


PACKAGES = {
    "std_msgs": ("ColorRGBA", "Header", "String"),
    "builtin_interfaces": ("Duration", "Time"),
    "geometry_msgs": (
        "Point", "Pose", "PoseWithCovariance", "Quaternion", "Transform", "TransformStamped", "Twist",
        "TwistWithCovariance", "Vector3",
    ),
    "nav_msgs": ("Odometry",),
    "rcl_interfaces": ("Log",),
    "sensor_msgs": ("CompressedImage", "JointState"),
    "tf2_msgs": ("TFMessage",),
    "visualization_msgs": ("Marker", "MarkerArray", "MeshFile"),
}  # fmt: skip
HOMES = {name: package for package, names in PACKAGES.items() for name in names}


@cache
def ros(name: str) -> Any:
    """The class of a message."""
    return store().types[f"{HOMES[name]}/msg/{name}"]


def header(time: int, frame: str) -> Any:
    return ros("Header")(stamp(time), frame)


def stamp(time: int) -> Any:
    return ros("Time")(*divmod(time, int(NANOSECONDS)))


def nanoseconds(seconds: float) -> int:
    return round(seconds * NANOSECONDS)


def times(frames: Frames) -> list[int]:
    """Of the rows, ns."""
    return [nanoseconds(seconds) for seconds in frames.trajectory.time.tolist()]


def once(message: Any) -> Messages:
    """At the beginning."""
    yield 0, message


def vectors(values: np.ndarray, kind: str = "Vector3") -> Iterator[Any]:
    """Of (T, 3)."""
    return (ros(kind)(*value) for value in values.tolist())


def quaternions(orientation: np.ndarray) -> Iterator[Any]:
    """Of (T, 4) w, x, y, z."""
    return (ros("Quaternion")(x, y, z, w) for w, x, y, z in orientation.tolist())


def rows(pose: Pose, place: str) -> Iterator[tuple[Any, Any]]:
    """Place, a Vector3 or a Point, and Quaternion of every row."""
    return zip(vectors(pose.position, place), quaternions(pose.orientation), strict=True)
