"""Set-valued friction of machines free in space: a slope holds them for ever or not at all, and smooth laws tend to it.

Measured values stand beside the bounds.
"""

import numpy as np
import pytest
from free_machines import free
from machines import machine, run
from scenes import simulate

G = 9.81
FRICTION = 0.6
LOCKED = {"kind": "follow", "times": [0.0, 2000.0], "angle": [0.0, 0.0]}
STEEPEST = {0.0: np.arctan(FRICTION / np.sqrt(2.0)), 45.0: np.arctan(FRICTION / 2.0)}  # by uphill_deg: of its wheels
END = 0.4  # s


def locked(part: float, uphill_deg: float, end: float, **changed) -> dict:
    """Four mecanum wheels that do not turn, on this part of the slope on which friction along their rollers' axes holds
    them."""
    slope = np.arctan(part * np.tan(STEEPEST[uphill_deg]))
    data = free(machine("mecanum", drives=[LOCKED] * 4, **changed), damping=150.0)
    data["floor"] = {"slope_deg": float(np.degrees(slope)), "uphill_deg": uphill_deg}
    data["friction"] = {"law": "coulomb", "coefficient": FRICTION}
    data["time"] = {"end": end, "step": 2e-4, "output_interval": end / 10}
    return data


def moved(motion) -> float:
    return float(np.linalg.norm(motion["body/position"][-1] - motion["body/position"][0]))


@pytest.mark.parametrize("uphill_deg", STEEPEST)
def test_below_the_limit_of_friction_nothing_moves(uphill_deg):
    motion = run(locked(0.98, uphill_deg, 1.0))
    assert moved(motion) < 1e-14  # m; measured 1e-16
    assert np.abs(motion["body/velocity"]).max() < 1e-13  # m/s


@pytest.mark.long
def test_for_a_thousand_seconds():
    data = locked(0.98, 0.0, 1000.0)
    data["time"]["step"] = 1e-3
    assert moved(run(data)) < 1e-12  # m: a creep of 1e-15 m/s


@pytest.mark.parametrize("uphill_deg", STEEPEST)
def test_above_it_slides_with_what_friction_leaves(uphill_deg):
    """g cos S (tan S - tan S*) at 1.5 tan S*, but for the small inertia of rollers that turn."""
    motion = run(locked(1.5, uphill_deg, 0.2))
    slope = np.arctan(1.5 * np.tan(STEEPEST[uphill_deg]))
    expected = G * np.cos(slope) * 0.5 * np.tan(STEEPEST[uphill_deg])
    assert abs(2.0 * moved(motion) / 0.2**2 / expected - 1.0) < 0.02


def test_smooth_friction_tends_to_it_as_slip_speed_falls():
    """A little less than in proportion: slip lasts longer the slower it is."""
    shared = ("time.end=0.4", "time.output_interval=0.1")
    limit = simulate("spatial_kiwi_slope", "friction={law='coulomb',coefficient=0.5}", "time.step=5e-5", *shared)
    errors = []
    for slip_speed in (3e-2, 3e-3, 3e-4):
        smooth = simulate("spatial_kiwi_slope", f"friction.slip_speed={slip_speed}", "solver.method='radau5'",
                          "time.step=2.5e-4", *shared)  # fmt: skip
        errors.append(np.abs(smooth["body/position"] - limit["body/position"]).max())
    assert errors[0] < 3e-3 and errors[2] < 1e-4  # m; measured 2.2e-3, 4.1e-4, 6.2e-5
    assert errors[0] / errors[1] > 4.5 and errors[1] / errors[2] > 6.0  # measured 5.3, 6.7


def test_energy_is_balanced_through_sticking_and_slipping():
    motion = simulate("spatial_kiwi_slope", "friction={law='coulomb',coefficient=0.5}", "time.step=5e-5",
                      "time.end=0.4", "time.output_interval=0.01")  # fmt: skip
    assert {"stick", "slip"} <= set(motion["events/kind"])
    assert np.abs(motion["energy/balance"]).max() < 3e-9  # J, of 3
