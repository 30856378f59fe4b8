"""Set-valued Coulomb friction against the regularized law at equal error, on the packaged scene coulomb_wheel.

Compared are the position, the yaw and the spin angle at the end with a converged state of the set-valued law. The
regularized law is off by its slip speed and by its step. It gets what is fair: every method and a ladder of steps at
every slip speed, and the three fastest of them once more at the slip speed that just reaches the error to be matched.
"""

import json
import math
import statistics
import time
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, interleaved, marching, median_ratio, simulation, table
from omnisim.base.methods import TABLEAUX
from omnisim.results.trajectory import Trajectory
from omnisim.scene.scene import Scene

TARGET, ALARM = 20.0, 5.0  # times faster than the regularized law: simulate, by the method of the scene
REFERENCE = Path(__file__).parents[1] / "tests/reference/coulomb_wheel.json"
RESOLVED = 1e-9  # what the reference is good to; smaller errors are not compared
FEW_ROWS = "time.output_interval=0.1"  # 21 rows instead of 201
CLOSEST = 3  # methods and steps that try to match an error
MARGIN = 0.97  # of the error to be matched: what the slip speed alone may take
NEAR = 0.93  # of the error to be matched: who is so close needs no better match
TRIALS = 2  # the best of which is the time of a survey
NOTES = """Errors are the largest of position (m), yaw and spin angle (rad) at 2 s. Orders are observed between a step
and the one above, down to the 1e-9 that the reference is good to. Times of simulate are those of the whole call, with
its output. Survey: the fastest step of each method, best of two; of rk4 and dopri5 the largest step that is stable."""


class Setup(NamedTuple):
    """A law (slip_speed in m/s of the regularized one, 0 for the set-valued one), a method and a step (s)."""

    slip_speed: float
    method: str
    step: float

    def scene(self, *overrides: str) -> Scene:
        law = ("friction.law=regularized", f"friction.slip_speed={self.slip_speed!r}") if self.slip_speed else ()
        solver = (f"solver.method={self.method}", f"time.step={self.step!r}")
        return omnisim.load("coulomb_wheel", (*law, *solver, *overrides))


class Trial(NamedTuple):
    """A setup of the regularized law, its error, and milliseconds of simulate."""

    setup: Setup
    error: float
    ms: float


class Plan(NamedTuple):
    """What is run: of the set-valued law methods x steps, of the regularized one slip speeds x methods x steps."""

    methods: tuple[str, ...]
    steps: tuple[float, ...]
    slip_speeds: dict[float, tuple[str, ...]]
    implicit_steps: tuple[float, ...]


EXPLICIT, IMPLICIT = ("rk4", "dopri5"), ("auto", "radau5")
EXPLICIT_STEPS = tuple(float(f"{digit}e-{k}") for k in range(3, 8) for digit in (1, 0.5, 0.2))
FULL = Plan(
    EXPLICIT + IMPLICIT,
    (1e-2, 5e-3, 2e-3, 1e-3),
    dict.fromkeys((1e-2, 1e-3, 1e-4), EXPLICIT + IMPLICIT) | dict.fromkeys((1e-5, 1e-6, 1e-7), IMPLICIT),
    (1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4, 5e-5),
)
SHORT = Plan(("rk4",), (1e-2, 5e-3), {1e-3: ("rk4", "radau5"), 1e-4: ("radau5",), 1e-5: ("radau5",)}, (2e-3,))
FULL_ROUNDS = 5  # fewer rounds are for the short plan


def measure(rounds: int) -> dict:
    """Errors and median milliseconds of both laws, and ratios of time at every error of the set-valued law."""
    plan = FULL if rounds >= FULL_ROUNDS else SHORT
    exact = [Setup(0.0, method, step) for method in plan.methods for step in plan.steps]
    errors = {setup: error_of(omnisim.simulate(setup.scene())) for setup in exact}
    surveyed = survey(plan)
    pool, compared = list(surveyed), [setup for setup in exact if errors[setup] >= RESOLVED]
    for setup in compared:
        pool += matched(errors[setup], surveyed, pool)
    rivals = {setup: fastest(errors[setup], pool) for setup in compared}
    contestants = {}
    for setup in dict.fromkeys([*exact, *(rival.setup for rival in rivals.values() if rival)]):
        contestants["simulate", setup] = partial(simulation, setup.scene())
        contestants["march", setup] = partial(marching, setup.scene())
        if not setup.slip_speed:
            contestants["few rows", setup] = partial(simulation, setup.scene(FEW_ROWS))
    seconds = interleaved(contestants, rounds)
    return {
        "exact": [exact_row(setup, errors, seconds) for setup in exact],
        "equal": [equal_row(setup, errors[setup], rival, seconds) for setup, rival in rivals.items() if rival],
        "survey": [trial.setup._asdict() | {"error": trial.error, "ms": trial.ms} for trial in surveyed],
    }


def error_of(run: Trajectory) -> float:
    """Largest error of position, yaw and spin angle at the end; infinite for a run that stopped."""
    if run.attributes["status"] != "complete":
        return math.inf
    reference = json.loads(REFERENCE.read_text())
    expected = [*reference["position"][-1], reference["yaw"][-1], reference["spin_angle"]["wheel"][-1]]
    found = [*run["body/position"][-1, :2], run["body/yaw"][-1], run["wheels/wheel/spin_angle"][-1]]
    return float(np.abs(np.subtract(found, expected)).max())


# --- the regularized law --------------------------------------------------------------------------


def survey(plan: Plan) -> list[Trial]:
    """Every slip speed, method and step; of an explicit method the largest step at which it is stable."""
    trials = []
    for slip_speed, methods in plan.slip_speeds.items():
        for method in methods:
            explicit = method in TABLEAUX
            for step in EXPLICIT_STEPS if explicit else plan.implicit_steps:
                found = attempt(Setup(slip_speed, method, step))
                if found.error < math.inf:
                    trials.append(found)
                    if explicit:
                        break
    return trials


def attempt(setup: Setup) -> Trial:
    scene, times = setup.scene(), []
    for _ in range(TRIALS):
        begun = time.perf_counter()
        run = omnisim.simulate(scene)
        times.append((time.perf_counter() - begun) * 1e3)
    return Trial(setup, error_of(run), min(times))


def matched(error: float, surveyed: list[Trial], pool: list[Trial]) -> list[Trial]:
    """The fastest setups at the nearest slip speed, at the slip speed that just reaches the error.

    None if one of the pool is as close.
    """
    if any(NEAR * error <= trial.error <= error for trial in pool):
        return []
    nearest = min(surveyed, key=lambda trial: abs(math.log(trial.error / error))).setup.slip_speed
    closest = sorted((trial for trial in surveyed if trial.setup.slip_speed == nearest), key=lambda trial: trial.ms)
    slip_speed = float(f"{MARGIN * error * nearest / closest[0].error:.2e}")
    return [attempt(trial.setup._replace(slip_speed=slip_speed)) for trial in closest[:CLOSEST]]


def fastest(error: float, pool: list[Trial]) -> Trial | None:
    """The fastest that is at least as accurate."""
    return min((trial for trial in pool if trial.error <= error), key=lambda trial: trial.ms, default=None)


# --- rows -----------------------------------------------------------------------------------------


def exact_row(setup: Setup, errors: dict[Setup, float], seconds: dict) -> dict:
    """Error, order and milliseconds of a run by the set-valued law."""
    coarser = [other for other in errors if other.method == setup.method and other.step > setup.step]
    above = min(coarser, key=lambda other: other.step, default=None)
    order = None
    if above and errors[setup] >= RESOLVED:
        order = observed_order((above.step, setup.step), (errors[above], errors[setup]))
    ms = {what: statistics.median(seconds[what, setup]) * 1e3 for what in ("simulate", "few rows", "march")}
    return setup._asdict() | {"end": setup.scene().config.time.end, "error": errors[setup], "order": order} | ms


def equal_row(setup: Setup, error: float, rival: Trial, seconds: dict) -> dict:
    """Both laws at equal error: milliseconds, and the regularized law's time over that of the set-valued one."""
    ms, ratio = {}, {}
    for what in ("simulate", "march"):
        ours, theirs = seconds[what, setup], seconds[what, rival.setup]
        ms[what] = statistics.median(ours) * 1e3, statistics.median(theirs) * 1e3
        ratio[what] = median_ratio(theirs, ours)
    sides = {"exact": setup._asdict() | {"error": error}, "rival": rival.setup._asdict() | {"error": rival.error}}
    return sides | {"ms": ms, "ratio": ratio}


def observed_order(knobs: tuple[float, float], errors: tuple[float, float]) -> float:
    """Power of the knob (a step, a slip speed) with which the error falls."""
    return math.log(errors[0] / errors[1]) / math.log(knobs[0] / knobs[1])


def span(result: dict, what: str, method: str | None = None) -> tuple[float, float]:
    """Smallest and largest ratio at equal error, of one method or of all."""
    ratios = [row["ratio"][what] for row in result["equal"] if method in (None, row["exact"]["method"])]
    return min(ratios), max(ratios)


def report(result: dict) -> str:
    exact = [
        [row["method"], f"{row['step']:.0e}", f"{row['error']:.1e}", f"{row['order']:.2f}" if row["order"] else "-"]
        + [f"{row[what]:.2f}" for what in ("march", "simulate", "few rows")]
        + [f"{row['end'] / row[what] * 1e3:.0f}" for what in ("march", "simulate", "few rows")]
        for row in result["exact"]
    ]
    equal = [
        [ours["method"], f"{ours['step']:.0e}", f"{ours['error']:.1e}"]
        + [theirs["method"], f"{theirs['slip_speed']:.1e}", f"{theirs['step']:.0e}", f"{theirs['error']:.1e}"]
        + [f"{ms:.2f}" for what in ("simulate", "march") for ms in row["ms"][what]]
        + [f"{row['ratio'][what]:.1f}" for what in ("simulate", "march")]
        for row in result["equal"]
        for ours, theirs in [(row["exact"], row["rival"])]
    ]
    best: dict[tuple[float, str], dict] = {}
    for row in sorted(result["survey"], key=lambda row: row["ms"]):
        best.setdefault((row["slip_speed"], row["method"]), row)
    surveyed = [
        [f"{row['slip_speed']:.0e}", row["method"], f"{row['step']:.0e}", f"{row['error']:.1e}", f"{row['ms']:.1f}"]
        for _, row in sorted(best.items(), key=lambda item: (-item[0][0], item[0][1]))
    ]
    times = [f"times real time, {what}" for what in ("march", "201 rows", "21 rows")]
    return "\n\n".join(
        [
            "The set-valued law:",
            table(
                ["method", "step, s", "error", "order", "march, ms", "simulate, 201 rows, ms", "21 rows, ms", *times],
                exact,
            ),
            "At equal error, the fastest of the regularized law that is at least as accurate (simulate with 201 rows):",
            table(
                ["coulomb", "step, s", "error", "regularized", "slip_speed, m/s", "step, s", "error"]
                + [f"{what}, {law}, ms" for what in ("simulate", "march") for law in ("coulomb", "regularized")]
                + ["simulate, times", "march, times"],
                equal,
            ),
            "Survey of the regularized law:",
            table(["slip_speed, m/s", "method", "step, s", "error", "simulate, ms"], surveyed),
            NOTES,
        ]
    )


def claims(result: dict) -> list[Claim]:
    least, _ = span(result, "simulate", "rk4")
    text = "simulate with the regularized law, by that with the set-valued one (rk4) at equal error"
    return [Claim(text, least, "at least", TARGET, ALARM)]
