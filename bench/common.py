"""What the benchmarks share: scenes, marches without output, interleaved timing, claims, tables."""

import math
import statistics
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

import numpy as np

import omnisim
from omnisim.base.methods import METHODS, Stages
from omnisim.base.status import COMPLETE, EVENTS_PER_STEP
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import Recording, Run
from omnisim.march.event_log import EVENT
from omnisim.march.initial_state import begin, blank_rows
from omnisim.march.march import march
from omnisim.results.trajectory import Trajectory
from omnisim.scene.scene import Scene, parse

QUIET = 0.1  # of the rounds, those that count where little is between contestants
ROLLER_RATES = (3.0, -2.0, 5.0, 1.0, -4.0, 2.0)
SCENE = """
schema = 1
time = {{ end = {end!r}, step = {step!r}, output_interval = {interval!r} }}
solver = {{ method = "{method}", tracking = "{tracking}" }}
friction = {{ law = "regularized", coefficient = 0.4, slip_speed = 0.05 }}
initial = {{ velocity = [0.5, 0.3], yaw_deg = 22.918311805232932, yaw_rate = 1.2 }}
[[wheels]]
name = "wheel"
type = "omni"
spin_angle_deg = 5.729577951308233
spin_rate = 12.0
roller_rates = {rates}
drive = {{ kind = "torque", torque = {torque!r} }}
[wheel_types.omni]
radius = 0.05
roller_distance = 0.04
roller_count = {rollers}
roller_angle_deg = {psi!r}
disk = {{ mass = 0.5, inertia_axle = 0.0004, inertia_diameter = 0.00022 }}
roller = {{ mass = 0.03, inertia_axial = 6e-06, inertia_transverse = 9e-06 }}
"""


def bare_wheel(
    step: float,
    end: float = 2.0,
    interval: float = 0.05,
    rollers: int = 6,
    psi: float = 0.0,
    torque: float = 0.0,
    method: str = "rk4",
    tracking: str = "explicit",
) -> Scene:
    """A bare wheel, by default the one of tests/reference/testbench_psi0."""
    rates = [ROLLER_RATES[i % len(ROLLER_RATES)] for i in range(rollers)]
    return parse(SCENE.format(**locals()), "bench")


class March(NamedTuple):
    """A march ready to go: what `stepper.march` takes."""

    parameters: Parameters
    stages: Stages
    run: Run
    rows: Recording
    log: np.recarray

    @property
    def steps(self) -> int:
        return int(self.run.clock.steps)

    @property
    def steps_per_row(self) -> int:
        return int(self.run.clock.steps_per_row)

    def go(self) -> "March":
        """March to the end; the rows and the log are filled, the run is spent."""
        self.run.clock.pause = np.iinfo(np.int64).max
        status = march(*self)
        if status != COMPLETE:
            raise RuntimeError(f"the march stopped with status {status}")
        return self


def ready(scene: Scene) -> March:
    """The march of a scene, with room for all its events."""
    config = scene.config
    parameters = pack(config)
    run = begin(config, parameters)
    rows = blank_rows(run, config.time.outputs + 1, config.bearing_loads, bool(parameters.machine.odometry))
    log = np.zeros(4 * EVENTS_PER_STEP, EVENT).view(np.recarray)
    return March(parameters, METHODS[config.solver.method].stages, run, rows, log)


def simulation(scene: Scene) -> Callable[[], Trajectory]:
    """A contestant: a call after another of its kind, since after long marches by others the first is cold."""
    omnisim.simulate(scene)
    return partial(omnisim.simulate, scene)


def marching(scene: Scene) -> Callable[[], object]:
    """The march of a scene, ready to go: a contestant, after another of its kind too."""
    ready(scene).go()
    return ready(scene).go


def interleaved(
    contestants: dict[str, Callable[[], Callable[[], object]]],
    rounds: int,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, list[float]]:
    """Seconds of every round of every contestant, round by round in turn, after one unmeasured round.

    A contestant is a function that prepares (not timed) and returns the function to time. clock: by default wall time;
    time.process_time where all of them run in this one thread and take milliseconds, since a busy machine interrupts
    those above all that take longer than its turns.
    """
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    for number in range(rounds + 1):
        for name, prepare in contestants.items():
            timed = prepare()
            begun = clock()
            timed()
            if number:
                seconds[name].append(clock() - begun)
    return seconds


def median_ratio(numerator: list[float], denominator: list[float]) -> float:
    """Median over the rounds of the ratio within a round: slow spells of the machine cancel."""
    return statistics.median(a / b for a, b in zip(numerator, denominator, strict=True))


def quiet(seconds: dict[str, list[float]]) -> dict[str, float]:
    """Mean of each contestant over the tenth of the rounds that took least in all."""
    rounds = np.array(list(seconds.values()))
    least = np.argsort(rounds.sum(axis=0))[: math.ceil(QUIET * rounds.shape[1])]
    return dict(zip(seconds, rounds[:, least].mean(axis=1).tolist(), strict=True))


def rates_in_turn(contestants: dict[str, Callable[[], int]], rounds: int) -> dict[str, list[float]]:
    """How much every contestant does a second, round by round in turn, each after another go of its own: threads that
    others have kept from their core wake late at first.

    A contestant is a function that returns how much it has done.
    """
    rates: dict[str, list[float]] = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, go in contestants.items():
            go()
            begun = time.perf_counter()
            done = go()
            rates[name].append(done / (time.perf_counter() - begun))
    return rates


class Claim(NamedTuple):
    """What is claimed of a measured value: that it is `bound`, "at most" or "at least", the target.

    alarm: the limit beyond which no noise of a machine explains the value; where nothing is timed, the target itself.
    reason: why the target cannot be met, by what was measured; told where it is missed.
    """

    text: str
    value: float
    bound: str
    target: float
    alarm: float
    reason: str = ""

    @property
    def met(self) -> bool:
        return self.keeps(self.target)

    @property
    def alarming(self) -> bool:
        return not self.keeps(self.alarm)

    def keeps(self, limit: float) -> bool:
        """Whether the value is no worse than the limit; what is no number is worse than any."""
        return self.value <= limit if self.bound == "at most" else self.value >= limit


def claims_table(claims: Iterable[Claim]) -> str:
    """A Markdown table, what is missed in bold."""
    header = ["claim", "measured", "target", "", "alarm"]
    rows = [
        [
            claim.text,
            f"{claim.value:.4g}",
            f"{claim.bound} {claim.target:g}",
            "met" if claim.met else "**missed**",
            f"{claim.alarm:g}",
        ]
        for claim in claims
    ]
    return table(header, rows)


def table(header: list[str], rows: list[list[object]]) -> str:
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines)
