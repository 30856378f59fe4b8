"""What it costs to have every body: the multibody formulation beside the reduced one, by scene and by rollers.

The same scene, method and step; how far the motions lie apart is the error of the multibody one, which integrates
rotations that the reduced one has in closed form. Also what it costs to recover the loads of all bearings from the
reduced one: in every row, and after every step, for the largest between rows.
"""

import statistics
from functools import partial

import omnisim
from bench.common import Claim, interleaved, marching, median_ratio, ready, simulation, table
from bench.machine_scenes import platform, ring
from omnisim.results.comparison import distance
from omnisim.scene.scene import Scene, load, parse

FORMULATIONS = ("reduced", "multibody")
PACKAGED = {"coulomb_wheel": 1e-3, "kiwi": 1e-3, "youbot": 1e-3}  # s
ROLLERS = (8, 16, 32, 64)
WHEELS = 4
LINEAR = 1.15  # times the ratio of the numbers of bodies


def measure(rounds: int) -> dict:
    scenes = {name: {form: packaged(name, step, form) for form in FORMULATIONS} for name, step in PACKAGED.items()}
    still = platform("diagonal with yaw", "torque", "rk4", 1e-3)
    scenes["platform"] = {form: changed(still, form) for form in FORMULATIONS}
    rings = {
        rollers: {form: changed(ring(WHEELS, "regularized", 1e-4, 0.1, rollers), form) for form in FORMULATIONS}
        for rollers in ROLLERS
    }
    return {
        "scenes": {name: compared(pair, rounds) for name, pair in scenes.items()},
        "rollers": {str(rollers): stepped(pair, rounds) for rollers, pair in rings.items()},
        "recovery": recovery(scenes["platform"]["reduced"], rounds),
    }


def packaged(name: str, step: float, formulation: str) -> Scene:
    return load(name, [f"time={{end=2.0, step={step}, output_interval=0.1}}", f"solver.formulation={formulation}"])


def changed(scene: Scene, *overrides: str) -> Scene:
    """A scene of machine_scenes.py with its formulation or other keys changed."""
    named = [f"solver.formulation={key}" if key in FORMULATIONS else key for key in overrides]
    return parse(scene.text, scene.source, named)


def compared(pair: dict[str, Scene], rounds: int) -> dict:
    """Times of both marches, states of the second, and how far it ends from the first."""
    seconds = interleaved({form: partial(marching, scene) for form, scene in pair.items()}, rounds)
    runs = {form: omnisim.simulate(scene) for form, scene in pair.items()}
    end = pair["reduced"].config.time.end
    return {
        "step": pair["reduced"].config.time.step,
        "states": {form: len(ready(scene).run.y) for form, scene in pair.items()},
        "times_real_time": {form: end / statistics.median(seconds[form]) for form in FORMULATIONS},
        "ratio": median_ratio(seconds["multibody"], seconds["reduced"]),
        "apart": distance(runs["reduced"], runs["multibody"]),
    }


def stepped(pair: dict[str, Scene], rounds: int) -> dict:
    """Nanoseconds of a step of a ring of omni wheels by both formulations."""
    seconds = interleaved({form: partial(marching, scene) for form, scene in pair.items()}, rounds)
    steps, rollers = pair["reduced"].config.time.steps, pair["reduced"].config.wheel_types["wheel"].roller_count
    bodies = 1 + WHEELS * (1 + rollers)
    taken = {form: statistics.median(seconds[form]) / steps * 1e9 for form in FORMULATIONS}
    ratio = median_ratio(seconds["multibody"], seconds["reduced"])
    return {"bodies": bodies, "ns": taken, "ns_by_body": taken["multibody"] / bodies, "ratio": ratio}


def recovery(scene: Scene, rounds: int) -> dict:
    """The whole of omnisim.simulate with and without the loads of the bearings."""
    contestants = {"without": scene, "with": changed(scene, "output.bearing_loads=true")}
    seconds = interleaved({name: partial(simulation, scene) for name, scene in contestants.items()}, rounds)
    taken = {name: statistics.median(values) * 1e3 for name, values in seconds.items()}
    return {
        "ms": taken,
        "ratio": median_ratio(seconds["with"], seconds["without"]),
        "rows": scene.config.time.outputs + 1,
        "steps": scene.config.time.steps,
        "bearings": sum(1 + scene.config.wheel_types[wheel.type].roller_count for wheel in scene.config.wheels),
    }


def report(result: dict) -> str:
    header = ["scene", "RK4 step, s", "states, reduced", "multibody", "times real time, reduced", "multibody",
              "multibody / reduced", "apart after the run, m or rad"]  # fmt: skip
    lines = [
        [name, f"{row['step']:g}", *(row["states"][form] for form in FORMULATIONS),
         *(f"{row['times_real_time'][form]:.0f}" for form in FORMULATIONS), f"{row['ratio']:.1f}",
         f"{row['apart']:.1e}"]
        for name, row in result["scenes"].items()
    ]  # fmt: skip
    by_rollers = [
        [rollers, row["bodies"], *(f"{row['ns'][form]:.0f}" for form in FORMULATIONS), f"{row['ratio']:.1f}",
         f"{row['ns_by_body']:.0f}"]
        for rollers, row in result["rollers"].items()
    ]  # fmt: skip
    found = result["recovery"]
    return "\n\n".join(
        [
            table(header, lines),
            f"One RK4 step of a ring of {WHEELS} omni wheels, by the number of rollers on each:",
            table(["rollers", "bodies", "reduced, ns", "multibody, ns", "ratio", "ns for each body"], by_rollers),
            f"Loads of all bearings of the platform recovered in {found['rows']} rows and after every step between: "
            f"`omnisim.simulate` takes {found['ms']['with']:.2f} ms instead of {found['ms']['without']:.2f} "
            f"({found['ratio']:.2f} times).",
        ]
    )


def of_a_step(recovery: dict) -> str:
    """What the loads of all bearings cost beside a step: the largest between rows are those of the whole march."""
    step, with_loads = (recovery["ms"][name] / recovery["steps"] * 1e6 for name in ("without", "with"))
    bearings = recovery["bearings"]
    return (
        f"For the largest between rows, forces and moments at {bearings} bearings are found after every step: "
        f"{(with_loads - step) / bearings:.0f} ns each beside {step:.0f} ns of the step and its share of all else"
    )


def claims(result: dict) -> list[Claim]:
    few, many = (result["rollers"][str(rollers)] for rollers in (ROLLERS[0], ROLLERS[-1]))
    growth, bodies = many["ns"]["multibody"] / few["ns"]["multibody"], many["bodies"] / few["bodies"]
    recovered = result["recovery"]["ratio"]
    return [
        Claim("a multibody step by that with an eighth of the rollers, by the ratio of the numbers of bodies",
              growth / bodies, "at most", LINEAR, 2.0),
        Claim("omnisim.simulate with the loads of all bearings recovered, by that without", recovered, "at most",
              1.2, 2.0, of_a_step(result["recovery"])),
    ]  # fmt: skip
