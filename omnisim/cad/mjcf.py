"""A scene for MuJoCo. Rollers touch as convex hulls of fine meshes, which roll far better there than few spheres."""

import math
from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from omnisim.cad.robot_description import COLOURS, LAID, Body, bodies, headed, numbers
from omnisim.dynamics.packing import gravity
from omnisim.scene.schema import Config

STEP = 1e-4  # s
# As near to rigid as this step allows: less stiffness and damping by mass (1/s^2, 1/s), critically damped.
CONTACT = {"solref": "-1e6 -2e3", "solimp": "0.999 0.9999 0.0001", "condim": "3"}
UNTOUCHED = {"contype": "0", "conaffinity": "0"}
# Touches what touches all, but no other roller. Geoms of group 3 are hidden until asked for.
TOUCHING = {"contype": "0", "conaffinity": "1", "group": "3"}


def mjcf(config: Config, name: str, meshes: Mapping[str, str], contacts: Mapping[str, str]) -> Element:
    """The scene on a floor; the keyframe "start" has its initial pose and velocities.

    meshes, contacts: of a roller of each wheel type in use, files of what is drawn and of what touches.
    A rate drive is a velocity actuator with its proportional gain and its limit, without the integral; any other drive
    is a torque (N m), of a motor at the axle. Actuators have the names of the wheels.
    """
    root = headed(Element("mujoco", model=name), config)
    SubElement(root, "compiler", angle="radian", eulerseq="XYZ")
    along, normal = gravity(config)
    option = {"timestep": numbers(STEP), "integrator": "implicitfast", "cone": "elliptic"}
    SubElement(root, "option", option, gravity=numbers(*along, -normal))
    friction = numbers(config.friction.coefficient, 0.0, 0.0)
    SubElement(SubElement(root, "default"), "geom", CONTACT | {"friction": friction})
    asset, world = SubElement(root, "asset"), SubElement(root, "worldbody")
    SubElement(world, "light", pos="0 0 3", directional="true")
    SubElement(world, "geom", name="floor", type="plane", size="10 10 1", rgba="0.85 0.85 0.85 1")
    for file in (*meshes.values(), *contacts.values()):
        SubElement(asset, "mesh", name=file, file=file)
    elements: dict[str | None, Element] = {}
    for body in bodies(config):
        element = SubElement(elements.get(body.parent, world), "body", name=body.name)
        element.attrib |= {"pos": numbers(*body.place), "euler": numbers(*body.angles)}
        if body.parent is None:
            base_joints(element, config)
        hinge_and_inertia(element, body)
        kind, size = body.shape
        if kind == "roller":
            drawn, touching = meshes[size], contacts[size]
            SubElement(element, "geom", UNTOUCHED, type="mesh", mesh=drawn, rgba=COLOURS["rubber"])
            SubElement(element, "geom", TOUCHING, type="mesh", mesh=touching)
        elif size[0] > 0.0:
            stand_in(element, body)
        elements[body.name] = element
    actuators(SubElement(root, "actuator"), config)
    start(SubElement(SubElement(root, "keyframe"), "key", name="start"), config)
    return root


def base_joints(element: Element, config: Config) -> None:
    """All six motions, or those of a body that is held upright."""
    if config.upright == "contacts":
        SubElement(element, "freejoint", name="base")
        return
    for axis, direction in (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1")):
        SubElement(element, "joint", name=axis, type="slide", axis=direction)
    SubElement(element, "joint", name="yaw", type="hinge", axis="0 0 1")


def hinge_and_inertia(element: Element, body: Body) -> None:
    if body.hinge:
        friction = {"damping": body.damping, "frictionloss": body.friction, "armature": body.armature}
        shown = {key: numbers(value) for key, value in friction.items() if value > 0.0}
        SubElement(element, "joint", shown, name=body.joint, axis=body.hinge)
    inertia = numbers(*body.inertia)
    SubElement(element, "inertial", pos=numbers(*body.centre), mass=numbers(body.mass), diaginertia=inertia)


def stand_in(element: Element, body: Body) -> None:
    """A plain shape that touches nothing."""
    kind, size = body.shape
    half = (*(0.5 * length for length in size),) if kind == "box" else (size[0], 0.5 * size[1])
    angles = LAID if kind == "cylinder" else (0.0, 0.0, 0.0)
    place = {"pos": numbers(*body.centre), "euler": numbers(*angles)}
    SubElement(element, "geom", UNTOUCHED | place, type=kind, size=numbers(*half), rgba=COLOURS["stand_in"])


def actuators(element: Element, config: Config) -> None:
    for wheel in config.wheels:
        target = {"name": wheel.name, "joint": f"{wheel.name}_wheel_joint"}
        if wheel.drive.kind != "rate":
            SubElement(element, "motor", target)
            continue
        velocity = SubElement(element, "velocity", target, kv=numbers(wheel.drive.proportional))
        if wheel.drive.torque_limit < math.inf:
            velocity.set("forcerange", numbers(-wheel.drive.torque_limit, wheel.drive.torque_limit))


def start(key: Element, config: Config) -> None:
    """Pose and velocities in the order of the joints."""
    initial = config.initial
    half = 0.5 * math.radians(config.initial.yaw_deg)
    place, speed = [*initial.position, 0.0], [*initial.velocity, 0.0]
    if config.upright == "contacts":
        place += [math.cos(half), 0.0, 0.0, math.sin(half)]
        speed += [0.0, 0.0, initial.yaw_rate]
    else:
        place.append(2.0 * half)
        speed.append(initial.yaw_rate)
    for wheel in config.wheels:
        count = config.type_of(wheel).roller_count
        place += [wheel.spin_angle, *[0.0] * count]
        speed += [wheel.spin_rate, *np.broadcast_to(wheel.roller_rates, count)]
    key.attrib |= {"qpos": numbers(*place), "qvel": numbers(*speed)}
