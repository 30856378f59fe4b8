"""Extremes of the march: a peak between two rows is not lost, and does not depend on how many rows there are.

Measured values stand beside the bounds.
"""

import numpy as np
import pytest
from machines import machine
from machines import run as run_machine
from scenes import of_wheels, simulate

import omnisim

BEARINGS = "output.bearing_loads=true"


def run(name, *overrides):
    return omnisim.simulate(omnisim.load(name, overrides))


def of_rows(trajectory, path):
    """The quantity of an interval_max/PATH in the rows themselves."""
    folder, _, name = path.rpartition("/")
    along = 2 if folder.endswith("rollers") else 1
    if name.startswith("bearing"):
        what = "moment" if name.endswith("moment") else "force"
        load = trajectory[f"{folder}/bearing_{what}"]
        return load[..., along] if "axial" in name else np.linalg.norm(np.delete(load, along, axis=-1), axis=-1)
    values = trajectory[path]
    return np.linalg.norm(values, axis=1) if values.ndim > 1 else values


SCENES = {
    "bare wheel, stopping": ("coulomb_wheel", "time.end=0.5"),
    "smooth friction": ("six_rollers", "time.end=0.2", BEARINGS),
    "machine with odometry": ("youbot", "time.end=0.3", "initial.yaw_deg=40.0", BEARINGS),
    "friction in bearings": ("youbot", "time.end=0.1", "wheel_types.mecanum.roller.bearing_torque=1e-3", BEARINGS),
    "bodies": ("kiwi", "time.end=0.1", "solver.formulation=multibody"),
    "free in space": ("spatial_mecanum_springs", "time.end=0.15", "time.output_interval=5e-3", BEARINGS),
    "implicit steps": ("authors_vehicle", "time.end=0.02", "solver.method=radau5"),
    "rest on two rollers": ("testbench_psi30", "time.end=6.6", "time.step=1e-3", "time.output_interval=0.1", BEARINGS),
}


@pytest.mark.parametrize("which", SCENES)
def test_no_row_lies_outside_the_interval_that_it_ends(which):
    """Nor outside the one that it begins: both hold its state, to rounding of what is recovered after the run."""
    name, *overrides = SCENES[which]
    motion = simulate(name, *overrides) if name.startswith(("testbench", "spatial")) else run(name, *overrides)
    checked = 0
    for path in motion:
        group, _, of = path.partition("/")
        if group not in ("interval_max", "interval_min") or path.endswith("rollers/roller"):
            continue
        sign = 1.0 if group == "interval_max" else -1.0
        extreme, row = sign * motion[path], sign * of_rows(motion, of)
        slack = 1e-12 + 1e-9 * np.abs(row).max(initial=0.0)  # measured: 5e-12 of the largest, where slip is recovered
        assert np.all(extreme >= row - slack), path
        assert np.all(extreme[1:] >= row[:-1] - slack), path
        np.testing.assert_allclose(extreme[0], row[0], atol=slack, err_msg=path)
        checked += 1
    assert checked >= 8


def test_extremes_do_not_depend_on_the_rows():
    """The largest of fine rows' intervals is that of the coarse row over them, bit for bit: the steps are the same."""
    coarse, fine = (
        run("youbot", "time.end=0.4", BEARINGS, f"time.output_interval={interval}") for interval in (0.1, 0.001)
    )
    for path in coarse:
        group = path.partition("/")[0]
        if group in ("interval_max", "interval_min") and not path.endswith("rollers/roller"):
            reduce = np.max if group == "interval_max" else np.min
            parts = fine[path][1:].reshape(4, 100, *fine[path].shape[1:])
            np.testing.assert_array_equal(coarse[path][1:], reduce(parts, axis=1), err_msg=path)


def test_a_peak_between_rows_is_found():
    """What axles and rollers carry along their axes peaks where a roller takes over: rows of 0.1 s miss most of it."""
    motion = run("youbot", "time.end=2.0", BEARINGS, "time.output_interval=0.1")
    for part, along in (("", 1), ("rollers/", 2)):
        path = f"wheels/front_left/{part}bearing"
        rows = np.abs(motion[f"{path}_force"][..., along]).max()
        most, least = (motion[f"interval_{end}/{path}_axial_force"] for end in ("max", "min"))
        assert max(most.max(), -least.min()) > 1.1 * rows


def test_a_pulse_of_torque_between_two_rows_is_seen_at_its_peak():
    """A triangle of 0.03 N m at 0.013 s, a knot, between rows at 0 and 0.02 s at which there is none: exact."""
    drive = "wheels.wheel.drive={kind='torque', times=[0.003, 0.013, 0.0171], torque=[0, 0.03, 0]}"
    motion = run("six_rollers", drive, "time.end=0.04", "time.output_interval=0.02")
    torque, spin_rate = motion["interval_max/wheels/wheel/drive_torque"], motion["wheels/wheel/spin_rate"]
    assert not motion["wheels/wheel/drive_torque"].any()
    np.testing.assert_array_equal(torque, [0.0, 0.03, 0.0])
    power = motion["interval_max/wheels/wheel/drive_power"][1]
    assert 0.03 * spin_rate.min() < power < 0.03 * spin_rate.max()


def test_a_jump_in_the_middle_of_a_step_is_seen_on_both_sides():
    """Torque that jumps to 0.03 N m at 0.01303 s and falls from there at once; the step is 0.1 ms."""
    drive = "wheels.wheel.drive={kind='torque', times=[0.003, 0.01303, 0.01303, 0.0171], torque=[0, 0, 0.03, 0]}"
    motion = run("six_rollers", drive, "time.end=0.04", "time.output_interval=0.02")
    np.testing.assert_array_equal(motion["interval_max/wheels/wheel/drive_torque"], [0.0, 0.03, 0.0])


def test_loads_are_seen_on_both_sides_of_an_exchange():
    """Without friction the load follows the contact point, which jumps from one end of a roller to the other: the least
    and the largest load are those on the two sides of the jump, at any step."""
    scene = machine("mecanum")
    scene["wheels"][0]["spin_rate"], found = 30.0, []
    for step in (2e-3, 1e-4):
        scene["time"] = {"end": 0.1, "step": step, "output_interval": 0.1}
        motion = run_machine(scene)
        assert (motion["events/kind"] == "exchange").sum() == 3
        found.append([motion[f"interval_{end}/wheels/w0/normal_force"][1] for end in ("max", "min")])
        rows = motion["wheels/w0/normal_force"]
        assert found[-1][0] > rows.max() + 0.05 and found[-1][1] < rows.min() - 0.05
    np.testing.assert_allclose(*found, rtol=1e-12)


@pytest.mark.parametrize(("method", "apart"), [("radau5", 1e-9), ("auto", 1e-6)])
def test_wheels_that_turn_alike_change_rollers_at_one_instant(method, apart):
    """Three wheels that spin in place by symmetry: no state in between, where rounding has changed one of them only,
    counts, so the extremes of the three are one (measured 5e-11 apart, by slips that end one by one 1.7e-7; where it
    counted, 0.19)."""
    motion, names = run("authors_vehicle", "time.end=6.0", f"solver.method={method}"), "abc"
    assert (motion["events/kind"] == "exchange").sum() == 3 * 14
    for quantity in ("interval_max/wheels/{}/normal_force", "interval_min/wheels/{}/normal_force"):
        found = np.array([motion[quantity.format(name)] for name in names])
        assert np.ptp(found, axis=0).max() < apart * found.max()


def test_a_pulse_of_voltage_between_two_rows_tells_the_current_that_it_takes():
    """12 V switched on for 4 ms between two rows: the wheel hardly turns at once, the current is U / R; and switched
    off, the motor brakes with K phi' / R."""
    pulse = "times=[0.003, 0.003, 0.007, 0.007], voltage=[0, 12, 12, 0], resistance=2.0, torque_constant=0.02"
    still = "wheels.wheel.spin_rate=0.0", "initial.velocity=[0, 0]", "initial.yaw_rate=0.0"
    drive, rows = f"wheels.wheel.drive={{kind='dc_motor', {pulse}}}", ("time.end=0.02", "time.output_interval=0.01")
    motion = run("six_rollers", drive, *still, *rows)
    most, least = (motion[f"interval_{end}/wheels/wheel/current"] for end in ("max", "min"))
    assert most[1] == pytest.approx(6.0, rel=1e-9)  # measured: 6e-11; friction turns the wheel a little before
    assert motion["interval_max/wheels/wheel/electrical_power"][1] == pytest.approx(72.0, rel=1e-9)
    assert motion["interval_max/wheels/wheel/voltage"].tolist() == [0.0, 12.0, 0.0]
    braking = 0.02 * motion["wheels/wheel/spin_rate"].max() / 2.0
    assert -1.5 * braking < least[1] <= -braking < 0.0
    assert np.abs(motion["wheels/wheel/current"]).max() < 0.5  # in the rows


def test_slip_that_begins_and_ends_between_rows_is_seen():
    """A wheel driven beyond the limit of friction for 30 ms between rows at which it rolls: slip, the limit itself."""

    def driven(w):
        return {"kind": "torque", "times": [0.1, 0.1, 0.13, 0.13], "torque": [0.0, 3.0, 3.0, 0.0]} if w == 0 else {}

    scene = machine("omni", drives=[driven(w) or {"kind": "free"} for w in range(4)])
    scene["friction"] = {"law": "coulomb", "coefficient": 0.4}
    scene["time"] = {"end": 0.6, "step": 1e-3, "output_interval": 0.3}
    motion = run_machine(scene)
    slip, seen = of_wheels(motion, "slip_velocity"), motion["interval_max/wheels/w0/slip_velocity"]
    assert np.abs(slip).max() < 1e-9 and seen[1] > 0.01
    friction, load = (motion[f"interval_max/wheels/w0/{name}_force"][1] for name in ("friction", "normal"))
    assert 0.4 * motion["interval_min/wheels/w0/normal_force"][1] <= friction <= 0.4 * load * (1 + 1e-12)


def test_a_row_that_a_controller_renews_keeps_its_interval():
    """An input set where a row stands changes the forces of that instant; what was before stays in its interval."""
    loop = omnisim.Loop(omnisim.load("kiwi", ["time.output_interval=0.1", "time.end=0.3"]))
    loop.command(0.5, 0.0, 0.0)
    loop.advance(0.1)
    before = loop.trajectory()["interval_max/wheels/right/drive_torque"][1]
    loop.command(-0.5, 0.0, 0.0)
    loop.advance(0.1)
    motion = loop.trajectory()
    assert before > 0.0 and motion["interval_max/wheels/right/drive_torque"][1] == before
    assert motion["wheels/right/drive_torque"][1] < 0.0  # the row holds the state after it
    assert motion["interval_min/wheels/right/drive_torque"][1] == motion["wheels/right/drive_torque"][1]


def test_extremes_begin_with_the_start_where_a_wheel_on_an_edge_is_looked_at_a_moment_later():
    """A torque that grows from nothing tells only later which roller carries on; row 0 knows nothing of that."""
    ramp = "wheels.wheel.drive={kind='torque', times=[0.0, 0.01], torque=[0.0, 0.05]}"
    still = ("wheels.wheel.spin_rate=0.0", "initial.velocity=[0, 0]", "initial.yaw_rate=0.0")
    edge = "wheels.wheel.spin_angle_deg=-30.0"  # of six rollers
    motion = run("six_rollers", ramp, *still, edge, "wheels.wheel.roller_rates=0.0", "time.end=0.01")
    assert motion["interval_max/wheels/wheel/drive_torque"][0] == 0.0
    assert motion["interval_max/wheels/wheel/friction_force"][0] == 0.0
