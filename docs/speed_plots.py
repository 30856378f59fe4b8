"""Plots of the pages on speed and accuracy, from what `python -m bench --report` wrote."""

from collections.abc import Callable
from itertools import groupby
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from omnisim_cli import bench_plot

OURS, ENGINES = "#0072B2", {"mujoco_peer": ("MuJoCo", "#D55E00", "o"), "drake_peer": ("Drake", "#CC79A7", "s")}
FORMS = {"NumPy": ("#D55E00", "^"), "scalars": ("#E69F00", "s"), "compiled": ("#CC79A7", "D")}  # of SciPy's equations
GREY = "0.6"
RESOLVED = 1e-9  # m: what the reference of the engines is good to
SHARED = {"color": "0.9", "linewidth": 0.6}  # grids


def draw(records: dict[str, dict], folder: Path) -> dict[str, str]:
    """Every plot as PNG and SVG; the stem of each, by the benchmark where it stands."""
    drawn = {}
    if "precision" in records:
        bench_plot.plot(list(records["precision"]["result"].items()), folder)
        drawn["precision"] = "work_precision"
    for name, (stem, size, paint) in FIGURES.items():
        if name in records:
            figure = Figure(figsize=size, layout="constrained")
            paint(figure, records)
            bench_plot.save(figure, folder / stem)
            drawn[name] = stem
    return drawn


def draw_limit(figure: Figure, records: dict[str, dict]) -> None:
    """Bars of ns per step: omnisim, the C loops, what the arithmetic alone would take."""
    axes = figure.subplots()
    result = records["limit"]["result"]
    labels, widths, colours = [], [], []
    for scene in [name for name in result if name != "cost"]:
        row = result[scene]
        bounds = {"floor of the arithmetic": row["floor"], "critical path": row["step"]["path"]}
        for how, ns in (row["ns_per_step"] | bounds).items():
            labels.append(f"{scene}: {how}")
            widths.append(ns)
            colours.append(OURS if how == "omnisim" else GREY if how in bounds else "#E69F00")
    bars = axes.barh(labels, widths, color=colours)
    axes.bar_label(bars, fmt="%.0f", padding=3)
    axes.invert_yaxis()
    axes.set(xlabel="ns per RK4 step", title="omnisim, C loops, and the limit of the arithmetic")
    axes.margins(x=0.12)


def draw_scipy(figure: Figure, records: dict[str, dict]) -> None:
    """A panel for each scene: every solver of SciPy that reaches an error, and the march, by form and method."""
    scenes = records["scipy_peer"]["result"]
    panels = figure.subplots(1, len(scenes), squeeze=False).ravel()
    entries = {}
    for axes, (name, part) in zip(panels, scenes.items(), strict=True):
        for form, (colour, marker) in FORMS.items():
            rows = [row for row in part["trials"] if row["form"] == form]
            look = {"color": colour, "marker": marker, "linestyle": "none", "markerfacecolor": "none"}
            axes.plot(*errors_and_ms(rows), label=f"SciPy, {form}", **look)
        for method in ("rk4", "dopri5"):
            rows = [row["ours"][method] for row in part["equal"] if method in row["ours"]]
            axes.plot(*errors_and_ms(rows), color=bench_plot.COLOURS[method], marker="o", label=f"omnisim, {method}")
        axes.set(xscale="log", yscale="log", title=name, xlabel="error at the end (m, rad)", ylabel="wall time (ms)")
        axes.xaxis.set_minor_formatter(NullFormatter())
        axes.grid(which="major", **SHARED)
        handles, labels = axes.get_legend_handles_labels()
        entries |= dict(zip(labels, handles, strict=True))
    figure.legend(entries.values(), entries, loc="outside lower center", ncols=len(entries), frameon=False)


def errors_and_ms(rows: list[dict]) -> tuple[list[float], list[float]]:
    return [row["error"] for row in rows], [row["ms"] for row in rows]


def draw_engines(figure: Figure, records: dict[str, dict]) -> None:
    """Every run of the engines and of omnisim: wall time of two simulated seconds against the error of the position."""
    axes = figure.subplots()
    for name, (engine, colour, marker) in ENGINES.items():
        if name in records:
            result = records[name]["result"]
            rows = result["rows"] if "rows" in result else result["survey"] + result["ladders"]
            rows = [row for row in rows if row["position_error"] < float("inf")]
            axes.plot(*position(rows), marker, color=colour, markersize=5, markerfacecolor="none", label=engine)
    ours = [row | row["simulate"] for row in records["mujoco_peer"]["result"]["omnisim"]]
    for method, group in groupby(ours, key=lambda row: row["method"]):
        look = {"color": bench_plot.COLOURS[method], "marker": "o", "markersize": 5, "linewidth": 1.4}
        axes.plot(*position(list(group)), label=f"omnisim, {method}", **look)
    axes.set(
        xscale="log",
        yscale="log",
        xlabel=f"position off by, at 2 s (m); the reference is good to {RESOLVED:g}",
        ylabel="wall time of 2 s (s)",
    )
    axes.set_title("One wheel under Coulomb friction: omnisim and general engines")
    axes.grid(which="major", **SHARED)
    figure_legend(axes)


def position(rows: list[dict]) -> tuple[list[float], list[float]]:
    """Errors of the position, m, and seconds."""
    return [max(row["position_error"], RESOLVED) for row in rows], [row["seconds"] for row in rows]


def draw_wheels(figure: Figure, records: dict[str, dict]) -> None:
    """ns of a step by the number of wheels."""
    axes = figure.subplots()
    for (law, rows), colour in zip(
        records["whole_machines"]["result"]["wheels"].items(), (OURS, "#E69F00"), strict=True
    ):
        wheels, ns = [row["wheels"] for row in rows], [row["ns"] for row in rows]
        axes.plot(wheels, ns, marker="o", color=colour, label=law)
    axes.set(
        xlabel="wheels",
        ylabel="ns per RK4 step",
        title="Rings of omni wheels that stick",
        ylim=(0, None),
        xlim=(0, None),
    )
    axes.grid(which="major", **SHARED)
    axes.legend(frameon=False)


def draw_kernels(figure: Figure, records: dict[str, dict]) -> None:
    """Bars of ns by method and tracking."""
    axes = figure.subplots()
    result = records["kernels"]["result"]
    places = range(len(result))
    for shift, tracking, colour in ((-0.2, "explicit", OURS), (0.2, "implicit", "#E69F00")):
        heights = [row[tracking] for row in result.values()]
        bars = axes.bar([place + shift for place in places], heights, 0.38, color=colour, label=f"{tracking} tracking")
        axes.bar_label(bars, fmt="%.0f", padding=2)
    axes.set_xticks(places, ["right-hand side" if what == "rhs" else f"step, {what}" for what in result])
    axes.set(ylabel="ns", title="A bare wheel of six rollers")
    axes.margins(y=0.1)
    axes.legend(frameon=False)


def figure_legend(axes: Axes) -> None:
    """To the right, where no point is."""
    axes.legend(frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))


FIGURES: dict[str, tuple[str, tuple[float, float], Callable[[Figure, dict], None]]] = {
    "limit": ("limit", (8.0, 4.2), draw_limit),
    "scipy_peer": ("scipy", (13.0, 4.4), draw_scipy),
    "mujoco_peer": ("engines", (8.0, 4.2), draw_engines),
    "whole_machines": ("wheels", (5.6, 3.8), draw_wheels),
    "kernels": ("kernels", (6.4, 3.8), draw_kernels),
}
