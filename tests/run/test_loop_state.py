"""A Loop for learning: its state is copied and restored to the last bit, looking leaves no trace, and it is pushed."""

import numpy as np
import pytest

import omnisim
from omnisim.dynamics.parameters import DRIVE_INPUT
from omnisim.run import inputs
from omnisim.run import loop as loop_module
from omnisim.run.inputs import table

MACHINE = {"time.end": 0.2, "time.step": 5e-4, "time.output_interval": 0.01}
COMMAND = {"command.times": [0.0, 0.1], "command.twist": [[0.4, 0.2, 0.5], [0.3, 0.1, 0.4]]}  # slips at once


def started(**overrides):
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE | COMMAND | overrides))
    loop.advance(0.02)
    return loop


def controlled(loop):
    """The states at all steps to the end, under a controller that pushes as well."""
    states, going = [], True
    while going:
        going = loop.advance(5e-4)
        loop.command(0.4, 0.2, 3.0 * (0.3 - loop.yaw))
        loop.wrench((2.0, -1.0, 0.0), 0.1 * loop.yaw_rate)
        states.append(loop.run.y.copy())
    return np.array(states)


def same(a, b):
    return list(a) == list(b) and all(np.array_equal(a[path], b[path]) for path in a)


def test_what_follows_a_restored_state_is_the_same_to_the_last_bit():
    loop = started()
    state = loop.copy()
    first, run = controlled(loop), loop.trajectory()
    assert len(set(run["events/kind"])) > 2  # it sticks, slips, and changes rollers
    loop.restore(state)
    assert loop.time == pytest.approx(0.02) and loop.status == "running"
    assert np.array_equal(controlled(loop), first) and same(loop.trajectory(), run)
    assert np.array_equal(controlled(state), first) and same(state.trajectory(), run)


def test_a_copy_and_its_original_go_their_own_ways():
    loop = started()
    other, twin = loop.copy(), loop.copy()
    other.drive("front_left", 30.0)
    other.wrench((0.0, 20.0, 0.0))
    other.advance(0.1)
    loop.advance(0.1)
    twin.advance(0.1)
    assert np.array_equal(loop.run.y, twin.run.y) and same(loop.trajectory(), twin.trajectory())
    assert np.abs(loop.position - other.position).max() > 1e-3  # measured 1e-2


def test_reset_begins_again_with_nothing_set_and_with_another_start_if_wanted():
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE | COMMAND))
    first = controlled(loop)
    loop.reset()
    assert loop.time == 0.0 and loop.trajectory().attributes["scene"] == loop.scene.text
    assert np.array_equal(controlled(loop), first)
    loop.reset({"initial.yaw_deg": 90.0, "initial": {"position": (1.0, 2.0)}})
    assert loop.yaw == pytest.approx(np.pi / 2) and loop.position == pytest.approx([1.0, 2.0])
    assert omnisim.load_text(loop.trajectory().attributes["scene"]).config.initial.position == (1.0, 2.0)
    with pytest.raises(omnisim.SceneError, match=r"overrides: initial\.yaw = 1: unknown key"):
        loop.reset({"initial.yaw": 1})
    assert loop.yaw == pytest.approx(np.pi / 2)


def test_looking_leaves_no_trace():
    """Sensors, trajectories on the way, and the status in between: the motion is the same to the last bit."""
    silent, watched = started(), started()
    going = True
    while going:
        yaw = silent.yaw
        for loop in (silent, watched):
            going = loop.advance(0.01)
            loop.command(0.4, 0.2, 0.3 - yaw)
            if loop is watched:
                loop.trajectory()
                for name in dir(loop):
                    if not name.startswith("_") and isinstance(getattr(type(loop), name, None), property):
                        getattr(loop, name)
    assert np.array_equal(silent.run.y, watched.run.y) and same(silent.trajectory(), watched.trajectory())


def test_sensors_show_what_the_trajectory_has():
    """At an output time every dataset of the last row is there, to the last bit."""
    loop = started()
    loop.advance(0.05)
    run, names = loop.trajectory(), list(loop.names)
    shown = {
        "drive_torque": loop.drive_torques,
        "normal_force": loop.normal_forces,
        "friction_force": loop.friction_forces,
        "slip_velocity": loop.slip_velocities,
        "contact_roller": loop.contact_rollers,
        "contact_share": loop.contact_shares,
        "spin_acceleration": loop.spin_accelerations,
    }
    for path, values in shown.items():
        assert np.array_equal(values, [run[f"wheels/{name}/{path}"][-1] for name in names]), path
    assert np.array_equal(loop.acceleration, run["body/acceleration"][-1, :2])
    assert loop.yaw_acceleration == run["body/yaw_acceleration"][-1]
    assert loop.normal_forces.sum() == pytest.approx(23.1 * 9.81, rel=0.2)  # of what weighs on them


def test_wheels_stick_where_friction_holds_them_and_slip_where_it_does_not():
    """The youBot at its lazy start, and on ice: coulomb knows which, and the slip says the same."""
    lazy = omnisim.Loop(omnisim.load("youbot", MACHINE))
    ice = omnisim.Loop(omnisim.load("youbot", MACHINE | COMMAND | {"friction.coefficient": 0.01}))
    for loop in (lazy, ice):
        loop.advance(0.05)
    assert lazy.sticking.all() and np.abs(lazy.slip_velocities).max() < 1e-12
    assert not ice.sticking.any() and np.linalg.norm(ice.slip_velocities, axis=1).min() > 1e-4  # measured 3.5e-4
    friction = np.linalg.norm(ice.friction_forces, axis=1)
    assert friction == pytest.approx(0.01 * ice.normal_forces, rel=1e-9)


def test_a_wrench_moves_the_machine_as_newton_says_and_its_tables_repeat_the_run():
    """Without friction the force has only masses to move; along the body's axes it turns with them."""
    scene = omnisim.load("youbot", MACHINE | {"friction.law": "none", "wrench": {"frame": "body", "times": [0.0]},
                                              "initial.yaw_deg": 90.0})  # fmt: skip
    loop = omnisim.Loop(scene)
    loop.advance(0.1)
    loop.wrench((4.5, 0.0, 0.0))
    loop.advance(0.1)
    mass = loop.parameters.machine.mass
    assert loop.velocity == pytest.approx([0.0, 0.1 * 4.5 / mass], abs=1e-12)
    assert loop.acceleration == pytest.approx([0.0, 4.5 / mass], abs=1e-12)
    run = loop.trajectory()
    again = omnisim.simulate(omnisim.load_text(run.attributes["scene"]))
    assert np.abs(run["body/position"] - again["body/position"]).max() < 1e-15
    assert run["energy/wrench_work"][-1] == pytest.approx(0.5 * mass * loop.velocity[1] ** 2, rel=1e-9)
    assert omnisim.load_text(run.attributes["scene"]).config.wrench.times == (0.0, 0.1, 0.1)


def test_a_controlled_run_with_pushes_is_repeated_by_its_scene_with_its_comments():
    loop = started()
    controlled(loop)
    run = loop.trajectory()
    scene = omnisim.load_text(run.attributes["scene"])
    assert scene.config.command is None and "# KUKA youBot" in scene.text
    again = omnisim.simulate(scene)
    assert np.abs(run["body/position"] - again["body/position"]).max() < 1e-10  # measured 1e-14


def test_a_thousand_commands_are_written_once_with_a_row_for_each(monkeypatch):
    """The work is linear: the text is rewritten once, by as many numbers as were set; nothing at all for a status."""
    rewritten, collected = [], []
    real, gathered = inputs.rewrite, loop_module.collect
    monkeypatch.setattr(inputs, "rewrite", lambda *given: rewritten.append(1) or real(*given))
    monkeypatch.setattr(loop_module, "collect", lambda *given: collected.append(1) or gathered(*given))
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE | {"time.end": 0.5}))
    for step in range(1000):
        loop.drive("front_left", 0.001 * step)
        loop.advance(5e-4)
    assert loop.status == "complete" and not collected
    scene = loop.trajectory().attributes["scene"]
    assert len(rewritten) == len(collected) == 1
    assert len(loop.parameters.starts) <= 2 * 1000 + 64
    times, _ = table(loop.parameters, loop._held, [DRIVE_INPUT])
    assert len(times) == 2 * 1000 - 1
    assert len(scene) < 60 * 1000  # measured 36 characters for each command


@pytest.mark.parametrize("law, seconds", [("coulomb", 0.2), ("regularized", 0.2), ("coulomb", 0.1)])
def test_the_status_is_that_of_the_trajectory(law, seconds):
    loop = omnisim.Loop(omnisim.load("youbot", MACHINE | {"friction.law": law, "friction.slip_speed": 1e-9}))
    loop.advance(seconds)
    status = loop.trajectory().attributes["status"]
    assert loop.status == (status if loop.run.clock.status else "running")
    assert {"coulomb": "complete", "regularized": "unstable"}[law] in status or seconds < 0.2


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda loop: loop.drive("nobody", 1.0), "no wheel is called 'nobody'; wheels: front_left"),
        (
            lambda loop: loop.drive("front_left", "fast"),
            "input of wheel 'front_left' must be a number",
        ),
        (lambda loop: loop.command(1.0, None, 0.0), r"vy must be a number, not None \(NoneType\)"),
        (lambda loop: loop.wrench(3.0), r"force must be three numbers \(x, y, z\), N, not 3.0"),
        (lambda loop: loop.wrench((1.0, 2.0, float("inf"))), "force z must be a finite number, not inf"),
        (lambda loop: loop.restore(loop.run), r"restore takes a Loop, as copy\(\) returns it, not Run"),
        (lambda loop: loop.advance("1"), "seconds must be a number, not '1'"),
    ],
)
def test_arguments_that_make_no_sense_get_a_sentence(call, sentence):
    with pytest.raises((KeyError, TypeError, ValueError), match=sentence):
        call(omnisim.Loop(omnisim.load("youbot", MACHINE)))
