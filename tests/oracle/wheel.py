"""The wheels of the oracle: shape, mounted rollers, the point where one is lowest, what resists its rolling."""

from math import asin, cos, nan, pi, radians, sin, sqrt, tan

import numpy as np

from oracle.vectors import AXIS, OMEGA, ROTATION, UP, cross


class Wheel:
    """Shape of one wheel, and the vectors fixed in its disk in the disk's own axes: (h, k, n) at phi = 0."""

    def __init__(self, entry: dict, kind: dict, disk: int) -> None:
        self.entry, self.name, self.kind = entry, entry["name"], kind
        self.radius, self.roller_distance = kind["radius"], kind["roller_distance"]
        rows = kind.get("rows", [{}])
        self.count = kind["roller_count"] * len(rows)
        self.half_pitch = pi / self.count
        # places among the bodies
        self.disk, self.rollers = disk, slice(disk + 1, disk + 1 + self.count)
        psi = radians(kind.get("roller_angle_deg", 0.0)) * (-1.0 if entry.get("mirrored") else 1.0)
        self.cos_psi, self.phase = cos(psi), radians(entry.get("phase_deg", 0.0) + rows[0].get("phase_deg", 0.0))
        gamma, aside = self.mounted(entry, rows)
        k = np.array([0.0, 1.0, 0.0])
        self.d = np.stack([np.sin(gamma), 0.0 * gamma, -np.cos(gamma)], axis=1)
        self.place = self.roller_distance * self.d + aside[:, None] * k
        self.a = cos(psi) * cross(k, self.d) + sin(psi) * k

    def mounted(self, entry: dict, rows: list[dict]) -> tuple[np.ndarray, np.ndarray]:
        """Azimuth of every roller in the disk, and its offset along the axle: in order of azimuth from the first row's
        roller 0 on."""
        turns = 2.0 * pi / self.kind["roller_count"] * np.arange(self.kind["roller_count"])
        own = radians(entry.get("phase_deg", 0.0))
        gamma = np.concatenate([own + radians(row.get("phase_deg", 0.0)) + turns for row in rows])
        aside = np.repeat([row.get("offset", 0.0) for row in rows], len(turns))
        order = np.argsort((gamma - gamma[0] + 0.5 * self.half_pitch) % (2.0 * pi))
        return gamma[order], aside[order]

    def azimuth(self, bodies: np.ndarray, contact: int) -> float:
        """q of a roller, from the orientation of the disk."""
        disk = bodies[self.disk]
        d = disk[ROTATION].reshape(3, 3) @ self.d[contact % self.count]
        return float(np.arctan2(d @ cross(disk[AXIS], UP), -d[2]))

    def spin_rate(self, bodies: np.ndarray) -> float:
        return float(bodies[self.disk, OMEGA] @ bodies[self.disk, AXIS])

    def lowest_point(self, axis: np.ndarray) -> tuple[np.ndarray, float]:
        """p = P - O_c of a roller with this axis, and the q of that point of its profile.

        Steeper than any axis in the wheel, as in a trial stage of too long a step: NaN, for which the step is refused.
        """
        c, s = self.cos_psi, axis[2]
        if abs(s) > c:
            return np.full(3, nan), nan
        q = asin(-s / c)
        h = self.radius - self.roller_distance / cos(q)
        u = self.roller_distance * tan(q) / c + h * c * sin(q)
        r = h * sqrt(1.0 - (c * sin(q)) ** 2)
        return u * axis - r * (UP - s * axis) / sqrt(1.0 - s**2), q


def rolling_resistance(roller: dict, turning: np.ndarray) -> np.ndarray:
    """Moment on a roller over N (m): against its angular velocity in the tangent plane, `turning`."""
    size = sqrt(turning @ turning + roller.get("rolling_rate", 0.1) ** 2)
    return -roller.get("rolling_resistance", 0.0) / size * turning
