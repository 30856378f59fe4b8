"""Runs of a study: from their numbers to how they ended and what was measured."""

import gc
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from omnisim.results.assembly import outcome
from omnisim.results.layout import COMPLETE
from omnisim.results.observables import Observables
from omnisim.results.trajectory import Trajectory
from omnisim.run.marching import Marching, blank_log, packed
from omnisim.run.simulation import simulate
from omnisim.scene.document import by_name, sentence
from omnisim.scene.problems import ConfigError, Problem
from omnisim.scene.scene import SceneError, changed
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import show_path
from omnisim.scene.validation import validate
from omnisim.studies.factors import Distribution, with_values
from omnisim.studies.measures import NoNumber, Reading, last_values, readings
from omnisim.studies.study import Study, StudyError

TOGETHER = 64  # runs that go through every stage side by side
IMPOSSIBLE = "impossible"  # begins the status of a run that has no scene


class Row(NamedTuple):
    """What is known of a run: its number, how it ended, at which time, s, and the wall time of its march, s.

    measures: a number for each Reading; None where there is none, as of runs that stop early. final: the same of the
    state at the stop, if it is kept.
    """

    run: int
    status: str
    stop_time: float
    wall_time: float
    measures: tuple[float | None, ...]
    final: tuple[float | None, ...]


class Ended(NamedTuple):
    """A run that has marched: its datasets, its scene, how and when it ended, s, the wall time of that, s, whether it
    has any row, and the numbers that have been read of it."""

    found: Observables | Trajectory
    config: Config
    status: str
    time: float
    wall_time: float
    some: bool
    numbers: list[float | None]


class Task:
    """Runs of a study by their number. Raises StudyError for measures that its scene does not have.

    folder: where trajectories are kept, None if they are not.
    """

    def __init__(self, study: Study, folder: Path | None = None):
        self.study = study
        self.folder = folder
        config = study.scene.config
        try:
            known = frozenset(sample(config).everything())
        except ConfigError as error:  # a machine free in space that cannot begin where it is put
            raise StudyError(study.scene.document.told(error.problems)) from None
        found = list(readings(study.config.measure, config, known))
        problems = [entry for entry in found if isinstance(entry, Problem)]
        if problems:
            raise StudyError(study.document.told(problems))
        self.readings = tuple(entry for entry in found if isinstance(entry, Reading))
        for other in other_kinds(study):
            with suppress(ConfigError):
                sample(other).everything()
        self.odometry = any(reading.follows("odometry/") for reading in self.readings)
        self.final = tuple(last_values(config)) if study.config.keep.trajectories == "final" else ()

    def __call__(self, runs: Sequence[int]) -> list[Row]:
        """What is known of these runs when they have run.

        Raises OSError where a trajectory cannot be kept; nothing else that fails in a run ends the study.
        """
        log = blank_log()  # one for all, whose events nobody reads
        with no_collection():
            return [row for i in range(0, len(runs), TOGETHER) for row in self.together(runs[i : i + TOGETHER], log)]

    def together(self, runs: Sequence[int], log: np.ndarray) -> list[Row]:
        """The same of a few, which go through every stage side by side: what Python does for one after the other takes
        half as long as between other stages, which empty the caches of the processor."""
        found: list[Any] = [log] * len(runs)
        stages: list[Callable[[int, Any], Any]] = [self.possible, self.begun, self.marched, self.ended]
        for stage in (*stages, *self.reads, self.row):
            found = [
                entry if isinstance(entry, Row) else self.guarded(stage, run, entry)
                for run, entry in zip(runs, found, strict=True)
            ]
        return found

    def guarded(self, stage: Callable[[int, Any], Any], run: int, entry: Any) -> Any:
        """What a stage makes of a run, or its Row if that fails."""
        try:
            return stage(run, entry)
        except OSError:
            raise
        except MemoryError:
            return self.nothing(run, "not enough memory")
        except Exception as error:
            return self.nothing(run, f"failed: a bug in omnisim: {type(error).__name__}: {error}".replace("\n", " "))

    def possible(self, run: int, log: np.ndarray) -> tuple[Config, np.ndarray] | Row:
        """The scene of a run, and the log of its events; its Row if it is impossible, or if it needs more than that."""
        try:
            config = self.study.checked(run)
            return self.whole(run) if self.folder or config.solver.error is not None else (config, log)
        except ConfigError as error:
            return self.impossible(run, error)
        except SceneError as error:
            return self.nothing(run, f"{IMPOSSIBLE}: {error}")

    def begun(self, run: int, possible: tuple[Config, np.ndarray]) -> Marching | Row:
        """A run that can march; its Row if a machine free in space cannot begin where it is put."""
        config, log = possible
        try:
            return Marching(config, log, packed(config, self.study.variants.complete), self.odometry)
        except ConfigError as error:
            return self.impossible(run, error)

    def impossible(self, run: int, error: ConfigError) -> Row:
        """The Row of a run without a scene."""
        data = self.study.data(run)
        told = "; ".join(sentence(problem, data) for problem in error.problems)
        return self.nothing(run, f"{IMPOSSIBLE}: {told}")

    def marched(self, run: int, marching: Marching) -> Marching:
        marching.march()
        return marching

    def ended(self, run: int, marching: Marching) -> Ended:
        found = marching.observables()
        end = outcome(marching.config, marching.run, found)
        some = len(found.rows.y) > 0
        return Ended(found, marching.config, end.sentence, end.time, marching.wall_time, some, [])

    @property
    def reads(self) -> Iterator[Callable[[int, Ended], Ended]]:
        """Stages that find a number each: the measures of a complete run, the last state of one with any row."""
        for reading in self.readings:
            yield partial(read, reading, lambda ended: ended.status == COMPLETE)
        for reading in self.final:
            yield partial(read, reading, lambda ended: ended.some)

    def row(self, run: int, ended: Ended) -> Row:
        numbers, split = tuple(ended.numbers), len(self.readings)
        return Row(run, ended.status, ended.time, ended.wall_time, numbers[:split], numbers[split:])

    def nothing(self, run: int, status: str) -> Row:
        """The Row of a run without numbers."""
        return Row(run, status, 0.0, 0.0, (None,) * len(self.readings), (None,) * len(self.final))

    def lost(self, run: int, how: str) -> Row:
        """The Row of a run that has killed its process."""
        return self.nothing(run, f"lost: its process was {how}")

    def whole(self, run: int) -> Row:
        """The same with a Trajectory, which may be kept."""
        scene = changed(self.study.scene, self.overrides(run))
        trajectory = simulate(scene)
        if self.folder:
            trajectory.save(self.folder / f"run_{run:06d}.h5", overwrite=True)
        a = trajectory.attributes
        some = len(trajectory.time) > 0
        ended = Ended(trajectory, scene.config, a["status"], a["stop_time"], a["wall_time"], some, [])
        for stage in self.reads:
            stage(run, ended)
        return self.row(run, ended)

    def overrides(self, run: int) -> dict[str, object]:
        """What `load` sets for this run: values by dotted keys."""
        data = self.study.scene.document.data
        return {show_path(by_name(path, data)): value for path, value in self.study.settings(run)}


@contextmanager
def no_collection() -> Iterator[None]:
    """Without Python's search for circles of objects, which would go through all modules again and again: runs leave
    none."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()


def read(reading: Reading, tells: Callable[[Ended], bool], run: int, ended: Ended) -> Ended:
    """A number more of a run that tells it."""
    ended.numbers.append(number(reading, ended.found, ended.config) if tells(ended) else None)
    return ended


def number(reading: Reading, found: Observables | Trajectory, config: Config) -> float | None:
    try:
        value = reading.of(found, config)
    except NoNumber:
        return None
    return value if math.isfinite(value) else None


def other_kinds(study: Study) -> Iterator[Config]:
    """Scenes of the kinds that words and tables in the study's lists make, whose kernels are compiled before all runs
    need them at once."""
    data = study.scene.document.data
    for factor in study.factors:
        for value in () if isinstance(factor.values, Distribution) else factor.values:
            if isinstance(value, str | dict):
                with suppress(ConfigError):
                    yield validate(with_values(data, [(target, value) for target in factor.targets]))


def sample(config: Config) -> Observables:
    """The datasets of the scene at its start."""
    marching = Marching(config.at_step(config.time.end) if config.time.step is None else config)
    marching.march(0)
    return marching.observables()
