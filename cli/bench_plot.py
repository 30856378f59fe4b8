"""Work-precision plots, drawn from the numbers of a report: the only matplotlib import of the command."""

from collections.abc import Sequence
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from omnisim.base.files import write_whole

# Okabe & Ito: told apart with any colour vision
COLOURS = {
    "heun": "#E69F00",
    "rk4": "#0072B2",
    "dopri5": "#009E73",
    "bs5": "#56B4E9",
    "radau5": "#D55E00",
    "auto": "#CC79A7",
}
STYLES = {"explicit": ("-", "o"), "implicit": ("--", "s")}
PANEL = (4.6, 4.0)  # inches


def plot(measured: Sequence[tuple[str, dict]], folder: Path) -> None:
    """One panel for each title and its `bench_report.scene_data`, written as work_precision.png and .svg."""
    across = 2 if len(measured) == 4 else min(3, len(measured))
    down = -(-len(measured) // across)
    figure = Figure(figsize=(PANEL[0] * across, PANEL[1] * down + 0.5), layout="constrained")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    entries: dict[str, Artist] = {}
    for axes, (title, data) in zip(panels, measured, strict=False):
        panel(axes, title, data)
        handles, labels = axes.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    for axes in panels[len(measured) :]:
        axes.set_axis_off()
    label_width = 0.6 + 0.085 * max(map(len, entries))  # inches
    columns = min(len(entries), int(PANEL[0] * across / label_width))
    figure.legend(list(entries.values()), list(entries), loc="outside lower center", ncols=columns, frameon=False)
    save(figure, folder / "work_precision")


def save(figure: Figure, stem: Path) -> None:
    """Write stem.png, and stem.svg, which is the same file for the same numbers; whole or not at all."""
    png, svg = BytesIO(), BytesIO()
    figure.savefig(png, format="png", dpi=160)
    with rc_context({"svg.hashsalt": stem.name}):
        figure.savefig(svg, format="svg", metadata={"Date": None})
    images = {stem.with_suffix(".png"): png.getvalue(), stem.with_suffix(".svg"): svg.getvalue()}
    write_whole(images, overwrite=True)


def panel(axes: Axes, title: str, data: dict) -> None:
    """A line for each method and tracking; the front thick and grey behind them, its points filled.

    Errors that the reference cannot tell stand at its limit; what is beyond is shaded.
    """
    trusted = data["reference"]["distance"]
    axes.set(xscale="log", yscale="log", title=title)
    axes.set(xlabel="largest error (m, rad)", ylabel="wall time (s per simulated s)")
    finished = [row for row in data["rows"] if row["error"] is not None]
    front = sorted((row for row in finished if row["pareto"]), key=lambda row: row["wall_s_per_simulated_s"])
    axes.plot(*points(front, trusted), color="0.82", linewidth=7, solid_capstyle="round", label="Pareto front")
    for (method, tracking), line in groupby(finished, key=lambda row: (row["method"], row["tracking"])):
        curve = list(line)
        style, marker = STYLES[tracking]
        label = method if tracking == "explicit" else f"{method}, {tracking} tracking"
        look: dict[str, Any] = {
            "color": COLOURS[method],
            "linestyle": style,
            "marker": marker,
            "markersize": 5.5,
            "linewidth": 1.4,
        }
        axes.plot(*points(curve, trusted), markerfacecolor="white", label=label, **look)
        axes.plot(*points([row for row in curve if row["pareto"]], trusted), **look | {"linestyle": "none"})
    limits = axes.get_xlim()
    if trusted > limits[0]:
        axes.axvspan(limits[0], trusted, color="0.93", zorder=0, label="reference limit")
        axes.set_xlim(limits)
    axes.xaxis.set_major_locator(LogLocator(numticks=8))
    axes.grid(which="major", color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def points(rows: list[dict], trusted: float) -> tuple[list[float], list[float]]:
    """Errors as far as the reference can tell them, and seconds per simulated second."""
    return [max(row["error"], trusted) for row in rows], [row["wall_s_per_simulated_s"] for row in rows]
