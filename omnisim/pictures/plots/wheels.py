"""The picture of wheels side by side: a panel for each quantity, a group of bars for each motion."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from omnisim.pictures.plots.style import COLOURS, empty_figure, finish
from omnisim.studies.wheel_cycle import Found

PANELS = {
    "speed": ("speed beside ideal wheels, %", 1e2),
    "ripple": ("ripple of the velocity, mm/s", 1e3),
    "height": ("up and down, mm", 1e3),
    "drag": ("drag, N", 1.0),
    "energy": ("energy, J/m", 1.0),
    "load": ("peak load, of its share", 1.0),
}
GROUP = 0.8  # of the room of a motion that its bars take


def side_by_side(title: str, names: Sequence[str], found: Sequence[dict[str, Found | str]]) -> Figure:
    """What wheels with these names were Found to do in each motion; no bar where a run has stopped."""
    figure = empty_figure(11.5, 5.8)
    motions = list(found[0])
    place, width = np.arange(len(motions)), GROUP / len(names)
    shown = [quantity for quantity in PANELS if told(found, quantity)]
    panels = figure.subplots(2, 3).ravel()
    for axes in panels[len(shown) :]:
        axes.set_axis_off()
    for axes, quantity in zip(panels, shown, strict=False):
        label, factor = PANELS[quantity]
        for i, (name, entries) in enumerate(zip(names, found, strict=True)):
            values = [value(entries[motion], quantity) * factor for motion in motions]
            where = place - 0.5 * GROUP + (i + 0.5) * width
            axes.bar(where, values, width, color=COLOURS[i % len(COLOURS)], label=name)
        axes.set_xticks(place, motions)
        axes.set_title(label, fontsize=10)
        finish(axes)
    bars = panels[0].get_legend_handles_labels()
    if len(shown) < len(panels):
        panels[-1].legend(*bars, loc="center")
    else:
        figure.legend(*bars, loc="outside lower center", ncols=min(len(names), 5))
    figure.suptitle(title, fontsize=11, parse_math=False)
    return figure


def told(found: Sequence[dict[str, Found | str]], quantity: str) -> bool:
    """Whether any wheel has a number of it."""
    return any(np.isfinite(value(entry, quantity)) for motions in found for entry in motions.values())


def value(found: Found | str, quantity: str) -> float:
    """A quantity of a motion, NaN where there is none."""
    number = None if isinstance(found, str) else getattr(found, quantity)
    return float("nan") if number is None else number
