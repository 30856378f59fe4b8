"""The authors' vehicle tends to its ideal, whose rollers have no mass, in proportion to it; bench/vehicle.py."""

import numpy as np
import pytest

import omnisim
from bench import vehicle
from bench.vehicle import SCENE, STARTS, Ideal, light
from omnisim.results.comparison import energy_error


@pytest.mark.parametrize("start", STARTS)
def test_the_distance_from_the_ideal_is_in_proportion_to_the_share_of_the_rollers(start):
    found = {share: vehicle.distance(light(share, start, 20.0), start) for share in (0.1, 0.03, 0.01, 0.003, 0.001)}
    assert 0.9 < vehicle.slope({share: found[share] for share in (0.1, 0.01)}) < 1.1  # measured 1.000, 0.954, 0.956
    assert abs(vehicle.slope(found) - 1.0) < 0.01  # measured 1.000, 0.996, 0.998
    assert (
        found[0.001] < {"in place": 5e-5, "straight": 2e-3, "both": 4e-2}[start]
    )  # rad, m; measured 2.4e-5, 9e-4, 0.02


def test_with_light_rollers_the_centre_runs_on_the_circle_of_the_ideal():
    """Three points give the circle: |v| / Omega, to the share."""
    found, ideal = light(1e-3, "both", 60.0), Ideal.of(omnisim.load(SCENE).config, STARTS["both"])
    a, b, c = found["body/position"][[0, 30, 60], :2] @ [1.0, 1j]
    radius = abs((a - b) * (b - c) * (c - a) / (2.0 * ((b - a).conjugate() * (c - a)).imag))
    assert abs(radius * ideal.turning / abs(ideal.velocity) - 1.0) < 5e-3  # measured 1.6e-3; at a share of 1e-4, 1.7e-4
    assert abs(np.hypot(*found["body/velocity"][-1, :2]) - 1.0) < 5e-3  # m/s; measured 1e-3
    assert abs(found["body/yaw_rate"][-1] - 1.0) < 1e-3  # rad/s; measured 8e-5


def test_of_a_light_roller_only_the_inertia_about_its_own_axis_counts():
    """Whether its mass is moved to the hub or not: all else is part of the wheel's mass and inertia."""
    moved, config = light(0.1, "both", 20.0), omnisim.load(SCENE).config
    (kind,) = config.wheel_types.values()
    spins = vehicle.wheel_rows(config) @ STARTS["both"]
    left = vehicle.run(
        20.0, "rk4", 1e-3, vehicle.COULOMB, f"{vehicle.WHEEL}.roller.inertia_axial={0.1 * kind.roller.inertia_axial!r}",
        "initial={velocity=[1.0, 0.0], yaw_rate=1.0}",
        *(f"wheels.{name}.spin_rate={float(rate)!r}" for name, rate in zip("abc", spins, strict=True)),
    )  # fmt: skip
    assert np.abs(moved["body/position"] - left["body/position"]).max() < 1e-9  # m; measured 0


def test_friction_that_knows_no_load_tips_the_vehicle_at_the_first_exchange():
    """F = -b v with b = 8.5e5 N s/m: a roller that lands at rest is stopped by far more than the weight.

    Wheel a is ahead of the others: of three wheels that change rollers at once no roller tips the vehicle.
    """
    law, ahead = "friction={law='viscous', viscosity=8.5e5}", "wheels.a.spin_angle_deg=1"
    found = omnisim.simulate(omnisim.load(SCENE, [law, ahead, "solver.method=radau5"]))
    assert "tips" in found.attributes["status"]
    assert found.attributes["stop_time"] == found["events/time"][0] and found["events/kind"][0] == "exchange"
    assert abs(found.attributes["stop_time"] - np.radians(35.0) / 3.0) < 1e-5  # s: the rest of half a pitch, 3 rad/s


@pytest.mark.parametrize("law", ["coulomb", "viscous"])
@pytest.mark.parametrize("end", [20.0, pytest.param(1000.0, marks=pytest.mark.long)])
def test_energy_is_balanced_for_long(end, law):
    """In 1000 s 2244 exchanges of all three wheels at once, each with a skid."""
    found = vehicle.vehicle("in place", law, end)
    assert energy_error(found).relative < 1e-9  # measured in 1000 s: 1.4e-13, 7.8e-12
    lost = end / 1000.0  # of 1 rad/s, nearly evenly
    assert abs(found["body/yaw_rate"][-1] - 1.0) < 0.13 * lost + 0.005  # measured 0.885, 0.884 after 1000 s
