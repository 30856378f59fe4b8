"""One figure that tells what happens in a run."""

from matplotlib.figure import Figure

from omnisim.pictures.plots.drive import SPIN_RATE, TORQUE, driven
from omnisim.pictures.plots.floor import draw_path
from omnisim.pictures.plots.marks import kinds_of
from omnisim.pictures.plots.motion import (
    BALANCE,
    HEIGHT,
    INCLINATION,
    NORMAL_FORCE,
    SLIP_SPEED,
    SPEED,
    WORKS,
    YAW_RATE,
    is_free,
)
from omnisim.pictures.plots.panels import LANE, draw_column
from omnisim.pictures.plots.style import Runs, figure_of, view

WIDTH, TALL = 14.0, 8.0  # inches


@view
def story(runs: Runs) -> Figure:
    """Path and energy at the left; speed, yaw rate, drives, normal forces, slip and events over time at the right; of
    machines free in space height, roll and pitch too."""
    drives = [SPIN_RATE, TORQUE] if any(driven(run) for run in runs.values()) else []
    free = [HEIGHT, INCLINATION] if all(is_free(run) for run in runs.values()) else []
    panels = [SPEED, YAW_RATE, *free, *drives, NORMAL_FORCE, SLIP_SPEED]
    kinds = len(kinds_of(runs))
    height = TALL + 1.1 * len(drives + free)  # a label is as long as its panel is high
    figure = figure_of(runs, WIDTH, height)
    left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=(0.85, 1.0))[0]
    path, works, balance = left.subplots(3, 1, height_ratios=(3.6, 1.0, 1.0))
    balance.sharex(works)
    works.tick_params(labelbottom=False)
    draw_path(path, runs)
    draw_column([works, balance], [WORKS, BALANCE], runs)
    heights = [height / (len(panels) + 1.0)] * len(panels) + [LANE * kinds] * bool(kinds)
    draw_column(right.subplots(len(heights), 1, sharex=True, height_ratios=heights), panels, runs)
    return figure
