"""What bearings carry: those of the wheels, and those of the rollers."""

import numpy as np
from matplotlib.figure import Figure

from omnisim.pictures.plots.panels import Bands, Curves, Panel, over_time, upwards
from omnisim.pictures.plots.style import PlotError, Runs, view
from omnisim.results.layout import HUB, LABELS, MOUNT, ROLLERS, WHEELS
from omnisim.results.trajectory import Trajectory

AXLE, ROLLER_AXIS = LABELS[HUB].index("k"), LABELS[MOUNT].index("axial")


@view
def bearings(runs: Runs) -> Figure:
    """Radial and axial force and tilting moment of each wheel's axle, and of the roller that carries most at the time.

    Raises PlotError for a run without them; a bare wheel has no axle.
    """
    for name, run in runs.items():
        if f"wheels/{run.wheels[0]}/rollers/bearing_force" not in run:
            raise PlotError(f"{name}: no bearing loads; output.bearing_loads = true in the scene writes them")
    panels = [*panels_of("axle", WHEELS, AXLE)] if any(has_axle(run) for run in runs.values()) else []
    return over_time(runs, [*panels, *panels_of("roller", ROLLERS, ROLLER_AXIS)])


def has_axle(run: Trajectory) -> bool:
    return f"wheels/{run.wheels[0]}/bearing_force" in run


def panels_of(name: str, group: str, axis: int) -> list[Panel]:
    """The three loads of the bearings in a group of the file, whose axle points along an axis."""

    def panel(label: str, load: str, dataset: str, part) -> Panel:
        def curves(run: Trajectory) -> Curves:
            paths = {wheel: f"{group.format(wheel=wheel)}/{dataset}" for wheel in run.wheels}
            return {wheel: most(part(run[path], axis)) for wheel, path in paths.items() if path in run}

        def bands(run: Trajectory) -> Bands:
            paths = {wheel: f"{group.format(wheel=wheel)}/bearing_{load}" for wheel in run.wheels}
            found = {wheel: peak(run, path) for wheel, path in paths.items() if f"interval_max/{path}" in run}
            return {wheel: upwards(curves(run)[wheel], highest) for wheel, highest in found.items()}

        return Panel(f"{name}, {label}", curves, bands)

    return [
        panel("radial, N", "radial_force", "bearing_force", across),
        panel("axial, N", "axial_force", "bearing_force", along),
        panel("tilting\nmoment, N m", "tilting_moment", "bearing_moment", across),
    ]


def peak(run: Trajectory, path: str) -> np.ndarray:
    """The largest magnitude (T) of a load since the row before, whichever its sign."""
    extremes = [most(np.abs(run[f"{group}/{path}"])) for group in ("interval_max", "interval_min")
                if f"{group}/{path}" in run]  # fmt: skip
    return np.max(extremes, axis=0)


def across(loads: np.ndarray, axis: int) -> np.ndarray:
    """Size of the components across an axis."""
    return np.linalg.norm(np.delete(loads, axis, axis=-1), axis=-1)


def along(loads: np.ndarray, axis: int) -> np.ndarray:
    """Size of the component along an axis."""
    return np.abs(loads[..., axis])


def most(loads: np.ndarray) -> np.ndarray:
    """Of loads (T) or (T, N_r): the largest at each time (T)."""
    return loads.max(axis=1) if loads.ndim > 1 else loads
