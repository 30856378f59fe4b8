r"""One omni wheel whose neighbouring rollers share the load by a smooth weight near their common edge.

A rigid wheel changes rollers at once, and may come to rest on two: phi' = 0, the load split by a share sigma such
that phi'' = 0. This oracle knows neither exchanges nor rest: it has no events and no modes. The load moves from
one roller to the next within a width delta of the edge,

    weight of roller i    w_i = S((alpha - q_i) / delta) S((alpha + q_i) / delta)          sum of w_i = 1
    S(x) = 1/2 + (15 x - 10 x^3 + 3 x^5) / 16 in [-1, 1],  0 below,  1 above

and every roller with w_i > 0 touches the floor, at its own contact point, with w_i times the friction that it would
have under the full load. Where both rollers push the wheel back, it swings within the layer, friction damps the
swings, and it settles where the weights balance: the share. As delta -> 0 the motion tends to the one with
exchanges and rest. Measured errors: delta^2 before a rest, delta in it (`limit` extrapolates on that ground),
delta^0.85 after it, as the wheel leaves the layer slowly; the time of leaving delta^0.4.

Equations of motion (z up, SI units, radians; h heading, k axle, q_i = gamma_i - phi azimuth of roller i from straight
down towards h, a_i its axis, p_i its absolute axial rate, c = cos psi, s = sin psi; the axle is horizontal):

    h_q = R - R1 / cos q     l = R1 tan q tan psi + offset     contact point O - R n + l k
    chi' = p - phi' s + theta' c sin q                         joint rate
    v_h = V_h - phi' R - theta' l - chi' h_q s                 slip
    v_k = V_k - chi' h_q c cos q
    Ia p_i' = h_q (-s F_h - c cos q F_k)
    M V' = sum F                                               M = m_disk + N_r m_r,  N = M g
    J_k phi'' + s sum Ia p_i' + theta' G_h = -R sum F_h        G_h = -sum Ia p_i c cos q_i
    J_t theta'' - sum Ia p_i' c sin q_i - phi' G_h = -sum l F_h

State: x, y, theta, phi - edge (reckoned from one edge, as it is to be resolved far below delta), their rates, all p_i.
It imports nothing of omnisim.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, radians, sin, sqrt, tan
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

SPIN = 3  # place of phi - edge in the state; the rates of x, y, theta, phi are 4 places further, then all p_i
# A wheel that passes an edge, or swings about it, leaves the layer sooner [s].
SHORTEST_REST = 0.02


class Rest(NamedTuple):
    """A time within the layer of one edge. share: its mean over that time, of the roller at q = +alpha."""

    begin: float
    end: float  # inf: still there at the end
    edge: float
    share: float


class Motion(NamedTuple):
    """Rows at the output times. share: that of the roller at q = +alpha at the nearest edge."""

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    yaw: np.ndarray
    yaw_rate: np.ndarray
    spin_angle: np.ndarray
    spin_rate: np.ndarray
    roller_axial_rate: np.ndarray
    share: np.ndarray
    rests: tuple[Rest, ...]


def smooth_step(x: float) -> float:
    """From 0 at x <= -1 to 1 at x >= 1 with two continuous derivatives; smooth_step(x) + smooth_step(-x) = 1."""
    if abs(x) >= 1.0:
        return 1.0 if x > 0.0 else 0.0
    return 0.5 + x * (15.0 - x * x * (10.0 - 3.0 * x * x)) / 16.0


class Wheel:
    """Parameters of the wheel of a scene, its start, and the right-hand side."""

    def __init__(self, scene: dict, delta: float) -> None:
        [wheel] = scene["wheels"]
        general, friction = scene.get("scene", {}), scene["friction"]
        if "chassis" in scene or "wrench" in scene or wheel.get("drive", {"kind": "free"}) != {"kind": "free"}:
            raise ValueError("this oracle knows one wheel that nothing drives")
        self.law, self.slip_speed = friction["law"], friction.get("slip_speed", 1e-6)
        if self.law not in ("regularized", "viscous"):
            raise ValueError(f"this oracle has no friction law {self.law!r}")
        kind = scene["wheel_types"][wheel["type"]]
        disk, roller, rows = kind["disk"], kind["roller"], kind.get("rows", [{}])
        self.count, turn = kind["roller_count"] * len(rows), 360.0 / kind["roller_count"] / len(rows)
        self.aside = [row.get("offset", 0.0) for row in rows]
        if any(row.get("phase_deg", 0.0) != i * turn for i, row in enumerate(rows)) or sum(self.aside) != 0.0:
            raise ValueError("this oracle knows rows in order that balance")
        self.radius, self.roller_distance, self.delta = kind["radius"], kind["roller_distance"], delta
        psi = radians(kind.get("roller_angle_deg", 0.0)) * (-1.0 if wheel.get("mirrored") else 1.0)
        self.c, self.s, self.alpha = cos(psi), sin(psi), pi / self.count
        self.axial, rollers = roller["inertia_axial"], self.count * roller["mass"]
        across, offset = self.count * roller["inertia_transverse"], rollers * self.roller_distance**2
        self.mass = disk["mass"] + rollers
        self.about_axle = disk["inertia_axle"] + offset + across * (1.0 - self.s**2)
        self.about_vertical = disk["inertia_diameter"] + offset / 2.0 + across * (1.0 - self.c**2 / 2.0)
        self.about_vertical += roller["mass"] * kind["roller_count"] * sum(aside**2 for aside in self.aside)
        load = self.mass * general.get("gravity", 9.81)
        self.strength = friction["viscosity"] if self.law == "viscous" else friction["coefficient"] * load
        self.begin(wheel, scene.get("initial", {}))

    def begin(self, wheel: dict, initial: dict) -> None:
        """Start of the state, and the edge from which phi is reckoned: the one nearest to the start."""
        phi, phase = radians(wheel.get("spin_angle_deg", 0.0)), radians(wheel.get("phase_deg", 0.0))
        pitches = round(((phi - phase) / self.alpha - 1.0) / 2.0)
        self.edge = phase + (2 * pitches + 1) * self.alpha
        # azimuths at that edge: (2 (i - pitches) - 1) alpha
        self.azimuth = [(2 * (i - pitches) - 1) * self.alpha for i in range(self.count)]
        spin_rate, yaw_rate = wheel.get("spin_rate", 0.0), initial.get("yaw_rate", 0.0)
        relative = np.broadcast_to(wheel.get("roller_rates", 0.0), self.count)
        across = [spin_rate * self.s - yaw_rate * self.c * sin(q - (phi - self.edge)) for q in self.azimuth]
        position, velocity = initial.get("position", [0.0, 0.0]), initial.get("velocity", [0.0, 0.0])
        turned = [radians(initial.get("yaw_deg", 0.0)), phi - self.edge]
        self.start = np.array([*position, *turned, *velocity, yaw_rate, spin_rate, *(relative + across)])

    def share(self, spin: float) -> float:
        """Share of the roller at q = +alpha at the nearest edge; spin is phi - edge."""
        return smooth_step(self.from_nearest_edge(spin) / self.delta)

    def from_nearest_edge(self, spin: float) -> float:
        return spin - 2.0 * self.alpha * round(spin / (2.0 * self.alpha))

    def friction(self, v_h: float, v_k: float) -> tuple[float, float]:
        """Force on a roller that carries the full load."""
        scale = self.strength
        if self.law == "regularized":
            scale /= sqrt(v_h * v_h + v_k * v_k + self.slip_speed**2)
        return -scale * v_h, -scale * v_k

    def derivative(self, time: float, state: np.ndarray) -> list[float]:
        _, _, yaw, spin, v_x, v_y, yaw_rate, spin_rate, *axial_rates = state.tolist()
        c, s, radius, h_x, h_y = self.c, self.s, self.radius, cos(yaw), sin(yaw)
        v_along, v_axle = v_x * h_x + v_y * h_y, v_y * h_x - v_x * h_y
        spins_up = [0.0] * self.count
        force_h = force_k = yaw_torque = gained_k = gained_n = g_h = 0.0
        for i, p in enumerate(axial_rates):
            q = self.azimuth[i] - spin
            q -= 2.0 * pi * round(q / (2.0 * pi))
            sin_q, cos_q = sin(q), cos(q)
            g_h -= self.axial * p * c * cos_q
            weight = smooth_step((self.alpha - q) / self.delta) * smooth_step((self.alpha + q) / self.delta)
            if weight == 0.0:
                continue
            height = radius - self.roller_distance / cos_q
            l = self.roller_distance * tan(q) * s / c + self.aside[i % len(self.aside)]
            joint_rate = p - spin_rate * s + yaw_rate * c * sin_q
            slip_h = v_along - spin_rate * radius - yaw_rate * l - joint_rate * height * s
            slip_k = v_axle - joint_rate * height * c * cos_q
            f_h, f_k = (weight * force for force in self.friction(slip_h, slip_k))
            torque = height * (-s * f_h - c * cos_q * f_k)
            spins_up[i] = torque / self.axial
            force_h, force_k, yaw_torque = force_h + f_h, force_k + f_k, yaw_torque - l * f_h
            gained_k, gained_n = gained_k + torque * s, gained_n - torque * c * sin_q
        acceleration = (force_h * h_x - force_k * h_y) / self.mass, (force_h * h_y + force_k * h_x) / self.mass
        yaw_acceleration = (yaw_torque - gained_n + spin_rate * g_h) / self.about_vertical
        spin_acceleration = (-radius * force_h - gained_k - yaw_rate * g_h) / self.about_axle
        return [v_x, v_y, yaw_rate, spin_rate, *acceleration, yaw_acceleration, spin_acceleration, *spins_up]


def find_rests(wheel: Wheel, time: np.ndarray, states: np.ndarray) -> tuple[Rest, ...]:
    """Times within a layer for longer than SHORTEST_REST, from the steps of the integrator."""
    spin = states[:, SPIN]
    offset = np.array([wheel.from_nearest_edge(value) for value in spin])
    edge = spin - offset
    inside = np.concatenate([[False], np.abs(offset) < wheel.delta, [False]])
    firsts, lasts = np.flatnonzero(inside[1:] & ~inside[:-1]), np.flatnonzero(inside[:-1] & ~inside[1:]) - 1
    share = np.array([wheel.share(value) for value in spin])
    slope = 15.0 / 16.0 * (1.0 - np.clip(offset / wheel.delta, -1.0, 1.0) ** 2) ** 2
    rate = slope * states[:, SPIN + 4] / wheel.delta
    rests = []
    for first, last in zip(firsts, lasts, strict=True):
        if time[last] - time[first] < SHORTEST_REST:
            continue
        end = boundary(wheel, time, spin - edge[last], last, last + 1) if last + 1 < len(time) else np.inf
        begin = boundary(wheel, time, spin - edge[first], first, first - 1) if first else time[0]
        steps, here = np.diff(time[first : last + 1]), slice(first, last + 1)
        # trapezoids with their end correction, as the share and its rate are known
        area = steps * (share[here][1:] + share[here][:-1]) / 2.0 - steps**2 * np.diff(rate[here]) / 12.0
        rests.append(Rest(begin, end, wheel.edge + edge[first], area.sum() / steps.sum()))
    return tuple(rests)


def boundary(wheel: Wheel, time: np.ndarray, offset: np.ndarray, inside: int, outside: int) -> float:
    """When |phi - edge| passes delta between two neighbouring steps."""
    reach = wheel.delta if offset[outside] > 0.0 else -wheel.delta
    part = (reach - offset[inside]) / (offset[outside] - offset[inside])
    return time[inside] + part * (time[outside] - time[inside])


def simulate(scene: dict, times: Sequence[float], delta: float, rtol: float = 1e-11) -> Motion:
    """Motion of the wheel of `scene` (a scene file as tomllib reads it) at `times`, which start at 0.

    Every output time is a restart, so that no interpolant enters. The layer is stiff for an explicit method and
    swings in it are fast for an implicit one: LSODA changes between the two.
    """
    wheel = Wheel(scene, delta)
    if times[0] != 0.0:
        raise ValueError("output times start at 0")
    rows, steps, states = [wheel.start], [np.zeros(1)], [wheel.start[None]]
    atol = np.full(len(wheel.start), 1e-2 * rtol)
    atol[SPIN] = 1e-6 * delta
    for begin, end in pairwise(times):
        march = solve_ivp(wheel.derivative, (begin, end), rows[-1], method="LSODA", rtol=rtol, atol=atol)
        if not march.success:
            raise RuntimeError(march.message)
        rows.append(march.y[:, -1])
        steps.append(march.t[1:])
        states.append(march.y[:, 1:].T)
    state = np.array(rows)
    return Motion(
        time=np.array(times, dtype=float),
        position=state[:, :2],
        velocity=state[:, 4:6],
        yaw=state[:, 2],
        yaw_rate=state[:, 6],
        spin_angle=wheel.edge + state[:, SPIN],
        spin_rate=state[:, 7],
        roller_axial_rate=state[:, 8:],
        share=np.array([wheel.share(value) for value in state[:, SPIN]]),
        rests=find_rests(wheel, np.concatenate(steps), np.concatenate(states)),
    )


def limit(coarse: Motion, fine: Motion, ratio: float) -> dict[str, np.ndarray]:
    """Rows of delta -> 0 from those of delta and delta / ratio, as the error is in proportion to delta."""
    motion = Motion._fields[1:-1]
    return {name: getattr(fine, name) + (getattr(fine, name) - getattr(coarse, name)) / (ratio - 1) for name in motion}
