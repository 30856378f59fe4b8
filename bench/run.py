"""Run the benchmarks: Markdown on stdout, progress on stderr.

python bench/run.py [--quick] [--json FILE] [BENCHMARK...]      c_loop limit scipy_peer laws scaling kernels
                                                                whole_machines startup memory hard_cases targets vehicle
                                                                twists mujoco_peer mujoco_platform drake_peer
"""

import argparse
import json
import platform
import sys
from pathlib import Path

import hard_cases
import kernels
import laws
import limit
import memory
import numba
import numpy
import scaling
import scipy
import startup
import targets
import twists
import vehicle
import whole_machines
from peers import c_loop, drake_peer, mujoco_peer, mujoco_platform, scipy_peer, wheel_scene

import omnisim

BENCHMARKS = {
    "c_loop": (c_loop, "RK4 against C loops", 31, 5),  # module, title, rounds, rounds with --quick
    "limit": (limit, "The limit of the arithmetic", 31, 5),
    "scipy_peer": (scipy_peer, "Against SciPy's solvers at equal error", 3, 1),
    "laws": (laws, "Set-valued against regularized friction at equal error", 20, 2),
    "scaling": (scaling, "64 rollers against 8", 31, 5),
    "kernels": (kernels, "Kernels", 31, 5),
    "whole_machines": (whole_machines, "Whole machines", 20, 1),
    "startup": (startup, "Whole command", 5, 1),
    "memory": (memory, "Memory of the whole command", 3, 1),
    "hard_cases": (hard_cases, "Hard cases", 1, 1),
    "targets": (targets, "Steps picked for an error", 2, 1),
    "vehicle": (vehicle, "The authors' vehicle against its ideal", 20, 2),  # simulated seconds, as of the next
    "twists": (twists, "Machines that follow a twist", 4, 4),
    "mujoco_peer": (mujoco_peer, "One wheel in MuJoCo", 5, 1),
    "mujoco_platform": (mujoco_platform, "The mecanum platform in MuJoCo", 5, 1),
    "drake_peer": (drake_peer, "One wheel in Drake", 5, 1),
}


def main() -> None:
    options = arguments()
    results, sections = {"machine": machine()}, [f"Measured on: {machine()}"]
    for name in options.benchmarks or BENCHMARKS:
        module, title, rounds, few = BENCHMARKS[name]
        print(f"{name} ...", file=sys.stderr, flush=True)
        results[name] = module.measure(few if options.quick else rounds)
        sections.append(f"## {title}\n\n{module.report(results[name])}")
    results["verdict"] = verdict(results)
    sections.append(f"## Verdict\n\n{results['verdict']}")
    print("\n\n".join(sections))
    if options.json:
        options.json.write_text(json.dumps(results, indent=1))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Speed of omnisim as ratios of one run")
    parser.add_argument("benchmarks", nargs="*", choices=[[], *BENCHMARKS], metavar="BENCHMARK", default=[])
    parser.add_argument("--quick", action="store_true", help="few rounds: shows that everything runs")
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the numbers")
    return parser.parse_args()


def machine() -> str:
    """Processor and versions."""
    info = Path("/proc/cpuinfo")
    models = [line for line in info.read_text().splitlines() if line.startswith("model name")] if info.exists() else []
    processor = models[0].partition(":")[2].strip() if models else platform.processor() or platform.machine()
    versions = ", ".join(f"{module.__name__} {module.__version__}" for module in (numba, numpy, scipy))
    return f"{processor}, {platform.system()}, Python {platform.python_version()}, {versions}"


def verdict(results: dict) -> str:
    """One sentence for each target, from the numbers."""
    sentences = []
    if loops := results.get("c_loop"):
        for scene, builds in loops.items():
            ratio = builds[c_loop.PLAIN]["ratio"]
            text = f"A march of the {scene} takes {ratio:.2f} times the C loop ({c_loop.PLAIN})"
            sentences.append(judge(text, c_loop.LOOPS[scene].target, ratio, "most"))
            fastest = max(builds, key=lambda name: builds[name]["ratio"])
            if fastest != c_loop.PLAIN:
                sentences.append(f"The fastest build, {fastest}, makes it {builds[fastest]['ratio']:.2f} times.")
    if bound := results.get("limit"):
        parts = (f"{bound[scene]['ratio']['omnisim']:.2f} times for the {scene}" for scene in c_loop.LOOPS)
        sentences.append(f"A march takes longer than the arithmetic of its equations: {', '.join(parts)}.")
    for scene, part in results.get("scipy_peer", {}).items():
        ratio = scipy_peer.least(part)
        text = f"{scene}: at equal error rk4 is at least {ratio:.0f} times faster than SciPy's best"
        sentences.append(judge(text, part["target"], ratio, "least"))
    if friction := results.get("laws"):
        (least, most), march = laws.span(friction, "simulate", "rk4"), laws.span(friction, "march", "rk4")
        text = f"At equal error the regularized law takes {least:.0f} to {most:.0f} times as long as the set-valued one"
        text += f" by rk4 (the march alone {march[0]:.0f} to {march[1]:.0f} times)"
        sentences.append(judge(text, laws.TARGET, least, "least"))
    if wheels := results.get("scaling"):
        worst = max(row["ratio"] for row in wheels.values())
        sentences.append(judge(f"64 rollers take {worst:.2f} times as long as 8", scaling.TARGET, worst, "most"))
    if whole := results.get("whole_machines"):
        sentences += machine_sentences(whole)
    if cases := results.get("hard_cases"):
        kept = sum(row["error"] < row["bound"] and row["energy"] < hard_cases.BALANCED for row in cases)
        sentences.append(f"{kept} of {len(cases)} hard cases keep their bounds.")
    for name, engine in (("mujoco_peer", "MuJoCo"), ("drake_peer", "Drake")):
        if peer := results.get(name):
            sentences.append(wheel_scene.claim(engine, peer["best"], peer["omnisim"]))
    if picked := results.get("targets"):
        sentences.append(targets.verdict(picked))
    return " ".join(sentences)


def machine_sentences(result: dict) -> list[str]:
    """Of the platform, of the wheels of a machine, of its rollers."""
    keys = ("rate", "march"), ("rate", "simulate"), ("torque", "march")
    march, whole, free = (f"{whole_machines.slowest(result, *key):.0f}" for key in keys)
    text = f"The platform on 4 x 9 mecanum rollers marches at {march} times real time in the slowest of its motions"
    text += (
        f" (the whole call at {whole}, without controllers the march at {free}), position within "
        f"{whole_machines.ACCURATE:g} m"
    )
    most = max(rows[-1]["ratio"] for rows in result["wheels"].values())
    steps = f"A step of {whole_machines.MOST} wheels takes {most:.2f} times that of {whole_machines.FEWEST}"
    rollers = max(row["ratio"] for row in result["rollers"].values())
    return [
        judge(text, whole_machines.TARGET, float(march), "least"),
        f"The aim is {whole_machines.AIM:g}; {whole_machines.ELSEWHERE}.",
        judge(steps, whole_machines.MOST / whole_machines.FEWEST, most, "most"),
        f"64 rollers on each of four wheels take {rollers:.2f} times as long as 8, with their exchanges.",
    ]


def judge(text: str, target: float, value: float, bound: str) -> str:
    met = value <= target if bound == "most" else value >= target
    return f"{text}: the target, at {bound} {target:g}, is {'met' if met else 'missed'}."


if __name__ == "__main__":
    print(f"omnisim from {Path(omnisim.__file__).parent}", file=sys.stderr)
    main()
