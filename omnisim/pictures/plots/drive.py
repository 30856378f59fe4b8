"""Drives over time: does each wheel turn as it should, what does that take, and from where."""

import numpy as np
from matplotlib.figure import Figure

from omnisim.pictures.plots.asked import target_rates
from omnisim.pictures.plots.panels import Panel, bands_of_wheels, of_wheels, over_time
from omnisim.pictures.plots.style import PlotError, Runs, view
from omnisim.results.trajectory import Trajectory


def deviations(run: Trajectory) -> dict[str, np.ndarray]:
    """Spin rates less their targets, rad/s."""
    return {wheel: run[f"wheels/{wheel}/spin_rate"] - target for wheel, target in target_rates(run).items()}


def totals(run: Trajectory) -> dict[str, np.ndarray]:
    """Power of all drives (W): at the wheels, and of motors from their supply and into heat."""
    kinds = {"at the wheels": "drive_power", "from the supply": "electrical_power", "heat": "heat"}
    found = {name: list(of_wheels(path)(run).values()) for name, path in kinds.items()}
    return {name: np.sum(powers, axis=0) for name, powers in found.items() if powers}


SPIN_RATE = Panel("spin rate, rad/s", of_wheels("spin_rate"), targets=target_rates)
TORQUE = Panel("drive torque,\nN m", of_wheels("drive_torque"), bands_of_wheels("drive_torque"))
PANELS = (
    SPIN_RATE,
    Panel("spin rate less\ntarget, rad/s", deviations),
    TORQUE,
    Panel("voltage, V", of_wheels("voltage"), bands_of_wheels("voltage")),
    Panel("current, A", of_wheels("current"), bands_of_wheels("current")),
    Panel("mechanical\npower, W", of_wheels("drive_power"), bands_of_wheels("drive_power")),
    Panel("electrical\npower, W", of_wheels("electrical_power"), bands_of_wheels("electrical_power")),
    Panel("power of all\ndrives, W", totals),
)


@view
def drives(runs: Runs) -> Figure:
    """Spin rate and its target, torque, voltage and current, mechanical and electrical power.

    Voltage, current and electrical power are those of motors. Raises PlotError for a run in which no wheel is driven.
    """
    for name, run in runs.items():
        if not driven(run):
            raise PlotError(f"{name}: no drives to show; every wheel turns freely")
    return over_time(runs, [panel for panel in PANELS if any(panel.curves(run) for run in runs.values())])


def driven(run: Trajectory) -> bool:
    """Whether a drive gives a torque, or has a target to reach."""
    return any(run[f"wheels/{wheel}/drive_torque"].any() for wheel in run.wheels) or bool(target_rates(run))
