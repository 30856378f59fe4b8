r"""A machine free in space as free rigid bodies that joints hold together and rubber keeps off the ground: the oracle.

It follows from the Newton-Euler equations and the constraints of the joints alone, imports nothing of omnisim and
shares none of its reductions: no composite inertia, no absolute axle rate, no travel in the mass matrix. SI units,
radians. World axes are those of the floor: x, y in its base plane, z its normal; gravity leans.

Bodies: the chassis; of every rocker its carrier, without mass; of every wheel the hub, if it has a suspension, the
disk and all rollers. Every body has v', w' (6), whatever holds it:

    m v' = force      I w' + w x (I w) = torque      of a disk or a roller I = I_t 1 + (I_a - I_t) a a^T, a its axis

Joints, all as rows on the accelerations. i: child, j: parent, r = x_i - x_j, e: a direction fixed in j.

    place   e . (v_i' - v_j' - w_j' x r) = e . (w_j x (w_j x r) + 2 w_j x r~)          r~ = rate of r within j
    turn    e . (w_i' - w_j')            = -(w_i - w_j) . (w_j x e)                    for e . (w_i - w_j) = 0

    roller in its disk                 place: all three e, r~ = 0      turn: two e across the axis a
    disk in hub, carrier or chassis    place: all three e, r~ = 0      turn: two e across the axle k
    carrier in the chassis             place: all three e, r~ = 0      turn: two e across the line it turns about
    hub in the chassis                 place: x, y,  r~ = s' z         turn: x, y, z

The multipliers of the rows do no work. One dense solve, symmetric but indefinite, is regular also with bodies
without mass, as long as what hangs on them has some:

    [ M  -J^T ] [ v', w'      ]   [ forces and torques, -w x (I w) ]
    [ J    0  ] [ multipliers ] = [ right sides of the rows        ]

What acts, all of it known from the state:

    contact     delta > 0 of roller i at X (wheel.py):  V = v_i + w_i x (X - B_i),   delta' = -V . nu
                N = max(0, stiffness delta + damping delta'),   slip v = V - (V . nu) nu,   F by the law, both at X
    drive       tau k on the disk, -tau k on what the axle sits in; a rotor that turns with phi' = (w_i - w_j) . k has
                the energy J phi'^2 / 2, so that J phi'' k is taken from the disk and given back to the other:
                k . (w_i' - w_j') = phi'', as (w_i - w_j) . (w_j x k) = phi' k . (w_j x k) = 0
    spring      -(preload + stiffness s + damping s') z on the hub, the opposite on the chassis, at the hub
    bearing     -viscosity chi' - torque chi' / sqrt(chi'^2 + rate^2) about a on the roller, opposite on the disk,
                chi' = p - w_disk . a
    wrench      force at the chassis' centre of mass, in world or chassis axes; yaw torque about z of the same axes

delta' is the rate of delta: P is extremal along nu, P - X lies along nu, X moves across it, so that only the velocity
of material counts, and V . nu is the same at P and at X.
"""

from math import sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np

from oracle.spatial.bodies import Bodies, Coordinates, Layout, placed, tilted_gravity
from oracle.spatial.ground import Ground
from oracle.spatial.wheel import Contact, Wheel
from oracle.vectors import along_motion, cross
from oracle.wheel import rolling_resistance

LAWS = ("regularized", "saturated", "viscous", "coulomb", "brush", "none")


class Touch(NamedTuple):
    """A roller that overlaps the ground. Vectors in world axes; friction: on the roller."""

    wheel: int
    roller: int
    piece: int  # of the ground, see wheel.py
    point: np.ndarray
    normal: np.ndarray
    depth: float
    depth_rate: float
    load: float  # N
    slip: np.ndarray
    friction: np.ndarray
    resisting: np.ndarray  # moment of rolling resistance on the roller
    turning: np.ndarray  # the roller's angular velocity along the ground

    @property
    def force(self) -> np.ndarray:
        return self.load * self.normal + self.friction


class Loads(NamedTuple):
    """What acts at a time: drive torques (W,); force at the chassis' centre of mass and torque (3,), world axes."""

    drives: np.ndarray
    force: np.ndarray
    torque: np.ndarray


class Reactions(NamedTuple):
    """Accelerations of the coordinates, those of all bodies (B, 6), contacts, and what joints do to bodies (B, 6).

    joints: force and moment at the centre of the body that hangs on the joint; drives with what their rotors take,
    springs and bearings included.
    """

    acceleration: np.ndarray  # of the chassis origin, world
    angular_acceleration: np.ndarray  # of the chassis, world
    spin: np.ndarray  # phi'' (W,)
    travel: np.ndarray  # s'' (W,), 0 without suspension
    axle: np.ndarray  # of the rockers (A,)
    rollers: list[np.ndarray]  # p' by wheel
    bodies: np.ndarray
    touches: list[Touch]
    joints: np.ndarray


class Machine:
    """Bodies, joints and loads of a scene, with the defaults of the scene format.

    given_drives (W,) replaces the torques of the drives; given_friction[wheel, roller, piece] (3,) the friction of a
    contact.
    """

    given_drives: np.ndarray | None = None

    def __init__(self, scene: dict, folder: Path = Path()) -> None:
        self.friction = scene["friction"]
        if self.friction["law"] not in LAWS:
            raise ValueError(f"the oracle has no friction law {self.friction['law']!r}")
        self.chassis, self.initial = scene["chassis"], scene.get("initial", {})
        floor = scene.get("floor", {})
        self.gravity = tilted_gravity(scene.get("scene", {}).get("gravity", 9.81), floor)
        self.ground = Ground.of(floor, folder)
        self.wheels = [Wheel(entry, scene["wheel_types"][entry["type"]]) for entry in scene["wheels"]]
        self.layout = Layout.of(self.chassis, self.wheels, scene.get("axles", []))
        self.wrench = scene.get("wrench", {})
        self.given_friction: dict[tuple[int, int, int], np.ndarray] = {}

    def loads(self, time: float, bodies: Bodies) -> Loads:
        """Tables at a time: linear between points, held outside; at two equal times the later one."""
        drives = self.given_drives
        if drives is None:
            drives = np.array([drive_torque(time, wheel.entry.get("drive", {"kind": "free"})) for wheel in self.wheels])
        force = table(time, self.wrench, "force", [0.0, 0.0, 0.0])
        torque = np.array([0.0, 0.0, table(time, self.wrench, "yaw_torque", 0.0)])
        axes = bodies.frame if self.wrench.get("frame", "world") == "body" else np.eye(3)
        return Loads(drives, axes @ force, axes @ torque)

    def touches(self, bodies: Bodies) -> list[Touch]:
        found = []
        for w, (wheel, rollers) in enumerate(zip(self.wheels, self.layout.rollers, strict=True)):
            for body in range(rollers.start, rollers.stop):
                for contact in wheel.contacts(bodies.x[body], bodies.axis[body], self.ground):
                    found.append(self.touch(w, body, contact, bodies))
        return found

    def touch(self, w: int, body: int, contact: Contact, bodies: Bodies) -> Touch:
        rubber, roller = self.wheels[w].kind["contact"], body - self.layout.rollers[w].start
        velocity = bodies.v[body] + cross(bodies.w[body], contact.point - bodies.x[body])
        rate = -float(velocity @ contact.normal)
        load = max(0.0, rubber["stiffness"] * contact.depth + rubber.get("damping", 0.0) * rate)
        slip = velocity + rate * contact.normal
        stream = np.zeros(3)
        if self.friction["law"] == "brush":
            stream = along_motion(
                lambda centre, axis: self.wheels[w].followed(contact, centre, axis, self.ground),
                (bodies.x[body], bodies.axis[body]),
                (bodies.v[body], bodies.w[body]),
            )
            stream -= velocity + (stream - velocity) @ contact.normal * contact.normal
        given = self.given_friction.get((w, roller, contact.piece))
        force = self.friction_force(load, slip, stream) if given is None else given
        shape = contact.piece, contact.point, contact.normal, contact.depth
        turning = bodies.w[body] - (bodies.w[body] @ contact.normal) * contact.normal
        resisting = load * rolling_resistance(self.wheels[w].kind["roller"], turning)
        return Touch(w, roller, *shape, rate, load, slip, force, resisting, turning)

    def friction_force(self, load: float, slip: np.ndarray, stream: np.ndarray) -> np.ndarray:
        law, speed = self.friction["law"], sqrt(slip @ slip)
        if law == "none":
            return np.zeros(3)
        if law == "viscous":  # without N, as long as there is any
            return -self.friction["viscosity"] * slip if load > 0.0 else np.zeros(3)
        slow = self.friction.get("slip_speed", 1e-6)
        if law == "brush":
            mu = self.friction["coefficient"]
            sigma = speed / sqrt(stream @ stream + slow**2)
            theta = min(self.friction["creep_stiffness"] * sigma / (3.0 * mu), 1.0)
            return -mu * load * (1.0 - (1.0 - theta) ** 3) / speed * slip
        scale = {"regularized": sqrt(speed**2 + slow**2), "saturated": max(speed, slow), "coulomb": speed}[law]
        return -self.friction["coefficient"] * load / scale * slip

    def bearings(self, w: int, bodies: Bodies) -> tuple[np.ndarray, np.ndarray]:
        """Joint rates chi' of the rollers of a wheel, and the torque of their bearings about a."""
        roller, rollers = self.wheels[w].kind["roller"], self.layout.rollers[w]
        chi = np.sum((bodies.w[rollers] - bodies.w[self.layout.disk[w]]) * bodies.axis[rollers], axis=1)
        slow = np.sqrt(chi**2 + roller.get("bearing_rate", 0.1) ** 2)
        return chi, -(roller.get("bearing_viscosity", 0.0) + roller.get("bearing_torque", 0.0) / slow) * chi

    def spring(self, w: int, now: Coordinates) -> float:
        """Force of the suspension on the hub, along the chassis' z."""
        spring = self.wheels[w].entry["suspension"]
        damping = spring.get("damping", 0.0) * now.travel_rate[w]
        return -(spring.get("preload", 0.0) + spring["stiffness"] * now.travel[w] + damping)

    def solve(self, time: float, now: Coordinates) -> Reactions:
        bodies = placed(self.layout, now)
        held, touches = self.inner(time, now, bodies), self.touches(bodies)
        rows, right, owner = self.rows(bodies)
        found = dense(self.masses(bodies), rows, self.applied(time, bodies, held, touches).ravel(), right)
        count = 6 * len(self.layout.mass)
        for body in range(1, len(held)):
            mine = owner == body
            held[body] += found[count:][mine] @ rows[mine, 6 * body : 6 * body + 6]
        reactions = self.told(now, bodies, found[:count].reshape(-1, 6), touches, held)
        for wheel, disk, spin in zip(self.wheels, self.layout.disk, reactions.spin, strict=True):
            held[disk, 3:] -= rotor_inertia(wheel.entry) * spin * bodies.axis[disk]
        return reactions

    def masses(self, bodies: Bodies) -> np.ndarray:
        """Of all bodies, and what the rotors of the drives add."""
        layout = self.layout
        move = 6 * np.arange(len(layout.mass))[:, None] + np.arange(3)
        mass = np.zeros((6 * len(layout.mass),) * 2)
        mass[move, move] = layout.mass[:, None]
        mass[move[:, :, None] + 3, move[:, None, :] + 3] = bodies.inertia
        for wheel, disk in zip(self.wheels, layout.disk, strict=True):
            rotor = rotor_inertia(wheel.entry) * np.outer(bodies.axis[disk], bodies.axis[disk])
            at, of = (slice(6 * body + 3, 6 * body + 6) for body in (disk, layout.parent[disk]))
            for row, column, sign in ((at, at, 1.0), (of, of, 1.0), (at, of, -1.0), (of, at, -1.0)):
                mass[row, column] += sign * rotor
        return mass

    def applied(self, time: float, bodies: Bodies, held: np.ndarray, touches: list[Touch]) -> np.ndarray:
        """Force and torque on every body at its centre: weight, gyroscopic, wrench, contacts, and within the joints."""
        layout, loads = self.layout, self.loads(time, bodies)
        applied = np.concatenate([layout.mass[:, None] * self.gravity, 0.0 * bodies.x], axis=1)
        applied[:, 3:] -= cross(bodies.w, (bodies.inertia @ bodies.w[:, :, None])[..., 0])
        applied[0] += np.concatenate([loads.force, loads.torque])
        for touch in touches:
            body = layout.rollers[touch.wheel].start + touch.roller
            arm = touch.point - bodies.x[body]
            applied[body] += np.concatenate([touch.force, cross(arm, touch.force) + touch.resisting])
        force, moment = held[1:, :3], held[1:, 3:]
        arm = bodies.x[1:] - bodies.x[layout.parent[1:]]
        applied[1:] += held[1:]
        np.subtract.at(applied, layout.parent[1:], np.concatenate([force, moment + cross(arm, force)], axis=1))
        return applied

    def inner(self, time: float, now: Coordinates, bodies: Bodies) -> np.ndarray:
        """Force and torque on every body, at its centre, of what sits in its joint: drive, spring, bearing (B, 6)."""
        layout, drives = self.layout, self.loads(time, bodies).drives
        held = np.zeros((len(layout.mass), 6))
        for w, disk in enumerate(layout.disk):
            held[disk, 3:] = drives[w] * bodies.axis[disk]
            held[layout.rollers[w], 3:] = self.bearings(w, bodies)[1][:, None] * bodies.axis[layout.rollers[w]]
            if w in layout.hub:
                held[layout.hub[w], :3] = self.spring(w, now) * bodies.frame[:, 2]
        return held

    def rows(self, bodies: Bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Constraint rows, their right sides, and the child that each belongs to."""
        layout = self.layout
        place, turn = bodies.place, bodies.turn
        rows = np.zeros((len(place.child) + len(turn.child), 6 * len(layout.mass)))
        right, xyz = np.zeros(len(rows)), np.arange(3)
        child, e = place.child, place.e
        parent, number = layout.parent[child], np.arange(len(child))[:, None]
        r, w = bodies.x[child] - bodies.x[parent], bodies.w[parent]
        rows[number, 6 * child[:, None] + xyz] = e
        rows[number, 6 * parent[:, None] + xyz] = -e
        rows[number, 6 * parent[:, None] + 3 + xyz] = -cross(r, e)
        centripetal = cross(w, cross(w, r)) + 2.0 * cross(w, bodies.sliding[child])
        right[: len(child)] = np.sum(e * centripetal, axis=1)
        start = len(child)
        child, e = turn.child, turn.e
        parent, number = layout.parent[child], start + np.arange(len(child))[:, None]
        rows[number, 6 * child[:, None] + 3 + xyz] = e
        rows[number, 6 * parent[:, None] + 3 + xyz] = -e
        w = bodies.w[parent]
        right[start:] = -np.sum((bodies.w[child] - w) * cross(w, e), axis=1)
        return rows, right, np.concatenate([place.child, turn.child])

    def told(self, now, bodies, accelerations, touches, held) -> Reactions:
        """Accelerations of the coordinates from those of the bodies."""
        layout, w, turned = self.layout, bodies.w[0], accelerations[:, 3:]
        linear, alpha = accelerations[:, :3], accelerations[0, 3:]
        origin = now.position - bodies.x[0]
        start = linear[0] + cross(alpha, origin) + cross(w, cross(w, origin))
        disks = np.array(layout.disk)
        spin = np.sum((turned[disks] - turned[layout.parent[disks]]) * bodies.axis[disks], axis=1)
        travel = np.zeros(len(disks))
        for number, hub in layout.hub.items():
            r, sliding = bodies.x[hub] - bodies.x[0], bodies.sliding[hub]
            within = linear[hub] - linear[0] - cross(alpha, r) - cross(w, cross(w, r)) - 2.0 * cross(w, sliding)
            travel[number] = within @ bodies.frame[:, 2]
        axle = np.array([(turned[body] - alpha) @ bodies.axis[body] for body in layout.carriers])
        rollers = [np.sum(turned[of] * bodies.axis[of], axis=1) for of in layout.rollers]
        return Reactions(start, alpha, spin, travel, axle, rollers, accelerations, touches, held)


def dense(mass: np.ndarray, rows: np.ndarray, applied: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Accelerations and multipliers; scaled by the roots of the inertias, so that all unknowns are of one size."""
    diagonal = np.diag(mass)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, diagonal.max()))
    scaled = rows * scale
    weight = 1.0 / np.abs(scaled).max(axis=1)
    scaled *= weight[:, None]
    moves = len(mass)
    matrix = np.zeros((moves + len(rows),) * 2)
    matrix[:moves, :moves] = mass * np.outer(scale, scale)
    matrix[moves:, :moves], matrix[:moves, moves:] = scaled, -scaled.T
    scale = np.concatenate([scale, weight])
    return scale * np.linalg.solve(matrix, scale * np.concatenate([applied, right]))


def drive_torque(time: float, drive: dict) -> float:
    if drive["kind"] not in ("torque", "free"):
        raise ValueError(f"the oracle is to be given the torque of a drive of kind {drive['kind']!r}")
    return float(table(time, drive, "torque", 0.0))


def rotor_inertia(entry: dict) -> float:
    """Of the motor, as the axle feels it."""
    drive = entry.get("drive", {})
    return drive.get("gear_ratio", 1.0) ** 2 * drive.get("rotor_inertia", 0.0)


def table(time: float, entry: dict, key: str, default: float | list[float]) -> np.ndarray:
    """A constant, or what a table over times holds at a time; default where the key is absent."""
    values = np.array(entry.get(key, default), dtype=float)
    if key not in entry or "times" not in entry:
        return values
    times = np.array(entry["times"])
    after = int(np.searchsorted(times, time, side="right"))
    if after in (0, len(times)):
        return values[max(after - 1, 0)]
    share = (time - times[after - 1]) / (times[after] - times[after - 1])
    return (1.0 - share) * values[after - 1] + share * values[after]
