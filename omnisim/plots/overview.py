"""One figure that tells what happens in a run."""

from matplotlib.figure import Figure

from omnisim.plots.floor import draw_path
from omnisim.plots.motion import BALANCE, NORMAL_FORCE, SLIP_SPEED, SPEED, WORKS, YAW_RATE
from omnisim.plots.panels import LANE, draw_column, kinds_of
from omnisim.plots.style import Runs, figure_of, view

WIDTH, HEIGHT = 14.0, 8.0  # inches


@view
def story(runs: Runs) -> Figure:
    """Path and energy at the left; speed, yaw rate, normal forces, slip and events over time at the right."""
    figure = figure_of(runs, WIDTH, HEIGHT)
    left, right = figure.subfigures(1, 2, width_ratios=(0.85, 1.0))
    path, works, balance = left.subplots(3, 1, height_ratios=(3.6, 1.0, 1.0))
    balance.sharex(works)
    works.tick_params(labelbottom=False)
    draw_path(path, runs)
    draw_column([works, balance], [WORKS, BALANCE], runs)
    panels, kinds = [SPEED, YAW_RATE, NORMAL_FORCE, SLIP_SPEED], len(kinds_of(runs))
    heights = [HEIGHT / 5.0] * len(panels) + [LANE * kinds] * bool(kinds)
    draw_column(right.subplots(len(heights), 1, sharex=True, height_ratios=heights), panels, runs)
    return figure
