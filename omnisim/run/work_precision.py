"""Speed against error: a scene by several methods, trackings and steps, against a reference computed on the spot."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from statistics import median
from typing import Any, NamedTuple

from omnisim.results.comparison import distance
from omnisim.results.trajectory import Trajectory
from omnisim.run.simulation import simulate
from omnisim.run.timing import interleaved
from omnisim.scene.scene import Scene, SceneError, parse

FACTORS = (10.0, 5.0, 2.0, 1.0, 0.5)  # of the scene's step: the ladder
APART = 1.5  # ratio of steps whose errors tell an order, at least
FINER = 5  # how often a step of the reference goes into the finest of the ladder
CLEAR = 10.0  # errors tell an order if they are so many times what the reference can be trusted to,
ROUNDING = 1e-11  # and not so small that rounding and the location of events decide


class Interrupted(Exception):
    """Raised by `progress` to stop measuring."""


class Unconverged(Exception):
    """Nothing to measure errors by: why the reference stopped early."""


class Setting(NamedTuple):
    """What the contestants differ in; the step in s."""

    method: str
    tracking: str
    step: float


class Reference(NamedTuple):
    """The converged run, who computed it and who confirmed it, and their distance: as far as it can be trusted."""

    run: Trajectory
    by: Setting
    confirmed_by: Setting
    distance: float


Measured = Any  # a float; None of a run that stopped early


class Row(NamedTuple):
    """What a setting costs and reaches.

    error   largest over all rows of output of position (m), yaw and spin angles (rad); None: it stopped early
    order   observed between the next longer step and this one; None where the errors do not tell it
    march   s of wall time per simulated second, marching alone; None: it stopped early
    whole   s of wall time of the whole call
    front   on the Pareto front: nobody else is as fast and as accurate; of timed rows
    """

    method: str
    tracking: str
    step: float
    error: Measured
    order: Measured
    march: Measured
    whole: Measured
    steps: int
    evaluations: int
    events: int
    front: bool
    status: str


class Precision(NamedTuple):
    """A scene under one friction law; times are medians of so many repeats, and None with none."""

    scene: Scene
    reference: Reference
    repeats: int
    rows: list[Row]


def ladder(scene: Scene, steps: Sequence[float] = ()) -> list[float]:
    """The steps to run, longest first: those given, or else multiples of the scene's own that suit its output."""
    interval, own = scene.config.time.output_interval, scene.config.time.step
    if own is None and not steps:
        raise SceneError(f"{scene.source}: time.step: missing; the steps to run are multiples of it, or must be given")
    for step in steps:
        if not scene.config.suits(step):
            samples = "".join(f", and the sample time {time!r} s" for time in sorted(set(scene.config.sample_times)))
            raise SceneError(
                f"{scene.source}: a step of {step!r} s must divide the output interval, {interval!r} s{samples}"
            )
    multiples = (factor * (own or 0.0) for factor in FACTORS)
    return sorted(set(steps) or {step for step in multiples if scene.config.suits(step)}, reverse=True)


def varied(scene: Scene, setting: Setting) -> Scene:
    """The scene with this setting and the rows that it has anyway."""
    method, tracking, step = setting
    interval = scene.config.time.output_interval
    solver = [f"solver.method={method}", f"solver.tracking={tracking}"]
    scene = parse(scene.text, scene.source, [*solver, f"time.step={step!r}", f"time.output_interval={interval!r}"])
    return replace(scene, config=scene.config.at_step(step))


def measure(
    scene: Scene, settings: Sequence[Setting], repeats: int, progress: Callable[[float], object] = lambda _: None
) -> Precision:
    """Run the scene with every setting: once for the error, which compiles as well, then `repeats` times in turn.

    progress: called with the fraction done, first when the kernels are ready. If it raises Interrupted, the rounds
    that are complete count; before the first there is nothing to return, and Interrupted is raised here. Raises
    Unconverged if the scene has no reference.
    """
    share = 1.0 / (1 + repeats)
    contestants = [varied(scene, setting) for setting in settings]  # once: what follows from them stays known
    untimed = compared(scene, settings, contestants, lambda part: progress(share * part))
    rows = list(untimed.rows)
    running = [place for place, row in enumerate(rows) if row.error is not None]
    timed = [contestants[place] for place in running]
    rounds: list[Any] = []
    try:
        for taken in interleaved(timed, repeats, lambda part: progress(share + (1.0 - share) * part)):
            rounds.append(taken)
    except Interrupted:
        if not rounds:
            raise
    for place, times in zip(running, zip(*rounds, strict=True), strict=True):
        march, whole = (median(seconds) for seconds in zip(*times, strict=True))
        rows[place] = rows[place]._replace(march=march / scene.config.time.end, whole=whole)
    return untimed._replace(repeats=len(rounds), rows=judged(rows, untimed.reference.distance))


def exact(scene: Scene, settings: Sequence[Setting], progress: Callable[[float], object] = lambda _: None) -> Precision:
    """What is the same on every machine: errors, observed orders and work of every setting. Raises Unconverged."""
    return compared(scene, settings, [varied(scene, setting) for setting in settings], progress)


def compared(
    scene: Scene, settings: Sequence[Setting], contestants: list[Scene], progress: Callable[[float], object]
) -> Precision:
    """The same of scenes with these settings."""
    reference = converged(scene, min(setting.step for setting in settings) / FINER, lambda _: progress(0.0))
    rows = []
    for done, (setting, contestant) in enumerate(zip(settings, contestants, strict=True)):
        run = simulate(contestant, partial(_tell, progress, done / len(settings)))
        rows.append(row_of(setting, run, reference.run))
    return Precision(scene, reference, 0, judged(rows, reference.distance))


def _tell(progress: Callable[[float], object], fraction: float, _: float) -> object:
    return progress(fraction)


def converged(scene: Scene, step: float, progress: Callable[[float], object]) -> Reference:
    """Two explicit methods with one step; where they stop, the implicit one with this step and with half of it."""
    explicit = Setting("bs5", "explicit", step), Setting("dopri5", "explicit", step)
    implicit = Setting("radau5", "explicit", step / 2), Setting("radau5", "explicit", step)
    for pair in (explicit, implicit):
        runs = []
        for setting in pair:
            runs.append(simulate(varied(scene, setting), progress))
            if not runs[-1].complete:
                break
        else:
            return Reference(runs[0], *pair, distance(*runs))
    raise Unconverged(runs[-1].attributes["status"])


def row_of(setting: Setting, run: Trajectory, reference: Trajectory) -> Row:
    """What one run says; untimed."""
    error = distance(run, reference) if run.complete else None
    said = run.attributes
    events = len(run["events/time"]) - (not run.complete)  # the last event of a run that stops is the stop
    work = said["steps"], said["rhs_evaluations"], events
    return Row(*setting, error, None, None, None, *work, False, said["status"])


def judged(rows: list[Row], trusted: float) -> list[Row]:
    """The rows with their orders, and the front of those that are timed; errors below `trusted` are all alike."""
    finished = [row for row in rows if row.error is not None]
    timed = [row for row in finished if row.march is not None]
    front = pareto([(max(row.error, trusted), row.march) for row in timed])
    best = {row[:3] for row, first in zip(timed, front, strict=True) if first}
    return [row._replace(front=row[:3] in best, order=order(row, finished, trusted)) for row in rows]


def pareto(points: Sequence[tuple[float, ...]]) -> list[bool]:
    """Whether each point is one that no other point beats: nowhere larger, and somewhere smaller."""

    def beats(other: tuple[float, ...], point: tuple[float, ...]) -> bool:
        return other != point and all(a <= b for a, b in zip(other, point, strict=True))

    return [not any(beats(other, point) for other in points) for point in points]


def order(row: Row, rows: Iterable[Row], trusted: float) -> float | None:
    """log(error / longer error) / log(step / longer step), with the next step of the same method that is longer by half
    or more: errors of closer ones differ by chance as well."""
    longer = [other for other in rows if other[:2] == row[:2] and other.step >= APART * row.step]
    if row.error is None or not longer or row.error <= max(CLEAR * trusted, ROUNDING):
        return None
    other = min(longer, key=lambda candidate: candidate.step)
    return math.log(row.error / other.error) / math.log(row.step / other.step) if other.error else None


def fastest(measured: Precision, below: float) -> Row | None:
    """The row that marches fastest of those with a smaller error, as far as the reference can tell."""
    trusted = measured.reference.distance
    rows = [row for row in measured.rows if row.error is not None and max(row.error, trusted) < below]
    return min(rows, key=lambda row: row.march, default=None)


def finest_orders(measured: Precision) -> dict[tuple[str, str], float]:
    """By method and tracking: the order between the two shortest steps that tell one."""
    told = sorted((row for row in measured.rows if row.order is not None), key=lambda row: -row.step)
    return {(row.method, row.tracking): row.order for row in told}
