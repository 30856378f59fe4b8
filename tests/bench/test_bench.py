"""The peers of the benchmarks simulate the same motion; nothing here is timed."""

import json
import math
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from helpers.stages import either

import omnisim
from bench import (
    laws,
    limit,
    machine_scenes,
    memory,
    outside,
    run,
    scaling,
    targets,
    whole_machines,
)
from bench.common import Claim, bare_wheel, claims_table, ready, table
from bench.peers import c_loop
from omnisim.cad.geometry import roller_frames
from omnisim.dynamics.packing import bodies
from omnisim.run.loop import Loop
from omnisim.run.work_precision import converged

CASES = {
    "straight rollers": (c_loop.WHEEL, bare_wheel(1e-3, 0.5)),
    "angled rollers under drive": (c_loop.WHEEL, bare_wheel(1e-3, 0.5, psi=30.0, torque=0.05)),
    "64 rollers": (c_loop.WHEEL, bare_wheel(2e-4, 0.5, rollers=64)),
    "mecanum machine": (c_loop.MACHINE, machine_scenes.slipping_platform(end=0.5)),
}


@pytest.mark.parametrize(("loop", "scene"), CASES.values(), ids=CASES)
def test_c_loop_moves_as_the_march_does_across_exchanges_and_sees_the_same_extremes(loop, scene):
    """The loops locate an exchange by steps of their own, the march aims at it: both far better than their steps."""
    library = c_loop.build(loop)
    if library is None:
        pytest.skip("no gcc on this machine")
    march = ready(scene).go()
    assert march.run.clock.events >= 3
    found = c_loop.prepare(loop, library, ready(scene))()
    # measured: 9e-8, 4e-7, 4e-9 and 3.3e-6 of what the steps err, 2e-6 to 9e-5; 1e-5 is allowed
    assert c_loop.disagreement(loop, march, *found) < c_loop.allowed(scene, march)


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


@pytest.mark.long
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
    from bench.peers import scipy_peer

    return scipy_peer


@pytest.mark.long
@pytest.mark.parametrize("form", ["NumPy", "scalars", "compiled"])
@pytest.mark.parametrize("solver", ["LSODA, solve_ivp", "LSODA, odeint", "DOP853, solve_ivp"])
@pytest.mark.parametrize("psi", [0.0, 30.0])
def test_scipy_moves_a_bare_wheel_as_the_march_does(scipy_peer, solver, form, psi):
    scene = bare_wheel(1e-4, end=0.5, psi=psi)
    found = scipy_peer.integrate(ready(scene), solver, form, 1e-10)
    np.testing.assert_allclose(found, scipy_peer.final(scene), rtol=0, atol=1e-7)  # measured: 2e-8, the roller rate


@pytest.mark.long
@pytest.mark.parametrize("solver", ["Radau, solve_ivp", "BDF, solve_ivp"])
def test_implicit_solvers_of_scipy_move_a_bare_wheel_as_the_march_does(scipy_peer, solver):
    scene = bare_wheel(1e-4, end=0.2)
    found = scipy_peer.integrate(ready(scene), solver, "compiled", 1e-8)
    np.testing.assert_allclose(found, scipy_peer.final(scene), rtol=0, atol=1e-5)  # measured: 7e-9, BDF 1.1e-6


@pytest.mark.long
@pytest.mark.parametrize("solver", ["LSODA, solve_ivp", "LSODA, odeint", "Radau, solve_ivp"])
def test_scipy_moves_a_stiff_wheel_as_radau5_does(scipy_peer, solver):
    scene = scipy_peer.smooth(omnisim.load("coulomb_wheel", ("solver.method=radau5", "time.end=0.3")), 1e-4)
    found = scipy_peer.integrate(ready(scene), solver, "compiled", 1e-9)
    assert scipy_peer.error_of(found, scipy_peer.final(scene), 1) < 1e-7  # measured: 5e-9, 1.8e-8, 1e-12


@pytest.mark.long
@pytest.mark.parametrize(
    ("solver", "form"),
    [("LSODA, solve_ivp", "NumPy"), *((f"{name}, solve_ivp", "compiled") for name in ("LSODA", "Radau", "BDF"))],
)
def test_scipy_moves_a_stiff_platform_as_radau5_does(scipy_peer, solver, form):
    """Over three exchanges, before its command has risen in full."""
    scene = scipy_peer.smooth(machine_scenes.platform("diagonal with yaw", "rate", "radau5", 5e-4, 0.3), 1e-3)
    found = scipy_peer.integrate(ready(scene), solver, form, 1e-8)
    assert scipy_peer.error_of(found, scipy_peer.final(scene), 4) < 1e-7  # measured: 1.1e-8, 1.2e-8, 3e-12, 7e-10


def test_scipy_goes_on_across_a_knot_of_the_command(scipy_peer):
    scene = scipy_peer.smooth(machine_scenes.platform("diagonal with yaw", "rate", "radau5", 5e-4, 0.6), 1e-3)
    found = scipy_peer.integrate(ready(scene), "LSODA, solve_ivp", "compiled", 1e-8)
    assert scipy_peer.error_of(found, scipy_peer.final(scene), 4) < 1e-6  # measured: 2.3e-8


def test_the_converged_march_of_coulomb_wheel_is_the_reference(scipy_peer):
    case, known = scipy_peer.CASES["coulomb_wheel"], json.loads(laws.REFERENCE.read_text())
    expected = [*known["position"][-1], known["yaw"][-1], known["spin_angle"]["wheel"][-1]]
    found = scipy_peer.final(case.scene(*case.fine))[:4]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)  # measured: 2e-11


def test_evaluations_of_the_equations_are_counted(scipy_peer, monkeypatch):
    from bench.peers import driver

    driver.integrate(ready(bare_wheel(1e-3, end=0.05)), "DOP853, solve_ivp", "compiled", 1e-3, math.inf)  # compiles
    calls, compiled = [], driver.FORMS["compiled"]

    def counted(march, box, n):
        f, jacobian = compiled(march, box, n)
        return lambda t, y: calls.append(t) or f(t, y), jacobian

    monkeypatch.setitem(driver.FORMS, "compiled", counted)
    case = scipy_peer.CASES["bare wheel, slip_speed 0.05 m/s"]
    trial = scipy_peer.Trial(scipy_peer.Peer("DOP853, solve_ivp", "compiled"), 1e-6, 1e-8, 0.0, 1e-6, 1.0)
    found = scipy_peer.evaluations(case, trial)
    assert found == len(calls) + 2 > 1000  # two find the roller in contact
    assert scipy_peer.evaluations(case, trial._replace(peer=scipy_peer.Peer("LSODA, odeint", "scalars"))) == 0


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


@pytest.mark.parametrize("drive", either(["rate", "torque"], ["rate"]))
@pytest.mark.parametrize("motion", either(machine_scenes.MOTIONS, ["sideways"]))
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
    for call in outside.CALLS.values():
        loop = Loop(scene)
        call(loop)
        assert loop.time == pytest.approx(0.5)
        poses.append(loop.position)
    np.testing.assert_array_equal(poses[1], poses[0])
    np.testing.assert_allclose(poses[2], poses[0], rtol=0, atol=1e-12)  # measured: 6e-14
    np.testing.assert_allclose(poses[3], poses[0], rtol=0, atol=1e-4)  # stairs for a ramp; measured: 3.7e-5


def test_a_table_is_markdown():
    assert table(["a", "b"], [[1, 2]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def claim(value, bound="at most", target=1.2, alarm=2.5):
    return Claim("a march", value, bound, target, alarm)


@pytest.mark.parametrize(
    ("value", "met", "alarming"), [(1.2, True, False), (1.21, False, False), (2.5, False, False), (2.51, False, True)]
)
def test_a_bound_is_still_within_itself_and_beyond_the_alarm_is_not(value, met, alarming):
    assert (claim(value).met, claim(value).alarming) == (met, alarming)
    from_above = claim(-value, "at least", -1.2, -2.5)
    assert (from_above.met, from_above.alarming) == (met, alarming)


@pytest.mark.parametrize("bound", ["at most", "at least"])
def test_what_is_no_number_is_missed_and_beyond_the_alarm(bound):
    assert not claim(math.nan, bound).met and claim(math.nan, bound).alarming


def test_the_table_of_claims_shows_what_is_missed():
    shown = claims_table([claim(1.0), claim(3.0)])
    assert "| a march | 1 | at most 1.2 | met | 2.5 |" in shown
    assert "| a march | 3 | at most 1.2 | **missed** | 2.5 |" in shown


@pytest.fixture
def fake(monkeypatch):
    """A benchmark whose value is the number of its rounds: 3, with --quick 2."""
    module = ModuleType("fake_benchmark")
    module.measure = lambda rounds: {"rounds": rounds}
    module.report = lambda result: f"{result['rounds']} rounds"
    module.claims = lambda result: [claim(float(result["rounds"]))]
    monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(run.BENCHMARKS, "fake", run.Benchmark(module.__name__, "A fake", 3, 2))
    return module


def test_a_check_passes_what_is_missed_within_the_alarm(fake, capsys):
    run.main(["--check", "fake"])
    assert "| a march | 2 | at most 1.2 | **missed** | 2.5 |" in capsys.readouterr().out


def test_a_check_fails_beyond_the_alarm_and_names_the_claim(fake, capsys):
    fake.claims = lambda _: [claim(2.51), claim(1.0)]
    with pytest.raises(SystemExit, match=r"^beyond its alarm: a march: 2\.51$"):  # a sentence: exit code 1
        run.main(["--check", "fake"])
    assert "## A fake" in capsys.readouterr().out
    run.main(["--quick", "fake"])  # only a check fails


def test_a_report_holds_the_numbers_and_their_circumstances(fake, tmp_path):
    run.main(["fake", "--report", str(tmp_path / "new")])
    data = json.loads((tmp_path / "new/fake.json").read_text())
    assert data["result"] == {"rounds": 3} and data["report"] == "3 rounds"
    assert Claim(**data["claims"][0]) == claim(3.0)
    assert data["command"] == "python -m bench fake"
    assert {"title", "date", "machine", "versions"} < set(data)


def test_a_benchmark_without_its_package_says_so_and_claims_nothing(fake, monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "scipy", None)  # importing it fails

    def measure(_):
        raise AssertionError

    fake.measure = measure
    monkeypatch.setattr(run, "import_module", lambda _: import_module("scipy"))
    run.main(["--check", "fake", "--report", str(tmp_path)])
    assert "scipy is not installed: not measured." in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


def test_groups_are_opened_and_nothing_runs_twice():
    chosen = run.chosen(run.parsed(["scaling", "ours"]))
    assert chosen[0] == "scaling" and sorted(chosen) == sorted(run.OURS)
    assert run.chosen(run.parsed([])) == list(run.BENCHMARKS)
    assert run.chosen(run.parsed(["--check"])) == list(run.CHECKED)


@pytest.mark.long
def test_every_benchmark_runs_and_reports(tmp_path):
    """The whole of `python -m bench --quick` but commands and other engines, with its claims."""
    parts = ("c_loop", "limit", "laws", "scaling", "kernels", "whole_machines", "vehicle", "twists")
    parts = (*parts, "precision", "accuracy")
    command = [sys.executable, "-m", "bench", "--quick", "--report", str(tmp_path), *parts]
    done = subprocess.run(command, cwd=Path(__file__).parents[2], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "## Kernels" in done.stdout
    for text in (
        "by that with the set-valued one",
        "with 64 rollers",
        "on two rows of rollers, by that on one: kiwi drive",
        "a step of 12 wheels",
        "times real time with errors below 1e-06, coulomb_wheel",
        "order of rk4, six_rollers",
    ):
        assert re.search(rf"^\| .*{text}.* \| (met|\*\*missed\*\*) \|", done.stdout, re.MULTILINE), text
    assert "| slope |" in done.stdout
    assert "| youbot | sideways |" in done.stdout
    assert {path.stem for path in tmp_path.iterdir()} >= set(parts) - {"c_loop", "limit"}  # which need a compiler


@pytest.mark.parametrize("name", scaling.machines())
def test_two_rows_have_the_rollers_of_one_at_the_same_azimuths(name):
    one, two = scaling.on_rows(scaling.machines()[name]).values()
    places = []
    for scene in (one, two):
        (kind,) = scene.config.wheel_types.values()
        places.append(np.array([centre for centre, _ in roller_frames(kind)]))
    np.testing.assert_allclose(places[1][:, [0, 2]], places[0][:, [0, 2]], rtol=0, atol=1e-16)
    assert set(places[1][:, 1].round(6)) == {-0.01, 0.01} and not places[0][:, 1].any()


def test_the_error_of_a_picked_step_is_judged_by_a_converged_run():
    case = targets.CASES[0]
    found = targets.row(case, "dopri5", 1e-6, converged(case.load(), 1e-4, lambda _: None), 1)
    assert found["trusted"] < 1e-12 < found["error"] < found["estimate"] <= 1e-6  # measured: 2e-13, 4.7e-10, 1.0e-7
    (kept,) = targets.claims([found])
    assert (kept.value, kept.met) == (1, True)
