"""A machine fitted to its logs: the search, what ideal kinematics makes of the same, and what comes of both."""

from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

import numpy as np

from omnisim.base.arguments import callable_or_none
from omnisim.fitting.fit_file import Fit, load_fit
from omnisim.fitting.ideal import IdealPaths
from omnisim.fitting.least_squares import Search, Solution, Trial
from omnisim.fitting.paths import Path, by_starts
from omnisim.fitting.result import FitResult, LogResult
from omnisim.fitting.simulation import Interrupted, SimulatedPaths, prepared
from omnisim.fitting.uncertainty import Remains, Uncertainty, uncertainty, unknown
from omnisim.studies.workers import cores

FINER = 2  # times smaller is the step by which the error of the usual one is told


def fit(
    source: str | PathLike[str] | Mapping[str, Any] | Fit,
    *,
    workers: int | None = None,
    progress: Callable[[Trial], object] | None = None,
    stop: Callable[[], object] | None = None,
) -> FitResult:
    """Estimate keys of a scene, and the tracked point, from logs of a machine.

        found = omnisim.fit("fit.toml")
        found.estimates["friction.coefficient"].low
        found.save("robot_fit")                     fitted.toml and fit.json

    source: a file, or a dict that says the same. workers: processes, by default one for each core. progress: called
    with a Trial after each point of the search. stop: asked ten times a second while runs are under way. If either
    returns something true, the search ends with the best so far.

    Raises FitError or SceneError for what is wrong with the fit, its scene or its logs.
    """
    callable_or_none("fit", "progress", progress, "a Trial")
    callable_or_none("fit", "stop", stop, "nothing")
    made = source if isinstance(source, Fit) else load_fit(source)
    wish = [False]

    def told(trial: Trial) -> None:
        wish[0] = wish[0] or bool(progress and progress(trial))

    def asked() -> bool:
        if wish[0] or (stop and stop()):
            raise Interrupted  # the runs under way are of no use
        return False

    prepared(made)
    everything = list(range(len(made.logs)))
    hands = workers or cores()
    simulated = SimulatedPaths(made, hands, asked)
    before = SimulatedPaths(made, hands, asked)(made.start[None], everything)[0]
    ideal = ideal_paths(made)
    search = Search(made, simulated, range(len(made.parameters)), told)
    far = np.array(
        [(ideal[0] or {}).get(one.key, one.start) for one in made.parameters]
    )  # on the way, unless wheels slip
    found = search.solve(far if search.nearer(far, before) else made.start)
    after, finer = (SimulatedPaths(made, hands, finer=times) for times in (1, FINER))
    paths = after(found.values[None], everything)[0]
    step_error = None
    if not found.interrupted:
        others = finer(found.values[None], everything)[0]
        step_error = max(
            float(np.hypot(*(a.position - b.position).T).max()) for a, b in zip(paths, others, strict=True)
        )
    values, nominal, fitted = ideal
    logs = tuple(
        LogResult(log, made.compared(log), before[i], paths[i], nominal[i], fitted[i])
        for i, log in enumerate(made.logs)
    )
    known = what_is_known(made, found, search.weights)
    return FitResult(made, found, known, logs, values, step_error, simulated.ran, tuple(after.early))


def what_is_known(made: Fit, found: Solution, weights: np.ndarray) -> Uncertainty:
    """What the fitted logs tell of the estimates."""
    if found.jacobian is None:
        return unknown(len(made.parameters))
    sizes = [len(path.yaw) - 1 for path in found.paths]
    residuals = np.split(found.residuals.reshape(-1, 3), np.cumsum(sizes)[:-1])
    return uncertainty(
        made.parameters, found.values, Remains(found.jacobian, by_starts(found.paths, weights), residuals)
    )


Ideal = tuple[dict[str, float] | None, list[Path | None], list[Path | None]]


def ideal_paths(made: Fit) -> Ideal:
    """What ideal kinematics makes of the same logs: values of those parameters that it knows, fitted by the same rule;
    paths at the start of the search, and with these values. None where wheels leave a motion open."""
    paths = IdealPaths(made)
    everything = list(range(len(made.logs)))
    try:
        nominal = paths(made.start[None], everything)[0]
    except ValueError:
        nothing: list[Path | None] = [None] * len(everything)
        return None, nothing, nothing
    used = [i for i in range(len(made.parameters)) if matters(made, paths, i)]
    if not used:
        return {}, [*nominal], [*nominal]
    found = Search(made, paths, used, lambda trial: None).solve(made.start)
    values = {made.parameters[i].key: float(found.values[i]) for i in used}
    return values, [*nominal], [*paths(found.values[None], everything)[0]]


def matters(made: Fit, paths: IdealPaths, i: int) -> bool:
    """Whether a parameter changes a path of ideal kinematics."""
    ends = np.repeat(made.start[None], 2, axis=0)
    ends[:, i] = made.low[i], made.high[i]
    one, other = (path[0] for path in paths(ends, made.fitted[:1]))
    return not (np.array_equal(one.position, other.position) and np.array_equal(one.yaw, other.yaw))
