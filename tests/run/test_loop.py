"""A controller's loop is the same run, step by step, and what it set repeats the run as a scene."""

import numpy as np
import pytest
from scenes import reference_scene

import omnisim
from omnisim.scene.scene import parse

MACHINE = ("time.end=0.4", "time.step=5e-4", "time.output_interval=0.01")


def worst(a, b):
    """The largest difference, by the largest value of its dataset or by 1."""
    rows = min(len(a.time), len(b.time))
    paths = [path for path in a if a[path].dtype == float and path.startswith(("body", "wheels", "energy", "odometry"))]
    return max(
        np.abs(a[path][:rows] - b[path][:rows]).max(initial=0.0) / np.abs(a[path]).max(initial=1.0) for path in paths
    )


@pytest.fixture(scope="module")
def controlled():
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE))
    while loop.advance(0.01):
        loop.command(0.4, 0.1, 2.0 * (0.3 - loop.yaw))
        if loop.time > 0.2:
            loop.drive("front_left", 3.0)
    return loop


def test_without_inputs_it_is_the_run_of_the_scene():
    scene = omnisim.load("youbot", MACHINE)
    loop = omnisim.Loop(scene)
    while loop.advance(0.002):
        pass
    assert worst(loop.trajectory(), omnisim.simulate(scene)) == 0.0
    assert loop.status == "complete" and loop.time == pytest.approx(0.4, abs=1e-15)


def test_what_was_set_stands_in_the_trajectory_and_repeats_the_run(controlled):
    run = controlled.trajectory()
    again = omnisim.simulate(parse(run.attributes["scene"]))
    assert run.complete and again.complete
    assert worst(run, again) < 1e-12  # measured 6.5e-14, in a spin acceleration of 1600 rad/s^2


def test_what_it_shows_is_what_the_trajectory_has(controlled):
    run = controlled.trajectory()
    names = list(controlled.names)
    assert np.abs(controlled.position - run["body/position"][-1, :2]).max() < 1e-15
    assert np.abs(controlled.velocity - run["body/velocity"][-1, :2]).max() < 1e-15
    assert (controlled.yaw, controlled.yaw_rate) == (run["body/yaw"][-1], run["body/yaw_rate"][-1])
    assert controlled.spin_angles.tolist() == [run[f"wheels/{name}/spin_angle"][-1] for name in names]
    assert controlled.spin_rates.tolist() == [run[f"wheels/{name}/spin_rate"][-1] for name in names]
    pose = [*run["odometry/position"][-1], run["odometry/yaw"][-1]]
    assert np.abs(controlled.odometry - pose).max() < 1e-15


def test_a_run_left_early_is_a_trajectory_that_says_so_and_goes_on():
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE))
    loop.advance(0.1)
    early = loop.trajectory()
    assert early.attributes["status"] == "ended by its controller at t = 0.1 s" and len(early.time) == 11
    assert loop.status == "running" and loop.advance(0.3) is False
    assert loop.trajectory().complete and loop.advance(0.1) is False


def test_inputs_join_the_tables_of_the_scene():
    """A torque set while a table of forces goes on: the table is as it was, before and after."""
    force = ("wrench.times=[0.0, 0.2, 0.2, 0.4]", "wrench.force=[[0, 0, 0], [4, 0, 0], [0, 2, 0], [0, 0, 0]]")
    scene = reference_scene("kiwi", "time.step=1e-4", "time.end=0.4", *force)
    loop = omnisim.Loop(scene)
    loop.advance(0.1)
    loop.drive("w0", 0.03)
    loop.drive("w1", -0.02)
    loop.drive("w0", 0.01)
    loop.advance(0.3)
    w0, w1, w2 = (scene.config.wheels[w].drive.torque[0] for w in range(3))
    tables = []
    for name, first, then in (("w0", w0, 0.01), ("w1", w1, -0.02)):
        before = first + 0.1 * (scene.config.wheels[int(name[1])].drive.torque[1] - first)
        tables.append(f"wheels.{name}.drive.times=[0.0, 0.1, 0.1]")
        tables.append(f"wheels.{name}.drive.torque=[{first!r}, {before!r}, {then!r}]")
    direct = omnisim.simulate(reference_scene("kiwi", "time.step=1e-4", "time.end=0.4", *force, *tables))
    assert w2 == scene.config.wheels[2].drive.torque[0]
    assert worst(loop.trajectory(), direct) < 1e-10  # measured 4e-13: knots at times that differ in rounding


@pytest.mark.parametrize("seconds", [0.0, -0.01, 1.3e-4, float("nan")])
def test_times_that_are_no_multiple_of_the_step_are_refused(seconds):
    with pytest.raises(ValueError, match="no multiple of the scene's step"):
        omnisim.Loop(omnisim.load("youbot", MACHINE)).advance(seconds)


def test_inputs_that_make_no_sense_are_refused():
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE))
    with pytest.raises(KeyError, match="nobody"):
        loop.drive("nobody", 1.0)
    with pytest.raises(ValueError, match="finite"):
        loop.drive("front_left", float("nan"))
    with pytest.raises(ValueError, match="no input"):
        omnisim.Loop(omnisim.load("six_rollers")).drive("wheel", 1.0)
    with pytest.raises(ValueError, match="no wheel"):
        omnisim.Loop(omnisim.load("six_rollers")).command(1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="tell no pose"):
        _ = omnisim.Loop(omnisim.load("six_rollers")).odometry


def test_a_loop_of_a_machine_free_in_space_shows_what_its_run_records():
    loop = omnisim.Loop(omnisim.load("cable_duct", ["time.end=0.7"]))
    while loop.advance(0.01):
        pass
    run = loop.trajectory()
    shown = {
        "body/position": [*loop.position, loop.height],
        "body/orientation": loop.orientation,
        "body/angular_velocity": loop.angular_velocity,
        "body/yaw": loop.yaw,
        "body/yaw_rate": loop.yaw_rate,
        "body/yaw_acceleration": loop.yaw_acceleration,
    }
    for path, value in shown.items():
        assert np.array_equal(run[path][-1], value), path
    assert np.array_equal(run["body/velocity"][-1, :2], loop.velocity)
    assert np.array_equal(run["body/acceleration"][-1, :2], loop.acceleration)
    forces = [run[f"wheels/{wheel}/normal_force"][-1] for wheel in run.wheels]
    assert np.array_equal(forces, loop.normal_forces) and loop.height < -1e-3
    assert loop.contact_rollers.tolist() == [run[f"wheels/{wheel}/contact_roller"][-1] for wheel in run.wheels]


def test_an_upright_machine_has_height_and_orientation_too():
    loop = omnisim.Loop(omnisim.load("kiwi", [*MACHINE, "initial.yaw_deg=60"]))
    assert loop.height == 0.0
    assert loop.orientation == pytest.approx([np.cos(np.pi / 6), 0.0, 0.0, 0.5], abs=1e-15)
    assert loop.angular_velocity.tolist() == [0.0, 0.0, loop.yaw_rate]
