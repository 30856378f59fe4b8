"""From the records of a march to a trajectory: observed rows, events in order, attributes."""

from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from omnisim.base import status
from omnisim.base.keeping import kept_by_first
from omnisim.base.records import plain
from omnisim.base.status import EVENT_KINDS
from omnisim.base.version import VERSION
from omnisim.dynamics.description import describe
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import Recording, Run
from omnisim.march.events import STOP
from omnisim.march.stiffness import method_used
from omnisim.results.observables import Observables
from omnisim.results.trajectory import Trajectory
from omnisim.scene.scene import Scene
from omnisim.scene.schema import Config

MODERATE = 1e50  # rad/s, m/s, and what else a state holds


def collect(
    scene: Scene, parameters: Parameters, run: Run, rows: Recording, log: np.ndarray, wall_time: float
) -> Trajectory:
    """The Trajectory of a march as far as it has come. Its datasets are computed when somebody asks for one of them:
    until then parameters and rows must stay as they are; the workspace may change."""
    config = scene.config
    clock = plain(run.clock)
    found = Observables(parameters, so_far(rows, clock.row), config.time.output_interval, config)
    kept = finite_count(found)
    end = ending(config, clock, kept)
    attributes = {
        "omnisim_version": VERSION,
        "title": config.title,
        "scene": scene.text,
        "wheels": tuple([wheel.name for wheel in config.wheels]),
        "model": model_line(config, parameters),
        "tracking": config.solver.tracking,
        "formulation": config.solver.formulation,
        "method": end.method,
        "step": config.time.step,
        "steps": clock.step,
        "rhs_evaluations": clock.rhs,
        "wall_time": wall_time,
        "status": end.sentence,
        "stop_time": end.time,
        "stop_wheel": end.wheel,
    }
    log = np.asarray(log)[: clock.events]
    return Trajectory(attributes, lambda: datasets(found, kept, end, log))


@kept_by_first
def model_line(config: Config, parameters: Parameters) -> str:
    """What the scene makes a model of, in a line."""
    return describe(config, parameters).line


class Ending(NamedTuple):
    """How a march has ended, or would have if it had been left here: its clock then, time (s), wheel, sentence."""

    clock: SimpleNamespace
    time: float
    wheel: str
    method: str
    sentence: str


def ending(config: Config, clock: SimpleNamespace, kept: int) -> Ending:
    """The Ending of a march of which so many rows are finite; clock: a copy of its record, which the Ending has."""
    if clock.status == status.RUNNING:
        clock.status = status.ENDED
    stop_time = clock.step * clock.dt + clock.elapsed
    if kept < clock.row:
        clock.status = status.NOT_FINITE
        clock.wheel = -1
        stop_time = kept * config.time.output_interval
    if clock.status == status.COMPLETE:
        stop_time = config.time.end
        clock.wheel = -1
    wheel = config.wheels[clock.wheel].name if clock.wheel >= 0 else ""
    method = method_used(config.solver.method, clock.choice)
    return Ending(clock, float(stop_time), wheel, method, status.sentence(clock, stop_time, wheel, method))


def outcome(config: Config, run: Run, found: Observables) -> Ending:
    """How a march has ended, as `collect` would tell it, from as little as that takes; found: its rows so far."""
    return ending(config, plain(run.clock), finite_count(found))


def datasets(found: Observables, kept: int, end: Ending, log: np.ndarray) -> dict[str, np.ndarray]:
    """All datasets of a march with this end, of which so many rows are finite."""
    sampled = found.everything()
    if kept < len(found.times):  # a state that overflows only when it is squared, say
        sampled = {path: values[:kept] for path, values in sampled.items()}
    happened = events(log, list(found.names))
    if end.clock.status != status.COMPLETE:
        happened = with_stop(happened, end.time, end.wheel)
    return sampled | happened


def finite_count(found: Observables) -> int:
    """Number of rows before the first that holds NaN or infinity in any dataset; all are computed only in doubt."""
    return len(found.rows.y) if moderate(found.rows) else finite_rows(found.everything())


def so_far(rows: Recording, written: int) -> Recording:
    """The rows that are written."""
    if written == len(rows.y):
        return rows
    parts: list[Any] = [values[:written] for values in rows]
    return Recording(*parts)


def finite_rows(sampled: dict[str, np.ndarray]) -> int:
    """The same from all datasets."""
    count = len(sampled["time"])
    broken = [~np.isfinite(values.reshape(count, -1)).all(axis=1) for values in sampled.values()] if count else []
    rows = np.flatnonzero(np.any(broken, axis=0)).tolist() if count else []
    return rows[0] if rows else count


def moderate(rows: Recording) -> bool:
    """Whether speeds are, all their squares together. If so nothing is infinite: every dataset is a product of few of
    them."""
    y, rates = rows.y, rows.rates
    return bool(np.vdot(y, y) < MODERATE**2 and np.vdot(rates, rates) < MODERATE**2)


def events(log: np.ndarray, names: list[str]) -> dict[str, np.ndarray]:
    """Datasets of the events in a log (E,), in order of time, then of wheels."""
    log = log[np.lexsort((log["wheel"], log["time"]))]
    return {
        "events/time": log["time"],
        "events/kind": np.array(EVENT_KINDS)[log["kind"]],
        "events/wheel": np.array(names)[log["wheel"]],
        "events/roller_from": log["roller_from"],
        "events/roller_to": log["roller_to"],
    }


def with_stop(data: dict[str, np.ndarray], stop_time: float, stop_wheel: str) -> dict[str, np.ndarray]:
    """The event datasets with the final "stop" appended."""
    last: dict[str, Any] = {
        "time": stop_time,
        "kind": EVENT_KINDS[STOP],
        "wheel": stop_wheel,
        "roller_from": -1,
        "roller_to": -1,
    }
    return data | {f"events/{name}": np.append(data[f"events/{name}"], value) for name, value in last.items()}
