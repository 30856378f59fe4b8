"""What a double-row omni wheel resists with on a bench: closed form, runs, and which losses the published drag tells of.

    python -m docs.wheel_bench          writes the table of docs/pages/rolling.md anew, draws pictures/wheel_bench.png

Duda, Gembalczyk, Machoczek, Kowalik (Sensors 2025, 25, 5026) pulled such a wheel over concrete and aluminium, by its
axle, at five angles under two loads. Their abstract tells the least and the largest mean force, and that it is largest
at 60 deg for both loads. That the least is of the lighter load along the wheel, and the largest of the heavier, is
ASSUMED; so are the wheel, its barrels and the speed of the packaged scene `wheel_bench`.
"""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

import omnisim
from omnisim.scene.scene import load_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HERE = Path(__file__).parent / "pages"
PAGE, PICTURE = HERE / "rolling.md", HERE / "pictures/wheel_bench.png"
BEGIN, END = "<!-- python -m docs.wheel_bench -->\n", "<!-- end -->\n"
LOADS = (117.7, 215.8)  # N
ANGLES = (0.0, 30.0, 45.0, 60.0, 90.0)  # deg, between the way and the wheel
CONCRETE, ALUMINIUM = (1.04, 10.34), (1.08, 10.11)  # N, least and largest mean
LARGEST_AT, ACROSS = 60.0, 90.0  # deg
SPEED, STEADY, SHORTEST, TURNS = 0.1, 0.5, 0.8, 3  # m/s; s from when on it is measured, so long; over so many exchanges
SPINS = "rubber that rolls and spins"
HARD = "wheel_types.omni.contact={stiffness = 1e8, damping = 1e4}"
EXACT = "wheel_types.omni.profile={kind = 'exact'}"
CONFIG = omnisim.load("wheel_bench").config
WHEEL = CONFIG.wheel_types["omni"]
MU = CONFIG.friction.coefficient
SECTOR = 2.0 * math.pi / WHEEL.rollers  # rad, from exchange to exchange
RATE, NO_PATCH = 0.02, 1e-9  # rad/s, over which torques change their sign; m
SPINNING = 3.0 * math.pi / 16.0  # torque of a patch by mu N and its radius: Contensou, without sliding


class Losses(NamedTuple):
    """By the load: f of rollers, radius of the contact patch, Coulomb torque of rollers' bearings and of the axle, m."""

    resistance: float = 0.0
    patch: float = 0.0
    bearing: float = 0.0
    axle: float = 0.0


class Turning(NamedTuple):
    """What turns by the way (1/m), the mean over the rollers that pass: along the floor, about its normal, in a roller's
    bearing, in the axle's."""

    rolling: float
    spinning: float
    joint: float
    axle: float


def turning(angle_deg: float, at: np.ndarray | None = None) -> Turning:
    """Of exact rollers, without slip. The axle turns with V_h / R, a roller at azimuth q with V_k / (R cos q - R1).

    at: azimuths q (rad), by default those of a sector; across the way, where the wheel stands still, the middle of one.
    """
    angle = math.radians(angle_deg)
    along, across = (0.0, 1.0) if angle_deg == ACROSS else (math.cos(angle), math.sin(angle))
    q = at if at is not None else 0.5 * SECTOR * (np.arange(2000) + 0.5) / 2000.0 * (angle_deg != ACROSS)
    joint = across / (WHEEL.radius * np.cos(q) - WHEEL.roller_distance)
    rolling = np.hypot(along / WHEEL.radius, joint * np.cos(q))
    return Turning(*(float(np.mean(rate)) for rate in (rolling, joint * np.sin(q), joint)), along / WHEEL.radius)


def drag(lost: Losses, angle_deg: float, load: float, at: np.ndarray | None = None) -> float:
    """Mean force along the way, N: what all losses take by the way; at: see `turning`."""
    turned = turning(angle_deg, at)
    arms = (lost.resistance, SPINNING * MU * lost.patch, lost.bearing, lost.axle)
    return load * math.fsum(arm * rate for arm, rate in zip(arms, turned, strict=True))


def found(published: tuple[float, float] = CONCRETE) -> dict[str, Losses]:
    """Three kinds of losses, each with what the two published numbers say: along the wheel one of them acts, and at 60
    deg another takes the rest."""
    along, most = published[0] / LOADS[0] * WHEEL.radius, published[1] / LOADS[1]
    turned = turning(LARGEST_AT)
    spinning = (most - along * turned.rolling) / turned.spinning
    return {
        "rubber that rolls": Losses(resistance=along),
        "bearings": Losses(axle=along, bearing=(most - along * turned.axle) / turned.joint),
        SPINS: Losses(resistance=along, patch=spinning / (SPINNING * MU)),
    }


def scene(lost: Losses, angle_deg: float, load: float, *overrides: str) -> omnisim.Scene:
    """The packaged bench with these losses."""
    angle = math.radians(angle_deg)
    wheel, roller = "wheels.wheel", "wheel_types.omni.roller"
    axle = f"resistance = 1.0, torque_constant = 1e-9, voltage = 0.0, friction_torque = {lost.axle * load}"
    turns = 0.0 if angle_deg == ACROSS else (TURNS + 0.5) * SECTOR * WHEEL.radius / math.cos(angle)
    keys = (
        f"time.end={round(STEADY + max(turns / SPEED, SHORTEST), 1)}",
        f"friction.patch_radius={max(lost.patch, NO_PATCH)}",
        f"{wheel}.heading_deg={angle_deg}",
        f"{wheel}.spin_rate={SPEED * turning(angle_deg).axle}",
        f"{wheel}.drive={{kind = 'dc_motor', friction_rate = {RATE}, {axle}}}",
        f"{wheel}.suspension.preload={load}",
        f"{wheel}.suspension.mass={load / 9.81}",
        f"{roller}.rolling_resistance={lost.resistance}",
        f"{roller}.bearing_torque={lost.bearing * load}",
        f"{roller}.bearing_rate={RATE}",
    )
    return omnisim.load("wheel_bench", [*keys, *overrides])


def force(run: omnisim.Trajectory) -> np.ndarray:
    """With which the axle pulls the wheel along its way, N (T,): h is turned from that by the heading."""
    angle = math.radians(load_text(run.attributes["scene"]).config.wheels[0].heading_deg)
    return run["wheels/wheel/bearing_force"] @ (math.cos(angle), -math.sin(angle), 0.0)


def steady(run: omnisim.Trajectory) -> np.ndarray:
    """Ways (m) and forces (N), (2, T), over whole sectors of a wheel that turns."""
    time, spin = run.time, run["wheels/wheel/spin_angle"]
    end = time[-1]
    if spin[-1] - spin[0] > SECTOR:
        end = np.interp(np.interp(STEADY, time, spin) + TURNS * SECTOR, spin, time)
    times = np.linspace(STEADY, end, 5001)
    return np.array([SPEED * (times - STEADY), np.interp(times, time, force(run))])


def pulled(lost: Losses, load: float, *overrides: str) -> list[np.ndarray]:
    """What `steady` finds at each of ANGLES."""
    runs = omnisim.simulate_many([scene(lost, angle, load, *overrides) for angle in ANGLES])
    assert all(run.complete for run in runs), [run.attributes["status"] for run in runs]
    return [steady(run) for run in runs]


def table() -> str:
    """Rows by losses and load: means of runs with exact rollers on hard rubber, of barrels also the extremes."""
    lines = [
        f"| mean drag, N, by angle | load, N | {' | '.join(f'{angle:g} deg' for angle in ANGLES)} |",
        f"| --- | ---: |{' ---: |' * len(ANGLES)}",
        f"| published | {LOADS[0]} | *{CONCRETE[0]}* | | | | |",
        f"| | {LOADS[1]} | | | | *{CONCRETE[1]}* | |",
    ]
    for name, lost in found().items():
        for load in LOADS:
            means = [force.mean() for _, force in pulled(lost, load, EXACT, HARD)]
            lines.append(row(name if load == LOADS[0] else "", load, means))
    for load in LOADS:
        forces = [force for _, force in pulled(found()[SPINS], load)]
        lines.append(row("the same on barrels" if load == LOADS[0] else "", load, [force.mean() for force in forces]))
        lines.append(row("... at least", load, [force.min() for force in forces]))
        lines.append(row("... at most", load, [force.max() for force in forces]))
    return "\n".join(lines) + "\n"


def row(name: str, load: float, forces: list[float]) -> str:
    return f"| {name} | {load} | {' | '.join(f'{force:.2f}' for force in forces)} |"


def draw() -> None:
    """Mean drag against the angle, and the force on the way over three rollers."""
    import matplotlib.pyplot as plt

    from omnisim.pictures.plots.style import COLOURS, finish

    figure, (means, ways) = plt.subplots(1, 2, figsize=(11.5, 4.0), layout="constrained")
    for (name, lost), colour in zip(found().items(), COLOURS, strict=False):
        for load, line in zip(LOADS, ("--", "-"), strict=True):
            draw_means(means, lost, load, color=colour, linestyle=line, label=name if load == LOADS[1] else None)
    runs = pulled(found()[SPINS], LOADS[1])
    means.plot(ANGLES, [force.mean() for _, force in runs], "s", color=COLOURS[2], label="runs on barrels")
    means.plot([0.0, LARGEST_AT], CONCRETE, "*", color="black", markersize=13, label="published")
    means.set(xlabel="angle between way and wheel / deg", ylabel="mean drag / N", title="117.7 N (dashed), 215.8 N")
    for angle, (way, force), colour in zip(ANGLES, runs, COLOURS, strict=False):
        shown = way < 0.08  # m
        ways.plot(1e3 * way[shown], force[shown], color=colour, label=f"{angle:g} deg")
    ways.axhline(0.0, color="0.6", linewidth=0.8)
    ways.set(xlabel="way / mm", ylabel="drag / N", title="runs on barrels, 215.8 N")
    for axes in (means, ways):
        finish(axes)
        axes.title.set_fontsize(10)
    means.legend(frameon=False, fontsize=8)
    ways.legend(frameon=False, fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(PICTURE, dpi=110)


def draw_means(axes: "Axes", lost: Losses, load: float, **look: Any) -> None:
    """The closed form while the wheel turns; across the way from the middle of the roller on which it stands to its
    end."""
    angles = np.linspace(0.0, 0.999 * ACROSS, 200)
    axes.plot(angles, [drag(lost, angle, load) for angle in angles], **look)
    stands = [drag(lost, ACROSS, load, np.array([q])) for q in (0.0, 0.5 * SECTOR)]
    axes.plot([ACROSS, ACROSS], stands, marker="_", **(look | {"label": None}))


def page() -> str:
    """The page with a new table."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return before + BEGIN + table() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    draw()
