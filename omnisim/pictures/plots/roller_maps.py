"""How fast every roller spins in its bearing."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from omnisim.pictures.plots.style import INK, Runs, empty_figure, view
from omnisim.results.layout import ROLLER
from omnisim.results.trajectory import Trajectory

COLOUR_MAP = "PuOr"  # two colours about white, told apart with any colour vision


@view
def rollers(runs: Runs) -> Figure:
    """A map for each wheel: a row for each roller, its joint rate over time as colour; a line follows the contact."""
    most = max(len(run.wheels) for run in runs.values())
    figure = empty_figure(3.0 + 6.0 * len(runs), 1.2 + 2.0 * most)
    grid = figure.subplots(most, len(runs), sharex="col", squeeze=False)
    limit = max(float(np.abs(rates(run, wheel)).max()) for run in runs.values() for wheel in run.wheels) or 1.0
    images = []
    for (name, run), column in zip(runs.items(), grid.T, strict=True):
        column[0].set_title(name, parse_math=False)
        images += [draw_map(axes, run, wheel, limit) for axes, wheel in zip(column, run.wheels, strict=False)]
        column[len(run.wheels) - 1].set_xlabel("time, s")
        for axes in column[len(run.wheels) :]:
            axes.set_axis_off()
    figure.colorbar(images[0], ax=grid, label="joint rate, rad/s")
    return figure


def rates(run: Trajectory, wheel: str) -> np.ndarray:
    """Joint rates (T, N_r), rad/s."""
    return run[f"wheels/{wheel}/rollers/joint_rate"]


def draw_map(axes: Axes, run: Trajectory, wheel: str, limit: float) -> AxesImage:
    """The map of one wheel; returned for the colour bar."""
    time = run.time
    count = len(run[ROLLER.format(wheel=wheel)])
    half = 0.5 * (time[1] if len(time) > 1 else 1.0)  # a row is shown about its time
    extent = time[0] - half, time[-1] + half, -0.5, count - 0.5
    image = axes.imshow(rates(run, wheel).T, origin="lower", aspect="auto", interpolation="nearest", extent=extent,
                        cmap=COLOUR_MAP, vmin=-limit, vmax=limit)  # fmt: skip
    axes.plot(time, run[f"wheels/{wheel}/contact_roller"], drawstyle="steps-mid", color=INK, linewidth=0.9)
    axes.set_ylabel(f"{wheel}\nroller")
    axes.locator_params(axis="y", integer=True)
    axes.tick_params(labelbottom=wheel == run.wheels[-1])
    return image
