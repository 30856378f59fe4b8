"""The mecanum machine of tests/reference/spatial_mecanum_bump, free in space: the scene, its bumps, errors of a motion.

Over the bumps it hops, which amplifies errors a thousandfold; the reference is good to RESOLVED.
"""

import json
import math
import statistics
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, interleaved, marching, median_ratio, table
from omnisim.scene.scene import Scene
from omnisim.scene.wheel_schema import WheelType

STEM = Path(__file__).parents[1] / "tests/reference/spatial_mecanum_bump"
RESOLVED = 1e-9  # m
BEST, FASTEST = "the best", "the fastest"
OURS = (("rk4", 3.2e-5), ("auto", 1e-3))  # methods and steps, s, beside the best of an engine
NEAR = 0.25  # m: no run that is farther off is called the fastest
CLOSER = 1000.0  # times: how much smaller the error of a run is that takes less time
ALARM = 0.3  # of its time, for the best of an engine
COLUMNS = ["position off by, mm", "turned off by, rad", "times real time"]
NOTES = """Errors at 1.6 s, of the position and of the orientation, against the reference, which has gone 1.05 m; the
machine hops, and small differences grow. The best is chosen with the exact answer at hand, which a user has not. Times
are of single runs, but those beside omnisim."""


@cache
def bumps(method: str = "rk4", step: float = 2e-5) -> Scene:
    return omnisim.load(STEM.with_suffix(".toml"), [f"solver.method={method}", f"time.step={step!r}"])


def wheel_type() -> WheelType:
    """The only one of the scene."""
    (kind,) = bumps().config.wheel_types.values()
    return kind


def end() -> float:
    return bumps().config.time.end


def heights(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Of the floor, m."""
    return sum(z * np.exp(-((x - u) ** 2 + (y - v) ** 2) / r**2) for u, v, z, r in bumps().config.floor.bumps)


def errors(position: np.ndarray, quaternion: np.ndarray) -> tuple[float, float]:
    """Of a pose at the end: distance from the reference, m, and angle between the orientations (w x y z), rad."""
    known = json.loads(STEM.with_suffix(".json").read_text())
    apart = np.asarray(known["quaternion"][-1])
    nearest = min(np.linalg.norm(quaternion - apart), np.linalg.norm(quaternion + apart))
    return math.dist(position, known["position"][-1]), 4.0 * math.asin(min(1.0, nearest / 2.0))


def outcome(scene: Scene) -> dict[str, float]:
    """Errors at the end, infinite if the run stops before."""
    found = omnisim.simulate(scene)
    if not found.complete:
        return {"position_error": math.inf, "turn_error": math.inf}
    far, turned = errors(found["body/position"][-1], found["body/orientation"][-1])
    return {"position_error": far, "turn_error": turned}


# --- engines beside omnisim -----------------------------------------------------------------------


def attempt(setup: NamedTuple, running: Callable) -> dict:
    """A run of an engine: its setup, errors at the end, and seconds."""
    run = running(setup)
    begun = time.perf_counter()
    run.go()
    seconds = time.perf_counter() - begun
    far, turned = run.outcome()
    return setup._asdict() | {"position_error": far, "turn_error": turned, "seconds": seconds}


def judged(runs: list[dict], prepare: Callable[[dict], Callable[[], object]], rounds: int, full: bool) -> dict:
    """The best of an engine and its fastest, and omnisim beside them, timed in turn; prepare: a row's run, to time."""
    best = min(runs, key=lambda row: row["position_error"])
    near = [row for row in runs if row["position_error"] < NEAR]
    fastest = min(near or runs, key=lambda row: row["seconds"])
    peers: dict[object, Callable] = {BEST: partial(prepare, best), FASTEST: partial(prepare, fastest)}
    ours = {setting: partial(marching, bumps(*setting)) for setting in (OURS if full else OURS[:1])}
    seconds = interleaved(peers | ours, rounds)
    rows = [
        {"method": setting[0], "step": setting[1], "seconds": statistics.median(seconds[setting])}
        | outcome(bumps(*setting))
        | {"ratios": {name: median_ratio(seconds[name], seconds[setting]) for name in peers}}
        for setting in ours
    ]
    return {"best": best, "fastest": fastest, "omnisim": rows}


def comparison(engine: str, result: dict) -> str:
    """The best and the fastest of an engine beside omnisim."""
    rows = [
        [row["method"], f"{row['step']:g}", *cells(row, 1), *(f"{row['ratios'][name]:.2f}" for name in (BEST, FASTEST))]
        for row in result["omnisim"]
    ]
    return table(
        ["omnisim", "step, s", *COLUMNS, *(f"{name} of {engine} takes, times" for name in (BEST, FASTEST))], rows
    )


def cells(row: dict, digits: int = 0) -> list[str]:
    """COLUMNS of a run; digits: of a power of ten, for small errors."""
    if row["position_error"] == math.inf:
        return ["fails", "-", "-"]
    off = (f"{row['position_error'] * 1e3:.{digits}e}", f"{row['turn_error']:.0e}")
    far = (f"{row['position_error'] * 1e3:.0f}", f"{row['turn_error']:.2f}")
    return [*(off if digits else far), f"{end() / row['seconds']:.2g}"]


def claims(engine: str, result: dict) -> list[Claim]:
    """That the best of an engine takes longer than a march whose error is CLOSER times smaller."""
    if not result:
        return []
    close = [row for row in result["omnisim"] if row["position_error"] * CLOSER <= result["best"]["position_error"]]
    fastest = max(close, key=lambda row: row["ratios"][BEST], default=None)
    text = f"{engine} over bumps at its best, by a march of omnisim with an error {CLOSER:g} times smaller"
    if fastest is None:
        return [Claim(text, 0.0, "at least", 1.0, ALARM)]
    closer = result["best"]["position_error"] / fastest["position_error"]
    reason = (
        f"By `{fastest['method']}` at {fastest['step']:g} s, as long a step as friction at this slip_speed lets it "
        f"take: with that its error is {closer:.0e} times smaller"
    )
    return [Claim(text, fastest["ratios"][BEST], "at least", 1.0, ALARM, reason)]
