"""Pictures of studies: the one that fits how many keys vary."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from omnisim.pictures.plots.style import COLOURS, QUIET, PlotError, empty_figure, finish
from omnisim.studies.effects import first_order
from omnisim.studies.result import RUN, StudyResult

PANEL = 2.6  # inches
MANY = 60  # runs, from which on the points of a curve are small
MOST_KEYS, MOST_MEASURES = 8, 8  # in a matrix
TOLD = "; line and band: median, 10 to 90 %; explains: share of the variance ± two deviations"
BAND = (10.0, 90.0)  # percentiles


def study(found: StudyResult) -> Figure:
    """One varied key: curves, which have no spread since nothing else varies; two on a grid: maps; else every measure
    against every key, with how much of its variance the key alone explains.

    Raises PlotError where no run has a number.
    """
    measures = [name for name in found.measures if np.isfinite(found[name]).any()]
    if not measures:
        raise PlotError("no measure of this study has a number in any run")
    names = list(keys_of(found))
    told = ""
    if len(names) == 1:
        figure = curves(found, names[0], measures)
    elif len(names) == 2 and found.attributes["design"] == "grid":
        figure = maps(found, names[0], names[1], measures)
    else:
        figure = matrix(found, names[:MOST_KEYS], measures[:MOST_MEASURES])
        told = TOLD
    a = found.attributes
    figure.suptitle(f"{a['finished']} of {a['runs']} runs, {a['design']}{told}", fontsize=10, parse_math=False)
    return figure


def keys_of(found: StudyResult) -> dict[str, np.ndarray]:
    """The varied keys with a value for every run; of one drawn for each wheel, each."""
    keys = [name for name, one in found.variables.items() if one.coordinate and name != RUN and "." in name]
    if found.attributes["design"] == "grid":
        places = np.meshgrid(*(found[key] for key in keys), indexing="ij")
        return {key: place.ravel() for key, place in zip(keys, places, strict=True)}
    columns: dict[str, np.ndarray] = {}
    for key in keys:
        values = found[key]
        if values.ndim == 1:
            columns[key] = values
            continue
        names = found[found.variables[key].dims[1]]
        columns |= {key.replace("*", str(name), 1): values[:, i] for i, name in enumerate(names)}
    return columns


def numbers(values: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Values on an axis, and labels for its ticks if they are no numbers."""
    if values.dtype.kind in "if":
        return values.astype(float), []
    labels, places = np.unique(values, return_inverse=True)
    return places.astype(float), [str(label) for label in labels]


def curves(found: StudyResult, key: str, measures: list[str]) -> Figure:
    figure = empty_figure(7.5, 1.0 + PANEL * len(measures))
    values = keys_of(found)[key]
    x, labels = numbers(values)
    order = np.argsort(x, kind="stable")
    rows = figure.subplots(len(measures), 1, sharex=True, squeeze=False)[:, 0]
    for axes, name in zip(rows, measures, strict=True):
        y = found[name].ravel()[order]
        there = np.isfinite(y)
        axes.plot(x[order][there], y[there], "o-", color=COLOURS[0], markersize=4 if len(x) <= MANY else 1.5)
        axes.set_ylabel(label(found, name), parse_math=False)
        finish(axes)
    rows[-1].set_xlabel(key, parse_math=False)
    ticks(rows[-1], labels)
    return figure


def cloud(axes: Axes, x: np.ndarray, y: np.ndarray) -> None:
    """Runs as points, their median and the band of most of them in classes of x."""
    axes.plot(x, y, ".", color=QUIET, markersize=2.5, alpha=0.6)
    there = np.isfinite(y)
    classes = np.array_split(np.flatnonzero(there), max(3, round(there.sum() ** (1.0 / 3.0))))
    middle = [np.median(x[part]) for part in classes]
    low, half, high = np.transpose([np.percentile(y[part], (BAND[0], 50.0, BAND[1])) for part in classes])
    axes.fill_between(middle, low, high, color=COLOURS[0], alpha=0.22, linewidth=0)
    axes.plot(middle, half, color=COLOURS[0])


def maps(found: StudyResult, across: str, up: str, measures: list[str]) -> Figure:
    columns = min(len(measures), 3)
    lines = -(-len(measures) // columns)
    figure = empty_figure(4.4 * columns, 0.6 + 3.6 * lines)
    (x, x_labels), (y, y_labels) = numbers(found[across]), numbers(found[up])
    everything = figure.subplots(lines, columns, squeeze=False).ravel()
    for axes, name in zip(everything, measures, strict=False):
        drawn = axes.pcolormesh(x, y, np.ma.masked_invalid(found[name].T), shading="nearest", cmap="viridis")
        figure.colorbar(drawn, ax=axes).set_label(label(found, name), parse_math=False)
        axes.set_facecolor("0.85")  # where there is no number
        axes.set_xlabel(across, parse_math=False)
        axes.set_ylabel(up, parse_math=False)
        ticks(axes, x_labels)
        if y_labels:
            axes.set_yticks(range(len(y_labels)), y_labels)
    for axes in everything[len(measures) :]:
        axes.remove()
    return figure


def matrix(found: StudyResult, keys: list[str], measures: list[str]) -> Figure:
    figure = empty_figure(1.2 + 2.1 * len(keys), 1.0 + 2.1 * len(measures))
    values = keys_of(found)
    panels = figure.subplots(len(measures), len(keys), sharex="col", sharey="row", squeeze=False)
    for row, name in zip(panels, measures, strict=True):
        y = found[name].ravel()
        for axes, key in zip(row, keys, strict=True):
            x, labels = numbers(values[key])
            order = np.argsort(x, kind="stable")
            cloud(axes, x[order], y[order])
            effect = first_order(x, y)
            if effect:
                axes.set_title(f"explains {effect.share:.2f} ± {2.0 * effect.deviation:.2f}", fontsize=8)
            ticks(axes, labels)
            finish(axes)
        row[0].set_ylabel(label(found, name), parse_math=False, fontsize=8)
    for axes, key in zip(panels[-1], keys, strict=True):
        axes.set_xlabel(key, parse_math=False, fontsize=8)
    return figure


def label(found: StudyResult, name: str) -> str:
    units = found.variables[name].units
    return name if units == "1" else f"{name} ({units})"


def ticks(axes: Axes, labels: list[str]) -> None:
    if labels:
        axes.set_xticks(range(len(labels)), labels, rotation=30, ha="right", parse_math=False)
