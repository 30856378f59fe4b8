"""From a scene to a trajectory: pack, begin, march in chunks, observe."""

import time
from collections.abc import Callable
from functools import cache
from importlib.metadata import version

import numpy as np

from omnisim import status
from omnisim.events import EVENT, STOP
from omnisim.model import describe
from omnisim.observables import datasets
from omnisim.parameters import Parameters, pack
from omnisim.scene import Scene, SceneError
from omnisim.start import begin, blank_rows
from omnisim.state import Rows, Run
from omnisim.status import EVENTS_PER_STEP
from omnisim.stepper import march
from omnisim.stiffness import method_used
from omnisim.tableau import METHODS
from omnisim.trajectory import EVENT_KINDS, Trajectory

MODERATE = 1e100  # J
CHUNK_SECONDS = 0.05  # between two calls of `progress`
FIRST_CHUNK, MOST_CHUNK = 20_000, 20_000_000  # right-hand sides between two calls: of the order of 1 ms to 1 s


def simulate(scene: Scene, progress: Callable[[float], object] | None = None) -> Trajectory:
    """Run a scene.

    progress: called with the fraction done, about 20 times a second, first with 0 when the kernels are ready; if it
    returns something true, the run stops there. A run that stops early, for whatever reason, returns what it has
    computed, and `attributes["status"]` says when, where and why. Raises SceneError if the rows do not fit into
    memory.
    """
    grid, stages = scene.config.time, METHODS[scene.config.solver.method].stages
    parameters = pack(scene.config)
    run = begin(scene.config, parameters)
    try:
        rows = blank_rows(run, grid.outputs + 1)
    except MemoryError as error:
        raise SceneError(f"{scene.source}: time.output_interval: too many rows for the memory: {error}") from None
    log = np.zeros(4 * EVENTS_PER_STEP, EVENT)
    wall_time, chunk = 0.0, 0
    while run.clock.status == status.RUNNING:
        run.clock.pause, begun = run.clock.rhs + chunk, time.perf_counter()
        room = march(parameters, stages, run, rows, log.view(np.recarray))
        elapsed = time.perf_counter() - begun
        if room == status.LOG_FULL:
            log = np.concatenate([log, np.zeros_like(log)])
        if run.clock.status == status.RUNNING and progress and progress(run.clock.step / grid.steps):
            run.clock.status = status.INTERRUPTED
        wall_time += elapsed if chunk else 0.0  # the first call marches nowhere: it loads or compiles the kernels
        chunk = chunk * CHUNK_SECONDS / max(elapsed, 1e-9) if chunk else FIRST_CHUNK
        chunk = int(min(max(chunk, FIRST_CHUNK), MOST_CHUNK))
    return collect(scene, parameters, run, rows, log, wall_time)


def collect(
    scene: Scene, parameters: Parameters, run: Run, rows: Rows, log: np.ndarray, wall_time: float
) -> Trajectory:
    """The Trajectory of a march that has ended."""
    config, clock, names = scene.config, run.clock, [wheel.name for wheel in scene.config.wheels]
    interval = config.time.output_interval
    sampled = datasets(parameters, Rows(*(values[: clock.row] for values in rows)), interval, config)
    stop_time, kept = clock.step * clock.dt + clock.elapsed, finite_rows(sampled)
    if kept < clock.row:  # a state that overflows only when it is squared, say
        clock.status, clock.wheel, stop_time = status.NOT_FINITE, -1, kept * interval
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
        "method": method,
        "step": config.time.step,
        "steps": int(clock.step),
        "rhs_evaluations": int(clock.rhs),
        "wall_time": wall_time,
        "status": status.sentence(clock, stop_time, stop_wheel, method),
        "stop_time": float(stop_time),
        "stop_wheel": stop_wheel,
    }
    happened = events(log[: clock.events], names)
    if stopped:
        happened = with_stop(happened, stop_time, stop_wheel)
    return Trajectory(attributes, {path: values[:kept] for path, values in sampled.items()} | happened)


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
