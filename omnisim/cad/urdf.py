"""A scene as a URDF: what it leaves out (floor, drives, rotors) is the business of who reads it.

URDF has no shape that is round both ways but the sphere: a roller touches as a row of them, which its profile holds.
Nor has it springs: a suspension slides between limits that nothing reaches, with its damping, and its spring stands in
Gazebo's extension, which other readers pass over. Friction on the floor, creep and rolling resistance go by the load,
friction of a joint does not: a comment has them.
"""

from collections.abc import Iterator, Mapping
from xml.etree.ElementTree import Element, SubElement

from omnisim.cad.geometry import Spheres, spheres_within
from omnisim.cad.robot_description import COLOURS, LAID, Body, bodies, headed, numbers, rolling_resistances
from omnisim.scene.schema import FRICTION_KEYS, Config

LIMITS = {"lower": "-1", "upper": "1", "effort": "1e6", "velocity": "1e3"}  # m, N, m/s: a slide has to have some


def urdf(config: Config, name: str, meshes: Mapping[str, str]) -> Element:
    """The machine, or the wheel alone: links on continuous joints. meshes: of a roller of each wheel type in use."""
    root = headed(Element("robot", name=name), config, *left_out(config))
    for colour, rgba in COLOURS.items():
        SubElement(SubElement(root, "material", name=colour), "color", rgba=rgba)
    spheres = {used: spheres_within(config.wheel_types[used]) for used in meshes}
    for body in bodies(config):
        link = SubElement(root, "link", name=body.name)
        inertial(link, body)
        kind, size = body.shape
        if kind == "roller":
            roller(link, meshes[size], spheres[size])
        elif size[0] > 0.0:
            stand_in(link, body)
        if body.parent is not None:
            joint(root, body)
    return root


def left_out(config: Config) -> Iterator[str]:
    """What a simulator has to be told by other ways, since URDF has no word for it."""
    friction = config.friction
    given = [f"{key} {getattr(friction, key):g}" for key in FRICTION_KEYS[friction.law]]
    law = [f"friction '{friction.law}', {' '.join(given)}"] if given else []
    if said := "; ".join([*law, *filter(None, [rolling_resistances(config)])]):
        yield f"left out, as URDF has no word for it: {said}"


def inertial(link: Element, body: Body) -> None:
    element = SubElement(link, "inertial")
    SubElement(element, "origin", xyz=numbers(*body.centre), rpy=numbers(0.0, 0.0, 0.0))
    SubElement(element, "mass", value=numbers(body.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    SubElement(element, "inertia", dict(zip(names, map(numbers, (*body.inertia, 0.0, 0.0, 0.0)), strict=True)))


def roller(link: Element, mesh: str, spheres: Spheres) -> None:
    """Drawn as a mesh, touching as spheres."""
    visual = SubElement(link, "visual")
    SubElement(SubElement(visual, "geometry"), "mesh", filename=mesh)
    SubElement(visual, "material", name="rubber")
    for place, radius in zip(*spheres, strict=True):
        collision = SubElement(link, "collision")
        SubElement(collision, "origin", xyz=numbers(0.0, 0.0, place), rpy=numbers(0.0, 0.0, 0.0))
        SubElement(SubElement(collision, "geometry"), "sphere", radius=numbers(radius))


def stand_in(link: Element, body: Body) -> None:
    """A plain shape that touches nothing."""
    kind, size = body.shape
    visual = SubElement(link, "visual")
    angles = LAID if kind == "cylinder" else (0.0, 0.0, 0.0)
    SubElement(visual, "origin", xyz=numbers(*body.centre), rpy=numbers(*angles))
    sizes = {"size": numbers(*size)} if kind == "box" else {"radius": numbers(size[0]), "length": numbers(size[1])}
    SubElement(SubElement(visual, "geometry"), kind, sizes)
    SubElement(visual, "material", name="stand_in")


def joint(root: Element, body: Body) -> None:
    element = SubElement(root, "joint", name=body.joint, type="prismatic" if body.slides else "continuous")
    SubElement(element, "origin", xyz=numbers(*body.place), rpy=numbers(*body.angles))
    SubElement(element, "parent", link=str(body.parent))
    SubElement(element, "child", link=body.name)
    SubElement(element, "axis", xyz=body.axis)
    if body.slides:
        SubElement(element, "limit", LIMITS)
    SubElement(element, "dynamics", damping=numbers(body.damping), friction=numbers(body.friction))
    if body.spring_at is not None:
        spring = SubElement(root, "gazebo", reference=body.joint)
        SubElement(spring, "springStiffness").text = numbers(body.stiffness)
        SubElement(spring, "springReference").text = numbers(body.spring_at)
