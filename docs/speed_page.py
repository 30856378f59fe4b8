"""Writes docs/speed_and_accuracy.md and its plots: python docs/speed_page.py (needs the extra `docs`).

Nothing is measured here: the numbers stand in bench/results, from `python bench/run.py --report bench/results`.
"""

import json
import sys
from collections.abc import Callable
from itertools import groupby
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
from common import Claim, claims_table, table

from omnisim_cli import bench_plot

HERE = Path(__file__).parent
RESULTS = HERE.parent / "bench/results"
EXPLICIT, DEFAULT = ("heun", "rk4", "dopri5"), "rk4"
METHODS = (*EXPLICIT, "radau5", "auto")
ERRORS = (1e-6, 1e-9)  # m, rad
LONG = 12  # rows: longer tables are folded
# In the order of the page; results of other benchmarks stand elsewhere.
SECTIONS = (
    "precision",
    "targets",
    "c_loop",
    "limit",
    "scipy_peer",
    "mujoco_peer",
    "mujoco_platform",
    "drake_peer",
    "laws",
    "whole_machines",
    "formulations",
    "hard_cases",
    "kernels",
    "scaling",
    "startup",
    "memory",
)
INTRODUCTION = """# Speed and accuracy

Written by `python docs/speed_page.py` from the numbers in [bench/results](../bench/results); every section names the
machine, the day and the command that repeats it. Ratios are medians of rounds in which the contestants took turns; the
rules stand in [bench/README.md](../bench/README.md), what real rollers do to machines in [machines.md](machines.md)."""
CLAIMS = (
    """A target is what is aimed at. Beyond its alarm a value is no noise of a machine; `bench/run.py --check` fails."""
)
OURS, ENGINES = "#0072B2", {"mujoco_peer": ("MuJoCo", "#D55E00", "o"), "drake_peer": ("Drake", "#CC79A7", "s")}
FORMS = {"NumPy": ("#D55E00", "^"), "scalars": ("#E69F00", "s"), "compiled": ("#CC79A7", "D")}  # of SciPy's equations
GREY = "0.6"
RESOLVED = 1e-9  # m: what the reference of the engines is good to
SHARED = {"color": "0.9", "linewidth": 0.6}  # grids


def main() -> None:
    records = read(RESULTS)
    plots = HERE / "speed"
    plots.mkdir(exist_ok=True)
    drawn = draw(records, plots)
    (HERE / "speed_and_accuracy.md").write_text(page(records, drawn), encoding="utf-8")


def read(folder: Path) -> dict[str, dict]:
    """What `bench/run.py --report` wrote, by benchmark."""
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted(folder.glob("*.json"))}


# --- text -----------------------------------------------------------------------------------------


def page(records: dict[str, dict], drawn: dict[str, str]) -> str:
    """The whole page; drawn: the stem of the plot of each benchmark that has one."""
    names = dict.fromkeys([name for name in SECTIONS if name in records] + list(records))
    claims = [Claim(**claim) for name in names for claim in records[name]["claims"]]
    parts = [INTRODUCTION, verdict(claims)]
    if "precision" in records:
        parts.append(recommendation(records["precision"]["result"]))
    parts += ["## Claims", claims_table(claims), CLAIMS]
    parts += [section(records[name], drawn.get(name)) for name in SECTIONS if name in records]
    return "\n\n".join(parts) + "\n"


def verdict(claims: list[Claim]) -> str:
    """How many targets are met, and a line for each that is not."""
    missed = [
        f"- {claim.text}: {claim.value:.3g}, to be {claim.bound} {claim.target:g}" for claim in claims if not claim.met
    ]
    met = f"**{len(claims) - len(missed)} of {len(claims)} targets are met.**"
    return "\n".join([f"{met} Missed:", "", *missed]) if missed else met


def recommendation(scenes: dict[str, dict]) -> str:
    """What each method gives at an error that most want and at a small one, and how far the default falls behind."""
    lines, behind = [], []
    for name, scene in scenes.items():
        for limit in ERRORS:
            speeds = {method: fastest(scene["rows"], method, limit) for method in METHODS}
            best = max(speeds, key=speeds.get)
            cells = [f"{speed:.3g}" if speed < 1e3 else f"{speed:.0f}" for speed in speeds.values()]
            marked = [f"**{cell}**" if method == best else cell for method, cell in zip(METHODS, cells, strict=True)]
            lines.append([name, f"{limit:.0e}", *(cell if cell.strip("*") != "0" else "-" for cell in marked)])
            if limit == ERRORS[0] and best in EXPLICIT and speeds[DEFAULT]:
                behind.append(speeds[best] / speeds[DEFAULT])
    return "\n\n".join(
        [
            "## Which method, which step",
            f"`{DEFAULT}`, the default, with a step from `solver.error`: of {len(scenes)} scenes there are "
            f"{len(behind)} on which it is the fastest with errors below {ERRORS[0]:.0e}, or another explicit one at "
            f"most {max(behind):.2f} times as fast. Smaller errors of a bare wheel, and a wheel near its limit of "
            "friction, are faster by `dopri5`; where friction is stiff, `auto` or `radau5`. The fastest "
            "march of each, times real time:",
            table(["scene", "errors below", *METHODS], lines),
        ]
    )


def fastest(rows: list[dict], method: str, limit: float) -> float:
    """Times real time of a method's fastest march with errors below a limit, by explicit tracking; 0: none."""
    speeds = [
        1.0 / row["wall_s_per_simulated_s"]
        for row in rows
        if (row["method"], row["tracking"]) == (method, "explicit")
        and row["error"] is not None
        and row["error"] < limit
    ]
    return max(speeds, default=0.0)


def section(record: dict, plot: str | None) -> str:
    """One benchmark."""
    versions = ", ".join(f"{name} {version}" for name, version in record["versions"].items())
    where = f"{record['machine']}; {versions}; {record['date'][:10]}; `{record['command']}`"
    picture = [f"[![{record['title']}](speed/{plot}.png)](speed/{plot}.svg)"] if plot else []
    return "\n\n".join([f"## {record['title']}", where, *picture, folded(record["report"])])


def folded(text: str) -> str:
    """Markdown whose long tables open on demand."""
    parts = []
    for is_table, group in groupby(text.split("\n"), key=lambda line: line.startswith("|")):
        lines = list(group)
        rows = len(lines) - 2  # without header and rule
        if is_table and rows > LONG:
            lines = [f"<details><summary>{rows} rows</summary>", "", *lines, "", "</details>"]
        parts += lines
    return "\n".join(parts)


# --- plots ----------------------------------------------------------------------------------------


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


if __name__ == "__main__":
    main()
