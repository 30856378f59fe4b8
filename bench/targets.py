"""Is a wanted error kept? Steps picked for `solver.error`, judged by converged runs; and what the search costs."""

import statistics
import time
from pathlib import Path
from typing import NamedTuple

import omnisim
from bench.common import Claim, table
from omnisim.results.comparison import distance
from omnisim.run.work_precision import Reference, converged
from omnisim.scene.scene import Scene

REFERENCE = Path(__file__).parents[1] / "tests" / "reference"
TARGETS = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
EXPLICIT = ("rk4", "dopri5")
CLEAR = 10.0  # a true error tells something if it is so many times what the reference can be trusted to


class Case(NamedTuple):
    """A scene, the methods that search a step for it, and the step of its reference (s)."""

    scene: str
    step: float
    methods: tuple[str, ...] = EXPLICIT
    overrides: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        return f"reference/{Path(self.scene).stem}" if self.scene.endswith(".toml") else self.scene

    def load(self, *overrides: str) -> Scene:
        return omnisim.load(self.scene, (*self.overrides, *overrides))


CASES = (
    Case("coulomb_wheel", 2e-5, ("heun", *EXPLICIT, "auto")),
    Case("six_rollers", 1e-5, (*EXPLICIT, "auto")),
    Case("thirty_two_rollers", 5e-6, (*EXPLICIT, "auto")),
    Case("fm202", 2e-5, (*EXPLICIT, "auto")),
    Case("authors_sliding", 5e-6, EXPLICIT, ("time.end=1.0",)),
    Case("authors_vehicle", 1e-4, ("auto",), ("time.end=2.0",)),
    Case("kiwi", 2e-5),
    Case("mixed", 2e-5),
    Case("soccer_kit", 2e-5),
    Case("soccer_robot", 2e-5),
    Case("youbot", 2e-5, (*EXPLICIT, "auto")),
    Case(str(REFERENCE / "coulomb_wheel.toml"), 2e-5),
    Case(str(REFERENCE / "kiwi.toml"), 2e-5, (*EXPLICIT, "auto")),
    Case(str(REFERENCE / "mecanum.toml"), 5e-6, (*EXPLICIT, "auto")),
    Case(str(REFERENCE / "testbench_psi0.toml"), 1e-5, (*EXPLICIT, "auto")),
    Case(str(REFERENCE / "testbench_psi30.toml"), 5e-6, (*EXPLICIT, "auto")),
)


def measure(rounds: int) -> list[dict]:
    """A row for each case, method and target: step, estimate, true error, seconds of the search and of its last run.

    With one round, as --quick has it, of the two first cases alone.
    """
    rows = []
    for case in CASES if rounds > 1 else CASES[:2]:
        reference = converged(case.load(), case.step, lambda _: None)
        for method in case.methods:
            rows += [row(case, method, target, reference, rounds) for target in TARGETS]
    return rows


def row(case: Case, method: str, target: float, reference: Reference, rounds: int) -> dict:
    scene = case.load(f"solver.method={method}", f"solver.error={target!r}")
    found = omnisim.simulate(scene).attributes
    interval = scene.config.time.output_interval
    fixed = case.load(f"solver.method={method}", f"time.step={found['step']!r}", f"time.output_interval={interval!r}")
    spent = [(seconds(scene), seconds(fixed)) for _ in range(rounds)]
    return {
        "scene": case.name,
        "method": method,
        "target": target,
        "step": found["step"],
        "estimate": found.get("error_estimate"),
        "error": distance(omnisim.simulate(fixed), reference.run),
        "trusted": reference.distance,
        "search_s": statistics.median(search for search, _ in spent),
        "run_s": statistics.median(run for _, run in spent),
        "status": found["status"],
    }


def seconds(scene: Scene) -> float:
    begun = time.perf_counter()
    omnisim.simulate(scene)
    return time.perf_counter() - begun


def report(rows: list[dict]) -> str:
    lines = []
    for name, method in dict.fromkeys((row["scene"], row["method"]) for row in rows):
        own = [row for row in rows if (row["scene"], row["method"]) == (name, method)]
        told = [row["estimate"] / row["error"] for row in own if row["error"] > CLEAR * row["trusted"]]
        steps = ", ".join(f"{row['step']:.2g}" for row in own)
        worst = max(row["error"] / row["target"] for row in own)
        ratio = f"{min(told):.2g} to {max(told):.2g}" if told else "-"
        cost = f"{statistics.median(row['search_s'] / row['run_s'] for row in own):.1f}"
        lines.append([name, method, steps, f"{worst:.2g}", ratio, cost])
    header = ["scene", "method", "steps picked, s", "largest error / target", "estimate / error", "search / run"]
    return table(header, lines)


def claims(rows: list[dict]) -> list[Claim]:
    kept = sum(row["error"] <= row["target"] for row in rows)
    text = f"errors below the wanted ones, {TARGETS[0]:g} to {TARGETS[-1]:g}, of {len(rows)} picked steps"
    return [Claim(text, kept, "at least", len(rows), len(rows))]
