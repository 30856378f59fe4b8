"""Rollers whose bearings drag, in kinematics, fitted to the measured mecanum robot: python -m docs.measured_drag (extra study)

For a table of docs/pages/measured_robots.md. A simulation of it has 32 rollers that turn, and takes ten times as long.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from omnisim.fitting.fit_file import load_fit
from omnisim.fitting.fitting import what_is_known
from omnisim.fitting.ideal import IdealPaths
from omnisim.fitting.least_squares import Search
from omnisim.fitting.logs import Log
from omnisim.fitting.parameters import Parameter
from omnisim.fitting.paths import Path, chassis_start, errors, measured, of_point, turned
from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows
from omnisim.scene.validation import checked
from omnisim.studies.factors import with_values

NONE = 1e-9  # a loss that is none: a range of 0 is not allowed


class DragPaths(IdealPaths):
    """Ideal kinematics of wheels whose rollers drag in their bearings, and creep for it.

    Real rollers go sideways at sin(a) / a of the ideal, a = pi / 8. Of that speed the share of the last parameter is lost,
    and of the turning as well where all rollers turn one way, |v_y| > |w| times half the wheelbase. Ahead rollers rest.
    """

    def path(self, point: np.ndarray, log: Log) -> Path:
        fit = self.fit
        config = checked(with_values(fit.base, fit.settings(point)))
        twist = np.diff(log.angles, axis=0) @ inverse(wheel_rows(config), rms_distance(config)).T
        sideways = np.abs(twist[:, 1]) > abs(config.wheels[0].position[0]) * np.abs(twist[:, 2])
        twist[:, 1] *= np.sinc(1.0 / 8.0) - point[-1]
        twist[:, 2] *= 1.0 - point[-1] * sideways
        tracked = fit.point(point)
        x, y, yaw = chassis_start(log, tracked)
        turned_to = yaw + np.concatenate([[0.0], np.cumsum(twist[:, 2])])
        middle = 0.5 * (turned_to[1:] + turned_to[:-1])
        place = np.cumsum(np.vstack([[x, y], turned(twist[:, :2], middle)]), axis=0)
        rows = fit.compared(log)
        return of_point(place[rows], turned_to[rows], tracked)


class Found(NamedTuple):
    """Sum of squares of weighted residuals; the share lost with its 95 % interval; mm and deg at the end of tested runs."""

    cost: float
    lost: tuple[float, float, float]
    ends: list[tuple[float, float]]


def fitted(kinds: tuple[str, ...], most: float) -> Found:
    """A fit to runs 1 and 4 of these kinds of path, with a loss up to so much; runs 2 and 3 of squares, then of circles."""
    base = load_fit("omni4_squares_mended")
    number = {log.file[len("omni4_") : -len(".csv.gz")]: i for i, log in enumerate(base.logs)}
    chosen = {number[f"{kind}_{run}"] for kind in kinds for run in (1, 4)}
    logs = tuple(replace(log, use="fit" if i in chosen else "test") for i, log in enumerate(base.logs))
    fit = replace(base, parameters=(*base.parameters, Parameter("drag", 0.0, -most, most, ())), logs=logs)
    paths = DragPaths(fit)
    search = Search(fit, paths, range(len(fit.parameters)), lambda trial: None)
    end = search.solve(fit.start)
    known = what_is_known(fit, end, search.weights)
    tested = [number[f"{kind}_{run}"] for kind in ("squares", "circles") for run in (2, 3)]
    ways = paths(end.values[None], tested)[0]
    found = [errors(way, measured(fit.logs[i], fit.compared(fit.logs[i]))) for i, way in zip(tested, ways, strict=True)]
    return Found(
        float(np.sum(end.residuals**2)),
        (float(end.values[-1]), float(known.low[-1]), float(known.high[-1])),
        [(1e3 * one.end_position, float(np.degrees(one.end_yaw))) for one in found],
    )


if __name__ == "__main__":
    for most in (NONE, 0.1):
        for kinds in (("squares",), ("circles",), ("squares", "circles")):
            print(kinds, fitted(kinds, most), flush=True)
