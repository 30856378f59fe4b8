"""Whole machines: speed against error of a mecanum platform, steps by wheels and rollers, stepping from outside.

The platform runs in three motions under both ways of driving it (`machine_scenes.py`), by every method and step of a
ladder. Its position is compared with a converged run, which another method with another step has to confirm; the
settings compared are those whose position is within ACCURATE of it in every row.
"""

import math
import statistics
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from bench import outside
from bench.common import Claim, bare_wheel, interleaved, marching, median_ratio, ready, simulation, table
from bench.machine_scenes import END, MOTIONS, platform, ring
from omnisim.results.trajectory import Trajectory

AT_EVENTS = (
    "3.2 times as many right-hand sides as its steps have stages, for 88 exchanges and as many stops. Run again and "
    "again the march is at 2020 to 2060; here one of its own comes between it and others, which caches remember"
)
TARGET, ALARM = 2000.0, 100.0  # times real time of the march, platform under rate drives, slowest motion
WHEELS_ALARM = 6.0  # times a step of the smallest ring, for the largest
ACCURATE = 1e-5  # m: error of position in any row
CONFIRMED = 1e-11  # m: largest distance of the two converged runs
CONVERGED = {"rk4": 2e-5, "dopri5": 4e-5}  # s; the first is the reference
ELSEWHERE = "MuJoCo with ellipsoids as rollers, measured elsewhere on such a platform: 39 to 46"
MECANUM = Path(__file__).parents[1] / "tests/reference/mecanum.toml"
WHEELS, FEWEST, MOST = (3, 4, 6, 8, 12), 3, 12
ROLLERS = (8, 64)
FINE = 2e-5  # s
STUCK = 0.2  # s: until then no wheel of a ring has come to its next roller
FULL_ROUNDS = 5  # fewer rounds are for the short ladder


class Setting(NamedTuple):
    """The platform: a motion, a kind of drives, a method and a step (s)."""

    motion: str
    drive: str
    method: str
    step: float


def measure(rounds: int) -> dict:
    steps = (0.1 / 7, 1.25e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4) if rounds >= FULL_ROUNDS else (1e-2, 2e-3)
    return {
        "platform": measure_platform(rounds, steps),
        "wheels": measure_wheels(rounds),
        "rollers": measure_rollers(rounds),
        "loop": outside.measure(rounds),
        "steps": measure_steps(rounds),
    }


# --- the platform: speed against error ------------------------------------------------------------


def measure_platform(rounds: int, steps: tuple[float, ...]) -> dict:
    """Error, work and median seconds of every setting, and what the reference says about the motion."""
    drives = ("rate", "torque")
    references = {(motion, drive): reference(motion, drive) for motion in MOTIONS for drive in drives}
    settings = [
        Setting(motion, drive, method, step)
        for drive in drives
        for motion in MOTIONS
        for method in CONVERGED
        for step in steps
    ]
    contestants: dict[tuple[str, Setting], Callable] = {}
    for setting in settings:
        scene = platform(*setting)
        contestants["simulate", setting] = partial(simulation, scene)
        contestants["march", setting] = partial(marching, scene)
    seconds = interleaved(contestants, rounds)
    return {
        "ladder": [ladder_row(setting, references[setting[:2]], seconds) for setting in settings],
        "motion": [motion_row(*key, run) for key, run in references.items()],
    }


def reference(motion: str, drive: str) -> Trajectory:
    """The converged run; RuntimeError if another method with another step says something else."""
    run, other = (omnisim.simulate(platform(motion, drive, method, step)) for method, step in CONVERGED.items())
    if not run.complete or not distances(run, other).max() < CONFIRMED:
        raise RuntimeError(f"{motion}, {drive} drives: the reference is not converged")
    return run


def distances(a: Trajectory, b: Trajectory) -> np.ndarray:
    """Of the positions in every row, m; infinite for a run that stopped."""
    if not (a.complete and b.complete):
        return np.array([math.inf])
    return np.linalg.norm(a["body/position"] - b["body/position"], axis=1)


def ladder_row(setting: Setting, converged: Trajectory, seconds: dict) -> dict:
    scene = platform(*setting)
    error, clock = distances(omnisim.simulate(scene), converged), ready(scene).go().run.clock
    ours = {what: seconds[what, setting] for what in ("march", "simulate")}
    return setting._asdict() | {
        "error_at_end": float(error[-1]),
        "error": float(error.max()),
        "events": int(clock.events),
        "evaluations": int(clock.rhs),
        "march": statistics.median(ours["march"]),
        "simulate": statistics.median(ours["simulate"]),
        "ratio": median_ratio(ours["simulate"], ours["march"]),
    }


def motion_row(motion: str, drive: str, run: Trajectory) -> dict:
    """Where the platform ends, where its wheels say that it does, and by how much it falls short of them."""
    (x, y), yaw = run["body/position"][-1, :2], run["body/yaw"][-1]
    wrong, wrong_yaw = run["odometry/position_error"][-1], run["odometry/yaw_error"][-1]
    gone, reported = math.hypot(x, y), math.hypot(x + wrong[0], y + wrong[1])
    return {
        "motion": motion,
        "drive": drive,
        "pose": [float(x), float(y), float(yaw)],
        "odometry_error": [float(wrong[0]), float(wrong[1]), float(wrong_yaw)],
        "short": 1.0 - gone / reported,
    }


def fastest(ladder: list[dict], drive: str) -> list[dict]:
    """For every motion the row of these drives that marches fastest of those that are ACCURATE."""
    rows = [row for row in ladder if row["drive"] == drive and row["error"] < ACCURATE]
    return [min((row for row in rows if row["motion"] == motion), key=lambda row: row["march"]) for motion in MOTIONS]


def slowest(result: dict, drive: str, what: str) -> float:
    """Times real time of march or simulate in the slowest of those motions."""
    return min(END / row[what] for row in fastest(result["platform"]["ladder"], drive))


# --- steps by wheels and rollers ------------------------------------------------------------------


def timed_steps(scenes: dict, rounds: int) -> tuple[dict, dict]:
    """Seconds of the rounds of every march, and what a step of it takes: ns, right-hand sides, events of the run."""
    seconds = interleaved({name: partial(marching, scene) for name, scene in scenes.items()}, rounds)
    found = {}
    for name, scene in scenes.items():
        clock, took = ready(scene).go().run.clock, statistics.median(seconds[name])
        found[name] = {
            "ns": took / clock.steps * 1e9,
            "evaluations": clock.rhs / clock.steps,
            "ns_evaluation": took / clock.rhs * 1e9,
            "events": int(clock.events),
        }
    return seconds, found


def measure_wheels(rounds: int) -> dict:
    """Rings of 3 to 12 wheels by both laws, without an exchange, each against the smallest by the same law."""
    result = {}
    for law in ("regularized", "coulomb"):
        scenes = {count: ring(count, law, step=FINE, end=STUCK) for count in WHEELS}
        seconds, found = timed_steps(scenes, rounds)
        result[law] = [
            {"wheels": count, "ratio": median_ratio(seconds[count], seconds[FEWEST])} | found[count] for count in WHEELS
        ]
    return result


def measure_rollers(rounds: int) -> dict:
    """Rings of four wheels with 8 and with 64 rollers, which speed up through exchanges."""
    few, many = ROLLERS
    result = {}
    for law in ("regularized", "coulomb"):
        scenes = {count: ring(4, law, step=1e-4, end=1.0, rollers=count) for count in ROLLERS}
        seconds, found = timed_steps(scenes, rounds)
        result[law] = {"few": found[few], "many": found[many], "ratio": median_ratio(seconds[many], seconds[few])}
    return result


def measure_steps(rounds: int) -> dict:
    """RK4 steps of FINE, which the regularized law needs: the bare wheel and machines, each against the bare wheel."""
    bare, fine = "bare wheel, regularized", f"time.step={FINE!r}"
    platforms = {kind: platform("forward", kind, "rk4", FINE, end=1.0) for kind in ("rate", "torque")}
    scenes = {
        bare: bare_wheel(FINE, end=1.0),
        "tests/reference/mecanum, 4 x 6, regularized": omnisim.load(MECANUM, [fine, "time.end=1.0"]),
        "kiwi, 3 x 18, coulomb, rate drives": omnisim.load("kiwi", [fine, "time.end=1.0"]),
        **{f"platform forward, 4 x 9, coulomb, {kind} drives": scene for kind, scene in platforms.items()},
    }
    seconds, found = timed_steps(scenes, rounds)
    return {name: row | {"ratio": median_ratio(seconds[name], seconds[bare])} for name, row in found.items()}


# --- report ---------------------------------------------------------------------------------------


def claims(result: dict) -> list[Claim]:
    """Of the platform in its slowest motion, of the wheels of a machine."""
    most = max(rows[-1]["ratio"] for rows in result["wheels"].values())
    platform_text = f"times real time of the march, platform on 4 x 9 mecanum rollers, position within {ACCURATE:g} m"
    wheels_text = f"a step of {MOST} wheels, by that of {FEWEST}"
    return [
        Claim(platform_text, slowest(result, "rate", "march"), "at least", TARGET, ALARM, AT_EVENTS),
        Claim(wheels_text, most, "at most", MOST / FEWEST, WHEELS_ALARM),
    ]


def report(result: dict) -> str:
    return "\n\n".join(
        [
            "The platform, 2 s with 21 rows. Errors are those of its position; simulate is the whole call:",
            ladder_table(result["platform"]["ladder"]),
            f"The fastest with an error below {ACCURATE:.0e} m in every row ({ELSEWHERE}):",
            fastest_table(result["platform"]["ladder"]),
            "Where it ends. Short: distance gone, against that of the odometry:",
            motion_table(result["platform"]["motion"]),
            "One RK4 step by the number of wheels, rings of omni wheels whose contacts all stick, no exchange:",
            wheels_table(result["wheels"]),
            "One RK4 step by the number of rollers, rings of four omni wheels:",
            rollers_table(result["rollers"]),
            "The kiwi drive stepped from outside, by its own step of 0.5 ms:",
            outside.loop_table(result["loop"]),
            f"One RK4 step of {FINE:.0e} s, in marches of 1 s, with the events of the run:",
            steps_table(result["steps"]),
        ]
    )


def ladder_table(ladder: list[dict]) -> str:
    header = ["drives", "motion", "method", "step, s", "error at the end, m", "error in any row, m", "events"]
    header += [
        "right-hand sides",
        "march, ms",
        "simulate, ms",
        "times real time, march",
        "simulate",
        "simulate / march",
    ]
    rows = [
        [row["drive"], row["motion"], row["method"], f"{row['step']:g}", f"{row['error_at_end']:.1e}"]
        + [f"{row['error']:.1e}", row["events"], row["evaluations"]]
        + [f"{row[what] * 1e3:.2f}" for what in ("march", "simulate")]
        + [f"{END / row[what]:.0f}" for what in ("march", "simulate")]
        + [f"{row['ratio']:.2f}"]
        for row in ladder
    ]
    return table(header, rows)


def fastest_table(ladder: list[dict]) -> str:
    header = ["drives", "motion", "method", "step, s", "error, m", "times real time, march", "simulate"]
    rows = [
        [row["drive"], row["motion"], row["method"], f"{row['step']:g}", f"{row['error']:.1e}"]
        + [f"{END / row[what]:.0f}" for what in ("march", "simulate")]
        for drive in ("rate", "torque")
        for row in fastest(ladder, drive)
    ]
    return table(header, rows)


def motion_table(motions: list[dict]) -> str:
    header = ["drives", "motion", "x, m", "y, m", "yaw, rad", "odometry off by x, mm", "y, mm", "yaw, mrad", "short"]
    rows = [
        [row["drive"], row["motion"]]
        + [f"{value + 0.0:.4f}" for value in np.round(row["pose"], 4)]
        + [f"{value + 0.0:.2f}" for value in np.round(1e3 * np.array(row["odometry_error"]), 2)]
        + [f"{row['short']:.2%}"]
        for row in motions
    ]
    return table(header, rows)


def wheels_table(rings: dict) -> str:
    header = ["wheels"] + [f"{law}{what}" for law in rings for what in (", ns per step", f", ratio to {FEWEST} wheels")]
    rows = [
        [row["wheels"]] + [cell for other in both for cell in (f"{other['ns']:.0f}", f"{other['ratio']:.2f}")]
        for both in zip(*rings.values(), strict=True)
        for row in both[:1]
    ]
    return table(header, rows)


def rollers_table(rings: dict) -> str:
    few, many = ROLLERS
    header = [
        "friction",
        f"{few} rollers, ns per step",
        f"{many} rollers",
        "events",
        "right-hand sides per step",
        "ratio",
    ]
    rows = [
        [
            law,
            f"{row['few']['ns']:.0f}",
            f"{row['many']['ns']:.0f}",
            f"{row['few']['events']}, {row['many']['events']}",
            f"{row['few']['evaluations']:.2f}, {row['many']['evaluations']:.2f}",
            f"{row['ratio']:.3f}",
        ]
        for law, row in rings.items()
    ]
    return table(header, rows)


def steps_table(steps: dict) -> str:
    header = ["machine", "ns per step", "ratio to the bare wheel", "right-hand sides per step", "ns for each", "events"]
    rows = [
        [
            name,
            f"{row['ns']:.0f}",
            f"{row['ratio']:.1f}",
            f"{row['evaluations']:.2f}",
            f"{row['ns_evaluation']:.0f}",
            row["events"],
        ]
        for name, row in steps.items()
    ]
    return table(header, rows)
