"""Every tableau converges at its order through exchanges, knots, jumps and kinks, by self-convergence.

The reference is a run of order 5 at an eighth of the smallest step. Steps are chosen well above the rounding floor.
"""

import numpy as np
import pytest
from scenes import final_state, reference_scene

import omnisim
from omnisim.base.methods import TABLEAUX

STEPS = {"heun": (4e-4, 2e-4, 1e-4), "rk4": (8e-4, 4e-4, 2e-4), "dopri5": (1e-3, 5e-4, 2.5e-4), "bs5": (1e-3, 5e-4)}
DRIVEN = (
    "wheels.wheel.drive={kind='torque', times=[0.0, 0.1234, 0.25, 0.25, 0.7], torque=[0.0, 0.3, 0.3, -0.2, 0.1]}",
    "wrench.frame='body'",
    "wrench.times=[0.0, 0.31, 0.31, 0.9]",
    "wrench.force=[[0.0, 0.2, 1.0], [0.5, 0.2, 1.0], [0.0, 0.0, -2.0], [0.3, -0.4, 0.0]]",
    "wrench.yaw_torque=[0.0, 0.01, -0.01, 0.0]",
)
CASES = {  # scene, a factor on the steps, overrides
    "psi 0": ("testbench_psi0", 1, ()),
    "psi 30": ("testbench_psi30", 1, ()),
    "driven and pushed by tables with jumps": ("testbench_psi30", 1, DRIVEN),
    "kinks of the saturated law": ("testbench_psi0", 1, ("friction.law=saturated",)),
    "viscous": ("testbench_psi30", 2, ("friction.law=viscous", "friction.viscosity=30.0")),
    "implicit tracking": ("testbench_psi30", 1, ("solver.tracking=implicit",)),
}


def run(case, *overrides):
    name, _, fixed = CASES[case]
    span = ("time.end=1.0", "time.output_interval=1.0")
    trajectory = omnisim.simulate(reference_scene(name, *span, *fixed, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", TABLEAUX)
def test_a_method_converges_at_its_order(method, case):
    steps = [CASES[case][1] * step for step in STEPS[method]]
    finest = run(case, "solver.method=dopri5", f"time.step={steps[-1] / 8}")
    assert len(finest["events/time"]) >= 3, "there is something to cross"
    errors = []
    for step in steps:
        trajectory = run(case, f"solver.method={method}", f"time.step={step}")
        errors.append(np.abs(final_state(trajectory) - final_state(finest)).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    # measured: heun 1.99 to 2.05, rk4 3.95 to 4.25, dopri5 4.85 (viscous, near the rounding floor) to 7.6, bs5 from 6.3
    assert orders.min() >= TABLEAUX[method].order - 0.2, (errors, orders)
    assert errors[-1] > 1e-13, "at the rounding floor an order means nothing"
