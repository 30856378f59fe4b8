"""From a scene to a trajectory, without anybody's hand in between."""

import time
from collections.abc import Callable
from os import PathLike

from omnisim.base import status
from omnisim.base.arguments import callable_or_none
from omnisim.results.trajectory import Trajectory
from omnisim.run.scene_march import SceneMarch
from omnisim.run.step_search import search
from omnisim.scene.scene import Scene, as_scene

CHUNK_SECONDS = 0.05  # between two calls of `progress`
FIRST_CHUNK, MOST_CHUNK = 20_000, 20_000_000  # right-hand sides between two calls: of the order of 1 ms to 1 s


def simulate(scene: Scene | str | PathLike[str], progress: Callable[[float], object] | None = None) -> Trajectory:
    """Run a scene; with a `solver.error`, by the step that it needs.

        run = omnisim.simulate("youbot")
        run["body/position"]

    scene: a Scene, or what `load` takes.
    progress: called with the fraction done, about 20 times a second, first with 0 when the kernels are ready; if it
    returns something true, the run stops there. While a step is picked, every run begins with 0 again. A run that stops
    early, for whatever reason, returns what it has computed, and `attributes["status"]` says when, where and why.
    Raises SceneError if the rows do not fit into memory, and as `load` does.
    """
    scene = as_scene("simulate", scene)
    callable_or_none("simulate", "progress", progress, "the fraction done")
    if scene.config.solver.error is None:
        return march_through(scene, progress).trajectory()
    return search(scene, lambda candidate: march_through(candidate, progress))


def march_through(scene: Scene, progress: Callable[[float], object] | None) -> SceneMarch:
    """The march of a scene where it ends: at its own end, where something stops it, or where `progress` does."""
    march = SceneMarch(scene)
    clock = march.run.clock
    chunk = FIRST_CHUNK
    if progress is not None or not march.loaded:  # else the march itself begins: a call of it is not for nothing
        march.begin()
    running = clock["status"] == status.RUNNING
    interrupted = progress is not None and progress(0.0)
    while running and not interrupted:
        begun = time.perf_counter()
        running = march.march(chunk) == status.RUNNING
        elapsed = time.perf_counter() - begun
        interrupted = running and progress is not None and progress(clock.step / clock.steps)
        chunk = int(min(max(chunk * CHUNK_SECONDS / max(elapsed, 1e-9), FIRST_CHUNK), MOST_CHUNK))
    if interrupted:
        clock.status = status.INTERRUPTED
    return march
