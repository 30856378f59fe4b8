"""Rollers of every profile in motion: the order of the method through all events, energy, and wheels at rest on lines.

Measured values beside the bounds, in the order of PROFILES.
"""

import copy
from itertools import pairwise

import numpy as np
import pytest
from machines import run, tables
from scenes import reference_scene

PROFILES = {
    "cylinder": {"kind": "cylinder", "radius": 0.008, "half_length": 0.012, "edge_radius": 0.001},
    "capsule": {"kind": "capsule", "radius": 0.008, "half_length": 0.016},
    "stepped": {"kind": "stepped", "radii": [0.008, 0.0072, 0.006], "lengths": [0.006, 0.005, 0.004]},
    "cone": {"kind": "cone", "radius": 0.008, "end_radius": 0.005, "half_length": 0.014},
    "points": {"kind": "points", "axial": [-0.014, -0.008, -0.002, 0.004, 0.009, 0.013],
               "radius": [0.0055, 0.0072, 0.008, 0.0077, 0.0068, 0.0055]},
}  # fmt: skip
STEPS = (6.25e-5, 3.125e-5, 1.5625e-5)


def machine(profile):
    """The kiwi of a reference case, which slides down a slope and spins; its rollers have another profile."""
    data = copy.deepcopy(tables(reference_scene("spatial_kiwi_slope")))
    data["wheel_types"]["type0"]["profile"] = profile
    return data | {"friction": {"law": "regularized", "coefficient": 0.5, "slip_speed": 0.3}}


@pytest.fixture(scope="module", params=PROFILES)
def runs(request):
    """Of three steps, each half of the last."""
    data = machine(PROFILES[request.param])
    return [run(data | {"time": {"end": 0.4, "step": step, "output_interval": 0.05}}) for step in STEPS]


def test_rk4_keeps_its_order_through_all_events(runs):
    """By how much positions change when the step is halved, and halved again."""
    first, second = (np.abs(one["body/position"] - other["body/position"]).max() for one, other in pairwise(runs))
    assert len(runs[-1]["events/kind"]) > 50  # 71, 71, 106, 113, 71, beside those from arc to arc
    assert 3.8 < np.log2(first / second) < 4.3  # measured 4.09, 4.07, 4.07, 3.99, 4.01
    assert second < 1e-8  # m, measured 1.9e-9, 2.2e-10, 8.4e-11, 3.0e-11, 5.6e-12


def test_energy_is_balanced_through_all_events(runs):
    motion = runs[-1]
    # measured 4.4e-9, 4.3e-10, 4.7e-10, 9.4e-11, 2.0e-10
    assert np.abs(motion["energy/balance"]).max() < 1e-7 * motion["energy/kinetic"].max()


def still(name: str, **changed) -> dict:
    """The kiwi on a level floor, each wheel flat on the roller below it."""
    data = machine(PROFILES[name]) | {"floor": {}, "initial": {}}
    data = {key: data[key] for key in data if key not in ("wrench", "command")}
    for wheel in data["wheels"]:
        for key in ("spin_rate", "spin_angle_deg", "phase_deg", "roller_rates"):
            wheel.pop(key, None)
        wheel["drive"] = {"kind": "free"}
    data["chassis"]["center_of_mass"] = [0.0, 0.0, 0.1]
    return data | changed


def askew(name: str, **changed) -> dict:
    """The same under Coulomb friction, with its centre of mass aside: flat wheels are no equilibrium, it rocks."""
    data = still(name, friction={"law": "coulomb", "coefficient": 0.5}, **changed)
    data["chassis"]["center_of_mass"] = [0.02, 0.01, 0.1]
    return data


@pytest.mark.parametrize("name", ["cylinder", "capsule", "stepped"])
def test_a_wheel_stands_on_a_line_with_both_its_ends(name):
    """Of three wheels, each flat on the roller below it: the sag is M g / (3 2 k), and nothing happens."""
    data = still(name)
    motion = run(data | {"time": {"end": 0.2, "step": 2e-5, "output_interval": 0.05}})
    kind = data["wheel_types"]["type0"]
    mass = data["chassis"]["mass"] + 3.0 * (kind["disk"]["mass"] + 6.0 * kind["roller"]["mass"])
    sag = mass * 9.81 / (3.0 * 2.0 * kind["contact"]["stiffness"])
    np.testing.assert_allclose(motion["body/position"], [[0.0, 0.0, -sag]] * 5, rtol=0, atol=1e-13)
    assert len(motion["events/kind"]) == 0
    for wheel in ("k0", "k1", "k2"):
        np.testing.assert_allclose(motion[f"wheels/{wheel}/contact_share"], 0.5, rtol=0, atol=1e-9)


@pytest.mark.long
def test_a_machine_that_rocks_on_its_lines_keeps_its_energy():
    """1e-7 J of it under Coulomb friction: ends of lines let go and stick again."""
    motion = run(askew("cylinder", time={"end": 0.1, "step": 2e-5, "output_interval": 0.002}))
    assert {"stick", "slip"} <= set(motion["events/kind"])
    assert np.abs(motion["energy/balance"]).max() < 1e-13  # J; measured 6e-16


@pytest.mark.long
def test_a_machine_settles_on_its_lines():
    """Put down aslant its ends bounce, slip and stick; no energy comes from nowhere."""
    initial = {"height": 0.0, "roll_deg": 0.3, "pitch_deg": 0.2}
    motion = run(askew("cylinder", initial=initial, time={"end": 0.5, "step": 2e-5, "output_interval": 0.01}))
    assert np.abs(motion["energy/balance"]).max() < 1e-8 * motion["energy/kinetic"].max()  # measured 2.1e-9
