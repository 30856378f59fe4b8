"""Made-up trajectories with all that a file may have, and what stands in a figure of them."""

import numpy as np
import pytest
from synthetic import synthetic_attributes, synthetic_data, synthetic_trajectory

from omnisim.base.status import EVENT_KINDS
from omnisim.results.trajectory import Trajectory

matplotlib = pytest.importorskip("matplotlib", reason="needs matplotlib")
matplotlib.use("agg")


MACHINE = ("left", "back", "right")


def machine(**attributes):
    """A made-up machine with all that a file may have, and every kind of event."""
    data = synthetic_data(rows=41, rollers=(6, 6, 8), events=2 * len(EVENT_KINDS), wheels=MACHINE)
    random, rows = np.random.default_rng(1).standard_normal, 41
    data |= {f"odometry/{name}": random((rows, 2)) for name in ("position", "position_error")}
    data |= {f"odometry/{name}": random(rows) for name in ("yaw", "yaw_error")}
    for wheel, n in zip(MACHINE, (6, 6, 8), strict=True):
        data[f"wheels/{wheel}/spin_angle"] = np.linspace(0.0, 6.0, rows)
        data |= {f"wheels/{wheel}/bearing_{name}": random((rows, 3)) for name in ("force", "moment")}
        data |= {f"wheels/{wheel}/rollers/bearing_{name}": random((rows, n, 3)) for name in ("force", "moment")}
    return Trajectory(synthetic_attributes(wheels=MACHINE, **attributes), data)


def motors():
    """The same with motors that have targets, and with the extremes between rows."""
    run = machine()
    random = np.random.default_rng(2).standard_normal
    for wheel in MACHINE:
        of = f"wheels/{wheel}"
        run.data |= {f"{of}/{name}": random(41) for name in ("target_rate", "voltage", "current", "electrical_power")}
        for name in ("normal_force", "drive_torque", "drive_power"):
            run.data[f"interval_max/{of}/{name}"] = run[f"{of}/{name}"] + 1.0
            run.data[f"interval_min/{of}/{name}"] = run[f"{of}/{name}"] - 2.0
        for name in ("slip_velocity", "friction_force"):
            run.data[f"interval_max/{of}/{name}"] = np.hypot(*run[f"{of}/{name}"].T) + 3.0
    return run


def undriven():
    run = synthetic_trajectory()
    run.data["wheels/wheel/drive_torque"] = np.zeros(11)
    return run


def axes_of(figure, ylabel):
    (axes,) = [axes for axes in figure.axes if axes.get_ylabel().replace("\n", " ") == ylabel]
    return axes


def lines(figure, ylabel):
    """The curves (x, y) of the axes with this label, by their own label."""
    return {line.get_label(): line.get_data() for line in axes_of(figure, ylabel).get_lines()}


def has_panel(figure, ylabel):
    return ylabel in [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]


def every_axis_is_named(figure):
    for axes in figure.axes:
        if axes.axison and axes.get_label() != "<colorbar>":
            kinds = {text.get_text() for text in axes.get_yticklabels()}
            assert axes.get_ylabel() or kinds & {"exchange", "contact begin"}
