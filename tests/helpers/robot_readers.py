"""Robots as readers other than omnisim find them: two URDF readers from the package index, and plain XML for MJCF."""

from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation


class Link(NamedTuple):
    """mass (kg), centre (3,) and inertia (3, 3) about it in the link's axes, and how it hangs on its parent: `origin`
    (4, 4) of its frame there, the joint and its axis (3,) in its own frame; None for the root."""

    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    parent: str | None
    joint: str | None
    origin: np.ndarray
    axis: np.ndarray | None


def transform(xyz, rpy) -> np.ndarray:
    """Matrix (4, 4) of a place and of roll, pitch and yaw about fixed axes."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), xyz
    return matrix


def poses(links: dict[str, Link], positions: dict[str, float]) -> dict[str, np.ndarray]:
    """Frames (4, 4) of all links in that of the root, parents first, at these positions of the joints (rad)."""
    found: dict[str, np.ndarray] = {}
    for name, link in links.items():
        if link.parent is None:
            found[name] = np.eye(4)
            continue
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec(positions[link.joint] * link.axis).as_matrix()
        found[name] = found[link.parent] @ link.origin @ turn
    return found


def by_urdf_parser_py(path) -> dict[str, Link]:
    """The reader of ROS 1 in Python."""
    reader = pytest.importorskip("urdf_parser_py.urdf", reason="needs urdf_parser_py")
    robot, found = reader.URDF.from_xml_file(str(path)), {}
    joints = {joint.child: joint for joint in robot.joints}
    for link in robot.links:
        joint, inertial = joints.get(link.name), link.inertial
        assert list(inertial.origin.rpy) == [0.0, 0.0, 0.0]
        hung = (None, None, np.eye(4), None)
        if joint:
            hung = (joint.parent, joint.name, transform(joint.origin.xyz, joint.origin.rpy), np.array(joint.axis))
        inertia = np.array(inertial.inertia.to_matrix())
        found[link.name] = Link(inertial.mass, np.array(inertial.origin.xyz), inertia, *hung)
    return found


def by_yourdfpy(path) -> dict[str, Link]:
    """The reader of many tools for learning and grasping."""
    robot, found = yourdfpy_robot(path, load_meshes=False).robot, {}
    joints = {joint.child: joint for joint in robot.joints}
    for link in robot.links:
        joint, inertial = joints.get(link.name), link.inertial
        np.testing.assert_array_equal(inertial.origin[:3, :3], np.eye(3))
        hung = (joint.parent, joint.name, joint.origin, joint.axis) if joint else (None, None, np.eye(4), None)
        found[link.name] = Link(inertial.mass, inertial.origin[:3, 3], inertial.inertia, *hung)
    return found


def yourdfpy_robot(path, **options):
    robot = pytest.importorskip("yourdfpy", reason="needs yourdfpy").URDF.load(str(path), **options)
    assert robot.validate(), robot.errors
    return robot


def by_xml(path) -> dict[str, Link]:
    """The bodies of an MJCF whose angles are radians about fixed axes, as its compiler is told."""
    root, found = ElementTree.parse(path).getroot(), {}
    assert root.find("compiler").attrib == {"angle": "radian", "eulerseq": "XYZ"}

    def walk(body, parent):
        inertial, joint = body.find("inertial"), body.find("joint")
        hung = (None, None, np.eye(4), None)
        if parent:
            origin = transform(values(body, "pos"), values(body, "euler"))
            hung = (parent, joint.get("name"), origin, values(joint, "axis"))
        inertia = np.diag(values(inertial, "diaginertia"))
        found[body.get("name")] = Link(float(inertial.get("mass")), values(inertial, "pos"), inertia, *hung)
        for child in body.findall("body"):
            walk(child, body.get("name"))

    for body in root.find("worldbody").findall("body"):
        walk(body, None)
    return found


def values(element, key) -> np.ndarray:
    return np.array([float(word) for word in element.get(key).split()])
