"""Short runs: what `omnisim.simulate` takes beside the march, for 21 rows of a bare wheel and of the youBot.

The same scene again, a scene that is loaded again from the same file, and one with another mass, by turns. Loading is
not timed, and datasets are computed when somebody asks for them. Beside the march is all but the call of the compiled
code that goes to the end: finding the rollers in contact at the start counts, too.
"""

import statistics
import tempfile
import time
from collections.abc import Callable
from itertools import count
from pathlib import Path

import omnisim
from bench.common import Claim, bare_wheel, table
from omnisim.scene.scene import Scene

ROWS = {"time.end": 1.0, "time.output_interval": 0.05}  # 21
SCENES = {"bare wheel": bare_wheel(1e-3), "youBot": omnisim.load("youbot")}
MASSES = {"bare wheel": "wheel_types.omni.disk.mass", "youBot": "chassis.mass"}
AGAIN, LOADED, OTHER = "the same scene", "loaded again", "another mass"


def measure(rounds: int) -> dict:
    """Seconds beside the march and of the march: quartiles of rounds in which they take turns."""
    with tempfile.TemporaryDirectory() as folder:
        return {name: measured(kinds(name, Path(folder)), rounds) for name in SCENES}


def kinds(name: str, folder: Path) -> dict[str, Callable[[], Scene]]:
    """What gives the next scene to run."""
    path = folder / f"{name}.toml"
    path.write_text(omnisim.load_text(SCENES[name].text, ROWS).text)
    same, numbers = omnisim.load(path), count(1)
    return {
        AGAIN: lambda: same,
        LOADED: lambda: omnisim.load(path),
        OTHER: lambda: omnisim.load(path, {MASSES[name]: 1.0 + 1e-4 * next(numbers)}),
    }


def measured(scenes: dict[str, Callable[[], Scene]], rounds: int) -> dict[str, list[float]]:
    """The quartiles of each kind, s."""
    found: dict[str, list[float]] = {kind: [] for kind in (*scenes, "march")}
    for _ in range(rounds):
        for kind, following in scenes.items():
            omnisim.simulate(following())  # each after another of its kind
            scene = following()
            begun = time.perf_counter()
            run = omnisim.simulate(scene)
            whole = time.perf_counter() - begun
            found[kind].append(whole - run.attributes["wall_time"])
            found["march"].append(run.attributes["wall_time"])
    return {kind: statistics.quantiles(values, n=4, method="inclusive") for kind, values in found.items()}


def report(result: dict) -> str:
    rows = [[name, *(f"{1e3 * value:.2f}" for value in medians(found).values())] for name, found in result.items()]
    return table(["beside the march, ms", AGAIN, LOADED, OTHER, "the march, ms"], rows)


def claims(result: dict) -> list[Claim]:
    return [
        Claim(f"ms that `simulate` takes beside the march of 21 rows, {name}, {kind}", 1e3 * value, "at most", 0.2, 1.0)
        for name, found in result.items()
        for kind, value in medians(found).items()
        if kind in (AGAIN, LOADED)
    ]


def medians(found: dict[str, list[float]]) -> dict[str, float]:
    return {kind: quartiles[1] for kind, quartiles in found.items()}
