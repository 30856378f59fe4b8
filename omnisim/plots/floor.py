"""The path of the body on the floor, with its heading and its events."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from omnisim.plots.panels import kinds_of
from omnisim.plots.style import INK, QUIET, Runs, figure_of, finish, look, view
from omnisim.trajectory import Trajectory

ARROWS = 16
SMALLEST = 1e-6  # m: a machine that turns on the spot moves by rounding
MARKERS = {
    "exchange": ".", "stick": "v", "slip": "^", "lift_off": "P", "touch_down": "X",
    "share_begin": "<", "share_end": ">", "stop": "s",
}  # fmt: skip


@view
def path(runs: Runs) -> Figure:
    """The path, arrows of the heading, events as marks on it; a ring where it begins."""
    figure = figure_of(runs, 8.0, 6.5)
    draw_path(figure.subplots(), runs)
    return figure


def draw_path(axes: Axes, runs: Runs) -> None:
    """The paths of all runs, with a legend of the marks below."""
    for number, (name, run) in enumerate(runs.items()):
        colour = look(number, 0, len(runs))["color"]
        x, y = run["body/position"][:, 0], run["body/position"][:, 1]
        axes.plot(x, y, color=colour, linewidth=1.3, label=name)
        axes.plot(x[0], y[0], "o", markersize=9, markerfacecolor="none", markeredgecolor=colour)
        draw_heading(axes, run, colour)
        draw_marks(axes, run, colour)
    handles = [Line2D([], [], linestyle="none", **mark(kind, INK)) for kind in kinds_of(runs)]
    begin = Line2D([], [], linestyle="none", marker="o", markersize=9, markerfacecolor="none", markeredgecolor=INK)
    labels = [kind.replace("_", " ") for kind in kinds_of(runs)]
    axes.legend([begin, *handles], ["begin", *labels], loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=5,
                frameon=False, fontsize=8)  # fmt: skip
    axes.set(xlabel="x, m", ylabel="y, m")
    axes.margins(0.1)  # room for the last arrow
    drawn = axes.dataLim
    if max(drawn.width, drawn.height) < SMALLEST:
        middle = 0.5 * (drawn.p0 + drawn.p1)
        axes.update_datalim([middle - SMALLEST, middle + SMALLEST])
        axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    finish(axes)


def draw_heading(axes: Axes, run: Trajectory, colour: str) -> None:
    """Arrows at equal times."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, ARROWS).round().astype(int))
    x, y, _ = run["body/position"][rows].T
    yaw = run["body/yaw"][rows]
    angles = np.degrees(yaw)  # on the paper, as on the floor: the axes are of equal scale
    axes.quiver(x, y, np.cos(yaw), np.sin(yaw), color=colour, angles=angles, scale=16, width=0.005, zorder=5)


def draw_marks(axes: Axes, run: Trajectory, colour: str) -> None:
    """Marks where the body is, between two rows on a line, when an event happens."""
    for kind in kinds_of({"": run}):
        times = run["events/time"][run["events/kind"] == kind]
        x, y = (np.interp(times, run.time, run["body/position"][:, axis]) for axis in (0, 1))
        axes.plot(x, y, linestyle="none", zorder=4, label=kind, **mark(kind, colour))


def mark(kind: str, colour: str) -> dict[str, object]:
    """Exchanges, which are many, are small and grey."""
    if kind == "exchange":
        return {"marker": MARKERS[kind], "markersize": 4, "color": QUIET}
    edge = {"markeredgecolor": colour, "markeredgewidth": 0.7}
    return {"marker": MARKERS[kind], "markersize": 4.5, "markerfacecolor": "white", **edge}
