"""Where coordinates put the bodies of the spatial oracle, how fast they are there, and what they weigh.

chassis axes x, y, z        quaternion (w, x, y, z) from chassis to world
wheel centre                chassis origin + (position, R) + s z; on a rocker turned with it about its line
h, k, n of a wheel          (cos heading, sin heading, 0), z x h, z of what carries it; turned by phi about k: disk
roller                      centre and axis fixed in the disk; w = w_disk + (p - w_disk . a) a, so that w . a = p
"""

from math import cos, pi, radians, sin
from typing import NamedTuple

import numpy as np

from oracle.spatial.wheel import Wheel
from oracle.vectors import cross, skew

X, Y, Z = np.eye(3)


class Coordinates(NamedTuple):
    """A state of the machine: W wheels, A rockers, N rollers by wheel."""

    position: np.ndarray  # of the chassis origin, world, m
    quaternion: np.ndarray
    velocity: np.ndarray  # of the origin, world, m/s
    angular_velocity: np.ndarray  # of the chassis, world, rad/s
    spin_angle: np.ndarray  # (W,) phi, in what carries the wheel
    spin_rate: np.ndarray
    travel: np.ndarray  # (W,) s, 0 without suspension
    travel_rate: np.ndarray
    axle_angle: np.ndarray  # (A,)
    axle_rate: np.ndarray
    axial_rates: list[np.ndarray]  # absolute, p (N,) of every wheel


class Joints(NamedTuple):
    """Rows: the body that hangs on the joint (n,), and a direction fixed in its parent (n, 3)."""

    child: np.ndarray
    e: np.ndarray


class Bodies(NamedTuple):
    x: np.ndarray  # centres of mass
    v: np.ndarray
    w: np.ndarray
    axis: np.ndarray  # that the body turns about in its joint; 0: none
    inertia: np.ndarray  # (B, 3, 3) about the centre of mass, world axes
    sliding: np.ndarray  # rate of x within the parent
    frame: np.ndarray  # of the chassis, columns x, y, z
    place: Joints
    turn: Joints


class Layout(NamedTuple):
    """What is fixed: order of the bodies, their parents and masses, what carries each wheel."""

    wheels: list[Wheel]
    mass: np.ndarray
    parent: np.ndarray  # -1 for the chassis
    centre: np.ndarray  # of mass of the chassis, from its origin, chassis axes
    inertia: np.ndarray  # of the chassis
    carriers: list[int]
    lines: list[tuple[np.ndarray, np.ndarray]]  # point and direction of every rocker, chassis axes
    rocker: dict[int, int]  # of a wheel on one
    hub: dict[int, int]  # body, of a wheel with suspension
    disk: list[int]
    rollers: list[slice]

    @classmethod
    def of(cls, chassis: dict, wheels: list[Wheel], axles: list[dict]) -> "Layout":
        mass, parent, hub, disk, rollers = [chassis["mass"]], [-1], {}, [], []
        names = [wheel.name for wheel in wheels]
        carriers = list(range(1, 1 + len(axles)))
        rocker = {names.index(name): number for number, axle in enumerate(axles) for name in axle["wheels"]}
        lines = [(np.array(axle["point"], dtype=float), {"x": X, "y": Y}[axle["about"]]) for axle in axles]
        mass, parent = mass + [0.0] * len(axles), parent + [0] * len(axles)
        for number, wheel in enumerate(wheels):
            carrier = carriers[rocker[number]] if number in rocker else 0
            if "suspension" in wheel.entry:
                if carrier:
                    raise ValueError(f"the oracle has no suspension on a rocker: {wheel.name}")
                hub[number] = carrier = len(mass)
                mass, parent = [*mass, wheel.entry["suspension"]["mass"]], [*parent, 0]
            disk.append(len(mass))
            rollers.append(slice(len(mass) + 1, len(mass) + 1 + wheel.count))
            mass += [wheel.kind["disk"]["mass"]] + wheel.count * [wheel.kind["roller"]["mass"]]
            parent += [carrier] + wheel.count * [disk[-1]]
        centre, inertia = np.array(chassis["center_of_mass"], dtype=float), np.diag(chassis["inertia"])
        return cls(
            wheels, np.array(mass), np.array(parent), centre, inertia, carriers, lines, rocker, hub, disk, rollers
        )


def placed(layout: Layout, now: Coordinates) -> Bodies:
    count, frame, w = len(layout.mass), rotation(now.quaternion), now.angular_velocity
    x, v, axis, sliding = np.zeros((4, count, 3))
    inertia, turning = np.zeros((count, 3, 3)), np.tile(w, (count, 1))
    x[0] = now.position + frame @ layout.centre
    v[0] = now.velocity + cross(w, x[0] - now.position)
    inertia[0] = frame @ layout.inertia @ frame.T
    for number, body in enumerate(layout.carriers):
        point, line = layout.lines[number]
        axis[body], x[body] = frame @ line, now.position + frame @ point
        v[body] = now.velocity + cross(w, x[body] - now.position)
        turning[body] = w + now.axle_rate[number] * axis[body]
    for number, wheel in enumerate(layout.wheels):
        arm = np.array([*wheel.entry["position"], wheel.radius])
        axes, origin, speed, base = frame, now.position, now.velocity, 0
        if number in layout.rocker:
            rocker = layout.rocker[number]
            point, line = layout.lines[rocker]
            base, arm = layout.carriers[rocker], arm - point
            axes, origin, speed = frame @ turned(line, now.axle_angle[rocker]), x[base], v[base]
        disk, rollers = layout.disk[number], layout.rollers[number]
        x[disk] = origin + axes @ arm
        if number in layout.hub:
            base = layout.hub[number]
            x[disk] += now.travel[number] * frame[:, 2]
            sliding[base] = now.travel_rate[number] * frame[:, 2]
            x[base], inertia[base] = x[disk], wheel.entry["suspension"]["inertia"] * np.eye(3)
        v[disk] = speed + cross(turning[base], x[disk] - origin) + sliding[base]
        if number in layout.hub:
            v[base] = v[disk]
        heading = radians(wheel.entry.get("heading_deg", 0.0))
        disk_axes = axes @ turned(Z, heading) @ turned(Y, now.spin_angle[number])
        axis[disk] = disk_axes[:, 1]
        turning[disk] = turning[base] + now.spin_rate[number] * axis[disk]
        place_rollers(wheel, disk_axes, now.axial_rates[number], disk, rollers, (x, v, turning, axis))
        solid, roller = wheel.kind["disk"], wheel.kind["roller"]
        inertia[disk] = about(axis[disk], solid["inertia_axle"], solid["inertia_diameter"])
        inertia[rollers] = about(axis[rollers], roller["inertia_axial"], roller["inertia_transverse"])
    return Bodies(x, v, turning, axis, inertia, sliding, frame, *joints(layout, axis, frame))


def place_rollers(wheel: Wheel, axes: np.ndarray, rates: np.ndarray, disk: int, rollers: slice, bodies: tuple) -> None:
    x, v, w, axis = bodies
    x[rollers], axis[rollers] = x[disk] + wheel.centres @ axes.T, wheel.axes @ axes.T
    v[rollers] = v[disk] + cross(w[disk], x[rollers] - x[disk])
    w[rollers] = w[disk] + (rates - axis[rollers] @ w[disk])[:, None] * axis[rollers]


def joints(layout: Layout, axis: np.ndarray, frame: np.ndarray) -> tuple[Joints, Joints]:
    """Rows of places and of turns: hubs slide, everything else turns about its axis."""
    hubs = np.array(list(layout.hub.values()), dtype=int)
    hinged = np.setdiff1d(np.arange(1, len(layout.mass)), hubs)
    place = [(np.repeat(hinged, 3), np.tile(np.eye(3), (len(hinged), 1)))]
    place += [(np.repeat(hubs, 2), np.tile(frame.T[:2], (len(hubs), 1)))]
    turn = [(np.repeat(hinged, 2), across(axis[hinged]).reshape(-1, 3))]
    turn += [(np.repeat(hubs, 3), np.tile(frame.T, (len(hubs), 1)))]
    return tuple(Joints(*(np.concatenate(parts) for parts in zip(*rows, strict=True))) for rows in (place, turn))


def across(axis: np.ndarray) -> np.ndarray:
    """Two unit vectors across each axis (n, 3): (n, 2, 3)."""
    first = cross(axis, np.eye(3)[np.argmin(np.abs(axis), axis=1)])
    first /= np.sqrt(np.sum(first**2, axis=1))[:, None]
    return np.stack([first, cross(axis, first)], axis=1)


def about(axis: np.ndarray, along: float, transverse: float) -> np.ndarray:
    """Inertia of a body that is round about an axis (..., 3)."""
    return transverse * np.eye(3) + (along - transverse) * axis[..., :, None] * axis[..., None, :]


def turned(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rotation by an angle about a unit axis."""
    return np.eye(3) + sin(angle) * skew(axis) + (1.0 - cos(angle)) * skew(axis) @ skew(axis)


def rotation(quaternion: np.ndarray) -> np.ndarray:
    """Matrix of a unit quaternion (w, x, y, z); of another one that of its direction."""
    w, *vector = quaternion / np.sqrt(quaternion @ quaternion)
    cross_matrix = skew(np.array(vector))
    return np.eye(3) + 2.0 * w * cross_matrix + 2.0 * cross_matrix @ cross_matrix


def tilted_gravity(gravity: float, floor: dict) -> np.ndarray:
    """In axes of the floor: uphill_deg is the direction, from x, in which it rises."""
    slope, uphill = (floor.get(key, 0.0) * pi / 180.0 for key in ("slope_deg", "uphill_deg"))
    return -gravity * np.array([sin(slope) * cos(uphill), sin(slope) * sin(uphill), cos(slope)])
