"""A scene as the bodies of other simulators: MJCF (of MuJoCo) and URDF are both written from these.

Masses, inertias, friction and bearings are those of the scene. Disks and chassis touch nothing: a plain cylinder and a
box are drawn for them, the box of the chassis' size where the scene has it. x is forward, y left, z up; wheels turn
about y, rollers about their own z, and the position of a joint is the angle that omnisim has for it: 0 is spin angle 0,
whatever the scene starts with. The hub of a suspension slides by s; a rocker, which weighs nothing, has next to nothing
here, since simulators ask for some.
"""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Comment, Element

from omnisim.cad.geometry import roller_frames
from omnisim.scene.drives import drive_law
from omnisim.scene.ground_schema import Rocker
from omnisim.scene.rollers import half_width, hub_radius
from omnisim.scene.schema import Config, Wheel

LAID = (-0.5 * math.pi, 0.0, 0.0)  # roll, pitch, yaw of a cylinder along the axle
ORIGIN = (0.0, 0.0, 0.0)
UNSEEN = ("box", ORIGIN)
ROCKER = 1e-6, (1e-9, 1e-9, 1e-9)  # kg, kg m^2
COLOURS = {"rubber": "0.25 0.25 0.28 1", "stand_in": "0.5 0.65 0.8 0.4"}


class Body(NamedTuple):
    """A rigid body on a hinge about `axis` of its own frame, or one that slides along it.

    The chassis, a rocker, the hub of a suspension, a disk, a roller.

    place, angles: of its frame in that of its parent, m and roll, pitch, yaw (rad, about fixed x, y, z). centre: of
    mass, in its own frame; inertia: about it, along the axes of the frame. shape: roller (wheel type), cylinder
    (radius, length) or box (x, y, z), m.
    """

    name: str
    parent: str | None
    axis: str
    place: tuple[float, ...]
    angles: tuple[float, float, float]
    mass: float
    centre: tuple[float, ...]
    inertia: tuple[float, float, float]
    shape: tuple[str, Any]
    damping: float = 0.0  # of the joint, N m s, or N s/m
    friction: float = 0.0  # N m
    armature: float = 0.0  # kg m^2
    slides: bool = False
    stiffness: float = 0.0  # of a spring at the joint, N/m
    preload: float = 0.0  # of it where the joint is at 0, N

    @property
    def joint(self) -> str:
        """Its name: not that of the body, since simulators that read SDF want every name once."""
        return f"{self.name}_joint"

    @property
    def spring_at(self) -> float | None:
        """Where the joint is when its spring is not strained, m; None without a spring."""
        return 0.0 - self.preload / self.stiffness if self.stiffness > 0.0 else None


def note(config: Config) -> str:
    """What whoever programs the controller has to know."""
    radii = {wheel.type: config.type_of(wheel).radius for wheel in config.wheels}
    said = "rolling radius for the controller: " + ", ".join(f"{r:g} m ({name})" for name, r in radii.items())
    return said + ("; the floor is the base plane, without bumps, grid and steps" if not config.floor.is_plane else "")


def rolling_resistances(config: Config) -> str:
    """Those of the wheel types in use, as a comment tells them; nothing if no roller resists."""
    found = {wheel.type: config.type_of(wheel).roller.rolling_resistance for wheel in config.wheels}
    told = ", ".join(f"{f:g} m ({name})" for name, f in found.items() if f > 0.0)
    return f"rolling_resistance {told}" if told else ""


def bodies(config: Config) -> Iterator[Body]:
    """Parents before what they carry."""
    root = None
    if config.chassis is not None:
        chassis, root = config.chassis, "chassis"
        box = ("box", chassis.size if chassis.size[0] > 0.0 else box_between(config))
        yield Body(root, None, "", ORIGIN, ORIGIN, chassis.mass, chassis.center_of_mass, chassis.inertia, box)
    paired = {name for rocker in config.axles for name in rocker.wheels}
    for wheel in config.wheels:
        if wheel.name not in paired:
            yield from wheel_bodies(config, wheel, root, ORIGIN)
    for rocker in config.axles:
        yield from rocker_bodies(config, rocker)


def rocker_bodies(config: Config, rocker: Rocker) -> Iterator[Body]:
    """A rocker and its wheels; its frame is at its point."""
    name, axis = f"{rocker.name}_rocker", {"x": "1 0 0", "y": "0 1 0"}[rocker.about]
    mass, inertia = ROCKER
    yield Body(name, "chassis", axis, rocker.point, ORIGIN, mass, ORIGIN, inertia, UNSEEN)
    for wheel in config.wheels:
        if wheel.name in rocker.wheels:
            yield from wheel_bodies(config, wheel, name, rocker.point)


def box_between(config: Config) -> tuple[float, float, float]:
    """A plain box that reaches towards the wheels, half as high as the smallest, m."""
    low = 0.5 * min(config.type_of(wheel).radius for wheel in config.wheels)
    x, y = (max(low, 1.4 * max(abs(wheel.position[axis]) for wheel in config.wheels)) for axis in (0, 1))
    return x, y, low


def wheel_bodies(config: Config, wheel: Wheel, parent: str | None, origin: tuple[float, ...]) -> Iterator[Body]:
    """The hub of its suspension, its disk, its rollers. origin: of its parent's frame in that of the chassis, m."""
    kind = config.type_of(wheel)
    name = f"{wheel.name}_wheel"
    disk, roller, spring = kind.disk, kind.roller, wheel.suspension
    across = disk.inertia_diameter
    place: tuple[float, ...] = tuple(
        there - here for there, here in zip((*wheel.position, kind.radius), origin, strict=True)
    )
    if spring is not None:
        hub = f"{wheel.name}_hub"
        yield Body(
            hub, parent, "0 0 1", place, ORIGIN, spring.mass, ORIGIN, (spring.inertia,) * 3, UNSEEN,
            damping=spring.damping, slides=True, stiffness=spring.stiffness, preload=spring.preload,
        )  # fmt: skip
        parent, place = hub, ORIGIN
    yield Body(
        name, parent, "0 1 0", place, (0.0, 0.0, math.radians(wheel.heading_deg)),
        disk.mass, ORIGIN, (across, disk.inertia_axle, across),
        ("cylinder", (hub_radius(kind), 2.0 * half_width(kind))),
        armature=drive_law(wheel.drive).rotor_inertia,
    )  # fmt: skip
    inertia = (roller.inertia_transverse, roller.inertia_transverse, roller.inertia_axial)
    frames = roller_frames(kind, wheel.mirrored, math.radians(wheel.phase_deg))
    for number, (centre, (x, y, z)) in enumerate(frames):
        yield Body(
            f"{wheel.name}_roller_{number}", name, "0 0 1",
            tuple(centre), (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)),
            roller.mass, ORIGIN, inertia, ("roller", wheel.type), roller.bearing_viscosity, roller.bearing_torque,
        )  # fmt: skip


def text(root: Element) -> str:
    """No encoding is declared: readers of a str refuse one, and those of bytes take UTF-8."""
    ElementTree.indent(root)
    return '<?xml version="1.0"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def numbers(*values: float) -> str:
    """To the last bit: every number of a description is written here, since repr of a NumPy number has its type."""
    return " ".join(repr(float(value)) for value in values)


def headed(root: Element, config: Config, *more: str) -> Element:
    """With comments: the note, and what else has to be said."""
    for said in (note(config), *more):
        root.append(Comment(f" {said.replace('--', '-')} "))  # two hyphens would end the comment
    return root
