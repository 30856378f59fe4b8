"""Pictures of fits: paths beside what was measured, and what is left of the difference."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from omnisim.fitting.paths import Path
from omnisim.fitting.result import FitResult, LogResult
from omnisim.pictures.plots.style import COLOURS, INK, QUIET, TARGET, empty_figure, finish

PANEL = 3.3  # inches
MOST_COLUMNS = 4
LINES = {  # of the paths in the order in which they are drawn
    "ideal": {"color": COLOURS[2], "linestyle": ":", "linewidth": 1.6},
    "before": {"color": QUIET, "linestyle": "--", "linewidth": 1.2},
    "after": {"color": COLOURS[1], "linestyle": "-", "linewidth": 1.2},
}
NAMES = {"ideal": "ideal kinematics, fitted", "before": "simulated before", "after": "simulated after"}


def fit_paths(found: FitResult) -> Figure:
    """Each log from above: measured, simulated before and after, and by fitted ideal kinematics; a dot ends each."""
    logs = found.logs
    columns = min(len(logs), MOST_COLUMNS)
    lines = -(-len(logs) // columns)
    figure = empty_figure(PANEL * columns, 0.7 + PANEL * lines)
    everything = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes, entry in zip(everything, logs, strict=False):
        axes.plot(*entry.measured.position.T, color=INK, label="measured", **TARGET)
        axes.plot(*entry.measured.position[-1], "o", color=INK, alpha=0.4, markersize=8)
        for name, path in paths_of(entry):
            axes.plot(*path.position.T, label=NAMES[name], **LINES[name])
            axes.plot(*path.position[-1], "o", color=LINES[name]["color"], markersize=4)
        after = entry.errors()["after"]
        told = f"{1e3 * after.end_position:.0f} mm, {np.degrees(after.end_yaw):.1f} deg at the end" if after else ""
        axes.set_title(f"{entry.log.file} ({entry.log.use})\n{told}", fontsize=9, parse_math=False)
        axes.set_aspect("equal")
        axes.set_xlabel("x (m)")
        axes.set_ylabel("y (m)")
        finish(axes)
    for axes in everything[len(logs) :]:
        axes.remove()
    legend(figure, everything[0])
    return figure


def fit_residuals(found: FitResult) -> Figure:
    """Of each log the distance from the measured place, and the difference of yaw, over time."""
    logs = found.logs
    columns = min(len(logs), MOST_COLUMNS)
    blocks = -(-len(logs) // columns)
    figure = empty_figure(PANEL * columns, 0.7 + 3.6 * blocks)
    panels = figure.subplots(2 * blocks, columns, squeeze=False)
    for i, entry in enumerate(logs):
        place, yaw = panels[2 * (i // columns) : 2 * (i // columns) + 2, i % columns]
        time = entry.log.time[entry.rows]
        measured = entry.measured
        for name, path in paths_of(entry):
            place.plot(time, 1e3 * np.hypot(*(path.position - measured.position).T), label=NAMES[name], **LINES[name])
            yaw.plot(time, np.degrees(path.yaw - measured.yaw), **LINES[name])
        place.set_title(f"{entry.log.file} ({entry.log.use})", fontsize=9, parse_math=False)
        place.set_ylabel("distance (mm)")
        yaw.set_ylabel("yaw error (deg)")
        yaw.set_xlabel("time (s)")
        finish(place)
        finish(yaw)
    for i in range(len(logs), blocks * columns):
        for axes in panels[2 * (i // columns) : 2 * (i // columns) + 2, i % columns]:
            axes.remove()
    legend(figure, panels[0, 0])
    return figure


def paths_of(entry: LogResult) -> list[tuple[str, Path]]:
    """The paths of a log that are drawn, by name."""
    return [(name, path) for name in LINES if (path := getattr(entry, name)) is not None]


def legend(figure: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
