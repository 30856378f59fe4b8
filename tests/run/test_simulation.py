"""Runs as a user sees them: rows, grid, early ends, interruption."""

import math

import numpy as np
import pytest
from scenes import reference_scene, simulate

import omnisim


def test_rows_stand_exactly_on_the_output_grid():
    run = simulate("testbench_psi0", "time.step=1e-3")
    assert np.array_equal(run.time, np.arange(41) * 0.05)
    assert run.attributes["steps"] == 2000
    assert run.attributes["stop_time"] == 2.0


def test_a_coarser_output_gives_the_same_motion_bit_for_bit():
    fine, coarse = simulate("testbench_psi30", "time.output_interval=0.01"), simulate("testbench_psi30")
    assert np.array_equal(fine["body/position"][::10], coarse["body/position"])


def test_calls_of_progress_do_not_touch_the_motion():
    done = []
    scene = reference_scene("testbench_psi30", "time.step=1e-5")
    watched, alone = omnisim.simulate(scene, lambda fraction: done.append(fraction)), omnisim.simulate(scene)
    assert np.array_equal(watched["body/position"], alone["body/position"])
    assert done[0] == 0.0
    assert np.all(np.diff(done) >= 0.0)


def test_a_run_stopped_from_outside_keeps_what_was_computed():
    scene = reference_scene("testbench_psi30", "time.step=1e-5")
    whole = omnisim.simulate(scene)
    part = omnisim.simulate(scene, lambda fraction: fraction > 0.3)
    assert "interrupted" in part.attributes["status"]
    assert 1 < len(part.time) < len(whole.time)
    assert np.array_equal(part["body/position"], whole["body/position"][: len(part.time)])
    assert part["events/kind"][-1] == "stop"
    assert part["events/time"][-1] == part.attributes["stop_time"] >= part.time[-1]


def test_the_scene_text_of_a_trajectory_repeats_the_run():
    run = simulate("testbench_psi0", "time.step=5e-4", "friction.law=saturated")
    from omnisim.scene.scene import parse

    again = omnisim.simulate(parse(run.attributes["scene"]))
    assert np.array_equal(run["body/position"], again["body/position"])


def test_a_run_too_stiff_for_its_step_stops_and_names_the_step_that_would_do():
    run = omnisim.simulate(reference_scene("testbench_psi30", "friction.slip_speed=1e-4"))
    assert not run.complete
    assert "unstable" in run.attributes["status"]
    advised = float(run.attributes["status"].split("time.step < ")[1].split()[0])
    assert 5e-7 < advised < 5e-6  # half of what is stable; mu N A / slip_speed = 1e6 1/s
    finer = omnisim.simulate(
        reference_scene("testbench_psi30", "friction.slip_speed=1e-4", f"time.step={5e-7!r}", "time.end=0.2")
    )
    assert finer.complete


def test_the_authors_testbench_is_stable_below_7_7e_6_and_refused_above():
    """An explicit step of order four must stay below 2.785 / 3.6e5 1/s; the message names half of that."""
    short = ("time.end=0.1", "time.output_interval=0.1")
    assert omnisim.simulate(omnisim.load("authors_testbench", ["time.step=6.25e-6", *short])).complete
    run = omnisim.simulate(omnisim.load("authors_testbench", ["time.step=1e-5", *short]))
    assert "unstable" in run.attributes["status"]
    assert "time.step < 3.9e-06" in run.attributes["status"]


def test_a_viscous_run_that_explodes_says_when_and_why_and_holds_no_nan():
    run = omnisim.simulate(reference_scene("testbench_psi30", "friction.law=viscous", "friction.viscosity=1e6"))
    assert not run.complete
    assert "time.step <" in run.attributes["status"]
    assert all(np.isfinite(values).all() for path, values in run.data.items() if values.dtype == float), "no NaN"


@pytest.mark.parametrize(
    "overrides",
    [
        ("wheels.wheel.spin_rate=1e300",),
        ("initial.velocity=[1e153, 0]",),
        ("initial.velocity=[1e200, 0]", "friction.law=none"),
    ],
)
def test_numbers_that_overflow_stop_the_run_without_a_nan(overrides):
    run = omnisim.simulate(reference_scene("testbench_psi30", *overrides))
    assert "diverged" in run.attributes["status"] or "cannot start" in run.attributes["status"]
    assert all(np.isfinite(values).all() for values in run.data.values() if values.dtype == float)


def test_a_wheel_lifted_by_the_wrench_leaves_the_floor_when_the_force_equals_the_weight():
    weight = (2.0 + 4 * 0.15) * 9.81
    run = omnisim.simulate(
        reference_scene("testbench_psi30", "wrench.times=[0, 1]", "wrench.force=[[0, 0, 0], [0, 0, 100]]")
    )
    assert run.attributes["stop_time"] == pytest.approx(weight / 100.0, rel=1e-12)
    assert list(run["events/kind"][-2:]) == ["lift_off", "stop"]
    assert "leaves the floor" in run.attributes["status"]


def test_a_wheel_lifted_from_the_start_has_its_first_row_and_stops():
    run = omnisim.simulate(reference_scene("testbench_psi30", "wrench.times=[0]", "wrench.force=[[0, 0, 100]]"))
    assert run.attributes["stop_time"] == 0.0
    assert "leaves the floor" in run.attributes["status"]


def test_more_events_than_a_step_can_hold_are_reported():
    run = omnisim.simulate(reference_scene("testbench_psi30", "time.step=1e-2", "wheels.wheel.spin_rate=5e7"))
    assert "events in one step" in run.attributes["status"]


def test_many_events_outgrow_the_log_without_loss():
    run = simulate(
        "testbench_psi0", "friction.law=none", "initial.yaw_rate=0", "wheels.wheel.spin_rate=20000", "time.step=1e-3"
    )
    assert len(run["events/time"]) == pytest.approx(20000 * 2.0 / (math.pi / 3), abs=1)
    assert np.all(np.diff(run["events/time"]) > 0.0)


def test_a_step_that_does_not_divide_the_interval_exactly_in_binary_keeps_the_grid():
    run = simulate("testbench_psi0", "time.step=0.0003", "time.output_interval=0.003", "time.end=0.3")
    assert run.time[-1] == 100 * 0.003
    assert run.attributes["steps"] == 1000


def test_a_knot_on_a_row_gives_the_row_the_value_after_the_jump():
    run = simulate(
        "testbench_psi0", "wheels.wheel.drive={kind='torque', times=[0.0, 0.5, 0.5], torque=[0.1, 0.1, -0.2]}"
    )
    assert run["wheels/wheel/drive_torque"][list(run.time).index(0.5)] == -0.2
    assert run["wheels/wheel/drive_torque"][list(run.time).index(0.45)] == 0.1


def test_the_wrench_in_the_body_frame_turns_with_the_wheel():
    still = (
        "friction.law=none",
        "initial.yaw_rate=0",
        "initial.yaw_deg=90",
        "wheels.wheel.roller_rates=0",
        "wrench.times=[0]",
    )
    world = simulate("testbench_psi0", *still, "wrench.force=[[0, 1, 0]]")
    body = simulate("testbench_psi0", *still, "wrench.force=[[1, 0, 0]]", "wrench.frame='body'")
    assert np.abs(world["body/velocity"] - body["body/velocity"]).max() < 1e-12


def test_the_datasets_of_a_row_belong_together():
    """What is stored twice in different form agrees: slip, geometry, velocities of the roller centres."""
    run = simulate("testbench_psi30", "time.step=1e-4", "time.output_interval=0.01", "time.end=1.0")
    yaw, angle = run["body/yaw"], run["wheels/wheel/contact_angle"]
    roller = run["wheels/wheel/contact_roller"]
    centres = run["wheels/wheel/rollers/center_position"]
    rows = np.arange(len(yaw))
    offset = centres[rows, roller] - run["body/position"]
    along_h = offset[:, 0] * np.cos(yaw) + offset[:, 1] * np.sin(yaw)
    np.testing.assert_allclose(along_h, 0.068 * np.sin(angle), rtol=0, atol=1e-14)
    np.testing.assert_allclose(centres[rows, roller][:, 2], 0.1 - 0.068 * np.cos(angle), rtol=0, atol=1e-14)
    assert np.all(np.argmin(centres[:, :, 2], axis=1) == roller), "the lowest roller is the one in contact"
    dt = 0.01
    numeric = (centres[2:] - centres[:-2]) / (2 * dt)
    smooth = run["wheels/wheel/rollers/center_velocity"][1:-1]
    assert (
        np.abs(numeric - smooth).max() < 2e-2
    )  # m/s; differences over 0.02 s of an accelerated motion, exchanges included
    assert np.all(run["wheels/wheel/contact_share"] == 1.0)
    assert np.all(run["wheels/wheel/contact_point"][:, 2] == 0.0)


def test_center_velocity_and_acceleration_are_the_derivatives_of_position():
    run = simulate(
        "testbench_psi30", "friction.law=none", "time.step=1e-4", "time.output_interval=1e-3", "time.end=0.2"
    )
    dt, rollers = 1e-3, "wheels/wheel/rollers"
    position, velocity, acceleration = (
        run[f"{rollers}/center_{name}"] for name in ("position", "velocity", "acceleration")
    )
    for values, rates in ((position, velocity), (velocity, acceleration)):
        numeric = (values[:-4] - 8 * values[1:-3] + 8 * values[3:-1] - values[4:]) / (12 * dt)
        assert np.abs(numeric - rates[2:-2]).max() < 1e-8 * np.abs(rates).max()  # measured 1.1e-10, 2.3e-10


def test_a_saturated_law_too_stiff_for_the_step_stops_instead_of_flipping_at_its_kink_for_ever():
    """At slip 30 times faster than the step, both branches of the law end on the other side of the kink."""
    run = omnisim.simulate(
        reference_scene("testbench_psi0", "friction.law=saturated", "friction.slip_speed=1e-3", "time.step=1e-3")
    )
    assert "unstable" in run.attributes["status"]


@pytest.mark.parametrize("seed", range(12))
def test_stiff_runs_of_any_law_end(seed):
    rng = np.random.default_rng(seed)
    law, slip_speed = rng.choice(["saturated", "regularized"]), 10.0 ** -rng.integers(1, 7)
    run = omnisim.simulate(
        reference_scene(
            "testbench_psi30",
            f"friction.law={law}",
            f"friction.slip_speed={slip_speed}",
            "time.end=0.5",
            f"wheel_types.omni.roller_angle_deg={rng.uniform(-70, 70)}",
            "time.output_interval=0.1",
            f"time.step={rng.choice([1e-2, 1e-3, 1e-4])}",
            f"wheels.wheel.spin_rate={rng.normal(0, 10)}",
            f"initial.velocity={rng.normal(size=2).tolist()}",
        )
    )
    relative = np.abs(run["energy/balance"]).max(initial=0.0) / max(run["energy/kinetic"].max(initial=0.0), 1e-9)
    assert not run.complete or relative < 1e-2  # of the two that complete: 2.1e-10, 3.2e-6


def test_a_load_lifted_on_an_output_time_is_in_the_last_row():
    run = omnisim.simulate(
        reference_scene(
            "testbench_psi30", "wrench.times=[0, 0.5, 0.5]", "wrench.force=[[0, 0, 0], [0, 0, 0], [0, 0, 99]]"
        )
    )
    assert run.attributes["stop_time"] == run.time[-1] == 0.5
    assert run["wheels/wheel/normal_force"][-1] == 0.0
    assert np.all(run["wheels/wheel/friction_force"][-1] == 0.0)


def test_knots_that_rounding_cannot_part_are_a_jump():
    run = simulate("testbench_psi0", "wheels.wheel.drive={kind='torque', times=[0.0, 5e-324], torque=[0.0, 0.05]}")
    jump = simulate("testbench_psi0", "wheels.wheel.drive={kind='torque', torque=0.05}")
    assert np.array_equal(run["body/position"], jump["body/position"])


def test_a_start_that_cannot_be_says_so():
    run = omnisim.simulate(reference_scene("testbench_psi0", "wheels.wheel.spin_rate=1e200"))
    assert "cannot start" in run.attributes["status"]


def test_a_state_that_bursts_within_a_step_leaves_no_event_without_a_time():
    """Stiff friction, skew rollers, a step a thousand times too long: guards become NaN while roots are sought."""
    run = omnisim.simulate(reference_scene(
        "testbench_psi30", "wheel_types.omni.roller_count=8", "wheel_types.omni.roller_distance=0.08776855558857224",
        "wheel_types.omni.roller_angle_deg=80", "friction.law=viscous", "friction.viscosity=1e4", "time.step=0.01",
        "time.output_interval=0.1", "time.end=0.6", "initial.velocity=[-2.91359, 0.40621]", "initial.yaw_rate=1.75433",
        "wheels.wheel.spin_rate=-2.41345", "wheels.wheel.spin_angle_deg=22.501114085523064",
        "wheels.wheel.drive={kind='torque', times=[0.0, 0.2, 0.2, 0.4], torque=[0.0079, -0.0079, 0.00395, 0.0]}",
        "wrench.times=[0.0, 0.3]", "wrench.force=[[0.0745, -0.0632, 0.0], [0.0, 0.0, 0.0]]",
        "wrench.yaw_torque=[0.0055, 0.0]",
        "wheel_types.omni.roller={mass=0.05, inertia_axial=3e-05, inertia_transverse=2e-5}",
    ))  # fmt: skip
    assert not run.complete and "time.step <" in run.attributes["status"]
    assert np.isfinite(run["events/time"]).all()
