"""Thousands of runs: a study on one process and on all cores, beside a loop over `simulate` and MuJoCo's rollout.

The mecanum platform of machine_scenes.py slides sideways for two seconds, by its torques, with a step that keeps the
position within 1e-5 m in every run, which is measured; friction, the mass of the chassis and the place of every roller
vary. MuJoCo rolls out as many models of other friction and mass, all at once, over as many threads, with the largest
step that it stands; models, states and results are made before the clock starts. It writes nothing, a study writes its
file.

How many times faster a study can be on all cores is a question to the machine as well: processes that are made before
the clock starts, that share nothing and have equal parts of the runs to do tell what it gives.
"""

import multiprocessing
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

import omnisim
from bench.common import Claim, median_ratio, rates_in_turn, table
from bench.machine_scenes import END, platform
from bench.memory import MEGABYTE, peak_of
from omnisim.studies.study import Study, load_study
from omnisim.studies.sweep import sweep
from omnisim.studies.task import Task
from omnisim.studies.workers import cores, on_cores, start

MOTION, METHOD, STEP = "sideways", "rk4", 1.25e-2  # s
EXACT = ("dopri5", 1e-3)  # method and step, s, of what the runs are compared with
RUNS, FEW, MANY = 1000, 100, 10_000  # of a study; of what is slower, or only by the way; of a large study
BATCH = 50  # runs
FRICTION, MASS = (0.5, 0.9), (19.0, 21.0)
STUDY = """
schema = 1
scene = "platform.toml"
[vary]
"friction.coefficient" = {{ uniform = {friction} }}
"chassis.mass" = {{ uniform = {mass} }}
"wheels.*.phase_deg" = {{ uniform = [0, 40], each = true }}
[design]
kind = "random"
count = {count}
[measure]
odometry_error = {{ dataset = "odometry/position_error", component = "norm", at = "end" }}
worst_slip = {{ dataset = "wheels/*/slip_velocity", component = "norm", reduce = "max" }}
drive_work = {{ dataset = "energy/drive_work", at = "end" }}
"""


def study_in(folder: Path, count: int) -> Path:
    """A file of this study with so many runs."""
    (folder / "platform.toml").write_text(platform(MOTION, "torque", METHOD, STEP).text)
    path = folder / f"study_{count}.toml"
    path.write_text(STUDY.format(friction=list(FRICTION), mass=list(MASS), count=count))
    return path


def measure(rounds: int) -> dict:
    """Runs a second of every contestant, round by round in turn; what a study takes beside its marches; its memory."""
    with (
        tempfile.TemporaryDirectory() as folder,
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as apart,
        idle_processes(study_in(Path(folder), RUNS)) as idle,
    ):
        path = study_in(Path(folder), RUNS)
        study = load_study(path)
        contestants: dict[str, Callable[[], int]] = {
            "study, 1 process": lambda: apart.submit(swept, path, 1).result(),
            f"study, {cores()} processes": lambda: apart.submit(swept, path, cores()).result(),
            f"its runs on {cores()} threads": lambda: threaded(study),
            "loop over simulate": lambda: looped(study),
            "its runs, 1 idle process": lambda: shared_out(idle[:1], study.count),
            f"its runs, {cores()} idle processes": lambda: shared_out(idle, study.count),
        }
        rates = rates_in_turn(contestants | rolled(), rounds)
        overhead = [beside_the_march(study) for _ in range(rounds)]
        sizes = (FEW, RUNS, MANY) if rounds > 1 else (FEW, RUNS)
        return {
            "cores": cores(),
            "rates": rates,
            "overhead": overhead,
            "position_error": position_error(study),
            "peak": {str(count): peak(Path(folder), count) for count in sizes},
        }


def swept(path: Path, workers: int) -> int:
    """The study in this file, in a process that has nothing else in its memory, as that of the command: to double one
    with MuJoCo in it takes twice as long."""
    study = loaded(path)
    sweep(study, path.with_suffix(".h5"), workers=workers, overwrite=True)
    return study.count


loaded = cache(load_study)


def threaded(study: Study) -> int:
    """The runs alone, without a file, by threads of one process."""
    batches = [range(first, first + BATCH) for first in range(0, study.count, BATCH)]
    with ThreadPoolExecutor(cores()) as pool:
        return sum(map(len, pool.map(Task(study), batches)))


@contextmanager
def idle_processes(study: Path) -> Iterator[list[Connection]]:
    """A process for each core, which does the runs that it is sent."""
    context, task, workers = multiprocessing.get_context("fork"), Task(load_study(study)), []
    for _ in range(cores()):
        workers.append(start(context, task, workers))
    found = [worker.connection for worker in workers]
    shared_out(found, FEW)  # what the first runs of a process take
    try:
        yield found
    finally:
        for one in found:
            one.send(())


def shared_out(idle: list[Connection], count: int) -> int:
    """So many runs, an equal part by each process, without a file."""
    for i, one in enumerate(idle):
        one.send(tuple(range(i, count, len(idle))))
    return sum(len(one.recv()) for one in idle)


def looped(study: Study) -> int:
    """The same runs by hand, one trajectory after the other."""
    task = Task(study)
    for run in range(FEW):
        omnisim.simulate(omnisim.load_text(study.scene.text, task.overrides(run)))
    return FEW


def beside_the_march(study: Study) -> float:
    """Time that one process takes for the runs beside their marches, by that of the marches."""
    task = Task(study)
    begun = time.perf_counter()
    rows = [row for rows in on_cores(task, list(range(RUNS)), 1, lambda: False) for row in rows]
    whole, marches = time.perf_counter() - begun, sum(row.wall_time for row in rows)
    return whole / marches - 1.0


def position_error(study: Study) -> float:
    """Largest error of a coordinate in any row of FEW runs over the whole study, m, by finer steps of higher order."""
    task, (method, step) = Task(study), EXACT

    def places(run: int, settings: dict[str, object]) -> np.ndarray:
        return omnisim.simulate(omnisim.load_text(study.scene.text, task.overrides(run) | settings))["body/position"]

    def off(run: int) -> float:
        return float(np.max(np.abs(places(run, {}) - places(run, {"solver.method": method, "time.step": step}))))

    return max(map(off, range(0, study.count, study.count // FEW)))


def peak(folder: Path, count: int) -> int:
    """Largest resident memory of `omnisim sweep`, bytes: of the process that hands out the runs or of any other."""
    command = [str(Path(sys.executable).with_name("omnisim")), "sweep", str(study_in(folder, count)), "--quiet"]
    return peak_of([*command, "--force", "-o", str(folder / "peak.h5")])


def rolled() -> dict[str, Callable[[], int]]:
    """MuJoCo's runs, of other friction and mass; none without it."""
    from bench.peers.mujoco_peer import mujoco  # here: not in the process of the study
    from bench.peers.mujoco_platform import HOW, LEVEL, Setup, model, rollout

    if mujoco is None:
        return {}

    def ready(setup: Setup) -> Callable[[], int]:
        random, models = np.random.default_rng(1), []
        for _ in range(FEW):
            variant = model(setup)
            variant.geom_friction[:, 0] = random.uniform(*FRICTION)
            variant.body_mass[1] = random.uniform(*MASS)
            models.append(variant)
        go = rollout(setup, models, END)
        return lambda: FEW if go() else 0

    return {
        f"MuJoCo rollout, {cores()} threads, {contact}, {integrator}, {step:g} s": ready(
            Setup(MOTION, LEVEL, contact, integrator, step)
        )
        for contact, integrator, step in HOW[:2]  # the third is slower by far
    }


def report(result: dict) -> str:
    rows = [[name, f"{statistics.median(values):.0f}"] for name, values in result["rates"].items()]
    peaks = [[count, f"{value / MEGABYTE:.0f}"] for count, value in result["peak"].items()]
    return "\n\n".join(
        [
            table(["runs of 2 s", "runs a second"], rows),
            f"Beside its marches a study takes {statistics.median(result['overhead']):.0%} of them. "
            f"Its positions err by {result['position_error']:.1e} m at most ({METHOD}, {STEP:g} s; {FEW} of its runs).",
            table(["runs of `omnisim sweep`", "peak of its largest process, MiB"], peaks),
        ]
    )


def claims(result: dict) -> list[Claim]:
    rates = result["rates"]
    one, all_of_them, _, _, one_idle, all_idle, *theirs = rates
    times, idle = median_ratio(rates[all_of_them], rates[one]), median_ratio(rates[all_idle], rates[one_idle])
    found = [
        Claim(
            f"a study of {RUNS} runs on {result['cores']} cores, runs a second by those on one",
            times,
            "at least",
            0.95 * result["cores"],
            0.5 * result["cores"],
            f"Processes that share nothing and wait for nobody make {idle:.2f}",
        ),
        Claim(
            "that, by the same of idle processes that share nothing: what the machine gives",
            times / idle,
            "at least",
            0.95,
            0.6,
        ),
        Claim(
            "what a study takes beside its marches, by those",
            statistics.median(result["overhead"]),
            "at most",
            0.3,
            0.8,
        ),
        Claim("largest error of position in a study, m", result["position_error"], "at most", 1e-5, 1e-5),
    ]
    if theirs:
        fastest = max(theirs, key=lambda name: statistics.median(rates[name]))
        times = median_ratio(rates[all_of_them], rates[fastest])
        found.append(
            Claim("runs a second of a study, by those of MuJoCo's fastest rollout", times, "at least", 15.0, 8.0)
        )
    return found
