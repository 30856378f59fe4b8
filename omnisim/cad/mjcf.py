"""A scene for MuJoCo. Rollers touch as convex hulls of fine meshes, which roll far better there than few spheres.

Contacts of a machine held upright are as rigid as the step allows, those of one free in space the rubber of the scene:
see rubber.py.
"""

import math
from collections.abc import Iterator, Mapping
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from omnisim.cad.robot_description import COLOURS, LAID, Body, bodies, headed, numbers, rolling_resistances
from omnisim.cad.rubber import SETTINGS, press, touching_name
from omnisim.dynamics.packing import gravity, pack
from omnisim.dynamics.state import places_in
from omnisim.march.spatial_start import pose_at_start, quaternion, state_in_space
from omnisim.scene.schema import Config
from omnisim.scene.wheel_schema import WheelType

STEP = 1e-4  # s
# As near to rigid as this step allows: less stiffness and damping by mass (1/s^2, 1/s), critically damped.
CONTACT = {"solref": "-1e6 -2e3", "solimp": "0.999 0.9999 0.0001", "condim": "3"}
PLANE = {"type": "plane"}
BLOCK = {"type": "box", "pos": "0 0 -1"}  # touches a hull at one point, a plane at up to four with a spring each
UNTOUCHED = {"contype": "0", "conaffinity": "0"}
Start = tuple[list[float], list[float], dict[str, tuple[float, float]]]  # qpos and qvel of the base; of some joints
# Touches what touches all, but no other roller. Geoms of group 3 are hidden until asked for.
TOUCHING = {"contype": "0", "conaffinity": "1", "group": "3"}


def mjcf(config: Config, name: str, meshes: Mapping[str, str], contacts: Mapping[str, str]) -> Element:
    """The scene on a floor; the keyframe "start" has its initial pose and velocities.

    meshes, contacts: of a roller of each wheel type in use, files of what is drawn and of what touches.
    A rate drive is a velocity actuator with its proportional gain and its limit, without the integral; any other drive
    is a torque (N m), of a motor at the axle. Actuators have the names of the wheels.
    """
    root = headed(Element("mujoco", model=name), config, *differences(config))
    SubElement(root, "compiler", angle="radian", eulerseq="XYZ")
    along, normal = gravity(config)
    free = config.upright == "free"
    option = {"timestep": numbers(STEP), "integrator": "implicitfast", "cone": "elliptic"}
    settings = SubElement(root, "option", option | (SETTINGS if free else {}), gravity=numbers(*along, -normal))
    if free:
        SubElement(settings, "flag", multiccd="disable")  # one point of contact of two shapes
    friction = numbers(config.friction.coefficient, 0.0, 0.0)
    SubElement(SubElement(root, "default"), "geom", CONTACT | {"friction": friction})
    asset, world = SubElement(root, "asset"), SubElement(root, "worldbody")
    SubElement(world, "light", pos="0 0 3", directional="true")
    SubElement(world, "geom", BLOCK if free else PLANE, name="floor", size="10 10 1", rgba="0.85 0.85 0.85 1")
    for file in (*meshes.values(), *contacts.values()):
        SubElement(asset, "mesh", name=file, file=file)
    elements: dict[str | None, Element] = {}
    everything = list(bodies(config))
    for body in everything:
        element = SubElement(elements.get(body.parent, world), "body", name=body.name)
        element.attrib |= {"pos": numbers(*body.place), "euler": numbers(*body.angles)}
        if body.parent is None:
            base_joints(element, config)
        joint_and_inertia(element, body)
        kind, size = body.shape
        if kind == "roller":
            drawn, touching = meshes[size], contacts[size]
            SubElement(element, "geom", UNTOUCHED, type="mesh", mesh=drawn, rgba=COLOURS["rubber"])
            given = TOUCHING | resisting(config.wheel_types[size], config.friction.coefficient)
            SubElement(element, "geom", given, name=touching_name(body), type="mesh", mesh=touching)
        elif size[0] > 0.0:
            stand_in(element, body)
        elements[body.name] = element
    if free:
        press(SubElement(root, "contact"), config, everything)
    actuators(SubElement(root, "actuator"), config)
    start(SubElement(SubElement(root, "keyframe"), "key", name="start"), config, everything)
    return root


def differences(config: Config) -> Iterator[str]:
    """What MuJoCo cannot be told, or is told otherwise."""
    if config.friction.law == "brush":
        creep = f"creep_stiffness = {config.friction.creep_stiffness:g}"
        yield f"left out: rubber that creeps, {creep}; MuJoCo's friction sticks up to the coefficient"
    if told := rolling_resistances(config):
        yield f"{told} is the rolling friction of rollers; it has no rolling_rate, and shares one cone with friction"


def resisting(kind: WheelType, coefficient: float) -> dict[str, str]:
    """Rolling friction of a geom: like rolling resistance a length, by the load."""
    if not kind.roller.has_rolling_resistance:
        return {}
    return {"condim": "6", "friction": numbers(coefficient, 0.0, kind.roller.rolling_resistance)}


def base_joints(element: Element, config: Config) -> None:
    """All six motions, or those of a body that is held upright."""
    if config.upright != "servo":
        SubElement(element, "freejoint", name="base")
        return
    for axis, direction in (("x", "1 0 0"), ("y", "0 1 0"), ("z", "0 0 1")):
        SubElement(element, "joint", name=axis, type="slide", axis=direction)
    SubElement(element, "joint", name="yaw", type="hinge", axis="0 0 1")


def joint_and_inertia(element: Element, body: Body) -> None:
    if body.axis:
        given = {"damping": body.damping, "frictionloss": body.friction, "armature": body.armature}
        given["stiffness"] = body.stiffness
        shown = {key: numbers(value) for key, value in given.items() if value > 0.0}
        if body.slides:
            shown["type"] = "slide"
        if body.spring_at is not None:
            shown["springref"] = numbers(body.spring_at)
        SubElement(element, "joint", shown, name=body.joint, axis=body.axis)
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


def start(key: Element, config: Config, everything: list[Body]) -> None:
    """Pose and velocities in the order of the joints."""
    place, speed, joints = start_in_space(config) if config.upright == "free" else start_on_plane(config)
    for wheel in config.wheels:
        joints[f"{wheel.name}_wheel_joint"] = wheel.spin_angle, wheel.spin_rate
        count = config.type_of(wheel).rollers
        for number, rate in enumerate(np.broadcast_to(wheel.roller_rates, count)):
            joints[f"{wheel.name}_roller_{number}_joint"] = 0.0, float(rate)
    for body in everything:
        if body.axis:
            place.append(joints[body.joint][0])
            speed.append(joints[body.joint][1])
    key.attrib |= {"qpos": numbers(*place), "qvel": numbers(*speed)}


def start_on_plane(config: Config) -> Start:
    """Of the base, held upright or carried by its contacts."""
    initial = config.initial
    half = 0.5 * math.radians(config.initial.yaw_deg)
    place, speed = [*initial.position, 0.0], [*initial.velocity, 0.0]
    if config.upright == "contacts":
        return [*place, math.cos(half), 0.0, 0.0, math.sin(half)], [*speed, 0.0, 0.0, initial.yaw_rate], {}
    return [*place, 2.0 * half], [*speed, initial.yaw_rate], {}


def start_in_space(config: Config) -> Start:
    """Of a free machine, at rest on its rubber if the scene does not place it. Raises ConfigError."""
    parameters, initial = pack(config), config.initial
    pose = pose_at_start(config, parameters)
    y, _ = state_in_space(config, parameters, pose)
    at = places_in(parameters)
    place = [*initial.position, pose.height, *quaternion(math.radians(initial.yaw_deg), pose.pitch, pose.roll)]
    speed = [*initial.velocity, initial.vertical_velocity, *y[at.rate : at.rate + 3]]
    names = [f"{wheel.name}_hub_joint" for wheel in config.wheels if wheel.suspension is not None]
    names += [f"{rocker.name}_rocker_joint" for rocker in config.axles]
    return place, speed, {name: (float(s), 0.0) for name, s in zip(names, pose.carriers, strict=True)}
