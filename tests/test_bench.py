"""The peers of the benchmarks simulate the same motion; nothing here is timed."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "bench"))
import c_loop
from common import bare_wheel, ready, table

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


def test_a_table_is_markdown():
    assert table(["a", "b"], [[1, 2]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_every_benchmark_runs_and_reports():
    """The whole of `python bench/run.py --quick` but the start-up of commands, with its verdict."""
    command = [sys.executable, "bench/run.py", "--quick", "c_loop", "scaling", "kernels"]
    done = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "## Kernels" in done.stdout
    assert "64 rollers take" in done.stdout
