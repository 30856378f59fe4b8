r"""One omni wheel as N_r + 1 free rigid bodies held together by multipliers: the oracle of the tests.

It follows from the Newton-Euler equations and the constraints alone, imports nothing of omnisim and shares
none of its reductions: no generalized coordinates, no normal force known beforehand, no composite inertia.
It is the testbench of Kosenko and Gerasimov, "Dynamical model of a vehicle with omni wheels", with z up.
SI units, radians.

        n (up)                    R wheel radius, R1 roller distance, psi roller angle, alpha = pi / N_r
        |                         k = n x h, into the page: spin phi > 0 rolls the wheel towards h
       .|----.                    q = gamma_i - phi      azimuth of roller i from straight down towards h
      / |     \                   d = -cos q n + sin q h   from wheel centre O to roller centre O_i = O + R1 d
     |  O------|--> h (heading)   t = k x d
      \  \    /                   a = cos(psi) t + sin(psi) k      roller axis
       '--d--'                    P contact point,  p = P - O_i
    =====P========  floor         w angular velocity,  alpha_b = w_b' angular acceleration of body b

State of body b (0 the disk, 1 + i roller i): centre x [m], rotation matrix Q [1] whose second column is the
axis of symmetry (k of the disk, a of a roller), velocity v [m/s], angular velocity w [rad/s], in world axes:

    x' = v     Q' = w x Q     m v' = force     I w' + w x (I w) = torque     I = It 1 + (Ia - It) a a^T

Constraints g = 0, imposed as g'' = 0 (the initial state has g = g' = 0), and what their multipliers are:

  joint, 3 rows   x_i - x_0 - r = 0,  r = R1 d fixed in the disk                                 force [N]
                  v_i' - v_0' - alpha_0 x r = w_0 x (w_0 x r)
  joint, 2 rows   e . a = 0  for e = d and e = a x d, both fixed in the disk;  b = a x e         torque [N m]
                  (alpha_i - alpha_0) . b = -(w_i - w_0) . b'
  floor, 1 row    n . x_c - S(s) = 0,  s = a . n: the lowest point of roller c has height 0      N [N]
                  n . v_c' + (p x n) . alpha_c = S' n . (w x (w x a)) + S'' s'^2
  servo, 1 row    k . n = 0                                                                      lambda [N m]
                  alpha_0 . (k x n) = -w_0 . ((w_0 x k) x n)

c is the roller in contact. S(s), how far a roller reaches below its centre, is the support function of its
profile u(q), r(q) (axial, radial): S = max over q of -u s + r sqrt(1 - s^2), at sin q = -s / cos(psi). There

    S = R - R1 cos q      S' = -R1 tan(q) / cos(psi) = -(u + r s / sqrt(1 - s^2))
    S'' = R1 / (cos(psi)^2 cos(q)^3)

The second form of S', the derivative of a maximum, makes g' the normal velocity n . (v_c + w_c x p) of the
MATERIAL point at p = u a - r (n - s a) / sqrt(1 - s^2). Hence the row (n, p x n), with the reaction at P; and
g'' = 0 is the paper's "zero relative acceleration at the contact": the rate of that normal velocity, taken
along the moving contact.

Friction on the roller at P, slip v = v_c + w_c x p: F = -mu N g(v) is proportional to the unknown N and so
belongs to the column of N, whose wrench is (f, p x f), f = n - mu g(v). All accelerations and multipliers
come from ONE dense solve of 6 (N_r + 1) + 5 N_r + 2 equations:

    [ M  -W^T ] [ v', alpha_b ]   [ applied forces and torques, -w x (I w) ]      W = J, but for the friction
    [ J    0  ] [ multipliers ] = [ right sides of the rows above          ]      in the row of N

Nothing is stabilized: how well g = 0 still holds (`constraint_residual`) measures the integration.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import asin, ceil, cos, floor, inf, pi, radians, sin, sqrt, tan
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

UP = np.array([0.0, 0.0, 1.0])
# Places in the 18 numbers of a body; AXIS is the second column of its Q.
POSITION, ROTATION, VELOCITY, OMEGA = slice(3), slice(3, 12), slice(12, 15), slice(15, 18)
AXIS = slice(4, 12, 3)
SKEW = np.zeros((3, 9))
SKEW[[0, 1, 2], [7, 2, 3]], SKEW[[0, 1, 2], [5, 6, 1]] = 1.0, -1.0


def skew(w: np.ndarray) -> np.ndarray:
    """Matrices of w x, shape (..., 3, 3)."""
    return (w @ SKEW).reshape(*w.shape, 3)


def cross(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """left x right along the last axis; several times faster than np.cross on a handful of rows."""
    return (skew(left) @ right[..., None])[..., 0]


class Mode(NamedTuple):
    """What is frozen between two restarts: the roller on the floor, and loads = value + slope * (t - begin).

    The loads: drive torque about k [N m], force at O [N] in world or (h, k, n) axes, yaw torque [N m].
    """

    contact: int
    begin: float
    value: np.ndarray
    slope: np.ndarray


class Reactions(NamedTuple):
    acceleration: np.ndarray  # v' and w' of every body, (N_r + 1, 6)
    normal_force: float
    servo_torque: float
    friction: np.ndarray  # on the roller, world axes


class Testbench:
    """The wheel, the floor and the loads of a scene, with the defaults of the scene format."""

    __test__ = False  # no test class, whatever its name suggests

    def __init__(self, scene: dict) -> None:
        [wheel] = scene["wheels"]
        general, friction = scene.get("scene", {}), scene["friction"]
        if "chassis" in scene or general.get("upright", "servo") != "servo":
            raise ValueError("the oracle knows one wheel that a servo keeps upright")
        if friction["law"] not in ("regularized", "saturated", "viscous", "none"):
            raise ValueError(f"the oracle has no friction law {friction['law']!r}")
        self.wheel, self.initial, self.gravity = wheel, scene.get("initial", {}), general.get("gravity", 9.81)
        self.law, self.slip_speed = friction["law"], friction.get("slip_speed", 1e-6)
        self.mu = friction["coefficient"] if self.law in ("regularized", "saturated") else 0.0
        self.viscosity = friction["viscosity"] if self.law == "viscous" else 0.0
        self.shape(scene["wheel_types"][wheel["type"]])
        self.load(wheel.get("drive", {}), scene.get("wrench", {}))
        self.lay_out()

    def shape(self, kind: dict) -> None:
        """Masses, inertias, and the vectors fixed in the disk in its own axes: (h, k, n) at phi = 0."""
        self.radius, self.roller_distance = kind["radius"], kind["roller_distance"]
        self.count = kind["roller_count"]
        psi = radians(kind.get("roller_angle_deg", 0.0)) * (-1.0 if self.wheel.get("mirrored") else 1.0)
        self.cos_psi, self.half_pitch = cos(psi), pi / self.count
        self.phase = radians(self.wheel.get("phase_deg", 0.0))
        disk, roller = kind["disk"], kind["roller"]
        self.mass = np.array([disk["mass"]] + self.count * [roller["mass"]])
        self.axial = np.array([disk["inertia_axle"]] + self.count * [roller["inertia_axial"]])
        self.transverse = np.array([disk["inertia_diameter"]] + self.count * [roller["inertia_transverse"]])
        gamma, k = self.phase + 2.0 * self.half_pitch * np.arange(self.count), np.array([0.0, 1.0, 0.0])
        self.d = np.stack([np.sin(gamma), 0.0 * gamma, -np.cos(gamma)], axis=1)
        self.a = cos(psi) * cross(k, self.d) + sin(psi) * k
        self.e = np.stack([self.d, cross(self.a, self.d)], axis=1)  # (N_r, 2, 3)

    def load(self, drive: dict, wrench: dict) -> None:
        """Tables as (times, values, the loads that they fill); a constant is a table of one point."""
        torque = drive.get("torque", 0.0) if drive.get("kind") == "torque" else 0.0
        times = np.array(wrench.get("times", [0.0]))
        force = np.broadcast_to(wrench.get("force", 0.0), (len(times), 3))
        yaw_torque = np.broadcast_to(wrench.get("yaw_torque", 0.0), len(times))
        self.tables = [
            (np.array(drive.get("times", [0.0])), np.reshape(torque, (-1, 1)), slice(0, 1)),
            (times, np.column_stack([force, yaw_torque]), slice(1, 5)),
        ]
        self.wrench_turns = wrench.get("frame", "world") == "body"

    def mode(self, time: float, roller: int) -> Mode:
        """The mode that begins at `time`: loads linear between points, held outside; two equal times jump."""
        value, slope = np.zeros(5), np.zeros(5)
        for times, values, columns in self.tables:
            after = int(np.searchsorted(times, time, side="right"))
            value[columns] = values[max(after - 1, 0)]
            if 0 < after < len(times):
                slope[columns] = (values[after] - values[after - 1]) / (times[after] - times[after - 1])
                value[columns] += slope[columns] * (time - times[after - 1])
        return Mode(roller % self.count, time, value, slope)

    def lay_out(self) -> None:
        """Where the blocks of the linear system lie, and its constant entries."""
        xyz, joints = np.arange(3), 5 * np.arange(self.count)[:, None]
        self.moves = 6 * (self.count + 1)
        self.turn = 6 * np.arange(self.count + 1)[:, None] + 3 + xyz  # columns of alpha_b
        self.hinge, self.align = joints + xyz, joints + np.array([3, 4])  # rows x_i - x_0 - r, e . a
        self.matrix = np.zeros((self.moves + 5 * self.count + 2,) * 2)
        self.matrix[self.turn - 3, self.turn - 3] = self.mass[:, None]
        self.matrix[self.moves + self.hinge, self.turn[1:] - 3] = 1.0
        self.matrix[self.moves + self.hinge, xyz] = -1.0

    def lowest_point(self, axis: np.ndarray) -> tuple[np.ndarray, float]:
        """p = P - O_c of a roller with this axis, and the q of that point of its profile."""
        c, s = self.cos_psi, axis[2]
        q = asin(-s / c)
        h = self.radius - self.roller_distance / cos(q)
        u = self.roller_distance * tan(q) / c + h * c * sin(q)
        r = h * sqrt(1.0 - (c * sin(q)) ** 2)
        return u * axis - r * (UP - s * axis) / sqrt(1.0 - s**2), q

    def friction(self, slip: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Force on the roller: what is multiplied by N [1], and what is not [N]."""
        speed = sqrt(slip @ slip)
        smooth = sqrt(speed**2 + self.slip_speed**2)
        scale = max(speed, self.slip_speed) if self.law == "saturated" else smooth
        return -self.mu * slip / scale, -self.viscosity * slip

    def solve(self, time: float, bodies: np.ndarray, mode: Mode) -> Reactions:
        matrix, right = self.matrix.copy(), np.zeros(len(self.matrix))
        jacobian, bias = matrix[self.moves :], right[self.moves :]
        applied = right[: self.moves].reshape(-1, 6)
        self.add_bodies(bodies, matrix, applied)
        self.add_loads(time, bodies, mode, applied)
        self.add_joints(bodies, jacobian, bias)
        self.add_servo(bodies, jacobian, bias)
        per_normal, free, push = self.add_contact(bodies, mode.contact, jacobian, bias)
        matrix[: self.moves, self.moves :] = -jacobian[:, : self.moves].T
        touching = slice(6 + 6 * mode.contact, 12 + 6 * mode.contact)
        matrix[touching, -2] -= push(per_normal)
        right[touching] += push(free)
        found = np.linalg.solve(matrix, right)
        normal, servo = found[-2:]
        return Reactions(found[: self.moves].reshape(-1, 6), normal, servo, normal * per_normal + free)

    def add_bodies(self, bodies: np.ndarray, matrix: np.ndarray, applied: np.ndarray) -> None:
        """Inertia, weight, and the gyroscopic torque -w x (I w) = -(Ia - It) (a . w) w x a."""
        axis, w, excess = bodies[:, AXIS], bodies[:, OMEGA], (self.axial - self.transverse)[:, None]
        inertia = excess[..., None] * axis[:, :, None] * axis[:, None, :]
        inertia += self.transverse[:, None, None] * np.eye(3)
        matrix[self.turn[:, :, None], self.turn[:, None, :]] = inertia
        applied[:, 2] = -self.mass * self.gravity
        applied[:, 3:] = -excess * np.sum(axis * w, axis=1, keepdims=True) * cross(w, axis)

    def add_loads(self, time: float, bodies: np.ndarray, mode: Mode, applied: np.ndarray) -> None:
        drive, *force, yaw_torque = mode.value + mode.slope * (time - mode.begin)
        k = bodies[0, AXIS]
        if self.wrench_turns:
            force = force[0] * cross(k, UP) + force[1] * k + force[2] * UP
        applied[0, :3] += force
        applied[0, 3:] += drive * k + yaw_torque * UP

    def add_joints(self, bodies: np.ndarray, jacobian: np.ndarray, bias: np.ndarray) -> None:
        disk, about = bodies[0, ROTATION].reshape(3, 3), skew(bodies[0, OMEGA])
        r = self.roller_distance * self.d @ disk.T
        jacobian[self.hinge[:, :, None], self.turn[0]] = skew(r)
        bias[self.hinge] = r @ (about @ about).T
        axis, w, e = bodies[1:, None, AXIS], bodies[1:, None, OMEGA], self.e @ disk.T
        b = cross(axis, e)
        b_rate = cross(cross(w, axis), e) + cross(axis, e @ about.T)
        jacobian[self.align[:, :, None], self.turn[1:, None, :]] = b
        jacobian[self.align[:, :, None], self.turn[0]] = -b
        bias[self.align] = -np.sum((w - bodies[0, OMEGA]) * b_rate, axis=2)

    def add_servo(self, bodies: np.ndarray, jacobian: np.ndarray, bias: np.ndarray) -> None:
        k, w = bodies[0, AXIS], bodies[0, OMEGA]
        jacobian[-1, 3:6] = cross(k, UP)
        bias[-1] = -w @ cross(cross(w, k), UP)

    def add_contact(self, bodies: np.ndarray, contact: int, jacobian: np.ndarray, bias: np.ndarray) -> tuple:
        """The floor row. Friction with and without N, and what turns a force at P into a wrench at O_c."""
        axis, w = bodies[1 + contact, AXIS], bodies[1 + contact, OMEGA]
        p, q = self.lowest_point(axis)
        push = lambda force: np.concatenate([force, cross(p, force)])  # noqa: E731
        axis_rate = cross(w, axis)
        slope = -self.roller_distance * tan(q) / self.cos_psi
        curvature = self.roller_distance / (self.cos_psi**2 * cos(q) ** 3)
        jacobian[-2, 6 + 6 * contact : 12 + 6 * contact] = push(UP)
        bias[-2] = slope * cross(w, axis_rate)[2] + curvature * axis_rate[2] ** 2
        slip = (bodies[1 + contact, VELOCITY] + cross(w, p)) * [1.0, 1.0, 0.0]
        return *self.friction(slip), push

    def derivative(self, time: float, state: np.ndarray, mode: Mode) -> np.ndarray:
        """Of 18 numbers a body, then phi and theta: integrated too, as Q knows them only to full turns."""
        bodies = state[:-2].reshape(-1, 18)
        rate = np.empty_like(bodies)
        rate[:, POSITION] = bodies[:, VELOCITY]
        rate[:, ROTATION] = (skew(bodies[:, OMEGA]) @ bodies[:, ROTATION].reshape(-1, 3, 3)).reshape(-1, 9)
        rate[:, VELOCITY.start :] = self.solve(time, bodies, mode).acceleration
        return np.append(rate, [bodies[0, OMEGA] @ bodies[0, AXIS], bodies[0, OMEGA][2]])

    def azimuth(self, state: np.ndarray, contact: int) -> float:
        """q of a roller, from the orientation of the disk."""
        d = state[ROTATION].reshape(3, 3) @ self.d[contact]
        return float(np.arctan2(d @ cross(state[AXIS], UP), -d[2]))


def start(bench: Testbench) -> tuple[np.ndarray, int]:
    """Initial state, and the roller on the floor (counted on beyond N_r, as phi is beyond 2 pi)."""
    wheel, initial = bench.wheel, bench.initial
    phi, yaw = radians(wheel.get("spin_angle_deg", 0.0)), radians(initial.get("yaw_deg", 0.0))
    h = np.array([cos(yaw), sin(yaw), 0.0])
    k = cross(UP, h)
    disk = np.stack([cos(phi) * h - sin(phi) * UP, k, sin(phi) * h + cos(phi) * UP], axis=1)
    d, a = bench.d @ disk.T, bench.a @ disk.T
    w = wheel.get("spin_rate", 0.0) * k + initial.get("yaw_rate", 0.0) * UP
    bodies = np.zeros((bench.count + 1, 18))
    bodies[:, POSITION] = [*initial.get("position", [0.0, 0.0]), bench.radius]
    bodies[1:, POSITION] += bench.roller_distance * d
    bodies[0, ROTATION] = disk.ravel()
    bodies[1:, ROTATION] = np.stack([cross(a, d), a, d], axis=2).reshape(-1, 9)
    bodies[:, VELOCITY] = [*initial.get("velocity", [0.0, 0.0]), 0.0]
    bodies[1:, VELOCITY] += bench.roller_distance * cross(w, d)
    bodies[:, OMEGA] = w
    bodies[1:, OMEGA] += np.broadcast_to(wheel.get("roller_rates", 0.0), bench.count)[:, None] * a
    return np.append(bodies, [phi, yaw]), first_contact(bench, bodies, phi)


def first_contact(bench: Testbench, bodies: np.ndarray, phi: float) -> int:
    """The roller with |q| <= alpha; on the edge the one that phi', or else phi'', turns towards the floor."""
    pitches = (phi - bench.phase) / (2.0 * bench.half_pitch)
    ahead, behind = floor(pitches + 0.5 + 1e-12), ceil(pitches - 0.5 - 1e-12)  # edge: q = alpha, -alpha
    if ahead == behind:
        return ahead
    turning = bodies[0, OMEGA] @ bodies[0, AXIS]
    if turning == 0.0:
        turning = bench.solve(0.0, bodies, bench.mode(0.0, ahead)).acceleration[0, 3:] @ bodies[0, AXIS]
    return ahead if turning > 0.0 else behind


def advance(bench: Testbench, mode: Mode, end: float, state: np.ndarray, rtol: float):
    """March to `end`, or to the first edge q = +-alpha of the roller on the floor: time, state, side or 0.

    SciPy locates an event on the interpolant of a step. Here that step is repeated up to the root without it,
    and what remains of q -+ alpha goes into one Newton correction. No step turns the wheel by much more than
    alpha / 2, so that trial steps stay on the roller.
    """
    turning = abs(state[OMEGA] @ state[AXIS])
    settings = {"method": "DOP853", "rtol": rtol, "atol": 1e-2 * rtol, "args": (mode,)}
    settings["max_step"] = 0.5 * bench.half_pitch / turning if turning > 0.0 else inf

    def to_edge(side: int):
        edge = lambda time, state, mode: bench.azimuth(state, mode.contact) - side * bench.half_pitch  # noqa: E731
        edge.terminal, edge.direction = True, side
        return edge

    events = {side: to_edge(side) for side in (-1, 1)}
    march = solve_ivp(bench.derivative, (mode.begin, end), state, events=list(events.values()), **settings)
    if march.status < 0:
        raise RuntimeError(march.message)
    if march.status == 0:
        return end, march.y[:, -1], 0
    side = -1 if march.t_events[0].size else 1
    time = march.t[-1]
    state = solve_ivp(bench.derivative, (march.t[-2], time), march.y[:, -2], **settings).y[:, -1]
    rate = bench.derivative(time, state, mode)
    correction = events[side](time, state, mode) / rate[-2]  # as q' = -phi'
    return time + correction, state + correction * rate, side


def observe(bench: Testbench, time: float, state: np.ndarray, mode: Mode) -> dict:
    """One row of output."""
    bodies = state[:-2].reshape(-1, 18)
    reactions = bench.solve(time, bodies, mode)
    disk, acceleration, k = bodies[0], reactions.acceleration[0], bodies[0, AXIS]
    return {
        "time": time,
        "position": disk[:2],
        "velocity": disk[VELOCITY][:2],
        "acceleration": acceleration[:2],
        "yaw": state[-1],
        "yaw_rate": disk[OMEGA] @ UP,
        "yaw_acceleration": acceleration[3:] @ UP,
        "spin_angle": state[-2],
        "spin_rate": disk[OMEGA] @ k,
        "spin_acceleration": acceleration[3:] @ k,
        "roller_axial_rate": np.sum(bodies[1:, OMEGA] * bodies[1:, AXIS], axis=1),
        "normal_force": reactions.normal_force,
        "servo_torque": reactions.servo_torque,
        "friction_force": np.array([reactions.friction @ cross(k, UP), reactions.friction @ k]),
        "contact_roller": mode.contact,
        "constraint_residual": constraint_residual(bench, bodies, mode.contact),
    }


def constraint_residual(bench: Testbench, bodies: np.ndarray, contact: int) -> float:
    """Largest |g| of all constraints, lengths over R."""
    disk, axis = bodies[0, ROTATION].reshape(3, 3), bodies[1:, AXIS]
    gap = bodies[1:, POSITION] - bodies[0, POSITION] - bench.roller_distance * bench.d @ disk.T
    tilt = (bench.e @ disk.T @ axis[..., None])[..., 0]
    height = bodies[1 + contact, 2] + bench.lowest_point(axis[contact])[0][2]
    lengths = max(np.abs(gap).max(), abs(height)) / bench.radius
    return max(lengths, np.abs(tilt).max(), abs(disk[2, 1]))


def check(bench: Testbench, time: float, state: np.ndarray, mode: Mode) -> None:
    """The contact assumed is the true one. N is linear in time between restarts: checking there is enough."""
    if bench.solve(time, state[:-2].reshape(-1, 18), mode).normal_force < 0.0:
        raise ValueError(f"the wheel lifts off by t = {time:.6g} s; the oracle keeps it on the floor")
    if abs(bench.azimuth(state, mode.contact)) > bench.half_pitch + 1e-9:
        raise ValueError(f"by t = {time:.6g} s the wheel has passed an edge unseen: rocking on two rollers?")


def simulate(scene: dict, times: Sequence[float], rtol: float = 1e-12) -> dict:
    """Motion of the wheel of `scene` (a scene file as tomllib reads it) at `times`, which start at 0.

    Returns the rows of `observe` stacked over time, and exchange_times. Output times, table points and
    exchanges are restarts, so that no interpolant enters; a row at such an instant holds the state after it.
    Friction with a small slip_speed is stiff: the cost grows as 1 / slip_speed.
    """
    bench, outputs = Testbench(scene), {float(time) for time in times}
    points = {float(time) for table in bench.tables for time in table[0]}
    stops = sorted(outputs | {time for time in points if 0.0 < time < max(outputs)})
    if stops[0] != 0.0:
        raise ValueError("output times start at 0")
    state, roller = start(bench)
    rows, exchange_times = [], [-inf]
    for time, end in pairwise([*stops, stops[-1]]):
        if time in outputs:
            rows.append(observe(bench, time, state, bench.mode(time, roller)))
        while time < end:
            mode = bench.mode(time, roller)
            check(bench, time, state, mode)
            time, state, side = advance(bench, mode, end, state, rtol)
            check(bench, time, state, mode)
            if side and time - exchange_times[-1] < 1e-9:
                raise ValueError(f"at t = {time:.6g} s the wheel rests on two rollers; the oracle knows one")
            if side:
                roller -= side
                exchange_times.append(time)
    columns = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    return columns | {"exchange_times": exchange_times[1:]}
