"""The peers of the benchmarks simulate the same motion; nothing here is timed."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
import c_loop
import laws
import machine_scenes
import targets
import whole_machines
from common import bare_wheel, ready, table

import omnisim
from omnisim.loop import Loop
from omnisim.packing import bodies
from omnisim.precision import converged

CASES = {
    "straight rollers": {},
    "angled rollers under drive": {"psi": 30.0, "torque": 0.05},
    "64 rollers": {"rollers": 64, "step": 2e-4},
}


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_c_loop_moves_as_the_march_does_across_exchanges(case):
    library = c_loop.build()
    if library is None:
        pytest.skip("no gcc on this machine")
    scene = bare_wheel(**{"step": 1e-3, "end": 0.5} | case)
    march = ready(scene).go()
    assert march.run.clock.events >= 3
    assert c_loop.disagreement(march, *c_loop.prepare(library, ready(scene))()) < 1e-11  # measured: 1.3e-13


@pytest.mark.parametrize(
    "name", [f"LSODA, {form}, {driver}" for form in ("NumPy", "scalars") for driver in ("solve_ivp", "odeint")]
)
@pytest.mark.parametrize("psi", [0.0, 30.0])
def test_lsoda_agrees_with_the_march_to_its_tolerance(name, psi):
    peer = pytest.importorskip("scipy_peer", reason="needs SciPy")
    march = ready(bare_wheel(1e-4, end=0.5, psi=psi)).go()
    found = peer.integrate(ready(bare_wheel(1e-3, end=0.5, psi=psi)), 1e-10, name)
    np.testing.assert_allclose(found, march.run.y[peer.MOTION], rtol=0, atol=1e-7)  # measured: 2e-8, the roller rate


def test_a_work_precision_curve_is_read_between_its_points():
    peer = pytest.importorskip("scipy_peer", reason="needs SciPy")
    curve = [(1e-3, 1e-4, 1.0), (1e-4, 1e-8, 100.0)]
    assert peer.time_at(1e-6, curve) == pytest.approx(10.0)
    assert peer.time_at(1e-3, curve) == 1.0
    assert peer.time_at(1e-9, curve) is None


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
    parts = ("c_loop", "laws", "scaling", "kernels", "whole_machines", "vehicle", "twists")
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
