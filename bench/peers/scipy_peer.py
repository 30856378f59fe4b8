"""The march against SciPy's solvers on the same equations, at equal error.

Three scenes: a bare wheel with a soft law of friction; one under set-valued friction; a mecanum platform under
set-valued friction and rate drives. SciPy knows no set-valued law: it integrates the regularized one, stiff, with the
slip speed that takes most of the error. For every error each solver climbs a ladder of tolerances until it reaches it,
and so does the march with its steps. Compared are position, yaw and spin angles at the end with a converged march.

SciPy gets the help that is fair, and more: the right-hand side of the march itself, compiled, its Jacobian in one call,
the states of the motion without the energy integrals. LSODA runs through `odeint` as well, which has less to do in
Python, but for bare wheels only: where four wheels leave their rollers in turn it knows no event to stop at.
"""

import math
import statistics
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, March, bare_wheel, interleaved, median_ratio, ready, table
from bench.machine_scenes import platform
from bench.peers.driver import Stalled, integrate
from bench.peers.equations import motion
from omnisim.scene.scene import Scene, parse

HAND, COMPILED = ("NumPy", "scalars"), ("compiled",)
EQUATIONS = {"NumPy": "equations in NumPy", "compiled": "omnisim's compiled equations"}
METHODS = ("rk4", "dopri5")  # the first is the default
STEPS = (1e-2, 5e-3, 2.5e-3, 2e-3, 1.25e-3, 1e-3, 6.25e-4, 5e-4, 4e-4, 2.5e-4, 2e-4, 1e-4, 5e-5)  # s
SHARE = 0.8  # of the error is the slip speed's, the rest the tolerance's
LOOSEST, TIGHTEST = 10.0, 1e-4  # tolerance by error
PATIENCE = 30.0  # s: for one run of a solver
MOTION = "diagonal with yaw"  # the slowest of the platform for the march
MACHINE_END = 1.0  # s: with these SciPy takes seconds
FULL_ROUNDS = 3  # fewer rounds are for the short ladder
TIMED = 3  # rounds at most: the slowest take seconds


class Peer(NamedTuple):
    """One of driver.SOLVERS on one of driver.FORMS."""

    solver: str
    form: str


class Case(NamedTuple):
    """A scene by method and step (s), and what SciPy gets of it.

    slip_error: error by slip speed of the regularized law, s (of angles rad s/m); 0: the scene itself is regularized.
    """

    scene: Callable[[str, float], Scene]
    wheels: int
    fine: tuple[str, float]  # method and step of the converged march
    slip_error: float
    errors: tuple[float, ...]
    steps: tuple[float, ...]
    peers: tuple[Peer, ...]
    targets: dict[str, tuple[float, float]]  # by form: times faster than SciPy's best, and a third of what was measured


class Trial(NamedTuple):
    """A run of SciPy that reaches `goal`, its error, and milliseconds of that one run."""

    peer: Peer
    goal: float
    tolerance: float
    slip_speed: float
    error: float
    ms: float


def packaged_wheel(method: str, step: float) -> Scene:
    return omnisim.load("coulomb_wheel", (f"solver.method={method}", f"time.step={step!r}"))


def peers_of(solvers: tuple[str, ...], forms: tuple[str, ...]) -> tuple[Peer, ...]:
    return tuple(Peer(solver, form) for solver in solvers for form in forms)


LSODA = ("LSODA, solve_ivp", "LSODA, odeint")
STIFF = ("Radau, solve_ivp", "BDF, solve_ivp")
BY_HAND = peers_of(LSODA, HAND)
CASES = {
    "bare wheel, slip_speed 0.05 m/s": Case(
        lambda method, step: bare_wheel(step, method=method),
        1,
        ("dopri5", 1e-4),
        0.0,
        (1e-5, 1e-6, 1e-7, 1e-8),
        STEPS[3:],
        BY_HAND + peers_of((*LSODA, *STIFF, "DOP853, solve_ivp"), COMPILED),
        {"NumPy": (100.0, 30.0)},
    ),
    "coulomb_wheel": Case(
        packaged_wheel,
        1,
        ("dopri5", 2e-4),
        0.061,
        (1e-5, 1e-6, 1e-7),
        STEPS,
        BY_HAND + peers_of(LSODA + STIFF, COMPILED),
        {"NumPy": (500.0, 250.0), "compiled": (500.0, 25.0)},
    ),
    f"platform, {MOTION}, 1 s": Case(
        lambda method, step: platform(MOTION, "rate", method, step, MACHINE_END),
        4,
        ("rk4", 2e-5),
        0.14,
        (1e-5, 1e-6),
        STEPS,
        peers_of((LSODA[0],), HAND[:1]) + peers_of((LSODA[0], *STIFF), COMPILED),
        {"NumPy": (200.0, 200.0), "compiled": (200.0, 70.0)},
    ),
}


def smooth(scene: Scene, slip_speed: float) -> Scene:
    """The scene under the regularized law with this slip speed (m/s); itself for 0."""
    law = ("friction.law=regularized", f"friction.slip_speed={slip_speed!r}")
    return parse(scene.text, scene.source, law) if slip_speed else scene


def final(scene: Scene) -> np.ndarray:
    """y of equations.py at the end of a march."""
    march = ready(scene).go()
    return march.run.y[motion(march)]


def error_of(found: np.ndarray, reference: np.ndarray, wheels: int) -> float:
    """Largest error of position, yaw and spin angles, which y begins with."""
    return float(np.abs(found - reference)[: 3 + wheels].max())


def measure(rounds: int) -> dict:
    """For every scene what each solver needs for an error, and the times at equal error."""
    integrate(ready(bare_wheel(1e-3, end=0.05)), LSODA[0], "compiled", 1e-3)  # compiles
    return {name: measure_case(case, rounds) for name, case in CASES.items()}


def measure_case(case: Case, rounds: int) -> dict:
    reference = final(case.scene(*case.fine))
    full = rounds >= FULL_ROUNDS
    errors = case.errors if full else case.errors[:1]
    peers = case.peers if full else [peer for peer in case.peers if peer.solver in LSODA and peer.form != "NumPy"]
    trials, missed = [], []
    for error in errors:
        for peer in peers:
            found = climb(case, peer, error, reference)
            (trials if found else missed).append(found or (peer, error))
    ours = steps_for(case, errors, reference)
    timed = {}
    for error in errors:
        for trial in chosen(trials, error):
            timed[trial] = partial(solving, case, trial)
        for method in METHODS:
            if (method, error) in ours:
                timed[method, error] = partial(marching, case, method, ours[method, error][0])
    seconds = interleaved(timed, min(rounds, TIMED))
    ms = {key: statistics.median(values) * 1e3 for key, values in seconds.items()}
    return {
        "targets": case.targets,
        "trials": [row_of(trial) for trial in trials],
        "missed": [{**peer._asdict(), "goal": error} for peer, error in missed],
        "equal": [
            row_of(trial)
            | {"ms": ms[trial], "evaluations": evaluations(case, trial)}
            | {"ours": our_rows(case, ours, ms, trial.goal), "ratio": times(trial, seconds)}
            for error in errors
            for trial in chosen(trials, error)
        ],
    }


def row_of(trial: Trial) -> dict:
    return trial._asdict() | trial.peer._asdict()


def our_rows(case: Case, ours: dict, ms: dict, error: float) -> dict:
    """Step, error, milliseconds and right-hand sides of each method that reaches an error."""
    rows = {}
    for method in METHODS:
        if (method, error) in ours:
            step, reached = ours[method, error]
            rhs = int(ready(case.scene(method, step)).go().run.clock.rhs)
            rows[method] = {"step": step, "error": reached, "ms": ms[method, error], "evaluations": rhs}
    return rows


def evaluations(case: Case, trial: Trial) -> int:
    """How often SciPy has the march's own equations evaluated, for Jacobians too; 0 of those by hand."""
    if trial.peer.form not in COMPILED:
        return 0
    march = smoothed(case, trial)
    integrate(march, *trial.peer, trial.tolerance, PATIENCE)
    return int(march.run.clock.rhs)


def climb(case: Case, peer: Peer, error: float, reference: np.ndarray) -> Trial | None:
    """The loosest tolerance by which a solver reaches an error; None if none does, or it stalls twice before."""
    slip_speed = SHARE * error / case.slip_error if case.slip_error else 0.0
    tolerance, stalls = LOOSEST * error, 0
    while tolerance >= 0.99 * TIGHTEST * error and stalls < 2:
        trial = Trial(peer, error, tolerance, slip_speed, math.inf, math.inf)
        go, begun = solving(case, trial), time.perf_counter()
        try:
            reached = error_of(go(), reference, case.wheels)
        except Stalled:  # a tighter tolerance may well get through
            reached, stalls = math.inf, stalls + 1
        spent = time.perf_counter() - begun
        if reached <= error:
            return trial._replace(error=reached, ms=spent * 1e3)
        tolerance /= 10.0
    return None


def solving(case: Case, trial: Trial) -> Callable[[], np.ndarray]:
    """Prepare a run of SciPy."""
    return partial(integrate, smoothed(case, trial), *trial.peer, trial.tolerance, PATIENCE)


def smoothed(case: Case, trial: Trial) -> March:
    """What SciPy is to integrate."""
    return ready(smooth(case.scene("rk4", STEPS[0]), trial.slip_speed))


def marching(case: Case, method: str, step: float) -> Callable:
    """Prepare a march, warmed up by another one: after seconds of SciPy the first is cold."""
    final(case.scene(method, step))
    return ready(case.scene(method, step)).go


def steps_for(case: Case, errors: tuple[float, ...], reference: np.ndarray) -> dict:
    """The largest step, and its error, by which each method reaches each error."""
    found = {}
    for method in METHODS:
        reached = {}
        for step in case.steps:
            reached[step] = error_of(final(case.scene(method, step)), reference, case.wheels)
        for error in errors:
            good = [step for step in case.steps if reached[step] <= error]
            if good:
                found[method, error] = good[0], reached[good[0]]
    return found


def chosen(trials: list[Trial], error: float) -> list[Trial]:
    """The fastest solver on each form of the right-hand side."""
    best: dict[str, Trial] = {}
    for trial in sorted((trial for trial in trials if trial.goal == error), key=lambda trial: trial.ms):
        best.setdefault(trial.peer.form, trial)
    return list(best.values())


def times(trial: Trial, seconds: dict) -> dict[str, float]:
    """How many times faster each method is that reaches the same error."""
    keys = {method: (method, trial.goal) for method in METHODS}
    return {method: median_ratio(seconds[trial], seconds[key]) for method, key in keys.items() if key in seconds}


def least(result: dict, form: str, method: str) -> dict | None:
    """The row of the smallest ratio of SciPy's best on a form to a method, over all errors; None if it was not run."""
    rows = [row for row in result["equal"] if row["form"] == form and method in row["ratio"]]
    return min(rows, key=lambda row: row["ratio"][method], default=None)


def reason(row: dict, more: dict | None) -> str:
    """What such a ratio is made of: how often the same equations are evaluated, and how long it takes with what is
    between; more: the row of the other method."""
    default, other = METHODS
    told = f"By {other} {more['ratio'][other]:.3g}" if more else ""
    if not row["evaluations"]:
        return told
    parts = []
    for name, done in ((row["solver"].split(",")[0], row), (default, row["ours"][default])):
        each = 1e3 * done["ms"] / done["evaluations"]
        parts.append(f"{name} evaluates them {done['evaluations']} times, which takes {each:.2g} µs each")
    return f"Both evaluate the march's own compiled equations: {'; '.join(parts)}, with all between. {told}"


def report(result: dict) -> str:
    return "\n\n".join(f"### {name}\n\n{report_case(part)}" for name, part in result.items())


def report_case(result: dict) -> str:
    equal = [
        [f"{row['goal']:.0e}", f"{row['solver']}, {row['form']}", f"{row['error']:.1e}", f"{row['ms']:.2f}"]
        + [
            text
            for method in METHODS
            for own in [row["ours"].get(method)]
            for text in ([f"{own['step']:.2e}", f"{own['error']:.1e}", f"{own['ms']:.2f}"] if own else ["-"] * 3)
        ]
        + [f"{row['ratio'][method]:.0f}" if method in row["ratio"] else "-" for method in METHODS]
        for row in result["equal"]
    ]
    ours = [f"{method}, {what}" for method in METHODS for what in ("step, s", "error", "ms")]
    climbed = [
        [f"{row['goal']:.0e}", row["solver"], row["form"], f"{row['slip_speed']:.1e}" if row["slip_speed"] else "-"]
        + [f"{row[name]:.0e}" for name in ("tolerance", "error")]
        + [f"{row['ms']:.1f}"]
        for row in result["trials"]
    ]
    for row in result["missed"]:
        climbed.append([f"{row['goal']:.0e}", row["solver"], row["form"], "-", "-", "not reached", "-"])
    return "\n\n".join(
        [
            "At equal error, SciPy's fastest solver on each form of the right-hand side:",
            table(["error", "SciPy", "its error", "ms", *ours, *(f"SciPy / {method}" for method in METHODS)], equal),
            "Every solver by the loosest tolerance that reaches the error, one run each:",
            table(["error", "solver", "right-hand side", "slip_speed, m/s", "tolerance", "its error", "ms"], climbed),
        ]
    )


def claims(result: dict) -> list[Claim]:
    default, other = METHODS
    return [
        Claim(
            f"SciPy's best on {EQUATIONS[form]}, by {default} at equal error: {name}",
            row["ratio"][default],
            "at least",
            *bounds,
            reason(row, least(part, form, other)),
        )
        for name, part in result.items()
        for form, bounds in part["targets"].items()
        if (row := least(part, form, default)) is not None
    ]
