"""A machine free in space: what a step costs beside a plain C loop, by its rollers, and what methods make of bumps.

The machine is that of bump_scene.py, four mecanum wheels of six rollers on rubber. For the cost of a step it coasts
on a plane at 0.5 m/s without torque; contacts that begin and end are located. There slip_speed is 0.1 m/s: at the
0.03 m/s of the reference a bounce lets rollers relax faster than RK4 at 1e-4 s can follow. A step costs the same.

Rollers: each of 24 a wheel is as heavy as one of six, its axial inertia in proportion to the square of its radius, and
the chassis lighter by what they weigh more. Rolling, more of them touch: neighbours share the rubber over 6 deg on
either side of an exchange, and exchanges come every 60 or every 15 deg. Standing on the middle of a roller, or on the
edge of two, as many touch either way: what differs are those in the air. So it is rolling on rubber that is 16 times
as stiff, where neighbours share it over a quarter of that angle: what differs are the exchanges. The rubber is damped
more than in the reference, or the exchanges of 24 rollers, at 40 Hz, make the machine hop.
"""

import math
import statistics
from collections.abc import Callable
from functools import partial

import omnisim
from bench.bump_scene import STEM, bumps, end, outcome
from bench.common import Claim, bare_wheel, interleaved, marching, quiet, ready, simulation, table
from bench.peers import c_loop
from omnisim.scene.scene import Scene, changed

STEP = 1e-4  # s
COASTING = 0.2  # s, of a march on the plane: short enough to fit between the turns of neighbours
MARCHES_PER_ROUND = 200
FEW_MARCHES_PER_ROUND = 20  # of those that take thirty times as long
TARGET, ALARM = 10.0, 30.0  # steps of the C loop
ROLLERS_TARGET, ROLLERS_ALARM = 1.1, 2.5  # times the machine with six
COUNTS = {6: (), 24: (
    "wheel_types.type0.roller_count=24",
    "wheel_types.type0.roller_distance=0.0445",
    "wheel_types.type0.roller={mass=0.05, inertia_axial=4.1e-7, inertia_transverse=1e-6}",
    "chassis.mass=16.4",
)}  # fmt: skip
# Neighbours share the rubber over an angle that falls with the root of its stiffness: here over a quarter.
FIRM = {"wheel_types.type0.contact.stiffness": 3.2e6, "wheel_types.type0.contact.damping": 6000.0}
DAMPED = "wheel_types.type0.contact.damping=1500.0"
LADDER = {"rk4": (3.2e-5, 2e-5, 1e-5), "dopri5": (2e-5,), "auto": (2e-3, 1e-3, 5e-4), "radau5": (1e-3, 5e-4)}
SHORT = {"rk4": (2e-5,)}
FULL_ROUNDS = 3  # fewer rounds are for the short ladder
NOTES = """Errors at 1.6 s, of the position and of the orientation, against the reference, which is good to 1e-9 m. With
larger steps than these rk4 and dopri5 stop: friction relaxes slip faster than they can follow."""


def on_plane(*overrides: str) -> Scene:
    """The machine on a plane, on rubber that carries it from the start."""
    free = [f"wheels.{name}.drive.torque=[0.0, 0.0]" for name in ("fl", "fr", "rl", "rr")]
    plane = ("floor={slope_deg=0.0}", "friction.slip_speed=0.1", "initial={velocity=[0.5, 0.0]}")
    time = (f"time.step={STEP!r}", f"time.end={COASTING!r}", f"time.output_interval={COASTING / 2!r}")
    return omnisim.load(STEM.with_suffix(".toml"), (*plane, *free, *time, *overrides))


def still(phase_deg: float = 0.0) -> list[str]:
    """Overrides: at rest, every wheel so far beside the middle of a roller."""
    values = {"phase_deg": phase_deg, "spin_rate": 0.0}
    wheels = [f"wheels.{name}.{key}={value!r}" for name in ("fl", "fr", "rl", "rr") for key, value in values.items()]
    return ["initial={velocity=[0.0, 0.0]}", *wheels]


def of_rollers() -> dict[str, dict[int, Scene]]:
    """The machines with each of COUNTS: rolling, standing on one roller a wheel, and on two."""
    starts: dict[str, Callable[[int], list[str]]] = {
        "rolling": lambda count: [],
        "standing on one": lambda count: still(),
        "standing on two": lambda count: still(180.0 / count),
    }
    found = {
        name: {count: on_plane(DAMPED, *rollers, *start(count)) for count, rollers in COUNTS.items()}
        for name, start in starts.items()
    }
    few, many = found["rolling"].values()
    return {**found, "rolling, as many touch": {6: few, 24: changed(many, FIRM)}}


def measure(rounds: int) -> dict:
    """Of a step on the plane, by rollers, and over the bumps."""
    ladder = LADDER if rounds >= FULL_ROUNDS else SHORT
    return {
        "step": beside_c(rounds),
        "rollers": by_rollers(rounds),
        "laws": by_law(rounds),
        "bumps": over_bumps(ladder, rounds),
    }


def beside_c(rounds: int) -> dict:
    """ns of a step of the machine and of the C loop of the bare wheel, in quiet rounds; empty without a compiler."""
    library = c_loop.build(c_loop.WHEEL)
    if library is None:
        return {}
    plane, wheel = on_plane(), bare_wheel(STEP, end=0.5)
    contestants = {
        "machine": partial(marching, plane),
        "C": lambda: c_loop.prepare(c_loop.WHEEL, library, ready(wheel)),
    }
    seconds = quiet(interleaved(contestants, MARCHES_PER_ROUND * rounds))
    ns = {"machine": seconds["machine"] / ready(plane).steps * 1e9, "C": seconds["C"] / ready(wheel).steps * 1e9}
    return {"ns_per_step": ns, "ratio": ns["machine"] / ns["C"], **counted(plane)}


def counted(scene: Scene) -> dict[str, float]:
    """Events, right-hand sides by the step, and contacts by the wheel in a march."""
    done = ready(changed(scene, {"time.output_interval": STEP})).go()
    contacts = float(done.rows.mode["contacts"].mean())
    clock = done.run.clock
    return {"events": int(clock.events), "rhs_per_step": float(clock.rhs / done.steps), "contacts": contacts}


def by_rollers(rounds: int) -> dict:
    """ns of a step of each machine of `of_rollers`; of 24 rollers by 6 the ratio, and that of right-hand sides."""
    result = {}
    for name, scenes in of_rollers().items():
        contestants = {str(count): partial(marching, scene) for count, scene in scenes.items()}
        seconds = quiet(interleaved(contestants, MARCHES_PER_ROUND * rounds))
        rows = {
            count: {"ns_per_step": seconds[count] / (COASTING / STEP) * 1e9, **counted(scenes[int(count)])}
            for count in seconds
        }
        few, many = rows.values()
        ratios = {key: many[of] / few[of] for key, of in (("ratio", "ns_per_step"), ("rhs_ratio", "rhs_per_step"))}
        result[name] = {"rows": rows, **ratios}
    return result


def by_law(rounds: int) -> dict[str, dict[str, float]]:
    """The machine that rolls, with the smooth law and with the set-valued one, whose contacts hold one another."""
    coefficient = bumps().config.friction.coefficient
    set_valued = f"friction={{law='coulomb', coefficient={coefficient!r}}}"
    scenes = {"regularized": on_plane(DAMPED), "coulomb": on_plane(DAMPED, set_valued)}
    contestants = {law: partial(marching, scene) for law, scene in scenes.items()}
    seconds = quiet(interleaved(contestants, FEW_MARCHES_PER_ROUND * rounds))
    return {
        law: {"ns_per_step": seconds[law] / (COASTING / STEP) * 1e9, **counted(scene)} for law, scene in scenes.items()
    }


def over_bumps(ladder: dict[str, tuple[float, ...]], rounds: int) -> list[dict]:
    """Errors at the end, and seconds of march and simulate, of every method and step, in turn."""
    settings = [(method, step) for method, steps in ladder.items() for step in steps]
    rows = [{"method": method, "step": step} | outcome(bumps(method, step)) for method, step in settings]
    whole = [(row["method"], row["step"]) for row in rows if row["position_error"] < math.inf]
    contestants: dict[object, Callable] = {("march", *one): partial(marching, bumps(*one)) for one in whole}
    contestants |= {("simulate", *one): partial(simulation, bumps(*one)) for one in whole}
    seconds = interleaved(contestants, rounds)
    for row in rows:
        for what in ("march", "simulate"):
            found = seconds.get((what, row["method"], row["step"]))
            row[what] = statistics.median(found) if found else math.inf
    return rows


def report(result: dict) -> str:
    step = result["step"]
    said = "No gcc on this machine: a step is not measured beside the C loop."
    if step:
        said = (
            f"On a plane a step of RK4 takes {step['ns_per_step']['machine']:.0f} ns, of the bare wheel in C "
            f"{step['ns_per_step']['C']:.0f} ns: {step['ratio']:.1f} of them. {step['events']} events in "
            f"{COASTING:g} s, {step['rhs_per_step']:.2f} right-hand sides a step."
        )
    rollers = [
        [
            name,
            count,
            f"{row['ns_per_step']:.0f}",
            row["events"],
            f"{row['rhs_per_step']:.2f}",
            f"{row['contacts']:.2f}",
            f"{row['ns_per_step'] / row['rhs_per_step']:.0f}",
        ]
        for name, of in result["rollers"].items()
        for count, row in of["rows"].items()
    ]
    counts = [f"events in {COASTING:g} s", "right-hand sides a step", "contacts a wheel"]
    header = ["", "rollers a wheel", "ns per step", *counts, "ns per right-hand side"]
    rolling = result["rollers"]["rolling"]
    ratio, more = rolling["ratio"], rolling["rhs_ratio"]
    shares = (
        f"Rolling, 24 rollers take {ratio:.2f} times as long as 6: {more:.2f} times by right-hand sides at events, "
        f"{ratio / more:.2f} times by what one takes with more contacts."
    )
    smooth, valued = result["laws"]["regularized"], result["laws"]["coulomb"]
    slower = valued["ns_per_step"] / smooth["ns_per_step"]
    more = valued["rhs_per_step"] / smooth["rhs_per_step"]
    laws = (
        f"With set-valued friction the one with 6 takes {slower:.1f} times as long, rolling: {more:.1f} times by "
        f"right-hand sides and {slower / more:.1f} times by what one takes."
    )
    columns = ["method", "step, s", "position off by, mm", "turned off by, rad", "times real time, march", "simulate"]
    return "\n\n".join(
        [
            said,
            table(header, rollers),
            shares,
            laws,
            "Over two bumps of 12 and 8 mm, up to its end:",
            table(columns, [[row["method"], f"{row['step']:g}", *cells(row)] for row in result["bumps"]]),
            NOTES,
        ]
    )


def cells(row: dict) -> list[str]:
    if row["position_error"] == math.inf:
        return ["fails", "-", "-", "-"]
    times = [f"{end() / row[what]:.2f}" for what in ("march", "simulate")]
    return [f"{row['position_error'] * 1e3:.1e}", f"{row['turn_error']:.1e}", *times]


def touching(of: dict) -> str:
    """What more of them cost: not those in the air, but those that touch, and exchanges."""
    few, many = (of["rows"][str(count)] for count in COUNTS)
    return (
        f"Of 24 rollers {many['contacts']:.2f} touch, of six {few['contacts']:.2f}; four times the exchanges take "
        f"{of['rhs_ratio']:.2f} times the right-hand sides"
    )


def claims(result: dict) -> list[Claim]:
    found = [
        Claim(
            f"a step of a free mecanum machine with 24 rollers a wheel, by that with 6, {name}",
            of["ratio"],
            "at most",
            ROLLERS_TARGET,
            ROLLERS_ALARM,
            touching(of),
        )
        for name, of in result["rollers"].items()
    ]
    if not result["step"]:
        return found
    text = "a step of a free mecanum machine on a plane, events located, by that of the bare wheel's C loop"
    return [Claim(text, result["step"]["ratio"], "at most", TARGET, ALARM), *found]
