"""Random scenes of all laws and methods against tight reference runs: does each tell how far it is off?

A wheel, three omni wheels or four mecanum wheels, upright or free in space, in any state, with any law of friction, by
any method, tracking and formulation, with torques, a controller or nothing, on a level floor or a slope. Each asks for
errors below ERROR; the same scene by `radau5` for errors below TIGHT is what it is compared with.

    right       it ends within its own estimate of the error, with that of the reference
    stopped     it or its reference stops early and says so: compared as far as both have come
    less        shorter steps than it may take would be needed: it says how far it is off, more than asked for
    long        it takes more than LONGEST, is interrupted and says so
    unsure      no reference that knows its own error to a tenth of ERROR, or within LONGEST
    wrong       it is off by more than it says
    raised      an exception
    impossible  no scene
"""

import math
import statistics
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from bench.common import Claim, table
from omnisim.results.comparison import distance
from omnisim.results.layout import COMPLETE
from omnisim.results.trajectory import Trajectory
from omnisim.run.simulation import simulate
from omnisim.scene.scene import SceneError, load_text
from omnisim.scene.toml_text import rewrite
from omnisim.studies.workers import cores, on_cores

HUNDRED = 100  # scenes of a round
ERROR, TIGHT = 1e-6, 1e-8  # m, rad: what is asked of a scene and of its reference
LONGEST = 60.0  # s of wall time for one run
END, INTERVAL = 0.4, 0.05  # s, of upright machines
END_FREE, INTERVAL_FREE = 0.1, 0.0125  # s, of machines free in space, which take so much longer
FREE, EVERY_BODY = 0.25, 0.2  # shares of machines that are free; of all others, that go by the multibody formulation
BY_BS5 = 0.5  # share of the scenes by a method of order 5 that are by this one
THIN_LAYERS = 0.3  # share of the saturated law by "auto" whose layer of slip is thin
EXPLICIT, IMPLICIT = ("heun", "rk4", "dopri5"), ("radau5", "auto")
RIGHT, STOPPED, LESS, LONG, UNSURE, WRONG, RAISED, IMPOSSIBLE = VERDICTS = (
    "right", "stopped", "less", "long", "unsure", "wrong", "raised", "impossible",
)  # fmt: skip
FAULTS = (WRONG, RAISED)


class Outcome(NamedTuple):
    """What came of a scene: its number, what it is, the verdict, what the run said, its error and what that may be
    (m, rad), its wall time and that of the reference, s."""

    number: int
    kind: str
    verdict: str
    said: str = ""
    error: float = math.nan
    allowed: float = math.nan
    seconds: float = math.nan
    reference_seconds: float = math.nan


def random_scene(number: int) -> dict[str, Any]:
    """What the scene of this number says."""
    rng = np.random.default_rng([20, number])
    machine = str(rng.choice(["wheel", "omni", "mecanum"]))
    free = machine != "wheel" and rng.random() < FREE
    multibody = not free and rng.random() < EVERY_BODY
    end, interval = (END_FREE, INTERVAL_FREE) if free else (END, INTERVAL)
    rollers = int(rng.integers(4, 13))
    angle = {"wheel": float(rng.choice([0.0, 30.0, 45.0])), "omni": 0.0, "mecanum": 45.0}[machine]
    law = str(rng.choice(["coulomb", "regularized", "saturated", "viscous"], p=[0.4, 0.3, 0.2, 0.1]))
    scene = {
        "schema": 1,
        "time": {"end": end, "output_interval": interval},
        "solver": {
            "method": str(rng.choice(EXPLICIT if multibody else EXPLICIT + IMPLICIT)),
            "tracking": "explicit" if free or multibody else str(rng.choice(["explicit", "implicit"])),
            "formulation": "multibody" if multibody else "reduced",
            "error": ERROR,
        },
        "friction": friction(rng, law),
        "wheel_types": {"type": wheel_type(rng, rollers, angle, free)},
        "wheels": list(wheels(rng, machine, end)),
        "initial": {
            "velocity": rng.uniform(-1.0, 1.0, 2).tolist(),
            "yaw_deg": rng.uniform(-180.0, 180.0),
            "yaw_rate": rng.uniform(-3.0, 3.0),
        },
    }
    if rng.random() < 0.1:
        scene["initial"] |= {"velocity": [0.0, 0.0], "yaw_rate": 0.0}
    if machine != "wheel":
        height = rng.uniform(0.05, 0.15)
        inertia = rng.uniform(0.05, 0.1) + np.array([0.0, 0.02, 0.05])
        place = [*rng.uniform(-0.02, 0.02, 2).tolist(), height]
        scene["chassis"] = {"mass": rng.uniform(4.0, 15.0), "center_of_mass": place, "inertia": inertia.tolist()}
        if rng.random() < 0.3:
            scene["floor"] = {"slope_deg": rng.uniform(0.0, 12.0), "uphill_deg": rng.uniform(-180.0, 180.0)}
    if scene["solver"]["method"] == "dopri5" and np.random.default_rng([22, number]).random() < BY_BS5:
        scene["solver"]["method"] = "bs5"
    if free:
        scene["scene"] = {"upright": "free"}
    elif law == "saturated" and scene["solver"]["method"] == "auto":
        thin = np.random.default_rng([21, number])
        if thin.random() < THIN_LAYERS:
            scene["friction"]["slip_speed"] = 10.0 ** thin.uniform(-8.0, -6.0)
    return scene


def friction(rng: np.random.Generator, law: str) -> dict[str, Any]:
    """[friction] of a law."""
    if law == "viscous":
        return {"law": law, "viscosity": 10.0 ** rng.uniform(0.5, 2.5)}
    found = {"law": law, "coefficient": rng.uniform(0.1, 0.9)}
    return found if law == "coulomb" else found | {"slip_speed": 10.0 ** rng.uniform(-2.5, -0.7)}


def wheel_type(rng: np.random.Generator, rollers: int, angle: float, free: bool) -> dict[str, Any]:
    """A wheel of 50 mm with so many exact rollers, a little lighter or heavier than usual."""
    heavier = rng.uniform(0.5, 2.0)
    found = {
        "radius": 0.05,
        "roller_distance": 0.05 * rng.uniform(0.6, 0.95) * math.cos(math.pi / rollers),
        "roller_count": rollers,
        "roller_angle_deg": angle,
        "disk": {"mass": 0.4 * heavier, "inertia_axle": 5e-4 * heavier, "inertia_diameter": 3e-4 * heavier},
        "roller": {"mass": 0.02, "inertia_axial": 2e-6 * heavier, "inertia_transverse": 5e-6 * heavier},
    }
    if free:
        found["contact"] = {"stiffness": 10.0 ** rng.uniform(4.7, 5.7), "damping": rng.uniform(20.0, 200.0)}
    return found


def wheels(rng: np.random.Generator, machine: str, end: float) -> Iterator[dict[str, Any]]:
    """The wheels of a machine, with any spin rates and drives of one kind."""
    places: list[dict[str, Any]] = [{}]
    if machine == "omni":
        angles = [60.0, 180.0, 300.0]
        places = [
            {"position": [0.15 * math.cos(math.radians(a)), 0.15 * math.sin(math.radians(a))], "heading_deg": a + 90.0}
            for a in angles
        ]
    elif machine == "mecanum":
        corners = [(0.2, 0.15), (0.2, -0.15), (-0.2, 0.15), (-0.2, -0.15)]
        places = [{"position": [x, y], "heading_deg": 0.0, "mirrored": (x > 0.0) == (y > 0.0)} for x, y in corners]
    kind = rng.choice(["none", "torque", "rate"])
    still = rng.random() < 0.1
    for w, place in enumerate(places):
        found = {"name": f"w{w}", "type": "type", **place, "spin_rate": 0.0 if still else rng.uniform(-20.0, 20.0)}
        found["phase_deg" if machine != "wheel" else "spin_angle_deg"] = rng.uniform(0.0, 360.0)
        if kind == "torque":
            torques = rng.uniform(-1.0, 1.0, 2).tolist()
            found["drive"] = {"kind": "torque", "times": [0.0, end], "torque": torques}
        elif kind == "rate":
            found["drive"] = {"kind": "rate", "rate": rng.uniform(-20.0, 20.0), "proportional": rng.uniform(0.02, 0.2)}
        yield found


def ran(data: dict[str, Any]) -> tuple[Trajectory, float]:
    """The trajectory of a scene and its wall time, s, once its kernels are compiled; interrupted after LONGEST."""
    scene = load_text(rewrite("", [], data))
    begun: list[float] = []

    def late(_: float) -> bool:
        begun.append(time.perf_counter())
        return begun[-1] - begun[0] > LONGEST

    found = simulate(scene, late)
    return found, time.perf_counter() - begun[0]


def outcome(number: int) -> Outcome:
    """What comes of the scene of this number."""
    data = random_scene(number)
    solver = data["solver"]
    kind = " ".join(
        [
            str(len(data["wheels"])),
            data.get("scene", {}).get("upright", "upright"),
            data["friction"]["law"],
            *(solver[key] for key in ("method", "tracking", "formulation")),
        ]
    )
    try:
        found, seconds = ran(data)
    except SceneError as error:
        return Outcome(number, kind, IMPOSSIBLE, str(error))
    except Exception as error:
        return Outcome(number, kind, RAISED, repr(error))
    said = str(found.attributes["status"])
    if "interrupted" in said:
        return Outcome(number, kind, LONG, said, seconds=seconds)
    tight = solver | {"method": "radau5", "tracking": "explicit", "formulation": "reduced", "error": TIGHT}
    reference, longer = ran(data | {"solver": tight})
    apart = distance(found, reference)
    own, known = (float(each.attributes.get("error_estimate", math.inf)) for each in (found, reference))
    verdict = judged(said, str(reference.attributes["status"]), apart, own, known)
    return Outcome(number, kind, verdict, said, apart, own + known, seconds, longer)


def judged(said: str, reference_said: str, apart: float, own: float, known: float) -> str:
    """The verdict on a run that ended as it said and is so far apart from its reference, by the estimates of both."""
    if said != COMPLETE and not math.isfinite(own):  # it cannot begin, or no step can follow
        return STOPPED
    if "interrupted" in reference_said or not known <= 0.1 * ERROR:
        return UNSURE
    if said != COMPLETE or reference_said != COMPLETE:
        return STOPPED if apart <= own + known else WRONG
    if not math.isfinite(own):
        return LESS
    if apart > own + known:
        return WRONG
    return RIGHT if own <= ERROR else LESS


class Search:
    """Outcomes by number, as a task for processes."""

    def __call__(self, runs: Sequence[int]) -> list[Outcome]:
        return [outcome(number) for number in runs]

    def lost(self, run: int, how: str) -> Outcome:
        return Outcome(run, "", RAISED, f"its process was {how}")


def measure(rounds: int) -> dict:
    """Outcomes of so many hundred scenes: how many of each verdict, and all faults."""
    numbers = list(range(rounds * HUNDRED))
    return summary([one for rows in on_cores(Search(), numbers, cores(), lambda: False) for one in rows])


def summary(outcomes: list[Outcome]) -> dict:
    """What they come to."""
    found = sorted(outcomes)
    shares = [one.error / one.allowed for one in found if one.verdict == RIGHT]
    slowest = max((one for one in found if one.seconds == one.seconds), key=lambda one: one.seconds)
    return {
        "verdicts": dict(Counter(one.verdict for one in found)),
        "faults": [one._asdict() for one in found if one.verdict in FAULTS],
        "stops": dict(Counter(one.said.split(":")[0].split(" at ")[0][:60] for one in found if one.verdict == STOPPED)),
        "share": {"median": statistics.median(shares), "most": max(shares)} if shares else {},
        "seconds": statistics.median(one.seconds for one in found if one.seconds == one.seconds),
        "slowest": slowest._asdict(),
    }


def report(result: dict) -> str:
    rows = [[verdict, str(result["verdicts"].get(verdict, 0))] for verdict in VERDICTS]
    faults = [
        [one["number"], one["kind"], one["verdict"], one["said"], one["error"], one["allowed"]]
        for one in result["faults"]
    ]
    share, slowest = result["share"], result["slowest"]
    parts = [
        table(["verdict", "scenes"], rows),
        f"Errors of those that are right are {share['median']:.2f} of what they may be, in the middle, and "
        f"{share['most']:.2f} at most. A run takes {result['seconds']:.2g} s in the middle, the slowest "
        f"{slowest['seconds']:.3g} s ({slowest['kind']}).",
    ]
    if faults:
        told = [[str(a), b, c, d, f"{e:.1e}", f"{f:.1e}"] for a, b, c, d, e, f in faults]
        parts.append(table(["scene", "kind", "verdict", "said", "off by", "may be off by"], told))
    return "\n\n".join(parts)


def claims(result: dict) -> list[Claim]:
    verdicts = result["verdicts"]
    valid = sum(verdicts.values()) - verdicts.get(IMPOSSIBLE, 0)
    faults = sum(verdicts.get(verdict, 0) for verdict in FAULTS)
    return [
        Claim(
            f"random scenes that raise an exception, or err by more than they say, of {valid}",
            faults,
            "at most",
            0,
            valid // 20,
        )
    ]
