"""Creep, rolling resistance and bearings of rollers, fitted to the measured robots (extra study).

    python -m docs.measured_drag                    writes the tables of docs/pages/measured_robots.md anew
    python -m docs.measured_drag omni3_squares      simulates the logs of a fit anew: five minutes, half of it for bearings

What a wheel with rollers does that an ideal one does not hardly depends on lengths that are known to a per cent, and is
proportional to 1 / c, f / c and T / c: creep stiffness, rolling resistance, torque of a roller's bearing. So each log is
simulated a few times, with the lengths that ideal kinematics finds from one kind of path: plainly, and with each of
WITH. From one compared row to the next a chassis moves, in its own axes, by

    ideal(lengths) + [plain - ideal] + sum over keys of s [run with the key - plain]

s: how much of it there is, by what the run had; both brackets by what ideal kinematics moves with other lengths. Fits
and their bootstraps take that for a simulation: at what squares tell of resistance and bearings it errs by 0.5 mm and
0.2 deg at the end of squares, by 5 mm and 0.7 deg of circles. Bearings, which take ten times as long, are simulated once,
with the lengths from both kinds.
"""

import math
import sys
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path as File
from typing import NamedTuple

import numpy as np

import omnisim
from docs.measured_robots import ALL, DRAWS, OFTEN, Transfer, begun, interval, of_kind, transfer, values
from omnisim.fitting.fit_file import Fit, load_fit
from omnisim.fitting.ideal import dead_reckoned
from omnisim.fitting.logs import Log
from omnisim.fitting.parameters import Parameter
from omnisim.fitting.paths import Path, chassis_start, of_point, turned
from omnisim.fitting.simulation import SimulatedPaths, prepared
from omnisim.scene.schema import Config
from omnisim.studies.factors import with_values

HERE = File(__file__).parent
PAGE, RECORD = HERE / "pages/measured_robots.md", HERE / "measured_drag.npz"
RECORDED = 1e-6  # m and rad: moves are kept in whole numbers of it
MARKS = ("<!-- python -m docs.measured_drag, {} -->\n", "<!-- end -->\n")
BRUSH = {"law": "brush", "coefficient": 0.5, "creep_stiffness": 12.0, "slip_speed": 2e-3}
STEP = 0.05  # s
KINDS, BOTH = ("squares", "circles"), "both"
FITS = {
    "omni4_squares_mended": "`omni4`, each message counted once",
    "omni4_squares": "`omni4`, log as published",
    "omni3_squares": "`omni3`",
}
WITH = {  # what the simulated runs have, beside that of BRUSH and none of the others
    "omni4": {"creep_stiffness": 6.0, "rolling_resistance": 8e-4, "bearing_torque": 2e-3},
    "omni3": {"creep_stiffness": 6.0, "rolling_resistance": 8e-4, "bearing_torque": 2e-2},
}
RANGES = {"creep_stiffness": (-1.0, 5.0), "rolling_resistance": (0.0, 5.0), "bearing_torque": (0.0, 10.0)}  # of parts
NAMES = {
    "creep_stiffness": "`creep_stiffness`",
    "rolling_resistance": "`rolling_resistance`, mm",
    "bearing_torque": "`bearing_torque`, N mm",
}
ROWS: dict[str, tuple[str, ...] | None] = {
    "ideal kinematics": None,
    "real rollers": (),
    "plus creep": ("creep_stiffness",),
    "plus rolling resistance": ("rolling_resistance",),
    "plus bearings": ("bearing_torque",),
    "plus all three": tuple(RANGES),
}
Runs = Mapping[str, np.ndarray]


def scene_of(robot: str, key: str = "", part: float = 1.0) -> omnisim.Scene:
    """The packaged robot with friction that creeps, and with so much of a key: see `amount`."""
    keys: dict[str, object] = {"time.step": STEP, "time.output_interval": STEP}
    keys |= {f"friction.{name}": entry for name, entry in BRUSH.items()}
    if key in BRUSH:
        keys[f"friction.{key}"] = amount(robot, key, part)
    elif key:
        types = omnisim.load(robot).config.wheel_types
        keys |= {f"wheel_types.{kind}.roller.{key}": amount(robot, key, part) for kind in types}
    return omnisim.load(robot, keys)


def amount(robot: str, key: str, part: float) -> float:
    """A key that is this part of what the simulated run has: of f or T, or of what that has more of 1 / c."""
    most = WITH[robot][key]
    if key not in BRUSH:
        return part * most
    plain = float(BRUSH[key])
    return 1.0 / (1.0 / plain + part * (1.0 / most - 1.0 / plain)) if part > -1.0 else math.inf


def along(fit: Fit, scene: omnisim.Scene, lengths: np.ndarray) -> list[np.ndarray]:
    """Moves along each log, simulated with these lengths."""
    fit = replace(fit, scene=scene)
    prepared(fit)
    simulated = SimulatedPaths(fit, 1)
    point, found = fit.point(lengths), []
    for path in simulated(lengths[None], list(range(len(fit.logs))))[0]:
        yaw = path.yaw - point.yaw
        found.append(moves(path.position - turned(np.array([point.x, point.y]), yaw), yaw))
    assert not simulated.early, simulated.early
    return found


def moves(position: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """(n - 1, 3): from row to row, m and rad, in the axes before."""
    return np.column_stack([turned(np.diff(position, axis=0), -yaw[:-1]), np.diff(yaw)])


class CarriedPaths:
    """Paths with other lengths, and with some of each key, from a few simulated ones; a key is a parameter of the fit."""

    def __init__(self, runs: Runs, fit: Fit):
        self.fit = fit
        self.keys = [(p, one.key) for p, one in enumerate(fit.parameters) if one.key in RANGES]
        self.radii = [p for p, one in enumerate(fit.parameters) if one.key.endswith(".radius")]
        self.there = np.append(runs["lengths"], np.zeros(len(self.keys)))
        self.beyond = []
        config = self.config(self.there)
        for log in fit.logs:
            of, ideal = name(log), self.ideal(config, log)
            found = {"plain": runs[f"{of}/plain"] - ideal} | {key: runs[f"{of}/{key}"] for _, key in self.keys}
            self.beyond.append({key: Share.of(moved, ideal) for key, moved in found.items()})

    def __call__(self, points: np.ndarray, logs: list[int]) -> list[list[Path]]:
        return [self.paths(point, logs) for point in points]

    def config(self, point: np.ndarray) -> Config:
        """Nothing but lengths is asked of it."""
        return Config.model_validate(with_values(self.fit.base, self.fit.settings(point)))

    def paths(self, point: np.ndarray, logs: list[int]) -> list[Path]:
        config, tracked = self.config(point), self.fit.point(point)
        smaller = self.there[self.radii].mean() / point[self.radii].mean()  # rollers, across which f and T pull
        found = []
        for i in logs:
            log, beyond = self.fit.logs[i], self.beyond[i]
            ideal = self.ideal(config, log)
            moved = ideal + beyond["plain"].by(ideal)
            for p, key in self.keys:
                moved += smaller * point[p] * beyond[key].by(ideal)
            x, y, yaw = chassis_start(log, tracked)
            turns = yaw + np.append(0.0, np.cumsum(moved[:, 2]))
            places = np.cumsum(np.vstack([[x, y], turned(moved[:, :2], turns[:-1])]), axis=0)
            found.append(of_point(places, turns, tracked))
        return found

    def ideal(self, config: Config, log: Log) -> np.ndarray:
        """Moves of ideal kinematics between compared rows, each an arc."""
        reckoned = dead_reckoned(config, log.angles[self.fit.compared(log)])
        assert reckoned is not None
        return moves(*reckoned)


class Share(NamedTuple):
    """Moves as a share of ideal ones, (3, 3), and what is left of them, (n, 3)."""

    share: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, moved: np.ndarray, ideal: np.ndarray) -> "Share":
        share = np.linalg.lstsq(ideal, moved, rcond=None)[0]
        return cls(share, moved - ideal @ share)

    def by(self, ideal: np.ndarray) -> np.ndarray:
        return ideal @ self.share + self.left


def name(log: Log) -> str:
    """Of the packaged file, without its suffixes."""
    return File(log.file).name.partition(".")[0]


def recorded(of: str, kind: str) -> Runs:
    """What has been simulated for a fit with the lengths that ideal kinematics finds from one kind of path: those, moves
    of each log's plain run, and how much further it moves with each key."""
    with np.load(RECORD) as found:
        runs = {key.partition("/")[2]: found[key] for key in found.files if key.startswith(f"{of}/")}
    ours = {key: moved for key, moved in runs.items() if key.startswith((f"{kind}/", f"{BOTH}/"))}
    lengths = ours.pop(f"{kind}/lengths")
    return {"lengths": lengths} | {key.partition("/")[2]: RECORDED * moved for key, moved in ours.items()}


def record(of: str) -> None:
    """Simulate the logs of a fit, and keep what they tell."""
    fit, found = load_fit(of), {}
    robot = of.partition("_")[0]
    for kind in (*KINDS, BOTH):
        lengths = values(fit, of_kind(fit, kind) or list(range(len(fit.logs))))
        keys = ("bearing_torque",) if kind == BOTH else ("creep_stiffness", "rolling_resistance")
        plain = along(fit, scene_of(robot), lengths)
        with_key = {key: along(fit, scene_of(robot, key), lengths) for key in keys}
        for i, log in enumerate(fit.logs):
            moved = {key: runs[i] - plain[i] for key, runs in with_key.items()}
            if kind != BOTH:
                moved["plain"] = plain[i]
            found |= {f"{of}/{kind}/{name(log)}/{key}": whole(entry) for key, entry in moved.items()}
        if kind != BOTH:
            found[f"{of}/{kind}/lengths"] = lengths
    with np.load(RECORD) as before:
        kept = {key: before[key] for key in before.files if not key.startswith(f"{of}/")}
    np.savez_compressed(RECORD, **kept, **found)


def whole(moved: np.ndarray) -> np.ndarray:
    return np.rint(moved / RECORDED).astype(np.int32)


def with_keys(fit: Fit, keys: tuple[str, ...]) -> Fit:
    """The same with these keys free as well: how much of what they are in the simulated run."""
    return replace(fit, parameters=(*fit.parameters, *(Parameter(key, 0.0, *RANGES[key], ()) for key in keys)))


def carried(of: str, kind: str, keys: tuple[str, ...] | None) -> Transfer:
    """Fitted to one kind of path, its lengths and these keys; None: ideal kinematics."""
    runs = recorded(of, kind)
    fit = begun(load_fit(of), runs["lengths"])
    mine, others = of_kind(fit, kind), of_kind(fit, KINDS[1 - KINDS.index(kind)])
    if keys is None:
        return transfer(fit, mine, others)
    return transfer(with_keys(fit, keys), mine, others, partial(CarriedPaths, runs))


def tables(of: str) -> tuple[list[str], list[str]]:
    """Rows of a fit: how errors carry over, and what is found."""
    robot, found = of.partition("_")[0], []
    made = {row: [carried(of, kind, keys) for kind in KINDS] for row, keys in ROWS.items()}
    rows = [f"| **{FITS[of]}** | | | | |"]
    for row, both in made.items():
        same = [
            f"{one.kind[:, 0].mean():.0f} mm, {one.kind[:, 0].min():.0f} to {one.kind[:, 0].max():.0f}" for one in both
        ]
        other = [other_kind(one, made["real rollers"][k] if ROWS[row] else one) for k, one in enumerate(both)]
        rows.append(f"| {row} | {' | '.join([*same, *other])} |")
    for row, keys in ROWS.items():
        if keys and len(keys) == 1:
            told = [estimate(robot, keys[0], one.estimates[:, -1]) for one in made[row]]
            found.append(f"| {FITS[of]} | {NAMES[keys[0]]} | {' | '.join(told)} |")
    return rows, found


def other_kind(one: Transfer, plain: Transfer) -> str:
    """Errors at the end on the other kind of path, with intervals; bold if nearly all draws are better than plainly."""
    low, high = interval(one.other, OFTEN)
    position, yaw = (
        f"{one.middle[c]:.{c}f}{unit}, {low[c]:.{c}f} to {high[c]:.{c}f}" for c, unit in ((0, " mm"), (1, " deg"))
    )
    better = interval(one.other[:, 0] - plain.other[:, 0], OFTEN)[1] < 0.0
    return f"**{position}**; {yaw}" if better else f"{position}; {yaw}"


def estimate(robot: str, key: str, parts: np.ndarray) -> str:
    """Value and interval of a key, in mm, N mm or as it is."""
    found = [parts[ALL], *interval(parts, [n for _, n in DRAWS])]
    if key in BRUSH:
        found = [found[0], found[2], found[1]]  # the more 1 / c, the less c
        value, low, high = ("stiff" if c > 1e3 else f"{c:.2g}" for c in (amount(robot, key, part) for part in found))
    else:
        amounts = (1e3 * amount(robot, key, part) for part in found)
        value, low, high = (f"{one:.2g}" if one > 5e-3 else "0" for one in amounts)
    return f"{value}, {low} to {high}"


def page() -> str:
    """The page with new tables."""
    text = PAGE.read_text(encoding="utf-8")
    errors = [
        "| fitted to, tested on | squares, other squares | circles, other circles | squares, circles | circles, squares |"
    ]
    errors.append("| --- | --- | --- | --- | --- |")
    found = ["| | free beside lengths | found from squares | from circles |", "| --- | --- | --- | --- |"]
    for of in FITS:
        more, told = tables(of)
        errors += more
        found += told
    for name, rows in (("errors", errors), ("found", found)):
        begin, end = MARKS[0].format(name), MARKS[1]
        before, _, rest = text.partition(begin)
        text = before + begin + "\n".join(rows) + "\n" + end + rest.partition(end)[2]
    return text


if __name__ == "__main__":
    if sys.argv[1:]:
        record(sys.argv[1])
    else:
        PAGE.write_text(page(), encoding="utf-8")
