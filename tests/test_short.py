"""Short runs that also pass with compilation off (NUMBA_DISABLE_JIT=1): the kernels are plain Python as well."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest
import scenes
from scenes import REFERENCE_CASES, reference_data, simulate

import omnisim

pytestmark = pytest.mark.short
LAWS = {
    "regularized": (),
    "saturated": ("friction.law=saturated",),
    "viscous": ("friction.law=viscous", "friction.viscosity=3.0"),
    "none": ("friction.law=none",),
}
PUSHED = (
    "wheels.wheel.drive={kind='torque', times=[0.0, 0.03, 0.03], torque=[0.2, 0.6, -0.4]}",
    "wrench.frame='body'", "wrench.times=[0.0, 0.04]", "wrench.force=[[0.5, -1.0, 2.0], [1.0, 0.5, -4.0]]",
)  # fmt: skip


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize("name", REFERENCE_CASES)
def test_the_first_rows_agree_with_the_reference(name, tracking):
    reference = reference_data(name)
    interval = reference["time"][1]
    run = simulate(name, f"solver.tracking={tracking}", f"time.end={2 * interval}", "time.step=2.5e-4")
    error = np.abs(run["body/position"][:, :2] - reference["position"][:3]).max()
    assert error < 1e-9  # measured 1.6e-11 and 2.5e-12; the step is coarse
    assert np.abs(run["wheels/wheel/spin_angle"] - reference["spin_angle"][:3]).max() < 1e-9  # 6.0e-10, 6.1e-11


def test_bodies_move_as_the_reduced_equations_say():
    short = ("time.end=0.02", "time.step=2.5e-4", "time.output_interval=0.01", *PUSHED)
    reduced, multibody = (
        simulate("testbench_psi30", *short, f"solver.formulation={f}") for f in ("reduced", "multibody")
    )
    for path in ("body/position", "body/velocity", "wheels/wheel/spin_rate", "wheels/wheel/normal_force"):
        assert np.abs(reduced[path] - multibody[path]).max() < 1e-9, path  # measured: 2e-11, the spin rate
    assert multibody["constraints/position"].max() < 1e-13  # measured: 3e-16


@pytest.mark.parametrize("law", ["regularized", pytest.param("coulomb", marks=pytest.mark.long)])  # a minute to compile
def test_a_machine_free_in_space_stands_on_its_springs(law):
    """For 2 ms, in which its drives have hardly begun."""
    run = omnisim.simulate(omnisim.load("cable_duct", [
        f"friction.law={law}", "time.step=1e-4", "time.end=0.002", "time.output_interval=1e-3",
    ]))  # fmt: skip
    assert run.complete and len(run.time) == 3
    assert np.abs(run["body/position"] - run["body/position"][0]).max() < 1e-6


@pytest.mark.parametrize("method", ["heun", "rk4", "dopri5", "bs5"])
@pytest.mark.parametrize("law", LAWS)
def test_energy_is_balanced_for_every_law_and_method(law, method):
    run = simulate(
        "testbench_psi30", *LAWS[law], *PUSHED, f"solver.method={method}", "time.end=0.1", "time.step=2.5e-4",
        "time.output_interval=0.05",
    )  # fmt: skip
    bound = 1e-6 if method == "heun" else 1e-8
    assert np.abs(run["energy/balance"]).max() < bound  # J, of 1 J; measured up to 3.4e-8 (heun), 2.9e-10


PROGRAM = """
import json, sys
from scenes import simulate
run = simulate("testbench_psi30", "time.end=0.2", "time.step=1e-3", "solver.tracking=" + sys.argv[1])
paths = ("body/position", "body/velocity", "wheels/wheel/spin_angle")
print(json.dumps({path: run[path][-1].tolist() for path in paths}))
"""


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="compares compiled with interpreted")
@pytest.mark.parametrize("tracking", ["explicit", pytest.param("implicit", marks=pytest.mark.long)])
def test_compiled_and_interpreted_kernels_compute_the_same(tracking):
    results = []
    for disabled in ("0", "1"):
        environment = {**os.environ, "NUMBA_DISABLE_JIT": disabled, "PYTHONPATH": os.path.dirname(scenes.__file__)}
        command = [sys.executable, "-c", PROGRAM, tracking]
        output = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
        results.append(np.concatenate([np.ravel(values) for values in json.loads(output).values()]))
    assert np.abs(results[0] - results[1]).max() < 1e-14  # the compiler may contract a b + c; measured 0
