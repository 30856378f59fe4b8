"""A step picked for the error that a scene allows: ever shorter ones, until the differences of the runs are small."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import count, pairwise

from omnisim.base.methods import METHODS
from omnisim.base.status import CURABLE, INTERRUPTED, RUNNING
from omnisim.results.comparison import distance
from omnisim.results.trajectory import Trajectory
from omnisim.run.scene_march import SceneMarch
from omnisim.scene.scene import Scene

FEWEST_STEPS = 100
MOST_STEPS = 10**8  # of the first run and of any run
ROUNDING = 1e-12  # m, rad: differences below it tell nothing
SLOWEST = 0.9  # differences that hardly fall, or grow, count as if they fell by so much
UNSEEN = {2: SLOWEST, 3: 0.75}  # by how many differences there are: ratio of those to come, at least
LEAST = 10.0 * ROUNDING  # m, rad: an estimate that no shorter step makes smaller
# Methods whose own differences do not tell how far they are off, and the one that does with the same step: "auto" takes
# other steps implicit with another step of time, and none with the shortest; where rollers rattle on an edge, errors of
# "heun" are ten thousand times those of order 4 and do not fall with the step.
CHECKED_BY = {"auto": "radau5", "heun": "rk4"}


def search(scene: Scene, run: Callable[[Scene], SceneMarch]) -> Trajectory:
    """The first of the runs with ever shorter steps of which the estimated error is at most `solver.error`.

    `run` marches a scene to where it ends. Runs that stop early for reasons that a shorter step may cure tell nothing;
    those that stop for others are compared as far as they have come. Where shorter steps help no more, or would be more
    than MOST_STEPS, the last run that tells something is returned; so it is when the user interrupts, and its status
    says so. `error_target` and, if there is one, `error_estimate` are added to its attributes.
    """
    solver = scene.config.solver
    order = METHODS[solver.method].tableau.order
    enough = max(solver.error or 0.0, LEAST)
    gaps: list[float] = []
    best: Trajectory | None = None
    code = RUNNING
    error = math.inf
    for candidate in candidates(scene):
        march = run(candidate)
        before = code
        code = int(march.run.clock.status)
        if code == INTERRUPTED:
            break
        if code in CURABLE:
            continue
        latest = march.trajectory()
        if not len(latest.time):  # it cannot begin, by any step
            best = latest
            break
        gaps = [*gaps, distance(best, latest)] if best is not None and code == before else []
        best = latest
        error = estimate(gaps, order)
        if error <= enough and solver.method in CHECKED_BY:
            other = run(by_method(candidate, CHECKED_BY[solver.method]))
            checked = int(other.run.clock.status)
            error = max(error, distance(latest, other.trajectory())) if checked == code else math.inf
            if checked == INTERRUPTED:
                code = checked
        if error <= enough or code == INTERRUPTED:
            break
    found = march.trajectory() if best is None else best
    if best is None and code in CURABLE:
        found.attributes["status"] += (
            "; solver.error tries no shorter step: choose another method, or give time.step alone"
        )
    if code == INTERRUPTED and found.complete:
        found.attributes["status"] = f"interrupted by the user before errors below {solver.error:g} were reached"
    found.attributes["error_target"] = solver.error
    if math.isfinite(error):
        found.attributes["error_estimate"] = error
    return found


def candidates(scene: Scene) -> Iterator[Scene]:
    """The scene with ever shorter steps: the output interval and 1/2, 1/5, 1/10, 1/20, ... of it."""
    time = scene.config.time
    for parts in (digit * 10**power for power in count() for digit in (1, 2, 5)):
        steps = time.outputs * parts
        if steps > max(MOST_STEPS, time.outputs):
            return
        if steps >= FEWEST_STEPS and scene.config.suits(time.output_interval / parts):
            yield replace(scene, config=scene.config.at_step(time.output_interval / parts))


def estimate(gaps: Sequence[float], order: int) -> float:
    """Error of the last of three runs or more, from the differences between neighbours; infinite of fewer runs.

    Each step is at most half of the one before, so the last difference is about the error of the run before the last.
    It is taken for that of the last run too, since the errors of events do not fall regularly. Three safeguards: a
    difference that fell by more than 2^-order did so by luck, and counts as if it fell so; where the worse of the last
    two ratios r of differences exceeds 1 / 2, those still to come add up to r / (1 - r) times the last, which is more
    than it (the geometric series of Aitken's extrapolation); and of few runs, whose steps are long, the ratios not seen
    count as UNSEEN: where they did not, one run in a hundred with three differences, under set-valued friction, erred
    by more than its estimate, by 2.5 times at most.
    """
    if len(gaps) < 2:
        return math.inf
    *_, before, last = seen = [max(gap, ROUNDING) for gap in gaps[-3:]]
    ratio = min(max(UNSEEN.get(len(gaps), 0.0), *(b / a for a, b in pairwise(seen))), SLOWEST)
    return max(last, before * 2.0**-order) * max(1.0, ratio / (1.0 - ratio))


def by_method(scene: Scene, method: str) -> Scene:
    """The scene by another method."""
    solver = scene.config.solver.model_copy(update={"method": method})
    return replace(scene, config=scene.config.model_copy(update={"solver": solver}))
