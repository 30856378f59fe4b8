"""How every figure looks: colours, lines, names of runs."""

from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from omnisim.results.trajectory import Trajectory

# Okabe & Ito, without their yellow: told apart with any colour vision, and on white paper
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
LINES = (("-", 1.9), ("--", 1.6), ("-.", 1.4), (":", 1.2))  # style and width: what lies beneath is wider, and seen
TARGET: dict[str, Any] = {
    "linewidth": 4.5,
    "alpha": 0.3,
    "solid_capstyle": "butt",
    "zorder": 1.5,
}  # pale, beneath what follows it
BAND: dict[str, Any] = {
    "alpha": 0.22,
    "linewidth": 0.0,
    "zorder": 1.2,
}  # extremes between rows, about the line through the rows
LEAST_SPAN = 1e-9  # of an axis, in its unit: less is rounding
INK, QUIET = "0.15", "0.6"
WIDEST, TALLEST = 120, 6  # characters in a line of the legend of runs, lines in that of parts

Runs = Mapping[str, Trajectory]  # by the name that the legend shows


class PlotError(ValueError):
    """What these trajectories do not have to show; the message is one line."""


def view(draw: Callable[[Runs], Figure]) -> Callable[[Trajectory | Iterable[Trajectory] | Runs], Figure]:
    """A view of one trajectory, of several, or of several by name; without names their titles are shown.

    Raises PlotError when there is nothing to show.
    """

    @wraps(draw)
    def drawn(trajectories: Trajectory | Iterable[Trajectory] | Runs) -> Figure:
        runs = named(trajectories)
        for name, run in runs.items():
            if not len(run.time):
                raise PlotError(f"{name}: no rows to show")
        return draw(runs)

    return drawn


def named(trajectories: Trajectory | Iterable[Trajectory] | Runs) -> Runs:
    """Trajectories by title; a number tells apart those of one title."""
    if isinstance(trajectories, Mapping):
        return trajectories
    runs = [trajectories] if isinstance(trajectories, Trajectory) else list(trajectories)
    titles = [run.attributes["title"] or "run" for run in runs]
    apart = len(set(titles)) == len(titles)
    return {
        title if apart else f"{title} ({i})": run for i, (title, run) in enumerate(zip(titles, runs, strict=True), 1)
    }


def look(run: int, part: int, runs: int) -> dict[str, Any]:
    """Colour and line of a part, a wheel for one: several runs have a colour each, and parts differ by their line."""
    colour = COLOURS[(run if runs > 1 else part) % len(COLOURS)]
    style, width = LINES[part % len(LINES)]
    return {"color": colour, "linestyle": style, "linewidth": width}


def nth(parts: list[str], runs: Runs) -> dict[str, int]:
    """What `look` calls each part: a wheel by its place among all wheels, so it looks the same in every panel."""
    wheels = list(dict.fromkeys(wheel for run in runs.values() for wheel in run.wheels))
    order = wheels if set(parts) <= set(wheels) else parts
    return {part: order.index(part) for part in parts}


def empty_figure(width: float, height: float) -> Figure:
    """A figure of pyplot, sizes in inches."""
    return plt.figure(figsize=(width, height), layout="constrained")


def figure_of(runs: Runs, width: float, height: float) -> Figure:
    """The same with names: one run is its title, several have a legend below."""
    figure = empty_figure(width, height)
    if len(runs) == 1:
        figure.suptitle(*runs, fontsize=12, parse_math=False)  # a title is no formula
    else:
        handles = [Line2D([], [], color=look(i, 0, len(runs))["color"], linewidth=3) for i in range(len(runs))]
        columns = max(1, min(len(runs), WIDEST // (max(map(len, runs)) + 8)))
        legend = figure.legend(handles, list(runs), loc="outside lower center", ncols=columns, frameon=False)
        for text in legend.get_texts():
            text.set_parse_math(False)
    return figure


def finish(axes: Axes) -> None:
    """What all axes share: a quiet grid, no frame above and at the right."""
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def widen(axes: Axes) -> None:
    """Let a constant look like one."""
    low, high = axes.dataLim.intervaly
    if high - low < LEAST_SPAN:
        margin = max(LEAST_SPAN, 0.1 * abs(low))
        axes.set_ylim(low - margin, high + margin)


def log_scale(axes: Axes) -> None:
    """A logarithmic y axis, unless nothing is above zero."""
    if any(np.any(np.asarray(line.get_ydata()) > 0.0) for line in axes.get_lines()):
        axes.set_yscale("log", nonpositive="mask")


def legend_of_parts(axes: Axes, parts: list[str], runs: Runs, more: Mapping[str, Artist]) -> None:
    """A legend of the parts, and of more by name, beside the axes.

    Of several runs, whose colours the figure explains, parts are told by their lines.
    """
    ink = {"color": INK} if len(runs) > 1 else {}
    lines = [Line2D([], [], **look(0, i, 1) | ink) for i in nth(parts, runs).values()]
    legend_beside(axes, [*lines, *more.values()], [*parts, *more])


def legend_beside(axes: Axes, handles: list, labels: list[str]) -> None:
    """A legend at the right of the axes, where it covers nothing."""
    columns = -(-len(labels) // TALLEST)
    axes.legend(handles, labels, loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False,
                fontsize=8, handlelength=2.6, ncols=columns)  # fmt: skip
