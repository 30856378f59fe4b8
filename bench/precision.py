"""Speed against error, from easy scenes to hard ones: what `omnisim bench` measures, by scenes chosen for it.

The reference of each scene is computed on the spot and confirmed by another method; see `omnisim.precision`.
"""

import math
from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from bench import alike
from bench.alike import Alike
from bench.common import Claim, table
from bench.machine_scenes import platform
from omnisim.base import methods
from omnisim.run import work_precision
from omnisim.run.work_precision import Setting, finest_orders, ladder
from omnisim.scene.scene import Scene, parse
from omnisim_cli.bench_report import GOALS, LEGEND, scene_data, section, winner

NEAR_LIMIT = Path(__file__).parent / "scenes/near_limit.toml"
METHODS = ("heun", "rk4", "dopri5", "bs5", "radau5", "auto")
TARGETS = {"heun": 1.9, "rk4": 3.8, "dopri5": 4.7, "bs5": 4.7}  # orders
ALARMS = {"heun": 1.7, "rk4": 3.5, "dopri5": 4.3, "bs5": 4.3}
PLATFORM_TITLE = "title='A platform on four mecanum wheels, diagonal with yaw by rate drives'"
THROWN = ('title="The authors\' vehicle, thrown ahead while it turns"', "initial.velocity=[1.0, 0.0]", "time.end=2.0")

NO_REASONS: dict[str, str] = {}


class Speed(NamedTuple):
    """How many times real time some method should march with errors below a limit."""

    limit: float
    target: float
    alarm: float


COARSE_SUB_STEPS = (
    "With long steps, sub-steps of slip are as coarse as is safe, and err less than a power of the step says; from "
    "2e-3 to 5e-4 s the order is 5.0 (`tests/laws/test_slow_slip.py`), by errors too small to tell one here"
)


class Entry(NamedTuple):
    """A scene with its methods and steps (s; none: the ladder of `omnisim bench`).

    bounds: of the error by method at the scene's own step.
    alarms: of the observed orders by method; slow slip and late events let a ladder tell less than a method's own.
    tracked: methods that run with implicit contact tracking as well.
    reasons: by method, why an order is less than it should be.
    alike: of machines that begin as it does, whose orders count instead of its own, which are a matter of chance.
    """

    scene: Callable[[], Scene]
    bounds: dict[str, float]
    alarms: dict[str, float] = ALARMS
    methods: tuple[str, ...] = METHODS
    steps: tuple[float, ...] = ()
    tracked: tuple[str, ...] = ()
    reasons: dict[str, str] = NO_REASONS
    speeds: tuple[Speed, ...] = ()
    alike: Alike | None = None

    def settings(self, methods: tuple[str, ...]) -> list[Setting]:
        """Of those methods that are the scene's as well."""
        explicit = product([method for method in self.methods if method in methods], ["explicit"])
        pairs = [*explicit, *product(self.tracked, ["implicit"])]
        return [Setting(*pair, step) for pair in pairs for step in ladder(self.scene(), self.steps)]


def near_limit_alike(generator: np.random.Generator) -> list[str]:
    """The velocity of one that begins as near_limit does, within 1 cm/s and 0.01 rad/s."""
    ahead, aside, yaw_rate = generator.uniform(-0.01, 0.01, 3).tolist()
    return [f"initial.velocity=[{0.5 + ahead!r}, {0.2 + aside!r}]", f"initial.yaw_rate={1.0 + yaw_rate!r}"]


ENTRIES = {
    "six_rollers": Entry(partial(omnisim.load, "six_rollers"), {"rk4": 1e-9}, tracked=("rk4", "dopri5")),
    "coulomb_wheel": Entry(
        partial(omnisim.load, "coulomb_wheel", ["time.output_interval=0.1"]),
        {"rk4": 5e-9, "dopri5": 1e-10},
        steps=(1.25e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4),
        reasons={"dopri5": COARSE_SUB_STEPS},
        speeds=(Speed(1e-6, 10000.0, 2000.0),),
    ),
    "authors_testbench": Entry(
        partial(omnisim.load, "authors_testbench", ["time.end=1.0"]), {"rk4": 1e-12}, steps=(1e-2, 1e-3, 1e-4, 5e-6)
    ),
    "near_limit": Entry(
        lambda: parse(NEAR_LIMIT.read_text(encoding="utf-8"), "near_limit"),
        {"rk4": 5e-5, "dopri5": 5e-7},
        steps=(1e-2, 5e-3, 1 / 300, 2.5e-3, 2e-3, 1e-3, 5e-4),
        alike=near_limit_alike,
        speeds=(Speed(1e-5, 1000.0, 250.0),),
    ),
    "kiwi": Entry(partial(omnisim.load, "kiwi"), {"rk4": 1e-10}),
    "platform": Entry(
        lambda: parse(platform("diagonal with yaw", "rate", "rk4", 1e-3).text, "platform", [PLATFORM_TITLE]),
        {"rk4": 1e-7},
        steps=(1e-2, 0.1 / 12, 5e-3, 0.1 / 36, 2e-3, 1e-3, 0.1 / 150, 5e-4),
        speeds=(Speed(1e-9, 500.0, 60.0),),
    ),
    "authors_vehicle": Entry(
        partial(omnisim.load, "authors_vehicle", THROWN),
        {"auto": 1e-6},
        methods=("rk4", "radau5", "auto"),
        speeds=(Speed(1e-6, 100.0, 30.0),),
    ),
}
QUICK = ("six_rollers", "coulomb_wheel"), ("rk4", "dopri5")  # scenes and methods
FULL_ROUNDS = 5  # fewer rounds are for the quick ones


def measure(rounds: int) -> dict:
    """By scene: the numbers of `omnisim bench`, orders by method, the scene's own step, and what the command says."""
    names, methods = QUICK if rounds < FULL_ROUNDS else (tuple(ENTRIES), METHODS)
    return {name: measure_entry(ENTRIES[name], methods, rounds) for name in names}


def measure_entry(entry: Entry, methods: tuple[str, ...], rounds: int) -> dict:
    scene = entry.scene()
    found = work_precision.measure(scene, entry.settings(methods), rounds)
    orders = {method: order for (method, tracking), order in finest_orders(found).items() if tracking == "explicit"}
    over_many = {}
    if entry.alike is not None:
        over_many = alike.orders(scene, entry.alike, [method for method in methods if method in TARGETS], entry.steps)
    return scene_data(found) | {
        "own_step_s": scene.config.time.step,
        "orders": orders | {method: order for method, (order, _) in over_many.items()},
        "alike": over_many,
        "winners": [winner(found, goal) for goal in GOALS],
        "report": "\n\n".join([*section(found), *([alike.told(over_many)] if over_many else [])]),
    }


def report(result: dict) -> str:
    header = ["scene", "friction", *(f"fastest with errors below {goal:.0e}" for goal in GOALS), "observed orders"]
    rows = []
    for name, data in result.items():
        errors = {method: f" ± {error:.2f}" for method, (_, error) in data["alike"].items()}
        told = ((method, order) for method, order in data["orders"].items() if method in TARGETS)
        orders = ", ".join(f"{method} {order:.2f}{errors.get(method, '')}" for method, order in told)
        rows.append([name, data["law"], *data["winners"], orders or "-"])
    scenes = (f"### {data['title']}\n\n{data['report']}" for data in result.values())
    return "\n\n".join([table(header, rows), LEGEND.replace("*:", "\\*:"), *scenes])


def claims(result: dict) -> list[Claim]:
    """Orders where the errors tell them, and errors at the scene's own step."""
    found = []
    for name, data in result.items():
        for method, order in data["orders"].items():
            if method in TARGETS:
                limits = TARGETS[method], ENTRIES[name].alarms[method]
                reason = ENTRIES[name].reasons.get(method, "")
                found.append(Claim(f"observed order of {method}, {name}", order, "at least", *limits, reason))
        for method, bound in ENTRIES[name].bounds.items():
            (error,) = (row["error"] for row in data["rows"] if own_step(row, method, data["own_step_s"]))
            text = f"error by {method} at {data['own_step_s']:g} s, {name}"
            found.append(Claim(text, math.nan if error is None else error, "at most", bound, bound))
        for speed in ENTRIES[name].speeds:
            rows = [row for row in data["rows"] if below(row, speed.limit)]
            fastest = max(rows, key=times_real_time, default=None)
            text = f"times real time with errors below {speed.limit:g}, {name}"
            value, reason = (times_real_time(fastest), spent(fastest)) if fastest else (0.0, "")
            found.append(Claim(text, value, "at least", speed.target, speed.alarm, reason))
    return found


def spent(row: dict) -> str:
    """What a march by an explicit method did beside the stages of its steps."""
    own = methods.METHODS[row["method"]].tableau.stages * row["steps"]
    return (
        f"By `{row['method']}` at {row['step_s']:g} s, {row['rhs_evaluations']} right-hand sides: {own} of its steps, "
        f"the others of {row['events']} events and of slow slip"
    )


def below(row: dict, limit: float) -> bool:
    return row["error"] is not None and row["error"] < limit


def times_real_time(row: dict) -> float:
    return 1.0 / row["wall_s_per_simulated_s"]


def own_step(row: dict, method: str, step: float) -> bool:
    return (row["method"], row["tracking"], row["step_s"]) == (method, "explicit", step)
