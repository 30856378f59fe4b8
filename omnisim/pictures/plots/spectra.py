"""The ripple that real rollers cause, as spectra over the exchange frequency."""

import numpy as np
from matplotlib.figure import Figure

from omnisim.pictures.plots.asked import rows_of
from omnisim.pictures.plots.panels import WIDTH
from omnisim.pictures.plots.style import PlotError, Runs, figure_of, finish, legend_of_parts, log_scale, look, nth, view
from omnisim.results.ripple import RippleError, of_wheel
from omnisim.results.trajectory import Trajectory

DECADES = 4  # shown below the largest amplitude


@view
def ripple(runs: Runs) -> Figure:
    """Amplitudes of the forward speed, by the rollers of the first wheel, and of each wheel's normal force.

    Wheels that do not turn far enough are left out. Raises PlotError if none does, or rows are too far apart.
    """
    spectra = {name: of_normal_forces(name, run) for name, run in runs.items()}
    wheels = list(dict.fromkeys(wheel for found in spectra.values() for wheel in found))
    numbers = nth(wheels, runs)
    figure = figure_of(runs, WIDTH, 6.5)
    above, below = figure.subplots(2, 1, sharex=True)
    for number, (name, found) in enumerate(spectra.items()):
        for wheel, spectrum in found.items():
            below.plot(*spectrum, label=wheel, **look(number, numbers[wheel], len(runs)))
        run, wheel = runs[name], next(iter(found))
        speed = of_wheel(run, wheel, forward_speed(run), rows_of(run, wheel))
        above.plot(*speed, label=name, **look(number, 0, len(runs)))
    if len(wheels) > 1:
        legend_of_parts(below, wheels, runs, {})
    above.set(ylabel="forward speed, m/s")
    below.set(ylabel="normal force, N", xlabel="frequency over the wheel's exchange frequency")
    for axes in (above, below):
        log_scale(axes)
        largest = max(line.get_ydata().max() for line in axes.get_lines())
        axes.set_ylim(bottom=10.0**-DECADES * largest or None)
        finish(axes)
    return figure


def forward_speed(run: Trajectory) -> np.ndarray:
    """Velocity (T) along the heading, m/s."""
    yaw, velocity = run["body/yaw"], run["body/velocity"]
    return np.cos(yaw) * velocity[:, 0] + np.sin(yaw) * velocity[:, 1]


def of_normal_forces(name: str, run: Trajectory) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Orders and amplitudes (N) by wheel, of those that have a spectrum; PlotError if none has."""
    found = {}
    reasons = []
    for wheel in run.wheels:
        try:
            found[wheel] = of_wheel(run, wheel, run[f"wheels/{wheel}/normal_force"], rows_of(run, wheel))
        except RippleError as error:
            reasons.append(f"{name}: no ripple to show: wheel '{wheel}' {error}")
    if not found:
        raise PlotError(reasons[0])
    return found
