"""The scenes of precision.py and accuracy.py, from easy to hard, with their methods, steps and bounds."""

from collections.abc import Callable
from functools import partial
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from bench.alike import Alike
from bench.machine_scenes import platform
from omnisim.run.work_precision import Setting, ladder
from omnisim.scene.scene import Scene, parse

NEAR_LIMIT = Path(__file__).parent / "scenes/near_limit.toml"
METHODS = ("heun", "rk4", "dopri5", "bs5", "radau5", "auto")
ALARMS = {"heun": 1.7, "rk4": 3.5, "dopri5": 4.3, "bs5": 4.3}  # orders
PLATFORM_TITLE = "title='A platform on four mecanum wheels, diagonal with yaw by rate drives'"
THROWN = ('title="The authors\' vehicle, thrown ahead while it turns"', "initial.velocity=[1.0, 0.0]", "time.end=2.0")


class Speed(NamedTuple):
    """How many times real time some method should march with errors below a limit."""

    limit: float
    target: float
    alarm: float


class Entry(NamedTuple):
    """A scene with its methods and steps (s; none: the ladder of `omnisim bench`).

    bounds: of the error by method at the scene's own step.
    alarms: of the observed orders by method; slow slip and late events let a ladder tell less than a method's own.
    tracked: methods that run with implicit contact tracking as well.
    alike: of machines that begin as it does, whose orders count instead of its own, which are a matter of chance.
    """

    scene: Callable[[], Scene]
    bounds: dict[str, float]
    alarms: dict[str, float] = ALARMS
    methods: tuple[str, ...] = METHODS
    steps: tuple[float, ...] = ()
    tracked: tuple[str, ...] = ()
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


def chosen(quick: bool) -> tuple[dict[str, Entry], tuple[str, ...]]:
    """The scenes by name and the methods."""
    names, methods = QUICK if quick else (tuple(ENTRIES), METHODS)
    return {name: ENTRIES[name] for name in names}, methods
