"""The peers of the benchmarks simulate the same motion; nothing here is timed."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
import laws
import limit
import machine_scenes
import memory
import targets
import whole_machines
from common import bare_wheel, ready, table
from peers import c_loop

import omnisim
from omnisim.loop import Loop
from omnisim.packing import bodies
from omnisim.precision import converged

CASES = {
    "straight rollers": (c_loop.WHEEL, bare_wheel(1e-3, 0.5)),
    "angled rollers under drive": (c_loop.WHEEL, bare_wheel(1e-3, 0.5, psi=30.0, torque=0.05)),
    "64 rollers": (c_loop.WHEEL, bare_wheel(2e-4, 0.5, rollers=64)),
    "mecanum machine": (c_loop.MACHINE, machine_scenes.slipping_platform(end=0.5)),
}


@pytest.mark.parametrize(("loop", "scene"), CASES.values(), ids=CASES)
def test_c_loop_moves_as_the_march_does_across_exchanges(loop, scene):
    library = c_loop.build(loop)
    if library is None:
        pytest.skip("no gcc on this machine")
    march = ready(scene).go()
    assert march.run.clock.events >= 3
    found = c_loop.prepare(loop, library, ready(scene))()
    assert c_loop.disagreement(loop, march, *found) < 1e-11  # measured: 4.0e-13


@pytest.mark.parametrize(("loop", "wheels"), [(c_loop.WHEEL, 1), (c_loop.MACHINE, 4)])
def test_a_right_hand_side_takes_a_root_and_two_divisions_for_each_wheel(loop, wheels):
    if not all(map(shutil.which, ("gcc", "g++"))):
        pytest.skip("no gcc or no g++ on this machine")
    of_rhs, of_step = limit.count(loop, [1.0] * len(limit.OPERATIONS))
    *_, divisions, roots, sines = of_rhs.operations
    machine = wheels > 1  # its loads take a division, its odometry a sine and a cosine
    assert (divisions, roots, sines) == (2 * wheels + machine, wheels, wheels + 1 + machine)
    assert of_rhs.written >= 8 * len(loop.order)
    assert (np.array(of_step.operations) > 4 * np.array(of_rhs.operations)).all()  # stages, and located exchanges
    assert of_rhs.path < of_step.path < 4 * of_rhs.path  # angles of a stage need no forces of the one before


def test_omnisim_takes_as_many_roots_and_sines_as_the_c_loops():
    if not all(map(shutil.which, ("gcc", "g++"))):
        pytest.skip("no gcc or no g++ on this machine")
    own = limit.own_counts()
    for name, loop in c_loop.LOOPS.items():
        of_rhs, _ = limit.count(loop, [1.0] * len(limit.OPERATIONS))
        assert own[name]["rhs"][3:] == of_rhs.operations[3:]
        assert own[name]["step"][3:] == [4 * number for number in of_rhs.operations[3:]]


def test_the_peak_of_a_command_is_its_own():
    peaks = [memory.peak_of([sys.executable, "-c", f"b'x' * {size}"]) for size in (0, 64 * memory.MEGABYTE)]
    assert peaks[1] - peaks[0] == pytest.approx(64 * memory.MEGABYTE, rel=0.05)  # measured: 63.8 MiB
    assert peaks[0] < 32 * memory.MEGABYTE  # not that of the process which asks; measured: 11 MiB


@pytest.fixture(scope="module")
def scipy_peer():
    pytest.importorskip("scipy", reason="a peer needs SciPy")
    from peers import scipy_peer

    return scipy_peer


@pytest.mark.parametrize("form", ["NumPy", "scalars", "compiled"])
@pytest.mark.parametrize("solver", ["LSODA, solve_ivp", "LSODA, odeint", "DOP853, solve_ivp"])
@pytest.mark.parametrize("psi", [0.0, 30.0])
def test_scipy_moves_a_bare_wheel_as_the_march_does(scipy_peer, solver, form, psi):
    scene = bare_wheel(1e-4, end=0.5, psi=psi)
    found = scipy_peer.integrate(ready(scene), solver, form, 1e-10)
    np.testing.assert_allclose(found, scipy_peer.final(scene), rtol=0, atol=1e-7)  # measured: 2e-8, the roller rate


@pytest.mark.parametrize("solver", ["Radau, solve_ivp", "BDF, solve_ivp"])
def test_implicit_solvers_of_scipy_move_a_bare_wheel_as_the_march_does(scipy_peer, solver):
    scene = bare_wheel(1e-4, end=0.2)
    found = scipy_peer.integrate(ready(scene), solver, "compiled", 1e-8)
    np.testing.assert_allclose(found, scipy_peer.final(scene), rtol=0, atol=1e-5)  # measured: 7e-9, BDF 1.1e-6


@pytest.mark.parametrize("solver", ["LSODA, solve_ivp", "LSODA, odeint", "Radau, solve_ivp"])
def test_scipy_moves_a_stiff_wheel_as_radau5_does(scipy_peer, solver):
    scene = scipy_peer.smooth(omnisim.load("coulomb_wheel", ("solver.method=radau5", "time.end=0.3")), 1e-4)
    found = scipy_peer.integrate(ready(scene), solver, "compiled", 1e-9)
    assert scipy_peer.error_of(found, scipy_peer.final(scene), 1) < 1e-7  # measured: 5e-9, 1.8e-8, 1e-12


@pytest.mark.parametrize("solver", ["LSODA, solve_ivp", "Radau, solve_ivp", "BDF, solve_ivp"])
def test_scipy_moves_a_stiff_platform_as_radau5_does(scipy_peer, solver):
    """Over three exchanges, before its command has risen in full."""
    scene = scipy_peer.smooth(machine_scenes.platform("diagonal with yaw", "rate", "radau5", 5e-4, 0.3), 1e-3)
    found = scipy_peer.integrate(ready(scene), solver, "compiled", 1e-8)
    assert scipy_peer.error_of(found, scipy_peer.final(scene), 4) < 1e-7  # measured: 5e-9, 3e-12, 7e-10


def test_scipy_goes_on_across_a_knot_of_the_command(scipy_peer):
    scene = scipy_peer.smooth(machine_scenes.platform("diagonal with yaw", "rate", "radau5", 5e-4, 0.6), 1e-3)
    found = scipy_peer.integrate(ready(scene), "LSODA, solve_ivp", "compiled", 1e-8)
    assert scipy_peer.error_of(found, scipy_peer.final(scene), 4) < 1e-6  # measured: 2.3e-8


def test_the_converged_march_of_coulomb_wheel_is_the_reference(scipy_peer):
    case, known = scipy_peer.CASES["coulomb_wheel"], json.loads(laws.REFERENCE.read_text())
    expected = [*known["position"][-1], known["yaw"][-1], known["spin_angle"]["wheel"][-1]]
    found = scipy_peer.final(case.scene(*case.fine))[:4]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)  # measured: 2e-11


def test_a_solver_that_makes_no_headway_is_given_up(scipy_peer):
    with pytest.raises(scipy_peer.Stalled):
        scipy_peer.integrate(ready(bare_wheel(1e-3)), "LSODA, solve_ivp", "compiled", 1e-10, patience=0.0)


def test_a_solver_takes_the_loosest_tolerance_that_reaches_an_error(scipy_peer):
    case = scipy_peer.CASES["bare wheel, slip_speed 0.05 m/s"]
    reference, peer = scipy_peer.final(case.scene(*case.fine)), scipy_peer.Peer("DOP853, solve_ivp", "compiled")
    found = scipy_peer.climb(case, peer, 1e-6, reference)
    assert found.error <= 1e-6
    looser = scipy_peer.solving(case, found._replace(tolerance=10.0 * found.tolerance))()
    assert found.tolerance == 10.0 * 1e-6 or scipy_peer.error_of(looser, reference, 1) > 1e-6


def law_error(*setup):
    return laws.error_of(omnisim.simulate(laws.Setup(*setup).scene()))


@pytest.mark.parametrize("method", ["rk4", "auto", "radau5"])
def test_the_set_valued_law_keeps_its_order_against_the_reference(method):
    steps = (1e-2, 2e-3)
    order = laws.observed_order(steps, [law_error(0.0, method, step) for step in steps])
    assert order > 3.5  # measured: 3.61, 3.61, 4.18


def test_the_regularized_law_tends_to_the_set_valued_one_at_first_order():
    slip_speeds = (1e-3, 1e-4, 1e-5)
    errors = [law_error(slip_speed, "radau5", 2e-3) for slip_speed in slip_speeds]
    for pair in (slice(0, 2), slice(1, 3)):
        assert laws.observed_order(slip_speeds[pair], errors[pair]) == pytest.approx(1.0, abs=0.01)  # measured: 0.999


def test_a_rival_is_the_fastest_that_is_at_least_as_accurate():
    setup = laws.Setup(1e-4, "radau5", 1e-3)
    pool = [laws.Trial(setup, 1e-5, 1.0), laws.Trial(setup, 1e-6, 2.0), laws.Trial(setup, 1e-7, 3.0)]
    assert laws.fastest(2e-6, pool) == pool[1]
    assert laws.fastest(1e-8, pool) is None


def test_an_unmatched_error_is_matched_by_the_slip_speed_that_just_reaches_it():
    near = laws.Trial(laws.Setup(1e-3, "radau5", 2e-3), 6.05e-5, 20.0)
    (found,) = laws.matched(3e-5, [near], [near])
    assert laws.NEAR * 3e-5 < found.error < 3e-5
    assert laws.matched(3e-5, [near], [found]) == []


def test_a_run_that_stops_has_no_error_to_compare():
    assert law_error(1e-3, "rk4", 1e-3) == np.inf


@pytest.mark.parametrize("drive", ["rate", "torque"])
@pytest.mark.parametrize("motion", machine_scenes.MOTIONS)
def test_the_reference_of_the_platform_is_confirmed_and_the_ladder_tends_to_it(motion, drive):
    converged = whole_machines.reference(motion, drive)
    run = omnisim.simulate(machine_scenes.platform(motion, drive, "rk4", 1e-3))
    error = whole_machines.distances(run, converged).max()
    assert error < 1e-7  # measured: 5.5e-9, diagonal with yaw by rate drives


def test_the_platform_weighs_what_it_should_and_goes_forward_as_ideal_wheels_do():
    scene = machine_scenes.platform("forward", "torque", "rk4", 1e-3)
    assert bodies(scene.config).mass == pytest.approx(22.7)
    x, y = omnisim.simulate(scene)["body/position"][-1, :2]
    assert (x, y) == pytest.approx((0.875, 0.0), abs=1e-3)  # measured: 0.3 mm short, what rollers take to speed up


@pytest.mark.parametrize("wheels", whole_machines.WHEELS)
def test_every_contact_of_a_ring_sticks_throughout(wheels):
    run = omnisim.simulate(machine_scenes.ring(wheels, "coulomb", 1e-3, whole_machines.STUCK))
    slip = max(np.abs(run[f"wheels/w{i}/slip_velocity"]).max() for i in range(wheels))
    assert run.complete
    assert len(run["events/time"]) == 0
    assert slip < 1e-11  # measured: 5e-13, of 12
    assert np.hypot(*run["body/velocity"][-1, :2]) > 0.01  # measured: 0.023, of 3


def test_stepping_from_outside_leaves_the_motion_as_it_is():
    scene = omnisim.load("kiwi")
    poses = []
    for call in whole_machines.CALLS.values():
        loop = Loop(scene)
        call(loop)
        assert loop.time == pytest.approx(0.5)
        poses.append(loop.position)
    np.testing.assert_array_equal(poses[1], poses[0])
    np.testing.assert_allclose(poses[2], poses[0], rtol=0, atol=1e-12)  # measured: 6e-14
    np.testing.assert_allclose(poses[3], poses[0], rtol=0, atol=1e-4)  # stairs for a ramp; measured: 3.7e-5


def test_a_table_is_markdown():
    assert table(["a", "b"], [[1, 2]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_every_benchmark_runs_and_reports():
    """The whole of `python bench/run.py --quick` but the start-up of commands, with its verdict."""
    parts = ("c_loop", "limit", "laws", "scaling", "kernels", "whole_machines", "vehicle", "twists")
    command = [sys.executable, "bench/run.py", "--quick", *parts]
    done = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "## Kernels" in done.stdout
    assert "times as long as the set-valued one" in done.stdout
    assert "64 rollers take" in done.stdout
    assert "A step of 12 wheels takes" in done.stdout
    assert "| slope |" in done.stdout
    assert "| youbot | sideways |" in done.stdout


def test_the_error_of_a_picked_step_is_judged_by_a_converged_run():
    case = targets.CASES[0]
    found = targets.row(case, "dopri5", 1e-6, converged(case.load(), 1e-4, lambda _: None), 1)
    assert found["trusted"] < 1e-12 < found["error"] < found["estimate"] <= 1e-6  # measured: 2e-13, 4.7e-10, 1.0e-7
    assert targets.report([found]).endswith("1 of 1 errors are below their targets, 0.0001 to 1e-09.")
