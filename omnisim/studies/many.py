"""Several scenes at once, each a whole Trajectory."""

from collections.abc import Iterable, Sequence
from os import PathLike

from omnisim.results.trajectory import Trajectory
from omnisim.run.simulation import simulate
from omnisim.scene.scene import Scene, as_scene
from omnisim.studies.workers import cores, on_cores


class Scenes:
    """The trajectories of these scenes by their number."""

    def __init__(self, scenes: list[Scene]):
        self.scenes = scenes

    def __call__(self, runs: Sequence[int]) -> list[tuple[int, Trajectory]]:
        return [(run, simulate(self.scenes[run])) for run in runs]

    def lost(self, run: int, how: str) -> tuple[int, Trajectory]:
        raise RuntimeError(f"{self.scenes[run].source}: its process was {how}")


def simulate_many(scenes: Iterable[Scene | str | PathLike[str]], workers: int | None = None) -> list[Trajectory]:
    """What `simulate` returns for each of these scenes, in their order; workers: processes, by default one a core.

        slow, fast = omnisim.simulate_many([omnisim.load("youbot", {"command.twist": ...}), "youbot"])

    Raises what `load` raises before anything runs, RuntimeError if a process is killed.
    """
    loaded = [as_scene("simulate_many", scene) for scene in scenes]
    if not loaded:
        return []
    hands = min(workers or cores(), len(loaded))
    found = dict(
        row for rows in on_cores(Scenes(loaded), list(range(len(loaded))), hands, lambda: False) for row in rows
    )
    return [found[run] for run in range(len(loaded))]
