"""Wheels on several rows of rollers, upright and rigid: what rows do, and what they leave as it is.

That rows are what free bodies do stands in tests/oracle. Measured values stand beside the bounds.
"""

import numpy as np
import pytest
from machines import CHASSIS, TYPES, machine, mirrored, run, scene
from scenes import REFERENCE, final_state, reference_scene

import omnisim
from omnisim.base.methods import TABLEAUX
from omnisim.dynamics.packing import pack
from omnisim.dynamics.static_loads import static_loads

SHORT = "time={end=0.2, step=5e-5, output_interval=0.01}"
# path, wheel type, its rollers, overrides
TWINS = {
    "bare wheel": (REFERENCE / "testbench_psi0.toml", "omni", 6, ["time.end=1.0"]),
    "implicit tracking": (REFERENCE / "testbench_psi0.toml", "omni", 6, ["time.end=1.0", "solver.tracking=implicit"]),
    "multibody": (REFERENCE / "mecanum.toml", "mecanum", 6, [SHORT, "solver.formulation=multibody"]),
    "mecanum": (REFERENCE / "mecanum.toml", "mecanum", 6, ["time.end=0.5", "time.step=5e-5"]),
    "coulomb friction": ("kiwi", "omni", 18, ["time.end=1.0"]),
    "three types, bearing friction": ("mixed", "omni", 10, ["time.end=0.5"]),
}


@pytest.mark.parametrize("case", TWINS)
def test_two_rows_in_one_plane_are_one_row_of_twice_the_rollers(case):
    """To the last bit, in every dataset and event, whichever row is named first and whatever turn of it."""
    path, kind, rollers, overrides = TWINS[case]
    overrides = [*overrides, "output.bearing_loads=true"]
    half, of = 180.0 / (rollers // 2), f"wheel_types.{kind}"
    rows = f"{of}.rows=[{{phase_deg=0}}, {{phase_deg={half - 2.0 * half * 5!r}}}]"
    one = omnisim.simulate(omnisim.load(path, overrides))
    two = omnisim.simulate(omnisim.load(path, [*overrides, f"{of}.roller_count={rollers // 2}", rows]))
    assert one.complete and "exchange" in one["events/kind"] and list(one) == list(two)
    assert [name for name in one if not np.array_equal(one[name], two[name])] == []


PAIR = ((-0.011, 0.0), (0.011, 36.0))  # offset, m, and phase, deg, of the rows of ten rollers
UNEVEN = ((0.004, 0.0), (0.026, 36.0))


def on_rows(rows=PAIR, kind: str = "omni", **changed) -> dict:
    """A machine of machines.py whose wheels have their rollers on these rows."""
    data = machine(kind, **changed)
    own = TYPES[kind] | {"roller_count": TYPES[kind]["roller_count"] // len(rows)}
    own["rows"] = [{"offset": offset, "phase_deg": phase} for offset, phase in rows]
    return data | {"wheel_types": {kind: own}}


TRIANGLE = tuple((0.2 * np.cos(angle), 0.2 * np.sin(angle)) for angle in np.radians([60.0, 180.0, 300.0]))
KIWI = {"places": TRIANGLE, "headings_deg": (150.0, 270.0, 30.0)}


def places(data: dict, motion) -> np.ndarray:
    """Contact points (T, W, 2) from the chassis origin."""
    points = np.stack([motion[f"wheels/{wheel}/contact_point"] for wheel in motion.wheels], axis=1)
    return points[..., :2] - motion["body/position"][:, None, :2]


@pytest.mark.parametrize("rows", [PAIR, UNEVEN], ids=["balanced", "all on one side"])
@pytest.mark.parametrize("turns", [0.0, 36.0])
def test_loads_at_rest_are_those_of_the_places_where_rollers_touch(rows, turns):
    """A frictionless tripod: three loads by statics about a centre of mass that rows may have moved."""
    data = on_rows(rows, **KIWI)
    for wheel in data["wheels"]:
        wheel["spin_angle_deg"] = turns
    motion, kind = run(data, "time.end=0.01"), data["wheel_types"]["omni"]
    ring = kind["roller_count"] * kind["roller"]["mass"]
    chassis, (x, y) = CHASSIS["mass"], np.array([CHASSIS["center_of_mass"][:2]]).T
    mass, moment = chassis, chassis * np.array([x[0], y[0]])
    for wheel in data["wheels"]:
        heading = np.radians(wheel["heading_deg"])
        k = np.array([-np.sin(heading), np.cos(heading)])
        for part, offset in ((kind["disk"]["mass"], 0.0), *((ring, offset) for offset, _ in rows)):
            mass, moment = mass + part, moment + part * (np.array(wheel["position"]) + offset * k)
    at = places(data, motion)[0]
    expected = np.linalg.solve(np.vstack([np.ones(3), at.T]), 9.81 * np.array([mass, *moment]))
    found = [motion[f"wheels/{wheel}/normal_force"][0] for wheel in motion.wheels]
    np.testing.assert_allclose(found, expected, rtol=1e-13)
    from_centres = np.linalg.norm(at - [wheel["position"] for wheel in data["wheels"]], axis=1)
    np.testing.assert_allclose(from_centres, abs(rows[round(turns / 36.0)][0]), rtol=1e-12)


def test_static_loads_are_those_under_the_middle_of_the_rows():
    """Exact where both rows stand in one plane beside the wheel's centre; `info` tells them."""
    beside = scene(
        on_rows(((0.03, 0.0), (0.03, 36.0)), **KIWI, chassis=CHASSIS | {"center_of_mass": [0.05, 0.02, 0.1]})
    )
    motion = omnisim.simulate(beside)
    found = [motion[f"wheels/{wheel}/normal_force"][0] for wheel in motion.wheels]
    np.testing.assert_allclose(static_loads(pack(beside.config)), found, rtol=1e-13)


def test_a_machine_that_turns_in_place_turns_as_fast_as_the_row_that_carries_lets_it():
    """Wheels that follow angles and do not slip: R phi' / (L - w), k points inwards. Between exchanges they roll."""
    follow = {"kind": "follow", "times": [0.0, 1.0], "angle": [0.0, 4.0]}
    data = on_rows(drives=[follow] * 3, **KIWI) | {"friction": {"law": "coulomb", "coefficient": 0.5}}
    for wheel in data["wheels"]:
        wheel["spin_rate"] = 4.0
    motion = run(data)
    rolling = np.linalg.norm(motion["wheels/w0/slip_velocity"], axis=1) < 1e-9
    row = motion["wheels/w0/contact_roller"] % 2
    expected = TYPES["omni"]["radius"] * 4.0 / (0.2 - np.where(row == 0, -0.011, 0.011))
    assert {*row[rolling].tolist()} == {0, 1} and rolling.sum() > 50
    np.testing.assert_allclose(motion["body/yaw_rate"][rolling], expected[rolling], rtol=1e-12)  # measured 2e-16


def test_without_friction_the_centre_of_mass_of_a_wheel_moves_straight_and_its_middle_about_it():
    """A bare wheel whose rows stand on one side: C is o = sum m w / m_w aside. Measured 3e-16 m."""
    rows = "wheel_types.omni.rows=[{offset=0.01}, {offset=0.04, phase_deg=60.0}]"
    motion = omnisim.simulate(
        reference_scene("testbench_psi0", "wheel_types.omni.roller_count=3", rows, "friction.law=none", "time.end=1.0")
    )
    aside = 3 * 0.03 * (0.01 + 0.04) / (0.5 + 6 * 0.03)
    yaw, rate = motion["body/yaw"], motion["body/yaw_rate"]
    k = np.column_stack([-np.sin(yaw), np.cos(yaw)])
    centre = motion["body/position"][:, :2] + aside * k
    velocity = motion["body/velocity"][0, :2] - rate[0] * aside * np.array([np.cos(yaw[0]), np.sin(yaw[0])])
    assert np.ptp(yaw) > 0.1
    assert np.abs(centre - centre[0] - motion.time[:, None] * velocity).max() < 1e-13


def test_the_contact_jumps_from_row_to_row():
    """Rollers across the wheel carry it below the middle of their row, and nowhere between."""
    motion = run(on_rows(drives=DRIVES, **KIWI) | {"friction": LAWS["viscous"]})
    assert np.sum(motion["events/kind"] == "exchange") > 5
    for w, wheel in enumerate(motion.wheels):
        heading = np.radians(KIWI["headings_deg"][w]) + motion["body/yaw"]
        k = np.column_stack([-np.sin(heading), np.cos(heading)])
        middle = motion[f"wheels/{wheel}/rollers/center_position"].mean(axis=1)[:, :2]
        aside = np.sum((motion[f"wheels/{wheel}/contact_point"][:, :2] - middle) * k, axis=1)
        row = motion[f"wheels/{wheel}/contact_roller"] % 2
        np.testing.assert_allclose(aside, np.where(row == 0, -0.011, 0.011), atol=1e-14)


LAWS = {
    "regularized": {"law": "regularized", "coefficient": 0.5, "slip_speed": 1.0},
    "coulomb": {"law": "coulomb", "coefficient": 0.5},
    "viscous": {"law": "viscous", "viscosity": 5.0},
}
DRIVES = [{"kind": "torque", "torque": torque} for torque in (0.1, -0.16, 0.24, 0.05)]  # N m


@pytest.mark.parametrize("law", LAWS)
def test_energy_is_accounted_for_while_contacts_jump(law):
    """Measured 8.2e-12 (regularized), 6.7e-15 and 5.2e-13 J, of 2 to 6 J of work."""
    motion = run(on_rows(UNEVEN, drives=DRIVES, **KIWI) | {"friction": LAWS[law]}, "time.step=2e-5")
    assert np.sum(motion["events/kind"] == "exchange") > 10
    assert np.abs(motion["energy/drive_work"]).max() > 0.5
    assert np.abs(motion["energy/balance"]).max() < 1e-10


def test_the_mirror_image_of_rows_moves_as_the_mirror_image():
    data = on_rows(((0.02, 0.0), (-0.03, 60.0)), "mecanum", drives=DRIVES) | {"friction": LAWS["viscous"]}
    data["initial"] = {"velocity": [0.2, 0.1], "yaw_rate": 0.3}
    one, other = run(data, "time.end=0.5"), run(mirrored(data), "time.end=0.5")
    assert np.sum(one["events/kind"] == "exchange") > 5
    flip = np.array([1.0, -1.0, 1.0])
    assert np.abs(one["body/position"] - flip * other["body/position"]).max() < 1e-13
    for wheel in one.wheels:
        path = f"wheels/{wheel}/normal_force"
        assert np.abs(one[path] - other[path]).max() < 1e-11


STEPS = {"heun": (4e-4, 2e-4, 1e-4), "rk4": (1e-3, 5e-4, 2.5e-4), "dopri5": (1e-3, 5e-4, 2.5e-4)}


@pytest.mark.parametrize("method", STEPS)
def test_methods_keep_their_order_while_contacts_jump(method):
    """A machine on rows that stand on one side, through 54 exchanges. Measured: heun 2.00, rk4 4.01, dopri5 5.05."""
    data = on_rows(UNEVEN, drives=DRIVES, **KIWI) | {"friction": LAWS["viscous"]}
    data["time"]["output_interval"] = 1.0
    runs = [run(data, f"solver.method={method}", f"time.step={step}") for step in STEPS[method]]
    finest = run(data, "solver.method=dopri5", "time.step=2.5e-5")
    assert np.sum(finest["events/kind"] == "exchange") > 50
    errors = np.array([np.abs(final_state(one) - final_state(finest)).max() for one in runs])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders.min() > TABLEAUX[method].order - 0.1, (errors, orders)
    assert errors[-1] > 1e-13, "at the rounding floor an order means nothing"


def test_rows_that_are_out_of_order_are_counted_by_azimuth():
    """Rows as they are listed, turned by whole pitches, or in another order from the second on: the same motion."""
    changed = {"drives": DRIVES, "friction": LAWS["viscous"], **KIWI}
    kinds = []
    for rows in (((-0.02, 0.0), (0.0, 30.0), (0.02, 60.0)), ((-0.02, 0.0), (0.02, -30.0), (0.0, 390.0))):
        data = machine("omni", **changed)
        rows = [{"offset": offset, "phase_deg": phase} for offset, phase in rows]
        data["wheel_types"] = {"omni": TYPES["omni"] | {"roller_count": 4, "rows": rows}}
        kinds.append(omnisim.simulate(scene(data)))
    one, other = kinds
    assert one.complete and np.sum(one["events/kind"] == "exchange") > 5
    assert [name for name in one if not np.array_equal(one[name], other[name])] == []
