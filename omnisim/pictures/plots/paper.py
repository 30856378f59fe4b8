"""Figures 5 to 7 of the paper: how far two contact trackings are apart."""

from matplotlib.figure import Figure

from omnisim.pictures.plots.panels import WIDTH
from omnisim.pictures.plots.style import (
    COLOURS,
    INK,
    PlotError,
    Runs,
    figure_of,
    finish,
    legend_beside,
    log_scale,
    view,
)
from omnisim.results.comparison import PAPER, same_contacts

UNITS = {"acceleration": "m/s$^2$", "velocity": "m/s", "position": "m"}


@view
def trackings(runs: Runs) -> Figure:
    """Differences over time of two runs in the height of the centre of the first wheel's roller 0, and the paper's.

    Rows in which the runs have different rollers in contact are left out, as in `analysis.compare`; on a logarithmic
    axis so are those without difference. Raises PlotError unless there are two runs of one title, wheels and times.
    """
    if len(runs) != 2:
        raise PlotError("two trackings are compared: two files, please")
    a, b = runs.values()
    rows = min(len(a.time), len(b.time))
    unlike = a.attributes["title"] != b.attributes["title"] or a.wheels != b.wheels
    if unlike or (a.time[:rows] != b.time[:rows]).any():
        raise PlotError(f"{' and '.join(runs)} are not two runs of one scene: title, wheels or output times differ")
    chosen = same_contacts(a, b)
    first, second = (run.attributes["tracking"] for run in (a, b))
    what = f"height of the centre of roller 0: {first} less {second} tracking"
    figure = figure_of({f"{a.attributes['title']}\n{what}": a}, WIDTH, 7.0)
    for axes, (name, bound) in zip(figure.subplots(3, 1, sharex=True), PAPER.items(), strict=True):
        path = f"wheels/{a.wheels[0]}/rollers/center_{name}"
        of_a, of_b = (run[path][:rows, 0, 2][chosen] for run in (a, b))
        look = {"color": COLOURS[0], "markersize": 3, "linewidth": 0.7, "label": name}
        line = axes.plot(a.time[:rows][chosen], abs(of_a - of_b), ".-", **look)
        log_scale(axes)
        bound_line = axes.axhline(bound, color=INK, linestyle="--", linewidth=1.0)
        legend_beside(axes, [*line, bound_line], ["difference", f"the paper: {bound:.0e}"])
        axes.set_ylabel(f"{name}, {UNITS[name]}")
        finish(axes)
    axes.set_xlabel("time, s")
    return figure
