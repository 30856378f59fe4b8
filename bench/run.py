"""Run the benchmarks: Markdown on stdout, progress on stderr.

python -m bench [--quick] [--report FOLDER] [BENCHMARK | ours | peers]...
python -m bench --check [--report FOLDER]         a few minutes; exits with 1 if a claim is beyond its alarm
"""

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import NamedTuple

# As `omnisim bench`, before the first import of NumPy: more threads gain nothing in small solves.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")
import omnisim
from bench.common import Claim, claims_table


class Benchmark(NamedTuple):
    """A module with measure(rounds), report(result) and claims(result), imported when it runs; rounds with --quick."""

    module: str
    title: str
    rounds: int
    quick: int


OURS = {
    "precision": Benchmark("bench.precision", "Speed against error", 5, 1),
    "accuracy": Benchmark("bench.accuracy", "Errors and orders", 1, 0),
    "laws": Benchmark("bench.laws", "Set-valued against regularized friction at equal error", 20, 2),
    "whole_machines": Benchmark("bench.whole_machines", "Whole machines", 20, 1),
    "hard_cases": Benchmark("bench.hard_cases", "Hard cases", 1, 1),
    "random_scenes": Benchmark("bench.random_scenes", "Random scenes", 100, 1),  # rounds: hundreds of scenes
    "targets": Benchmark("bench.targets", "Steps picked for an error", 2, 1),
    "formulations": Benchmark("bench.formulations", "Every body against the reduced equations", 15, 2),
    "kernels": Benchmark("bench.kernels", "Kernels", 31, 5),
    "spatial": Benchmark("bench.spatial", "Machines free in space", 3, 1),
    "scaling": Benchmark("bench.scaling", "More rollers, more rows", 31, 5),
    "startup": Benchmark("bench.startup", "Whole command", 5, 1),
    "memory": Benchmark("bench.memory", "Memory of the whole command", 3, 1),
    "short_runs": Benchmark("bench.short_runs", "Short runs", 300, 5),
    "studies": Benchmark("bench.studies", "Thousands of runs", 5, 1),
    "gym": Benchmark("bench.gym", "Environments for learning", 5, 1),
    "native": Benchmark("bench.native", "As native code", 100, 2),
    # rounds of the next two are simulated seconds
    "vehicle": Benchmark("bench.vehicle", "The authors' vehicle against its ideal", 20, 2),
    "twists": Benchmark("bench.twists", "Machines that follow a twist", 4, 4),
}
PEERS = {
    "c_loop": Benchmark("bench.peers.c_loop", "RK4 against C loops", 31, 5),
    "limit": Benchmark("bench.limit", "The limit of the arithmetic", 31, 5),
    "scipy_peer": Benchmark("bench.peers.scipy_peer", "Against SciPy's solvers at equal error", 3, 1),
    "mujoco_peer": Benchmark("bench.peers.mujoco_peer", "One wheel in MuJoCo", 5, 1),
    "mujoco_platform": Benchmark("bench.peers.mujoco_platform", "The mecanum platform in MuJoCo", 5, 1),
    "mujoco_bumps": Benchmark("bench.peers.mujoco_bumps", "A free machine over bumps in MuJoCo", 5, 1),
    "drake_peer": Benchmark("bench.peers.drake_peer", "One wheel in Drake", 5, 1),
    "drake_bumps": Benchmark("bench.peers.drake_bumps", "A free machine over bumps in Drake", 3, 1),
}
GROUPS = {"ours": OURS, "peers": PEERS}
BENCHMARKS = OURS | PEERS
CHECKED = ("precision", "accuracy", "hard_cases", "kernels", "scaling", "spatial", "c_loop", "scipy_peer")
OPTIONAL = ("scipy", "mujoco", "pydrake", "gymnasium", "fmpy")  # packages that a benchmark may miss
VERSIONS = ("omnisim-engine", "numba", "numpy", "scipy", "mujoco", "drake")


class Run(NamedTuple):
    """What came of a benchmark; without a result it was not measured, and the report says why."""

    result: object
    report: str
    claims: list[Claim]


def main(arguments: Sequence[str] | None = None) -> None:
    """Exits with 1, and names the claims, if a check finds one beyond its alarm."""
    options = parsed(arguments)
    print(f"omnisim from {Path(omnisim.__file__).parent}", file=sys.stderr)
    print(f"Measured on: {machine()}, {', '.join(' '.join(pair) for pair in versions().items())}", flush=True)
    claims = []
    for name in chosen(options):
        benchmark = BENCHMARKS[name]
        print(f"{name} ...", file=sys.stderr, flush=True)
        done = run(benchmark, benchmark.quick if options.quick else benchmark.rounds)
        print(f"\n## {benchmark.title}\n\n{done.report}", flush=True)
        claims += done.claims
        if options.report and done.result:
            write(options.report, name, done, options.quick)
    print(f"\n## Claims\n\n{claims_table(claims)}", flush=True)
    alarms = [f"beyond its alarm: {claim.text}: {claim.value:.3g}" for claim in claims if claim.alarming]
    if options.check and alarms:
        sys.exit("\n".join(alarms))


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser("python -m bench", description="Speed of omnisim as ratios of one run")
    names = [[], *BENCHMARKS, *GROUPS]
    parser.add_argument("benchmarks", nargs="*", choices=names, metavar="BENCHMARK", default=[])
    parser.add_argument("--quick", action="store_true", help="few rounds: shows that everything runs")
    parser.add_argument(
        "--check", action="store_true", help="the short set, quick; fails if a claim is beyond its alarm"
    )
    parser.add_argument("--report", type=Path, metavar="FOLDER", help="also write FOLDER/BENCHMARK.json")
    options = parser.parse_args(arguments)
    options.quick |= options.check
    return options


def chosen(options: argparse.Namespace) -> list[str]:
    """Names of the benchmarks to run: groups opened, none twice."""
    names = options.benchmarks or (CHECKED if options.check else GROUPS)
    return list(dict.fromkeys(single for name in names for single in GROUPS.get(name, (name,))))


def run(benchmark: Benchmark, rounds: int) -> Run:
    """Measure, unless a package is missing."""
    try:
        module = import_module(benchmark.module)
    except ModuleNotFoundError as error:
        if error.name not in OPTIONAL:
            raise
        return Run(None, f"{error.name} is not installed: not measured.", [])
    result = module.measure(rounds)
    return Run(result, module.report(result), module.claims(result))


def write(folder: Path, name: str, done: Run, quick: bool) -> None:
    """The numbers with their circumstances, and what was said of them, as FOLDER/NAME.json."""
    data = {
        "title": BENCHMARKS[name].title,
        "command": f"python -m bench {'--quick ' * quick}{name}",
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "versions": versions(),
        "claims": [claim._asdict() for claim in done.claims],
        "report": done.report,
        "result": done.result,
    }
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{name}.json").write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")


def machine() -> str:
    """The processor with its family and model, which shared machines tell when they hide its name."""
    info = Path("/proc/cpuinfo")
    pairs = [line.partition(":") for line in info.read_text().splitlines()] if info.exists() else []
    said = {name.strip(): value.strip() for name, _, value in reversed(pairs)}
    processor = said.get("model name") or platform.processor() or platform.machine()
    kind = f" (family {said['cpu family']}, model {said['model']})" if {"cpu family", "model"} <= said.keys() else ""
    return f"{processor}{kind}, {os.cpu_count()} cores, {platform.system()}"


def versions() -> dict[str, str]:
    """Of Python, the packages that are there, and the compiler of the C loops."""
    found = {"Python": platform.python_version()}
    for package in VERSIONS:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            continue
    if shutil.which("gcc"):
        said = subprocess.run(["gcc", "-dumpfullversion", "-dumpversion"], capture_output=True, text=True, check=True)
        found["gcc"] = said.stdout.strip()
    return found
