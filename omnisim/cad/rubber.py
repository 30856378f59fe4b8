"""Rubber of a machine free in space in MuJoCo's terms: N = stiffness delta + damping delta'.

MuJoCo scales a contact by an inverse mass w: of all translations of the centre of mass of the roller, averaged over
directions, in the pose where all joints are at 0. With impedance d and solref = (-K, -B) it presses with

    N (a + w (1 - d) / d) = (K delta + B delta') / d - a_0        a: inverse mass along the normal, a_0: acceleration
                                                                  without contact

which is (K delta + B delta') / w to the order of d. So K = stiffness w and B = damping w at a small d. Friction of so
soft a contact would creep: impratio = 1 / d makes it as firm as d = 1/2 does, and slip is taken away within 1 ms.
"""

from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from omnisim.cad.robot_description import Body, numbers
from omnisim.scene.schema import Config
from omnisim.scene.wheel_schema import WheelType

IMPEDANCE = 1e-4  # the smallest that MuJoCo takes
SLIP_RATE = 2e3  # 1/s
SETTINGS = {"impratio": numbers(1.0 / IMPEDANCE), "ccd_tolerance": "1e-9"}  # m, of where hulls touch


class Frame(NamedTuple):
    """Place (m) and axes of a body in the frame of the first one, and its motion (6, J) by the rates of all joints, of
    which the first six are those of the base: its turning, and the velocity of what is at the origin."""

    place: np.ndarray
    axes: np.ndarray
    motion: np.ndarray


def touching_name(body: Body) -> str:
    """Of what touches of a roller."""
    return f"{body.name}_contact"


def press(element: Element, config: Config, everything: list[Body]) -> None:
    """A contact pair of the floor and each roller."""
    mobility = inverse_masses(everything)
    for body in everything:
        kind, wheel_type = body.shape
        if kind == "roller":
            own = rubber(config.wheel_types[wheel_type], mobility[body.name], config.friction.coefficient)
            SubElement(element, "pair", own, geom1="floor", geom2=touching_name(body))


def rubber(kind: WheelType, mobility: float, coefficient: float) -> dict[str, str]:
    """Attributes of a contact pair of a roller with this inverse mass, 1/kg, and this coefficient of friction; rolling
    friction is like rolling resistance a length, by the load."""
    contact, rolling = kind.contact, kind.roller.rolling_resistance
    assert contact is not None
    return {
        "condim": "6" if rolling > 0.0 else "3",
        "friction": numbers(coefficient, coefficient, 0.0, rolling, rolling),
        "solref": numbers(-contact.stiffness * mobility, -contact.damping * mobility),
        "solreffriction": numbers(-1.0, -SLIP_RATE * IMPEDANCE),
        "solimp": numbers(IMPEDANCE, IMPEDANCE, 1e-3),
    }


def inverse_masses(everything: list[Body]) -> dict[str, float]:
    """By body: the mean of the inverse masses of its centre of mass along three axes, 1/kg, of a machine whose first
    body is free in space and whose joints are at 0."""
    moves = {body.name: 6 + number for number, body in enumerate(body for body in everything if body.axis)}
    count = 6 + len(moves)
    mass = np.zeros((count, count))
    reach: dict[str, np.ndarray] = {}
    seen: dict[str | None, Frame] = {None: Frame(np.zeros(3), np.eye(3), np.eye(6, count))}
    for body in everything:
        parent = seen[body.parent]
        place, axes = parent.place + parent.axes @ body.place, parent.axes @ turned(*body.angles)
        motion = parent.motion.copy()
        if body.axis:
            along = axes @ np.array(body.axis.split(), dtype=float)
            screw = (np.zeros(3), along) if body.slides else (along, np.cross(place, along))
            motion[:, moves[body.name]] = np.concatenate(screw)
            mass[moves[body.name], moves[body.name]] += body.armature
        seen[body.name] = Frame(place, axes, motion)
        turning = axes.T @ motion[:3]
        linear = motion[3:] + np.cross(motion[:3], place + axes @ body.centre, axis=0)
        mass += body.mass * linear.T @ linear + turning.T @ np.diag(body.inertia) @ turning
        reach[body.name] = linear
    inverse = np.linalg.inv(mass)
    return {name: float(np.trace(linear @ inverse @ linear.T) / 3.0) for name, linear in reach.items()}


def turned(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Rotation by these angles about fixed x, y, z."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(angle), np.sin(angle)) for angle in (roll, pitch, yaw))
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
