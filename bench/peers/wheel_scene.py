r"""The packaged coulomb_wheel as general engines take it: shapes of its rollers, and errors of what comes out.

Engines know few shapes exactly. How high one of these rollers carries the centre of the wheel at azimuth q,

    H(q) = R1 cos q + sqrt(b^2 + x sin^2 q),  x = c^2 (a^2 - b^2)      for an ellipsoid of axial semi-axis a, the others
                                                                       b = R - R1

         true: H = R everywhere        level: H = R at q = 0          smooth: H' = 0 at
                                       and at q = +-alpha             q = +-alpha
    H    R |--------------------|        .--.        .--.             ---.            .---
           |                    |       /    '-.__.-'    \                '-.      .-'
           |                    |      /                  \                  '-..-'
         -alpha      0       alpha     a knee: impacts                no knee, but heaves more

is R for the true roller. No ellipsoid is level and smooth at once. The scene's rollers are straight, psi = 0;
ellipsoids and frames are for any psi.
"""

import json
import math
import statistics
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

import omnisim
from bench.common import Claim, interleaved, median_ratio, ready, simulation, table
from omnisim.cad.mesh import roller
from omnisim.contact.roller_profile import length
from omnisim.dynamics.packing import pack
from omnisim.scene.scene import Scene
from omnisim.scene.wheel_schema import WheelType

SCENE = "coulomb_wheel"
REFERENCE = Path(__file__).parents[2] / "tests/reference/coulomb_wheel.json"
ROWS = 200  # of the height of the wheel, evenly over the run
SETTLED = 0.1  # s: the ripple of the height is judged from here on
LOST = 0.1  # of the radius: a height that far from it is a failure
LEVEL, SMOOTH, CAPSULE = "ellipsoid, level", "ellipsoid, smooth", "capsule"
RESOLVED = 1e-9  # m: what the reference is good to
PEERS = BEST, FASTEST = "the best", "the fastest"
CLOSER = 1000.0  # times: how much smaller the error of a run is that takes less time
ALARM = 0.5  # of its time, for the best of an engine
LADDER = [(method, step) for method in ("rk4", "dopri5") for step in (1e-2, 5e-3, 2e-3, 1e-3)]
NOTES = f"""Errors are distances at 2 s from the converged rigid state, of the position and of the yaw. It is good to
{RESOLVED:g}: no smaller error of a position is told.
Ripple: highest less lowest centre of the wheel from {SETTLED:g} s on, 0 if it is round. Speed left: after 2 s of
rolling straight at 0.5 m/s, which nothing slows down. Fails: the height is off by {LOST:.0%} of the radius, or is no
number. The best is the closest in position, chosen with the exact answer at hand, which a user has not; the fastest is
that of those within a wheel radius. Times are of single runs, but those beside omnisim."""


class Shape(NamedTuple):
    """A shape about the roller's axis z, m: semi-axes (x, y, z), radius and half length, or vertices (V, 3)."""

    kind: str
    size: np.ndarray


class Outcome(NamedTuple):
    """What a run makes of the scene: errors at the end (m, rad), ripple (m), wall time (s); infinite if it fails."""

    position_error: float
    yaw_error: float
    ripple: float
    seconds: float


FAILED = Outcome(math.inf, math.inf, math.inf, math.inf)


class Running(Protocol):
    """A run of an engine at t = 0."""

    def advance(self, until: float) -> None:
        """Step on to this time, s."""

    def pose(self) -> tuple[float, float, float, float]:
        """x, y, z of the wheel centre (m) and yaw (rad)."""

    def speed(self) -> float:
        """Of the wheel centre along x, m/s."""


@cache
def scene(method: str = "rk4", step: float = 1e-3) -> Scene:
    return omnisim.load(SCENE, [f"solver.method={method}", f"time.step={step!r}"])


@cache
def wheel_type() -> WheelType:
    """The only one of the scene."""
    (kind,) = scene().config.wheel_types.values()
    return kind


def end() -> float:
    return scene().config.time.end


# --- shapes ---------------------------------------------------------------------------------------


def level_ellipsoid(kind: WheelType) -> Shape:
    """It stands on the floor as high as the true roller, in its middle and at its ends: H(0) = H(alpha) = R."""
    alpha = math.pi / kind.roller_count
    reach = kind.radius - kind.roller_distance * math.cos(alpha)
    return ellipsoid(kind, (reach**2 - (kind.radius - kind.roller_distance) ** 2) / math.sin(alpha) ** 2)


def smooth_ellipsoid(kind: WheelType) -> Shape:
    """It hands over to the next roller without a knee, H'(alpha) = 0: x cos(alpha) = R1 sqrt(b^2 + x sin^2(alpha))."""
    alpha, across, distance = math.pi / kind.roller_count, kind.radius - kind.roller_distance, kind.roller_distance
    cosine, half = math.cos(alpha) ** 2, 0.5 * (distance * math.sin(alpha)) ** 2
    return ellipsoid(kind, (half + math.sqrt(half**2 + cosine * (distance * across) ** 2)) / cosine)


def ellipsoid(kind: WheelType, x: float) -> Shape:
    """Of x = c^2 (a^2 - b^2), m^2."""
    across, cosine = kind.radius - kind.roller_distance, math.cos(math.radians(kind.roller_angle_deg))
    return Shape("ellipsoid", np.array([across, across, math.sqrt(across**2 + x / cosine**2)]))


def capsule(kind: WheelType) -> Shape:
    """As long and as thick as the roller."""
    radius = kind.radius - kind.roller_distance
    return Shape("capsule", np.array([radius, 0.5 * length(packed()) - radius]))


def mesh(rings: int, corners: int) -> Shape:
    """Points of the true surface, rings x corners; engines take their convex hull."""
    return Shape("mesh", roller(wheel_type(), rings, corners).vertices[:-2])  # without those on the axis


def packed() -> np.record:
    """The wheel as kernels know it."""
    return pack(scene().config).wheels[0]


# --- outcomes -------------------------------------------------------------------------------------


def errors(x: float, y: float, yaw: float) -> tuple[float, float]:
    """Distance of a pose at the end from the reference, m and rad."""
    reference = json.loads(REFERENCE.read_text())
    return math.dist((x, y), reference["position"][-1]), abs(yaw - reference["yaw"][-1])


def observe(run: Running) -> Outcome:
    """Run to the end in ROWS parts; timed are the steps alone."""
    radius, stop, seconds, heights = wheel_type().radius, end(), 0.0, []
    for row in range(1, ROWS + 1):
        begun = time.perf_counter()
        run.advance(stop * row / ROWS)
        seconds += time.perf_counter() - begun
        x, y, z, yaw = run.pose()
        if not abs(z - radius) < LOST * radius:  # true of no number, too
            return FAILED
        if stop * row / ROWS >= SETTLED:
            heights.append(z)
    return Outcome(*errors(x, y, yaw), float(np.ptp(heights)), seconds)


def speed_left(run: Running) -> float:
    """Along x after rolling straight to the end, m/s; not a number if it fails."""
    run.advance(end())
    _, _, z, _ = run.pose()
    radius = wheel_type().radius
    return run.speed() if abs(z - radius) < LOST * radius else math.nan


def best_of(rows: list[dict]) -> dict:
    """The row with the smallest error of position."""
    return min(rows, key=lambda row: row["position_error"])


def fastest_of(rows: list[dict]) -> dict:
    """The row that takes the least time of those within a wheel radius."""
    near = [row for row in rows if row["position_error"] < wheel_type().radius]
    return min(near, key=lambda row: row["seconds"])


def cells(row: dict) -> list[str]:
    """Of an outcome: errors, ripple, wall time of a simulated second, real-time factor."""
    if row["seconds"] == math.inf:
        return ["fails", "-", "-", "-", "-"]
    per_second = row["seconds"] / end()
    lengths = [f"{row['position_error'] * 1e3:.2f}", f"{row['yaw_error']:.3f}", f"{row['ripple'] * 1e6:.0f}"]
    return [*lengths, f"{per_second * 1e3:.1f}", f"{1.0 / per_second:.3g}"]


def speed_cell(value: float) -> str:
    return "fails" if math.isnan(value) else f"{value:.4f}"


CELLS = ["position off by, mm", "yaw off by, rad", "ripple, um", "ms per simulated second", "times real time"]


# --- omnisim beside them --------------------------------------------------------------------------


def against(peers: dict[str, Callable[[], Callable[[], object]]], rounds: int) -> list[dict]:
    """Errors and seconds of omnisim along LADDER, and the time of each peer over its own, timed in turn."""
    ours: dict[tuple, Callable] = {}
    for method, step in LADDER:
        ours["march", method, step] = partial(warm_march, scene(method, step))
        ours["simulate", method, step] = partial(simulation, scene(method, step))
    seconds = interleaved({**peers, **ours}, rounds)
    rows = []
    for method, step in LADDER:
        run = omnisim.simulate(scene(method, step))
        found = errors(*run["body/position"][-1, :2], run["body/yaw"][-1])
        row = {"method": method, "step": step, "position_error": found[0], "yaw_error": found[1]}
        for what in ("march", "simulate"):
            mine = seconds[what, method, step]
            ratios = {peer: median_ratio(seconds[peer], mine) for peer in peers}
            row[what] = {"seconds": statistics.median(mine), "ratios": ratios}
        rows.append(row)
    return rows


def warm_march(scene: Scene) -> Callable[[], object]:
    """A contestant: a march after another of its kind, since after a long run of a peer the first is cold."""
    ready(scene).go()
    return ready(scene).go


def comparison(engine: str, best: dict, ours: list[dict]) -> str:
    """The best and the fastest of an engine beside omnisim."""
    rows = [
        [row["method"], f"{row['step']:.0e}", f"{resolved(row) * 1e3:.1e}", f"{row['yaw_error']:.1e}"]
        + [f"{end() / row[what]['seconds']:.0f}" for what in ("march", "simulate")]
        + [f"{row[what]['ratios'][peer]:.1f}" for peer in PEERS for what in ("march", "simulate")]
        + [f"{best['position_error'] / resolved(row):.0f}"]
        for row in ours
    ]
    header = ["omnisim", "step, s", "position off by, mm", "yaw off by, rad"]
    header += [f"times real time, {what}" for what in ("march", "simulate")]
    header += [f"{peer} of {engine} takes, times the {what}" for peer in PEERS for what in ("march", "simulate")]
    fastest = max(row["simulate"]["ratios"][FASTEST] for row in ours)
    said = f"{engine} at its fastest takes up to {fastest:.1f} times as long as omnisim.simulate."
    return f"{table([*header, 'best is off by, times'], rows)}\n\n{said}"


def claims(engine: str, result: dict) -> list[Claim]:
    """That the best of an engine takes longer than a run whose error is CLOSER times smaller."""
    if not result:
        return []
    best, ours = result["best"], result["omnisim"]
    ratios = [row["simulate"]["ratios"][BEST] for row in ours if resolved(row) * CLOSER <= best["position_error"]]
    text = f"{engine} at its best, by omnisim.simulate with an error {CLOSER:g} times smaller"
    return [Claim(text, max(ratios, default=0.0), "at least", 1.0, ALARM)]


def resolved(row: dict) -> float:
    """Error of the position, m, but no less than what the reference is good to."""
    return max(row["position_error"], RESOLVED)
