"""Estimates of the steepest slopes: closed forms, and the machines themselves just below and just above them."""

import math

import numpy as np
import pytest
from machines import BOX, CHASSIS, machine, scene, tables

import omnisim
from omnisim.dynamics.packing import bodies, pack
from omnisim.dynamics.slopes import steepest

MU, G = 0.5, 9.81
COULOMB = {"law": "coulomb", "coefficient": MU}
TRIANGLE = ((0.2, 0.02), (-0.1, 0.16), (-0.12, -0.15))
LOCKED = {"kind": "dc_motor", "voltage": 0.0, "resistance": 1.0, "torque_constant": 1e-9, "rotor_inertia": 1e4}


def estimate(data: dict, uphill_deg: float = 0.0):
    config = scene(data).config
    return steepest(config, pack(config), uphill_deg)


@pytest.mark.short
@pytest.mark.parametrize("uphill_deg", [0.0, 30.0, 45.0, 90.0, 200.0])
def test_four_mecanum_wheels_hold_along_their_rollers(uphill_deg):
    expected = MU / (2.0 * max(abs(math.cos(math.radians(uphill_deg + side))) for side in (-45.0, 45.0)))
    found = estimate(machine("mecanum", friction=COULOMB), uphill_deg)
    assert math.tan(found.holds) == pytest.approx(expected, rel=1e-11)
    assert found.climbs == pytest.approx(0.0, abs=1e-11)  # free wheels


@pytest.mark.short
def test_a_kiwi_holds_by_its_two_wheels_uphill():
    data = tables("kiwi") | {"friction": COULOMB}
    height = bodies(scene(data).config).centre[2]
    expected = (MU / 3.0) / (1.0 / math.sqrt(3.0) + MU * height / 0.375)
    assert math.tan(estimate(data).holds) == pytest.approx(expected, rel=1e-7)  # its places have eight digits


@pytest.mark.short
def test_torques_limit_what_wheels_can_climb():
    """Four straight wheels: 4 tau / R = M g sin S; sideways nothing holds them."""
    rate = {"kind": "rate", "rate": 1.0, "proportional": 1.0, "torque_limit": 0.3}
    motor = {"kind": "dc_motor", "voltage": 6.0, "resistance": 2.0, "torque_constant": 0.1}
    for drive in (rate, motor, motor | {"voltage": 7.0, "friction_torque": 0.05}):
        data = machine("omni", friction=COULOMB, drives=[drive] * 4)
        found, mass = estimate(data), bodies(scene(data).config).mass
        assert math.sin(found.climbs) == pytest.approx(4.0 * 0.3 / 0.0625 / (mass * G), rel=1e-9)
        assert math.tan(found.holds) == pytest.approx(MU, rel=1e-9)
        assert estimate(data, 90.0).holds == pytest.approx(0.0, abs=1e-11)
    told = estimate(machine("omni", friction=COULOMB, drives=[{"kind": "torque", "torque": 0.3}] * 4))
    assert told.climbs == told.holds  # a torque of the scene itself is no limit


@pytest.mark.short
def test_a_machine_tips_where_its_plumb_line_leaves_the_wheels():
    data = machine("omni", friction=COULOMB)
    height, (front, left) = bodies(scene(data).config).centre[2], BOX[0]
    for uphill_deg, reach in ((0.0, front), (90.0, left), (180.0, front)):
        assert math.tan(estimate(data, uphill_deg).tips) == pytest.approx(reach / height, rel=1e-11)
    assert estimate(data | {"scene": {"upright": "servo"}}).tips == pytest.approx(math.pi / 2)
    assert estimate(machine("omni")).holds == pytest.approx(0.0, abs=1e-11)  # no friction


@pytest.mark.parametrize("uphill_deg", [20.0, 140.0, 260.0])
def test_a_skew_machine_holds_below_the_estimate_and_slides_above(uphill_deg):
    """Three unlike headings, an offset centre of mass, locked wheels: at 0.99 of the estimate it stands."""
    data = machine("omni", TRIANGLE, [10.0, 130.0, 250.0], [LOCKED] * 3, friction=COULOMB,
                   chassis=CHASSIS | {"center_of_mass": [0.03, -0.02, 0.12]})  # fmt: skip
    holds, speeds = estimate(data, uphill_deg).holds, []
    for part in (0.99, 1.01):
        floor = {"slope_deg": math.degrees(part * holds), "uphill_deg": uphill_deg}
        motion = omnisim.simulate(scene(data | {"floor": floor}, "time={end=0.1, step=1e-3, output_interval=0.1}"))
        assert motion.complete, motion.attributes["status"]
        speeds.append(np.linalg.norm(motion["body/velocity"][-1]))
    assert speeds[0] < 1e-6 and speeds[1] > 1e-4  # m/s
