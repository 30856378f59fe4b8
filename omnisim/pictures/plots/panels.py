"""Panels over time, one below the other: the curves of all runs, and their events."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from omnisim.pictures.plots.marks import OFTEN, kinds_of, named, stride, thinned
from omnisim.pictures.plots.style import (
    BAND,
    INK,
    TARGET,
    Runs,
    figure_of,
    finish,
    legend_of_parts,
    log_scale,
    look,
    nth,
    widen,
)
from omnisim.results.trajectory import Trajectory

WIDTH, PANEL, LANE = 9.0, 1.9, 0.3  # inches: a figure, the height of a panel, of one kind of events
TALLEST = 10.0  # inches: panels together
MANY, MOST_TICKS = 100, 500  # in a lane: ticks are fine; more of a kind would be one bar

Curves = Mapping[str, np.ndarray]  # values (T) by the name of the part, a wheel for one; empty where there is but one
Bands = Mapping[str, tuple[np.ndarray, np.ndarray]]  # lowest and highest values (T) since the row before, by part


def nothing(run: Trajectory) -> dict:
    """Neither bands nor targets."""
    return {}


@dataclass(frozen=True)
class Panel:
    """What one pair of axes shows.

    label    of the y axis, with the unit
    curves   of a run
    bands    how far values reach between rows, of parts of which the file has it
    targets  what curves are to follow, of parts that have a target
    """

    label: str
    curves: Callable[[Trajectory], Curves]
    bands: Callable[[Trajectory], Bands] = nothing
    targets: Callable[[Trajectory], Curves] = nothing
    log: bool = False
    steps: bool = False  # values hold until the next row


def size(vectors: np.ndarray) -> np.ndarray:
    """Lengths (T) of vectors (T, n)."""
    return np.linalg.norm(vectors, axis=-1)


def of_wheels(path: str, value: Callable[[np.ndarray], np.ndarray] = np.asarray) -> Callable[[Trajectory], Curves]:
    """The curves of a dataset of the wheels that have it."""

    def curves(run: Trajectory) -> Curves:
        paths = {wheel: f"wheels/{wheel}/{path}" for wheel in run.wheels}
        return {wheel: value(run[path]) for wheel, path in paths.items() if path in run}

    return curves


def bands_of_wheels(path: str) -> Callable[[Trajectory], Bands]:
    """Extremes between rows of a dataset of the wheels, vectors by their length."""

    def bands(run: Trajectory) -> Bands:
        paths = {wheel: f"wheels/{wheel}/{path}" for wheel in run.wheels}
        return {wheel: extremes(run, path) for wheel, path in paths.items() if f"interval_max/{path}" in run}

    return bands


def extremes(run: Trajectory, path: str) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest (T) of a dataset since the row before, of vectors their length."""
    highest = run[f"interval_max/{path}"]
    if f"interval_min/{path}" in run:
        return run[f"interval_min/{path}"], highest
    return upwards(run[path] if run[path].ndim == 1 else size(run[path]), highest)


def upwards(values: np.ndarray, highest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The band of values (T) of which only the highest since the row before is known: from the rows up."""
    return np.minimum(values, np.append(values[:1], values[:-1])), highest


def over_time(runs: Runs, panels: Sequence[Panel]) -> Figure:
    """A figure of panels with the events below."""
    kinds = len(kinds_of(runs))
    heights = [min(PANEL, TALLEST / len(panels))] * len(panels) + [LANE * kinds] * bool(kinds)
    figure = figure_of(runs, WIDTH, sum(heights) + 1.2)
    column = figure.subplots(len(heights), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    draw_column(column, panels, runs)
    return figure


def draw_column(column: Sequence[Axes] | np.ndarray, panels: Sequence[Panel], runs: Runs) -> None:
    """Panels into the axes of a column, the events into the last one if there is one more."""
    shown: list[str] = []
    explained: set[str] = set()
    for axes, panel in zip(column, panels, strict=False):
        parts, more = draw(axes, panel, runs)
        new = {name: handle for name, handle in more.items() if name not in explained}
        explained |= set(new)
        telling = parts if parts != shown and len(parts) > 1 else []
        if telling or new:
            legend_of_parts(axes, telling, runs, new)
        shown = parts
    if len(column) > len(panels):
        draw_events(column[-1], runs)
        wheels = [wheel for run in runs.values() for wheel in run.wheels]
        if len(runs) == 1 and shown != wheels and len(wheels) > 1:  # its lanes are wheels
            legend_of_parts(column[-1], wheels, runs, {})
    column[-1].set_xlabel("time, s")
    column[0].figure.align_ylabels(list(column))


def draw(axes: Axes, panel: Panel, runs: Runs) -> tuple[list[str], dict[str, Artist]]:
    """The curves of all runs; the names of the parts, and what else is to be explained."""
    curves = [panel.curves(run) for run in runs.values()]
    parts = list(dict.fromkeys(part for each in curves for part in each))
    numbers = nth(parts, runs)
    more: dict[str, Artist] = {}
    for number, (name, run, each) in enumerate(zip(runs, runs.values(), curves, strict=True)):
        style: dict[str, Any] = {
            "drawstyle": "steps-post" if panel.steps else "default",
            "marker": "." if len(run.time) == 1 else "",
        }
        looks = {part: look(number, numbers[part], len(runs)) for part in each}
        for part, values in panel.targets(run).items():
            axes.plot(run.time, values, **TARGET, color=looks[part]["color"], label=f"target of {part or name}")
            more["target"] = Line2D([], [], color=INK, **TARGET)
        for part, (low, high) in panel.bands(run).items():
            colour = looks[part]["color"]
            axes.fill_between(run.time, low, high, step="pre", **BAND, color=colour, label=f"band of {part or name}")
            more["between rows"] = Patch(color=INK, **BAND)
        for part, values in each.items():
            axes.plot(run.time, values, **looks[part], **style, label=part or name)
    if panel.log:
        log_scale(axes)
    else:
        widen(axes)
    axes.set_ylabel(panel.label)
    finish(axes)
    return parts, more


def draw_events(axes: Axes, runs: Runs) -> None:
    """A row of ticks for each kind of events, those at every roller fine, with lanes within it; thinned where many."""
    kinds = kinds_of(runs)
    events = lanes(runs)
    names = []
    height = 0.8 / len(events)
    most = max((np.isin(kind_of, OFTEN, invert=True).sum() for *_, kind_of in events), default=0)
    for row, kind in enumerate(kinds):
        found = [(colour, time[kind_of == kind]) for colour, time, kind_of in events]
        counts = [len(times) for _, times in found]
        every = stride(counts, MOST_TICKS)
        names.append(named(kind, every, sum(counts), between="\n"))
        width = 0.6 if kind in OFTEN else 1.8 if most < MANY else 1.0
        for lane, (colour, times) in enumerate(found):
            times = thinned(times, every)
            y = np.full(len(times), row - 0.4 + height * (lane + 0.5))
            axes.plot(times, y, "|", color=colour, label=kind, markersize=2.0 + 14.0 / len(events),
                      markeredgewidth=width)  # fmt: skip
    axes.set_yticks(range(len(kinds)), names)
    for name in axes.get_yticklabels():
        name.set_fontsize(7 if "\n" in name.get_text() else 10)
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
