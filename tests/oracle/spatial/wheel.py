r"""Rollers and where they touch the ground, for the spatial oracle. SI units, radians.

A roller is a body of revolution about its unit axis a with centre B; r(u), |u| <= u_end, is its radius at u along a.
Its lowest point along -nu maximizes -(P - B) . nu = -u s + r sqrt(1 - s^2), s = a . nu:

    P = B + u a - r (nu - s a) / sqrt(1 - s^2)

    inside   d/du of that vanishes:   s = r' sqrt(1 - s^2)          steeper than the profile: the rim of that end
    exact    u = R1 tan q / c + h c sin q,   r = h sqrt(1 - c^2 sin^2 q),   h = R - R1 / cos q,   c = cos psi
             r' = -c sin q / sqrt(1 - c^2 sin^2 q), so sin q = -s / c, |q| <= covered
             others: see profiles.py
    arc      r = radius - rho + sqrt(rho^2 - u^2),   r' = -u / sqrt(rho^2 - u^2), so u = -rho s, |u| <= half_length

The contact is a pair (P, X): X = (x, y, H(x, y)) of the ground, P the lowest point along -nu(X), P - X along nu(X):

    f(x, y) = (x, y) - P_xy - (P_z - H) grad H = 0        delta = (X - P) . nu

f is solved by Newton's method with a Jacobian from central differences, renewed where it converges slowly, until
rounding is left. On a plane f is linear with the unit matrix, and X is P projected. The edge of a step is a surface of
its own, see `meet_edge`: a roller may touch it and the level before it.
"""

from math import asin, cos, pi, radians, sin, sqrt, tan
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from oracle.spatial.ground import Ground, Step
from oracle.spatial.profiles import Hull, parts_of
from oracle.vectors import UP, cross

DIFFERENCE = 1e-6  # m, for the Jacobian of f
LOOKS = 9  # directions across an edge, to begin with
ROUNDING = 1e-16  # m, what may be left of f


class Exact(NamedTuple):
    """The envelope that makes an upright wheel round: R, R1, c and the largest |q|."""

    radius: float
    distance: float
    cosine: float
    covered: float

    def lowest(self, s: float) -> tuple[float, float]:
        """u and r of the lowest point of a roller whose axis rises by s."""
        q = asin(min(max(-s / self.cosine, -1.0), 1.0))
        return self.at(min(max(q, -self.covered), self.covered))

    def at(self, q: float) -> tuple[float, float]:
        h = self.radius - self.distance / cos(q)
        u = self.distance * tan(q) / self.cosine + h * self.cosine * sin(q)
        return u, max(h, 0.0) * sqrt(1.0 - (self.cosine * sin(q)) ** 2)

    @property
    def reach(self) -> float:
        """No point is further from the centre."""
        u, r = self.at(self.covered)
        return sqrt(u**2 + max(r, self.radius - self.distance) ** 2)


class Arc(NamedTuple):
    """A barrel: its radius in the middle, rho, and half its length."""

    radius: float
    curvature_radius: float
    half_length: float

    def lowest(self, s: float) -> tuple[float, float]:
        u = min(max(-self.curvature_radius * s, -self.half_length), self.half_length)
        return u, self.radius - self.curvature_radius + sqrt(self.curvature_radius**2 - u**2)

    @property
    def reach(self) -> float:
        return sqrt(self.half_length**2 + self.radius**2)


class Contact(NamedTuple):
    """P and X of a roller in world axes, the normal nu there, delta > 0 where they overlap; piece 1 + k: edge k, and
    all of them again for each further part of the roller."""

    lowest: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    depth: float
    piece: int


class Wheel:
    """Shape of a wheel: vectors fixed in its disk, (N, 3), in the disk's own axes (h, k, n) at phi = 0.

    Rollers count around the wheel, and in each pitch over the rows: number i * rows + r is roller i of row r.
    centres: of rollers from the wheel's; axes: a.
    """

    def __init__(self, entry: dict, kind: dict) -> None:
        self.entry, self.kind, self.name = entry, kind, entry["name"]
        self.radius, self.distance = kind["radius"], kind["roller_distance"]
        rows, around = kind.get("rows", [{}]), kind["roller_count"]
        self.count = around * len(rows)
        psi = radians(kind.get("roller_angle_deg", 0.0)) * (-1.0 if entry.get("mirrored") else 1.0)
        phases = np.radians([row.get("phase_deg", 0.0) for row in rows])
        turns = radians(entry.get("phase_deg", 0.0)) + 2.0 * pi / around * np.arange(around)
        gamma = (turns[:, None] + phases).ravel()
        offsets = np.tile([row.get("offset", 0.0) for row in rows], around)
        k = np.array([0.0, 1.0, 0.0])
        d = np.stack([np.sin(gamma), 0.0 * gamma, -np.cos(gamma)], axis=1)
        self.centres = self.distance * d + offsets[:, None] * k
        self.axes = cos(psi) * cross(k, d) + sin(psi) * k
        profile = kind.get("profile", {"kind": "exact"})
        if profile["kind"] == "arc":
            profiles = [Arc(*(profile[key] for key in Arc._fields))]
        elif profile["kind"] == "exact":
            covered = radians(kind.get("covered_deg", covered_by_default(around, phases)))
            profiles = [Exact(self.radius, self.distance, cos(psi), covered)]
        else:
            profiles = parts_of(profile)
        self.parts = [Part(profile, self.name) for profile in profiles]

    def lowest(self, centre: np.ndarray, axis: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """P of a roller along -nu."""
        return min((part.lowest(centre, axis, nu) for part in self.parts), key=lambda point: point @ nu)

    def followed(self, contact: Contact, centre: np.ndarray, axis: np.ndarray, ground: Ground) -> np.ndarray:
        """X of the common normal that a contact has become on a roller that has moved a little."""
        number, piece = divmod(contact.piece, pieces_of(ground))
        if piece:
            found = self.parts[number].meet_edge(centre, axis, ground.steps[piece - 1], ground)
        else:
            found = self.parts[number].meet(centre, axis, ground, contact.point[:2])
        assert found is not None
        return found.point

    def contacts(self, centre: np.ndarray, axis: np.ndarray, ground: Ground) -> list[Contact]:
        """Where a roller overlaps the ground: one of its parts after the other."""
        pieces = pieces_of(ground)
        return [
            contact._replace(piece=number * pieces + contact.piece)
            for number, part in enumerate(self.parts)
            for contact in part.contacts(centre, axis, ground)
        ]


class Part(NamedTuple):
    """A convex part of the rollers of a wheel."""

    profile: Exact | Arc | Hull
    name: str

    def lowest(self, centre: np.ndarray, axis: np.ndarray, nu: np.ndarray) -> np.ndarray:
        """P along -nu."""
        s = axis @ nu
        u, r = self.profile.lowest(s)
        return centre + u * axis - r / sqrt(1.0 - s**2) * (nu - s * axis)

    def contacts(self, centre: np.ndarray, axis: np.ndarray, ground: Ground) -> list[Contact]:
        """Where it overlaps the ground, its level or smooth part first, then the edges of its steps."""
        below = self.lowest(centre, axis, UP)
        if below[2] > ground.top:
            return []
        found = self.meet_anywhere(centre, axis, ground, below)
        contacts = [found] if all(step.off(found.point) for step in ground.steps) else []
        for number, step in enumerate(ground.steps):
            edge = self.meet_edge(centre, axis, step, ground)
            contacts += [] if edge is None else [edge._replace(piece=1 + number)]
        return [contact for contact in contacts if contact.depth > 0.0]

    def meet_edge(self, centre: np.ndarray, axis: np.ndarray, step: Step, ground: Ground) -> Contact | None:
        """Common normal of a roller and the edge of a step, or the face below.

        Of all directions nu across the edge that which keeps roller and cylinder furthest apart: the largest
        (P - C) . nu - e, C the axis of the cylinder, is where (P - C) . nu' = 0, as P is extremal along nu.
        """
        s, along = step.beyond(centre), cross(UP, step.up)
        if not -self.profile.reach < s < step.width + self.profile.reach:
            return None
        foot = centre + (step.width - s) * step.up
        axis_of = step.centre + ((centre - step.centre) @ along) * along + ground.below(step, *foot[:2]) * UP

        def turning(angle: float) -> float:
            lowest = self.lowest(centre, axis, step.normal(angle))
            return float((lowest - axis_of) @ (-sin(angle) * UP - cos(angle) * step.up))

        angles = np.linspace(0.0, step.last, LOOKS)
        apart = [(self.lowest(centre, axis, step.normal(angle)) - axis_of) @ step.normal(angle) for angle in angles]
        best = int(np.argmax(apart))
        low, high = angles[max(best - 1, 0)], angles[min(best + 1, LOOKS - 1)]
        if turning(low) <= 0.0:
            return None  # it lies on the level above
        if turning(high) >= 0.0:
            return self.meet_face(centre, axis, step, axis_of[2]) if step.faced else None
        angle = brentq(turning, low, high, xtol=1e-16, rtol=1e-15)
        nu = step.normal(angle)
        lowest = self.lowest(centre, axis, nu)
        point = axis_of + ((lowest - axis_of) @ along) * along + step.e * nu
        return Contact(lowest, point, nu, float((point - lowest) @ nu), 0)

    def meet_face(self, centre: np.ndarray, axis: np.ndarray, step: Step, height: float) -> Contact | None:
        """The vertical face below an edge at this height."""
        lowest = self.lowest(centre, axis, -step.up)
        depth = step.beyond(lowest)
        return Contact(lowest, lowest - depth * step.up, -step.up, depth, 0) if lowest[2] <= height else None

    def meet_anywhere(self, centre: np.ndarray, axis: np.ndarray, ground: Ground, below: np.ndarray) -> Contact:
        """The common normal with the ground without its edges, from below the roller or from elsewhere."""
        for start in (below, centre, *(centre + part * self.profile.reach * axis for part in (-1.0, -0.5, 0.5, 1.0))):
            found = self.meet(centre, axis, ground, start[:2])
            if found is not None:
                return found
        raise ArithmeticError(f"no common normal of {self.name} and the ground below {centre}")

    def meet(self, centre: np.ndarray, axis: np.ndarray, ground: Ground, place: np.ndarray) -> Contact | None:
        """The common normal that Newton's method finds from a place (x, y) on the ground, whatever its depth."""

        def gap(place: np.ndarray) -> np.ndarray:
            lowest = self.lowest(centre, axis, ground.normal(*place))
            return place - lowest[:2] - (lowest[2] - ground.height(*place)) * ground.gradient(*place)

        last, inverse = np.inf, np.eye(2)
        for number in range(60):
            left = gap(place)
            size = np.abs(left).max()
            if size <= ROUNDING or (size >= 0.5 * last and size < 1e-14):
                point, nu = np.array([*place, ground.height(*place)]), ground.normal(*place)
                lowest = self.lowest(centre, axis, nu)
                return Contact(lowest, point, nu, float((point - lowest) @ nu), 0)
            if not ground.flat and (number == 0 or size > 0.1 * last):
                steps = DIFFERENCE * np.eye(2)
                rates = [(gap(place + step) - gap(place - step)) / (2.0 * DIFFERENCE) for step in steps]
                inverse = np.linalg.inv(np.stack(rates, axis=1))
            place, last = place - inverse @ left, size
        return None


def pieces_of(ground: Ground) -> int:
    """The level or smooth part, and every edge."""
    return 1 + len(ground.steps)


def covered_by_default(around: int, phases: np.ndarray) -> float:
    """Half the angle (deg) that a roller of the exact profile covers: rows that are spread evenly share a pitch."""
    pitch, rows = 2.0 * pi / around, len(phases)
    turned = np.sort(np.mod(phases - phases[0] + 1e-9, pitch))
    even = np.allclose(turned, 1e-9 + pitch / rows * np.arange(rows), rtol=0.0, atol=1e-8)
    return 180.0 / around / (rows if even else 1)
