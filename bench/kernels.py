"""What one right-hand side and one step cost, for every method and tracking."""

import statistics

import numba

from bench.common import Claim, bare_wheel, interleaved, ready, table
from omnisim.base.methods import TABLEAUX
from omnisim.dynamics.right_hand_side import rhs
from omnisim.dynamics.state import Stage

EVALUATIONS = 20_000
TARGET, ALARM = 1.5, 1.1  # how many times faster explicit tracking makes an rk4 step; the paper found about 1.5


@numba.njit(error_model="numpy")
def evaluate(parameters, run, count):
    """`count` right-hand sides, each at a state that depends on the one before, as in a march."""
    for _ in range(count):
        rhs(parameters, Stage(run.mode, 0, 0.0, run.y, run.slopes[0], run.monitors, True))
        for m in range(len(run.y)):
            run.y[m] += 1e-9 * run.slopes[0, m]


def measure(rounds: int) -> dict:
    """Median ns of one right-hand side and of one step of a whole march (exchanges and rows included)."""
    contestants, counts = {}, {}
    for tracking in ("explicit", "implicit"):
        key = "rhs", tracking
        scene = bare_wheel(1e-4, end=1.0, tracking=tracking)
        contestants[key] = lambda scene=scene: evaluation(scene)
        counts[key] = EVALUATIONS
        for method in TABLEAUX:
            key, scene = (method, tracking), bare_wheel(1e-4, end=1.0, method=method, tracking=tracking)
            contestants[key] = lambda scene=scene: ready(scene).go
            counts[key] = scene.config.time.steps
    seconds = interleaved(contestants, rounds)
    result: dict[str, dict[str, float]] = {}
    for (what, tracking), values in seconds.items():
        result.setdefault(what, {})[tracking] = statistics.median(values) / counts[what, tracking] * 1e9
    return result


def evaluation(scene):
    """A function that evaluates the right-hand side EVALUATIONS times, from the state after the first steps."""
    march = ready(scene)
    march.run.clock.steps = march.run.clock.goal = 10
    march.go()
    return lambda: evaluate(march.parameters, march.run, EVALUATIONS)


def report(result: dict) -> str:
    stages = {name: f"one step, {name} ({method.stages} right-hand sides)" for name, method in TABLEAUX.items()}
    names = {"rhs": "one right-hand side"} | stages
    rows = [
        [names[what], f"{row['explicit']:.0f}", f"{row['implicit']:.0f}", f"{row['implicit'] / row['explicit']:.1f}"]
        for what, row in result.items()
    ]
    return table(["bare wheel, 6 rollers", "explicit, ns", "implicit, ns", "ratio"], rows)


def claims(result: dict) -> list[Claim]:
    ratio = result["rk4"]["implicit"] / result["rk4"]["explicit"]
    return [Claim("an rk4 step with implicit contact tracking, by one with explicit", ratio, "at least", TARGET, ALARM)]
