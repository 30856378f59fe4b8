"""The machine of a fit, driven by what the wheels of its logs have turned."""

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from omnisim.fitting.fit_file import Fit
from omnisim.fitting.logs import FitError, Log
from omnisim.fitting.paths import Path, between, chassis_start, of_point
from omnisim.results.layout import COMPLETE
from omnisim.run.marching import Marching
from omnisim.scene.document import sentence
from omnisim.scene.problems import ConfigError
from omnisim.scene.validation import checked
from omnisim.studies.factors import with_values
from omnisim.studies.task import sample
from omnisim.studies.workers import on_cores

KNOT = 0.05  # s between the angles that a wheel follows, at least: finer ones are the encoder's steps, not the wheel's
ROW = 0.05  # s between rows, at most: cubics between them are off by micrometres
STEP = 1e-3  # s, of a scene that has none


class Interrupted(Exception):
    """Somebody wished to stop."""


class Outcome(NamedTuple):
    """Of one run: its number, its path, and its status; a run that stops early stays where it stopped."""

    run: int
    path: Path
    status: str


class Runs:
    """Runs of a fit by their number: each point (P,) of values with each log, points first.

    finer: how many times smaller the step is than usual.
    """

    def __init__(self, fit: Fit, points: np.ndarray, logs: list[int], finer: int = 1):
        self.fit = fit
        self.points = points
        self.logs = logs
        self.finer = finer
        self.bases = [driven(fit, fit.logs[i], finer) for i in logs]

    def __call__(self, runs: Sequence[int]) -> list[Outcome]:
        return [self.outcome(run) for run in runs]

    def outcome(self, run: int) -> Outcome:
        """Raises FitError for values that no scene has."""
        fit = self.fit
        values, i = self.points[run // len(self.logs)], run % len(self.logs)
        log = fit.logs[self.logs[i]]
        point = fit.point(values)
        x, y, yaw = chassis_start(log, point)
        initial = {"position": (x, y), "yaw_deg": math.degrees(yaw)}
        data = with_values(self.bases[i], fit.settings(values)) | {"initial": initial}
        try:
            marching = Marching(checked(data))
        except ConfigError as error:
            raise FitError(f"no such scene: {sentence(error.problems[0], data)}") from None
        marching.march()
        found = marching.observables()
        wanted = log.time[fit.compared(log)]
        return Outcome(run, path_of(found, wanted, point), marching.ending().sentence)

    def lost(self, run: int, how: str) -> Outcome:
        raise FitError(f"{self.fit.logs[self.logs[run % len(self.logs)]].file}: its process was {how}")


def path_of(found: Any, wanted: np.ndarray, point: Any) -> Path:
    """The tracked point at wanted times (m,), s, from the datasets of a run; after its last row it stands still."""
    time = found.times
    wanted = np.minimum(wanted, time[-1])
    if len(time) < 2:
        position, yaw = (np.repeat(found[name][:1], len(wanted), axis=0) for name in ("body/position", "body/yaw"))
    else:
        position = between(time, found["body/position"], found["body/velocity"], wanted)
        yaw = between(time, found["body/yaw"], found["body/yaw_rate"], wanted)
    return of_point(position[:, :2], yaw, point)


def prepared(fit: Fit) -> None:
    """Load or compile the kernels that the runs need, before several processes want them at once.

    Raises FitError for a machine free in space that does not rest where it is put.
    """
    data = driven(fit, fit.logs[fit.fitted[0]])
    config = checked(data)
    try:
        sample(config).everything()
    except ConfigError as error:
        raise FitError(f"no such scene: {sentence(error.problems[0], data)}") from None


def driven(fit: Fit, log: Log, finer: int = 1) -> dict[str, Any]:
    """The data of the scene with its wheels turned as a log says, from rest, on its times."""
    data = {key: value for key, value in fit.base.items() if key not in ("command", "output")}
    end = float(log.time[-1])
    rows = math.ceil(end / ROW)
    step = float(fit.base["time"].get("step", STEP)) / finer
    interval = end / rows
    time = {"end": end, "step": interval / math.ceil(interval / step * (1.0 - 1e-9)), "output_interval": interval}
    solver = {key: value for key, value in fit.base.get("solver", {}).items() if key != "error"}
    knots = knots_of(log.time)
    wheels = []
    for w, wheel in enumerate(fit.base["wheels"]):
        first = math.radians(wheel.get("spin_angle_deg", 0.0))
        table = {"times": tuple(log.time[knots].tolist()), "angle": tuple((first + log.angles[knots, w]).tolist())}
        at_rest = {key: value for key, value in wheel.items() if key not in ("spin_rate", "roller_rates")}
        wheels.append(at_rest | {"drive": {"kind": "follow", **table}})
    return data | {"time": time, "solver": solver, "wheels": tuple(wheels)}


def knots_of(time: np.ndarray) -> np.ndarray:
    """The rows whose angles a wheel follows: KNOT apart or more, the first and the last among them."""
    kept = [0]
    for row, t in enumerate(time):
        if t - time[kept[-1]] >= KNOT * (1.0 - 1e-9):
            kept.append(row)
    if kept[-1] != len(time) - 1:
        kept = [*kept[: -1 if len(kept) > 1 else None], len(time) - 1]
    return np.array(kept)


class SimulatedPaths:
    """Paths of a fit's logs by simulation, all runs of a call in parallel.

    stop: asked between runs. early: of each run so far that stopped before its log ended, which log, and how.
    """

    def __init__(self, fit: Fit, workers: int, stop: Callable[[], bool] = lambda: False, finer: int = 1):
        self.fit = fit
        self.workers = workers
        self.stop = stop
        self.finer = finer
        self.ran = 0
        self.early: list[str] = []

    def __call__(self, points: np.ndarray, logs: list[int]) -> list[list[Path]]:
        """For each point (P,) of values the path of each of these logs. Raises FitError for values that no scene has,
        Interrupted."""
        found = {outcome.run: outcome for outcome in self.outcomes(points, logs)}
        count = len(points) * len(logs)
        if len(found) < count:
            raise Interrupted
        self.ran += count
        for run, outcome in sorted(found.items()):
            if outcome.status != COMPLETE:
                self.early.append(f"{self.fit.logs[logs[run % len(logs)]].file}: {outcome.status}")
        return [[found[p * len(logs) + i].path for i in range(len(logs))] for p in range(len(points))]

    def outcomes(self, points: np.ndarray, logs: list[int]) -> Iterator[Outcome]:
        runs = Runs(self.fit, points, logs, self.finer)
        count = len(points) * len(logs)
        for batch in on_cores(runs, list(range(count)), min(self.workers, count), self.stop):
            yield from batch
