"""A scene as a URDF: what it leaves out (floor, contact, drives, rotors) is the business of who reads it."""

from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

from omnisim.config import Config
from omnisim.robot_description import LAID, Body, bodies, headed, numbers


def urdf(config: Config, meshes: Mapping[str, str]) -> Element:
    """The machine, or the wheel alone: links on continuous joints."""
    root = headed(Element("robot", name="omnisim"), config)
    for body in bodies(config, meshes):
        link(SubElement(root, "link", name=body.name), body)
        if body.parent is not None:
            joint = SubElement(root, "joint", name=body.name, type="continuous")
            SubElement(joint, "origin", xyz=numbers(*body.place), rpy=numbers(*body.angles))
            SubElement(joint, "parent", link=body.parent)
            SubElement(joint, "child", link=body.name)
            SubElement(joint, "axis", xyz=body.hinge)
            SubElement(joint, "dynamics", damping=repr(body.damping), friction=repr(body.friction))
    return root


def link(element: Element, body: Body) -> None:
    """Its inertia and shape."""
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=numbers(*body.centre))
    SubElement(inertial, "mass", value=repr(body.mass))
    diagonal = dict(zip(("ixx", "iyy", "izz"), map(repr, body.inertia), strict=True))
    SubElement(inertial, "inertia", diagonal, ixy="0", ixz="0", iyz="0")
    kind, size = body.shape
    if kind == "mesh":
        for use in ("visual", "collision"):
            SubElement(SubElement(SubElement(element, use), "geometry"), "mesh", filename=size)
    elif size[0] > 0.0:
        visual = SubElement(element, "visual")
        laid, place = (LAID, (0.0, 0.0, 0.0)) if kind == "cylinder" else ((0.0, 0.0, 0.0), body.centre)
        SubElement(visual, "origin", xyz=numbers(*place), rpy=numbers(*laid))
        sizes = {"size": numbers(*size)} if kind == "box" else {"radius": repr(size[0]), "length": repr(size[1])}
        SubElement(SubElement(visual, "geometry"), kind, sizes)
