"""Panels over time, one below the other: the curves of all runs, and their events."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from omnisim.plots.style import INK, Runs, figure_of, finish, legend_of_parts, log_scale, look, widen
from omnisim.status import EVENT_KINDS
from omnisim.trajectory import Trajectory

WIDTH, PANEL, LANE = 9.0, 1.9, 0.3  # inches: a figure, the height of a panel, of one kind of events


@dataclass(frozen=True)
class Panel:
    """What one pair of axes shows.

    label   of the y axis, with the unit
    curves  values (T) of a run by the name of the part, a wheel for one; empty where there is but one part
    """

    label: str
    curves: Callable[[Trajectory], Mapping[str, np.ndarray]]
    log: bool = False
    steps: bool = False  # values hold until the next row


def of_wheels(path: str, value: Callable[[np.ndarray], np.ndarray] = np.asarray) -> Callable:
    """The curves of a dataset of every wheel."""
    return lambda run: {wheel: value(run[f"wheels/{wheel}/{path}"]) for wheel in run.wheels}


def over_time(runs: Runs, panels: Sequence[Panel]) -> Figure:
    """A figure of panels with the events below."""
    kinds = len(kinds_of(runs))
    heights = [PANEL] * len(panels) + [LANE * kinds] * bool(kinds)
    figure = figure_of(runs, WIDTH, sum(heights) + 1.2)
    column = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    draw_column(column, panels, runs)
    return figure


def draw_column(column: Sequence[Axes], panels: Sequence[Panel], runs: Runs) -> None:
    """Panels into the axes of a column, the events into the last one if there is one more."""
    shown: list[str] = []
    for axes, panel in zip(column, panels, strict=False):
        parts = draw(axes, panel, runs)
        if parts != shown and len(parts) > 1:
            legend_of_parts(axes, parts, runs)
        shown = parts
    if len(column) > len(panels):
        draw_events(column[-1], runs)
        wheels = [wheel for run in runs.values() for wheel in run.wheels]
        if len(runs) == 1 and shown != wheels and len(wheels) > 1:  # its lanes are wheels
            legend_of_parts(column[-1], wheels, runs)
    column[-1].set_xlabel("time, s")
    column[0].get_figure().align_ylabels(list(column))


def draw(axes: Axes, panel: Panel, runs: Runs) -> list[str]:
    """The curves of all runs; the names of the parts."""
    curves = [panel.curves(run) for run in runs.values()]
    parts = list(dict.fromkeys(part for each in curves for part in each))
    for number, (name, run, each) in enumerate(zip(runs, runs.values(), curves, strict=True)):
        marker = "." if len(run.time) == 1 else ""
        for part, values in each.items():
            line = look(number, parts.index(part), len(runs)) | {"marker": marker, "label": part or name}
            axes.plot(run.time, values, drawstyle="steps-post" if panel.steps else "default", **line)
    if panel.log:
        log_scale(axes)
    else:
        widen(axes)
    axes.set_ylabel(panel.label)
    finish(axes)
    return parts


def kinds_of(runs: Runs) -> list[str]:
    """The kinds of events that the runs have."""
    return [kind for kind in EVENT_KINDS if any(kind in run["events/kind"] for run in runs.values())]


def draw_events(axes: Axes, runs: Runs) -> None:
    """A row of ticks for each kind of events, those of exchanges fine, with lanes within it."""
    kinds, events = kinds_of(runs), lanes(runs)
    height = 0.8 / len(events)
    for lane, (colour, time, kind_of) in enumerate(events):
        for row, kind in enumerate(kinds):
            times = time[kind_of == kind]
            y = np.full(len(times), row - 0.4 + height * (lane + 0.5))
            axes.plot(times, y, "|", color=colour, label=kind, markersize=2.0 + 14.0 / len(events),
                      markeredgewidth=0.6 if kind == "exchange" else 1.8)  # fmt: skip
    axes.set_yticks(range(len(kinds)), [kind.replace("_", " ") for kind in kinds])
    axes.set_ylim(len(kinds) - 0.4, -0.6)
    finish(axes)
    axes.grid(visible=False, axis="y")


def lanes(runs: Runs) -> list[tuple[str, np.ndarray, np.ndarray]]:
    """Colour, times and kinds of the events of each run, or of each wheel of a single one and of the run as a whole."""
    if len(runs) > 1:
        return [(look(i, 0, len(runs))["color"], run["events/time"], run["events/kind"])
                for i, run in enumerate(runs.values())]  # fmt: skip
    (run,) = runs.values()
    found = [(look(0, i, 1)["color"], run["events/wheel"] == wheel) for i, wheel in enumerate(run.wheels)]
    if "" in run["events/wheel"]:
        found.append((INK, run["events/wheel"] == ""))
    return [(colour, run["events/time"][chosen], run["events/kind"][chosen]) for colour, chosen in found]
