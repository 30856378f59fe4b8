"""Motion of a bare wheel or of a vehicle whose parts are all free bodies: the oracle of the tests.

`machine` holds the equations. Here they are marched by DOP853 from restart to restart: output times, points of the
tables of drives and wrench, and exchanges of rollers, so that no interpolant enters.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import ceil, cos, floor, inf, radians, sin
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from oracle.machine import Machine, Mode
from oracle.vectors import AXIS, FLAT, OMEGA, POSITION, ROTATION, UP, VELOCITY, cross
from oracle.wheel import Wheel

# s, with brush: where all of a contact begins to slide a third derivative jumps, which long steps do not see. A
# roller's rate is off by 5e-9 rad/s without it, by 4e-12 at 2e-5 s.
BRUSH_STEP = 4e-5


class Turning(NamedTuple):
    """How one wheel stands and turns: spin angle, its rate, and those of the rollers in their joints."""

    angle: float
    rate: float
    rollers: np.ndarray | float


def start(machine: Machine) -> tuple[np.ndarray, list[int]]:
    """Initial state, and the roller of every wheel on the floor."""
    initial, entries = machine.initial, [wheel.entry for wheel in machine.wheels]
    angles = [radians(entry.get("spin_angle_deg", 0.0)) for entry in entries]
    yaw, yaw_rate = radians(initial.get("yaw_deg", 0.0)), initial.get("yaw_rate", 0.0)
    turnings = [Turning(angle, entry.get("spin_rate", 0.0), entry.get("roller_rates", 0.0))
                for angle, entry in zip(angles, entries, strict=True)]  # fmt: skip
    position, velocity = (np.array([*initial.get(key, [0.0, 0.0]), 0.0]) for key in ("position", "velocity"))
    bodies = place(machine, position, velocity, yaw, yaw_rate, turnings)
    return np.concatenate([bodies.ravel(), angles, [yaw]]), first_contacts(machine, bodies, angles)


def place(
    machine: Machine, origin: np.ndarray, velocity: np.ndarray, yaw: float, yaw_rate: float, turnings: list[Turning]
) -> np.ndarray:
    """Bodies where joint coordinates put them; origin (3,) and its velocity (3,): of the wheel or the chassis, below.

    A turning for each wheel.
    """
    turned = np.array([[cos(yaw), -sin(yaw), 0.0], [sin(yaw), cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    bodies = np.zeros((len(machine.mass), 18))
    bodies[0, POSITION], bodies[0, ROTATION] = origin + turned @ machine.centre, turned.ravel()
    bodies[:, OMEGA] = yaw_rate * UP
    for wheel, turning in zip(machine.wheels, turnings, strict=True):
        place_wheel(wheel, turning, bodies, origin, turned)
    bodies[:, VELOCITY] += velocity + yaw_rate * cross(UP, bodies[:, POSITION] - origin)
    return bodies


def place_wheel(wheel: Wheel, turning: Turning, bodies: np.ndarray, origin: np.ndarray, turned: np.ndarray) -> None:
    """Disk and rollers where they stand in the base, with the velocities that the spin of the wheel adds."""
    entry, rollers, phi = wheel.entry, bodies[wheel.rollers], turning.angle
    heading = radians(entry.get("heading_deg", 0.0))
    h = turned @ [cos(heading), sin(heading), 0.0]
    k = cross(UP, h)
    disk = np.stack([cos(phi) * h - sin(phi) * UP, k, sin(phi) * h + cos(phi) * UP], axis=1)
    d, a = wheel.d @ disk.T, wheel.a @ disk.T
    centre = origin + turned @ [*entry.get("position", [0.0, 0.0]), wheel.radius]
    bodies[wheel.disk, POSITION], bodies[wheel.disk, ROTATION] = centre, disk.ravel()
    rollers[:, POSITION] = centre + wheel.place @ disk.T
    rollers[:, ROTATION] = np.stack([cross(a, d), a, d], axis=2).reshape(-1, 9)
    rollers[:, VELOCITY] = turning.rate * wheel.roller_distance * cross(k, d)
    bodies[wheel.disk, OMEGA] += turning.rate * k
    rollers[:, OMEGA] += turning.rate * k + np.broadcast_to(turning.rollers, wheel.count)[:, None] * a


def first_contacts(machine: Machine, bodies: np.ndarray, angles: list[float]) -> list[int]:
    """The roller with |q| <= alpha; on the edge the one that phi', or else phi'', turns towards the floor."""
    pitches = [(phi - w.phase) / (2.0 * w.half_pitch) for phi, w in zip(angles, machine.wheels, strict=True)]
    ahead = [floor(pitch + 0.5 + 1e-12) for pitch in pitches]  # edge: q = alpha
    behind = [ceil(pitch - 0.5 - 1e-12) for pitch in pitches]  # q = -alpha
    turning = [wheel.spin_rate(bodies) for wheel in machine.wheels]
    if any(rate == 0.0 and one != other for rate, one, other in zip(turning, ahead, behind, strict=True)):
        acceleration = machine.solve(0.0, bodies, machine.mode(0.0, ahead)).acceleration
        for i, wheel in enumerate(machine.wheels):
            turning[i] = turning[i] or acceleration[wheel.disk, 3:] @ bodies[wheel.disk, AXIS]
    return [one if rate > 0.0 else other for rate, one, other in zip(turning, ahead, behind, strict=True)]


def advance(machine: Machine, mode: Mode, end: float, state: np.ndarray, rtol: float) -> tuple[float, np.ndarray, list]:
    """March to `end`, or to the first edge q = +-alpha of a roller on the floor: time, state, exchanges.

    Exchanges are pairs of the wheel's place and the side +-1 on which its roller leaves the floor. SciPy locates an
    event on the interpolant of a step. Here that step is repeated up to the root without it, and what remains of
    q -+ alpha goes into one Newton correction. No step turns a wheel by much more than alpha / 2, so that trial
    steps stay on the roller.
    """
    settings = {"method": "DOP853", "rtol": rtol, "atol": 1e-2 * rtol, "args": (mode,)}
    turning = max(abs(wheel.spin_rate(machine.bodies(state))) / wheel.half_pitch for wheel in machine.wheels)
    settings["max_step"] = 0.5 / turning if turning > 0.0 else inf
    if machine.law == "brush":
        settings["max_step"] = min(settings["max_step"], BRUSH_STEP)

    def to_edge(place: int, side: int):
        def edge(time: float, state: np.ndarray, mode: Mode) -> float:
            wheel = machine.wheels[place]
            return wheel.azimuth(machine.bodies(state), mode.contacts[place]) - side * wheel.half_pitch

        edge.terminal, edge.direction, edge.place = True, side, place
        return edge

    edges = [to_edge(place, side) for place in range(len(machine.wheels)) for side in (-1, 1)]
    march = solve_ivp(machine.derivative, (mode.begin, end), state, events=edges, **settings)
    if march.status < 0:
        raise RuntimeError(march.message)
    for time, passed in zip(march.t, march.y.T, strict=True):
        check(machine, time, passed, mode)
    if march.status == 0:
        return end, march.y[:, -1], []
    [edge] = [edge for edge, times in zip(edges, march.t_events, strict=True) if times.size]
    time = march.t[-1]
    state = solve_ivp(machine.derivative, (march.t[-2], time), march.y[:, -2], **settings).y[:, -1]
    rate = machine.derivative(time, state, mode)
    correction = edge(time, state, mode) / rate[edge.place - len(machine.wheels) - 1]  # as q' = -phi'
    state = state + correction * rate
    return time + correction, state, leaving(machine, state, mode)


def leaving(machine: Machine, state: np.ndarray, mode: Mode) -> list[tuple[int, int]]:
    """Wheels, and sides, whose roller stands at an edge and goes on outwards: several at once exchange together."""
    bodies, found = machine.bodies(state), []
    for place, (wheel, contact) in enumerate(zip(machine.wheels, mode.contacts, strict=True)):
        q = wheel.azimuth(bodies, contact)
        if abs(q) > wheel.half_pitch - 1e-12 and q * wheel.spin_rate(bodies) < 0.0:
            found.append((place, 1 if q > 0.0 else -1))
    return found


def observe(machine: Machine, time: float, state: np.ndarray, mode: Mode) -> dict:
    """One row of output: of the machine, and under "wheels" of every wheel by name."""
    bodies = machine.bodies(state)
    reactions = machine.solve(time, bodies, mode)
    base, acceleration, w = bodies[0], reactions.acceleration[0], bodies[0, OMEGA]
    r = base[ROTATION].reshape(3, 3) @ (machine.centre * FLAT) if machine.chassis else np.zeros(3)
    spin_angles = state[-1 - len(machine.wheels) : -1]
    row = {
        "time": time,
        "position": (base[POSITION] - r)[:2],
        "velocity": (base[VELOCITY] - cross(w, r))[:2],
        "acceleration": (acceleration[:3] - cross(acceleration[3:], r) - cross(w, cross(w, r)))[:2],
        "yaw": state[-1],
        "yaw_rate": w[2],
        "yaw_acceleration": acceleration[5],
        "servo_torque": reactions.servo_torque if machine.chassis else reactions.servo_torque[0],
        "kinetic": machine.kinetic_energy(bodies),
        "constraint_residual": machine.constraint_residual(bodies, mode.contacts),
        "wheels": {},
    }
    if machine.upright == "contacts":
        row["servo_torque"] = np.zeros(2)
    for i, wheel in enumerate(machine.wheels):
        k, friction, rollers = bodies[wheel.disk, AXIS], reactions.friction[i], bodies[wheel.rollers]
        row["wheels"][wheel.name] = {
            "spin_angle": spin_angles[i],
            "spin_rate": wheel.spin_rate(bodies),
            "spin_acceleration": reactions.acceleration[wheel.disk, 3:] @ k,
            "roller_axial_rate": np.sum(rollers[:, OMEGA] * rollers[:, AXIS], axis=1),
            "normal_force": reactions.normal_force[i],
            "friction_force": np.array([friction @ cross(k, UP), friction @ k]),
            "contact_roller": mode.contacts[i] % wheel.count,
        }
    return row


def check(machine: Machine, time: float, state: np.ndarray, mode: Mode) -> None:
    """The contacts assumed are the true ones; at every step."""
    bodies = machine.bodies(state)
    normal_forces = machine.solve(time, bodies, mode).normal_force
    for wheel, contact, normal_force in zip(machine.wheels, mode.contacts, normal_forces, strict=True):
        if normal_force < 0.0:
            raise ValueError(f"{wheel.name} lifts off by t = {time:.6g} s; the oracle keeps all wheels on the floor")
        if abs(wheel.azimuth(bodies, contact)) > wheel.half_pitch + 1e-9:
            raise ValueError(f"by t = {time:.6g} s {wheel.name} has passed an edge unseen: rocking on two rollers?")


def stack(rows: list[dict]) -> dict:
    """Rows over time as arrays, of every wheel too."""
    return {key: stack([row[key] for row in rows]) if isinstance(value, dict) else np.array([row[key] for row in rows])
            for key, value in rows[0].items()}  # fmt: skip


def simulate(scene: dict, times: Sequence[float], rtol: float = 1e-12) -> dict:
    """Motion of the machine of `scene` (a scene file as tomllib reads it) at `times`, which start at 0.

    Returns the rows of `observe` stacked over time, and exchange_times, pairs of time and wheel. A bare wheel's
    columns stand beside those of the machine, and its exchange_times are times alone. A row at the instant of a
    restart holds the state after it. Position, velocity and acceleration are those of the chassis origin or the
    wheel centre on the floor. Friction with a small slip_speed is stiff: the cost grows as 1 / slip_speed.
    """
    machine, outputs = Machine(scene), {float(time) for time in times}
    points = {float(time) for table in machine.tables for time in table[0]}
    stops = sorted(outputs | {time for time in points if 0.0 < time < max(outputs)})
    if stops[0] != 0.0:
        raise ValueError("output times start at 0")
    state, contacts = start(machine)
    rows, exchanges, last = [], [], {wheel.name: -inf for wheel in machine.wheels}
    for time, end in pairwise([*stops, stops[-1]]):
        if time in outputs:
            rows.append(observe(machine, time, state, machine.mode(time, contacts)))
        while time < end:
            mode = machine.mode(time, contacts)
            time, state, exchanging = advance(machine, mode, end, state, rtol)
            for place, side in exchanging:
                name = machine.wheels[place].name
                if time - last[name] < 1e-9:
                    raise ValueError(f"at t = {time:.6g} s {name} rests on two rollers; the oracle knows one")
                contacts[place] -= side
                last[name] = time
                exchanges.append((float(time), name))
    columns = stack(rows)
    if machine.chassis:
        return columns | {"exchange_times": exchanges}
    [wheel] = columns.pop("wheels").values()
    return columns | wheel | {"exchange_times": [time for time, _ in exchanges]}
