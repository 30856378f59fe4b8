"""The path of the body on the floor: where it was, where it should have been, where it thought to be."""

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from omnisim.dynamics.ground import floor_of_scene
from omnisim.pictures.ground import heights
from omnisim.pictures.plots.asked import commanded_path, config_of
from omnisim.pictures.plots.marks import kinds_of, mark, named, stride, thinned
from omnisim.pictures.plots.outline import draw_outlines
from omnisim.pictures.plots.panels import Bands, Panel, draw, extremes, size
from omnisim.pictures.plots.style import INK, TARGET, Runs, figure_of, finish, look, view
from omnisim.results.trajectory import Trajectory

ARROWS = 12
CELLS, CONTOURS, REACH = 300, 7, 1.2  # of uneven ground: points each way, levels, half the width by that of the path
HEIGHTS = "YlOrBr"
MOST_TICKS = 6  # of the axis along x, so that labels in a narrow picture stay apart
UNMARKED = ("contact_begin", "contact_end")  # at every roller, and often two of a wheel at once
MOST_MARKS = 30  # of a kind along a path
SMALLEST = 1e-6  # m: a machine that turns on the spot moves by rounding
RING: dict[str, Any] = {"linestyle": "none", "marker": "o", "markersize": 9, "markerfacecolor": "none"}


def deviations(run: Trajectory) -> dict[str, np.ndarray]:
    """Distances (m): of the body from where it was commanded to be, of the odometry from the body."""
    found = {}
    commanded = commanded_path(run)
    if commanded is not None:
        found["machine from command"] = size(run["body/position"][:, :2] - commanded[:, :2])
    if "odometry/position_error" in run:
        found["odometry from machine"] = size(run["odometry/position_error"])
    return found


def reach(run: Trajectory) -> Bands:
    """How far the odometry's distance reaches between rows."""
    path = "odometry/position_error"
    return {"odometry from machine": extremes(run, path)} if f"interval_max/{path}" in run else {}


DEVIATIONS = Panel("distance, m", deviations, reach)


@view
def path(runs: Runs) -> Figure:
    """The path with the commanded one and the odometry's, the machine from above, arrows of the heading, events.

    Below it how far the machine is from where it was to be at the time, and its odometry from the machine.
    """
    if not any(deviations(run) for run in runs.values()):
        figure = figure_of(runs, 8.0, 6.5)
        draw_path(figure.subplots(), runs)
        return figure
    figure = figure_of(runs, 8.0, 8.5)
    above, below = figure.subplots(2, 1, height_ratios=(5.0, 1.0))
    draw_path(above, runs)
    parts, _ = draw(below, DEVIATIONS, runs)
    ink = {"color": INK} if len(runs) > 1 else {}
    handles = [Line2D([], [], **look(0, i, 1) | ink) for i in range(len(parts))]
    below.legend(handles, parts, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, frameon=False, fontsize=8)
    below.set_xlabel("time, s")
    return figure


def draw_path(axes: Axes, runs: Runs) -> None:
    """The paths of all runs, with a legend below."""
    kinds = [kind for kind in kinds_of(runs) if kind not in UNMARKED]
    every = {kind: stride([count(run, kind) for run in runs.values()], MOST_MARKS) for kind in kinds}
    lines: dict[str, Line2D] = {}
    for number, (name, run) in enumerate(runs.items()):
        colour = look(number, 0, len(runs))["color"]
        x, y = run["body/position"][:, 0], run["body/position"][:, 1]
        axes.plot(x, y, **look(number, 0, len(runs)), label=name)
        axes.plot(x[0], y[0], **RING, markeredgecolor=colour)
        lines |= draw_others(axes, run, number, len(runs))
        draw_machine(axes, run, colour, filled=len(runs) == 1)
        draw_heading(axes, run, colour)
        draw_marks(axes, run, colour, every)
    axes.set(xlabel="x, m", ylabel="y, m")
    axes.locator_params(axis="x", nbins=MOST_TICKS)
    axes.margins(0.1)  # room for the last arrow
    drawn = axes.dataLim
    if max(drawn.width, drawn.height) < SMALLEST:
        middle = 0.5 * (drawn.p0 + drawn.p1)
        axes.update_datalim([middle - SMALLEST, middle + SMALLEST])
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    finish(axes)
    lines |= draw_ground(axes, next(iter(runs.values())))
    ink = {"color": INK} if len(runs) > 1 else {}
    handles = [Line2D([], [], **RING, markeredgecolor=INK), Line2D([], [], **look(0, 0, 1) | ink), *lines.values()]
    handles += [Line2D([], [], linestyle="none", **mark(kind, INK)) for kind in every]
    totals = {kind: sum(count(run, kind) for run in runs.values()) for kind in every}
    labels = ["begin", "path", *lines, *(named(kind, every[kind], totals[kind]) for kind in every)]
    axes.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=4, frameon=False, fontsize=8)


def draw_ground(axes: Axes, run: Trajectory) -> dict[str, Line2D]:
    """Contours of uneven ground beneath all else, as wide as an axis of equal scale may become; a handle by what they
    say."""
    config = config_of(run)
    floor = None if config is None else floor_of_scene(config)
    if floor is None:
        return {}
    ends = np.array([axes.get_xlim(), axes.get_ylim()])
    before = axes.dataLim.frozen()
    middle, half = ends.mean(axis=1), REACH * np.ptp(ends, axis=1).max()
    x, y = np.meshgrid(*(np.linspace(one - half, one + half, CELLS) for one in middle))
    height = 1e3 * heights(floor, x, y)
    span = float(np.ptp(height))
    if span > 0.0:
        levels = height.min() + span * (np.arange(CONTOURS) + 0.5) / CONTOURS
        least = height.min() - span  # the lightest colours would not be seen
        axes.contour(x, y, height, levels, cmap=HEIGHTS, linewidths=0.8, zorder=0.5, vmin=least)
    axes.dataLim.set(before)
    axes.autoscale_view()
    said = f"ground: {span / CONTOURS:.2g} mm apart, dark is high"
    return {said: Line2D([], [], color=colormaps[HEIGHTS](0.75), linewidth=0.8)} if span > 0.0 else {}


def count(run: Trajectory, kind: str) -> int:
    return int(np.count_nonzero(run["events/kind"] == kind))


def draw_others(axes: Axes, run: Trajectory, number: int, runs: int) -> dict[str, Line2D]:
    """The commanded path and the odometry's, those that there are; handles for a legend by name."""
    lines = {}
    commanded = commanded_path(run)
    if commanded is not None:
        colour = INK if runs == 1 else look(number, 0, runs)["color"]
        axes.plot(*commanded[:, :2].T, color=colour, **TARGET, label="commanded")
        lines["commanded"] = Line2D([], [], color=INK, **TARGET)
    if "odometry/position" in run:
        style = look(number, 1, runs) | {"zorder": 3}
        axes.plot(*run["odometry/position"].T, **style, label="odometry")
        lines["odometry"] = Line2D([], [], **style | ({"color": INK} if runs > 1 else {}))
    return lines


def draw_machine(axes: Axes, run: Trajectory, colour: str, filled: bool) -> None:
    """The machine from above at a few instants, if its scene can be read."""
    config = config_of(run)
    if config is not None:
        draw_outlines(axes, config, np.column_stack([run["body/position"][:, :2], run["body/yaw"]]), colour, filled)


def draw_heading(axes: Axes, run: Trajectory, colour: str) -> None:
    """Arrows at equal times, beneath the lines."""
    rows = np.unique(np.linspace(0, len(run.time) - 1, ARROWS).round().astype(int))
    x, y, _ = run["body/position"][rows].T
    yaw = run["body/yaw"][rows]
    angles = np.degrees(yaw)  # on the paper, as on the floor: the axes are of equal scale
    axes.quiver(x, y, np.cos(yaw), np.sin(yaw), color=colour, angles=angles, scale=18, width=0.003,
                headwidth=6.0, zorder=1.9)  # fmt: skip


def draw_marks(axes: Axes, run: Trajectory, colour: str, every: dict[str, int]) -> None:
    """Marks where the body is, between two rows on a line, when an event happens; of many every so many."""
    for kind in kinds_of({"": run}):
        if kind not in every:
            continue
        times = thinned(run["events/time"][run["events/kind"] == kind], every[kind])
        x, y = (np.interp(times, run.time, run["body/position"][:, axis]) for axis in (0, 1))
        axes.plot(x, y, linestyle="none", zorder=4, label=kind, **mark(kind, colour))
