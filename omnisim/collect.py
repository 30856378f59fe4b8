"""From the records of a march to a trajectory: observed rows, events in order, attributes."""

from functools import cache
from importlib.metadata import version

import numpy as np

from omnisim import status
from omnisim.events import STOP
from omnisim.model import describe
from omnisim.observables import datasets
from omnisim.parameters import Parameters
from omnisim.records import plain
from omnisim.scene import Scene
from omnisim.state import Rows, Run
from omnisim.status import EVENT_KINDS
from omnisim.stiffness import method_used
from omnisim.trajectory import Trajectory

MODERATE = 1e100  # J


def collect(
    scene: Scene, parameters: Parameters, run: Run, rows: Rows, log: np.ndarray, wall_time: float
) -> Trajectory:
    """The Trajectory of a march as far as it has come; the Run may go on."""
    config, clock, names = scene.config, plain(run.clock), [wheel.name for wheel in scene.config.wheels]
    if clock.status == status.RUNNING:
        clock.status = status.ENDED
    interval = config.time.output_interval
    sampled = datasets(parameters, Rows(*(values[: clock.row] for values in rows)), interval, config)
    stop_time, kept = clock.step * clock.dt + clock.elapsed, finite_rows(sampled)
    if kept < clock.row:  # a state that overflows only when it is squared, say
        clock.status, clock.wheel, stop_time = status.NOT_FINITE, -1, kept * interval
        sampled = {path: values[:kept] for path, values in sampled.items()}
    stopped = clock.status != status.COMPLETE
    if not stopped:
        stop_time = config.time.end
    stop_wheel = names[clock.wheel] if stopped and clock.wheel >= 0 else ""
    method = method_used(config.solver.method, clock.choice)
    attributes = {
        "omnisim_version": installed_version(),
        "title": config.title,
        "scene": scene.text,
        "wheels": names,
        "model": describe(config, parameters).line,
        "tracking": config.solver.tracking,
        "formulation": config.solver.formulation,
        "method": method,
        "step": config.time.step,
        "steps": clock.step,
        "rhs_evaluations": clock.rhs,
        "wall_time": wall_time,
        "status": status.sentence(clock, stop_time, stop_wheel, method),
        "stop_time": float(stop_time),
        "stop_wheel": stop_wheel,
    }
    happened = events(np.asarray(log)[: clock.events], names)
    if stopped:
        happened = with_stop(happened, stop_time, stop_wheel)
    return Trajectory(attributes, sampled | happened)


@cache
def installed_version() -> str:
    return version("omnisim-engine")


def finite_rows(sampled: dict[str, np.ndarray]) -> int:
    """Number of rows before the first that holds NaN or infinity in any dataset.

    Of moderate energy nothing is infinite: every dataset is a product of few speeds.
    """
    count = len(sampled["time"])
    if np.all(np.abs(sampled["energy/balance"]) + sampled["energy/kinetic"] < MODERATE):
        return count
    broken = [~np.isfinite(values.reshape(count, -1)).all(axis=1) for values in sampled.values()] if count else []
    rows = np.flatnonzero(np.any(broken, axis=0)) if count else []
    return int(rows[0]) if len(rows) else count


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
    last = {"time": stop_time, "kind": EVENT_KINDS[STOP], "wheel": stop_wheel, "roller_from": -1, "roller_to": -1}
    return data | {f"events/{name}": np.append(data[f"events/{name}"], value) for name, value in last.items()}
