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


F, T = 1.5e-3, 2e-3  # m, N m: rolling resistance, and of a roller's bearing


def rubbing(data: dict, **roller: float) -> dict:
    """The machine with these keys of its rollers; they are its only resistance."""
    ((name, kind),) = data["wheel_types"].items()
    return data | {"wheel_types": {name: kind | {"roller": kind["roller"] | roller}}}


def sizes(data: dict) -> tuple[float, float]:
    """R and the radius of a roller, m."""
    (kind,) = data["wheel_types"].values()
    return kind["radius"], kind["radius"] - kind["roller_distance"]


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
def test_rolling_resistance_holds_locked_wheels_across_their_rollers():
    """Aside straight rollers have nothing else; on mecanum wheels it shares the circle of friction."""
    straight, mecanum = (rubbing(machine(kind, friction=COULOMB), rolling_resistance=F) for kind in ("omni", "mecanum"))
    part = F / sizes(straight)[1]
    assert math.tan(estimate(straight, 90.0).holds) == pytest.approx(part, rel=1e-11)
    assert math.tan(estimate(straight).holds) == pytest.approx(MU, rel=1e-11)  # nothing more along them
    part = F / sizes(mecanum)[1]
    expected = math.sqrt(0.5) * (part + math.sqrt(MU**2 - part**2))
    assert math.tan(estimate(mecanum, 90.0).holds) == pytest.approx(expected, rel=1e-11)


@pytest.mark.short
def test_a_machine_without_power_rests_below_what_its_wheels_resist():
    """Ahead f / R, aside as its rollers and wheels turn together; a bearing of straight rollers resists aside alone."""
    data = rubbing(machine("mecanum", friction=COULOMB), rolling_resistance=F)
    radius, thin = sizes(data)
    assert math.tan(estimate(data).rests) == pytest.approx(F / radius, rel=1e-9)
    expected = F * math.hypot(1.0 / thin, 1.0 / thin - 1.0 / radius)
    assert math.tan(estimate(data, 90.0).rests) == pytest.approx(expected, rel=1e-9)
    straight = rubbing(machine("omni", friction=COULOMB), bearing_torque=T)
    mass = bodies(scene(straight).config).mass
    assert math.sin(estimate(straight, 90.0).rests) == pytest.approx(
        4.0 * T / sizes(straight)[1] / (mass * G), rel=1e-9
    )
    motor = {"kind": "dc_motor", "voltage": 0.0, "resistance": 2.0, "torque_constant": 0.1, "friction_torque": 0.05}
    braked = machine("omni", friction=COULOMB, drives=[motor] * 4)
    assert math.sin(estimate(braked).rests) == pytest.approx(4.0 * 0.05 / 0.0625 / (mass * G), rel=1e-9)
    assert estimate(machine("omni", friction=COULOMB)).rests == 0.0


@pytest.mark.short
def test_drives_climb_against_rolling_resistance():
    rate = {"kind": "rate", "rate": 1.0, "proportional": 1.0, "torque_limit": 0.3}
    data = rubbing(machine("omni", friction=COULOMB, drives=[rate] * 4), rolling_resistance=F)
    (radius, _), mass = sizes(data), bodies(scene(data).config).mass
    climbs = estimate(data).climbs
    expected = (4.0 * 0.3 / (mass * G) - F * math.cos(climbs)) / radius
    assert math.sin(climbs) == pytest.approx(expected, rel=1e-9)


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


@pytest.mark.parametrize(("which", "drive", "uphill_deg"), [
    ("rests", {"kind": "free"}, 0.0), ("rests", {"kind": "free"}, 35.0), ("holds", LOCKED, 70.0),
])  # fmt: skip
def test_rollers_that_resist_creep_below_the_estimate_and_run_away_above(which, drive, uphill_deg):
    """Below it the speed settles, above it grows by g times what the slope is steeper."""
    data = rubbing(machine("omni", friction=COULOMB, drives=[drive] * 4), rolling_resistance=F)
    slope = getattr(estimate(data, uphill_deg), which)
    early, late = {}, {}  # gained in the first half second, and in the next
    for part in (0.9, 1.1):
        floor = {"slope_deg": math.degrees(part * slope), "uphill_deg": uphill_deg}
        motion = omnisim.simulate(scene(data | {"floor": floor}, "time={end=1.0, step=1e-3, output_interval=0.5}"))
        assert motion.complete, motion.attributes["status"]
        speeds = np.linalg.norm(motion["body/velocity"], axis=1)
        early[part], late[part] = np.diff(speeds)
    assert late[0.9] < 0.1 * early[0.9]  # measured 0.085, 0.082, 4e-7
    assert late[1.1] > 0.8 * 0.5 * 0.1 * G * math.tan(slope)  # measured 1.08, 0.88, 0.94
