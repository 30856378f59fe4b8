"""The ideal machine beside the fitted one: dead reckoning by wheels that do not slip."""

import numpy as np

from omnisim.fitting.fit_file import Fit
from omnisim.fitting.logs import Log
from omnisim.fitting.paths import Path, chassis_start, of_point, turned
from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows
from omnisim.scene.schema import Config
from omnisim.scene.validation import checked
from omnisim.studies.factors import with_values

SMALL = 1e-6  # rad, below which an arc is a chord


def dead_reckoned(config: Config, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Place (n, 2) m and yaw (n,) rad of a chassis that starts at 0, from what its wheels have turned, (n, W) rad; None
    where they leave a motion open.

    Between two rows the twist is constant, so that the chassis moves along an arc: with yaw increment a its
    displacement in the axes before is [sin a, -(1 - cos a); 1 - cos a, sin a] / a times what it moves in its own.
    """
    found = inverse(wheel_rows(config), rms_distance(config))
    if found is None:
        return None
    x, y, a = found @ np.diff(angles, axis=0).T
    small = np.abs(a) < SMALL
    safe = np.where(small, 1.0, a)
    sine = np.where(small, 1.0 - a * a / 6.0, np.sin(safe) / safe)
    cosine = np.where(small, 0.5 * a, (1.0 - np.cos(safe)) / safe)
    yaw = np.concatenate([[0.0], np.cumsum(a)])
    moved = turned(np.column_stack([sine * x - cosine * y, cosine * x + sine * y]), yaw[:-1])
    return np.concatenate([np.zeros((1, 2)), np.cumsum(moved, axis=0)]), yaw


class IdealPaths:
    """Paths of a fit's logs by ideal kinematics, as `SimulatedPaths` by simulation."""

    def __init__(self, fit: Fit):
        self.fit = fit

    def __call__(self, points: np.ndarray, logs: list[int]) -> list[list[Path]]:
        """For each point (P,) of values the path of each of these logs. Raises ValueError where wheels leave a motion
        open."""
        return [[self.path(values, self.fit.logs[i]) for i in logs] for values in points]

    def path(self, values: np.ndarray, log: Log) -> Path:
        found = dead_reckoned(checked(with_values(self.fit.base, self.fit.settings(values))), log.angles)
        if found is None:
            raise ValueError("these wheels leave a motion open")
        point = self.fit.point(values)
        x, y, yaw = chassis_start(log, point)
        place = np.array([x, y]) + turned(found[0], yaw)
        rows = self.fit.compared(log)
        return of_point(place[rows], found[1][rows] + yaw, point)
