"""The reduced equations against the oracle: disk and every roller as free bodies held together by multipliers."""

import tomllib

import numpy as np
import pytest
from scenes import REFERENCE

import omnisim
from omnisim.scene import load
from oracle.multibody import simulate as multibody

BASE = REFERENCE / "testbench_psi30.toml"
MOVING = (
    "initial.yaw_rate=1.1", "initial.yaw_deg=20.0", "wheels.wheel.spin_angle_deg=12.0",
    "wheels.wheel.roller_rates=[3.0, -2.0, 5.0, 1.0]", "time.output_interval=0.05", "time.step=1e-5",
)  # fmt: skip
PUSHED = (
    "wheels.wheel.drive={kind='torque', times=[0.0, 0.25, 0.25, 0.5], torque=[0.2, 0.6, -0.4, 0.1]}",
    "wrench.frame='body'", "wrench.times=[0.0, 0.31, 0.31]",
    "wrench.force=[[0.5, -1.0, 2.0], [1.0, 0.5, -4.0], [0.0, 0.7, 3.0]]", "wrench.yaw_torque=[0.02, -0.01, 0.03]",
)  # fmt: skip
CASES = {
    f"psi {psi:g}": (f"wheel_types.omni.roller_angle_deg={psi!r}", "time.end=0.5") for psi in (0.0, 30.0, 45.0, -45.0)
}
CASES["mirrored, phase, driven and pushed"] = (
    "wheels.wheel.mirrored=true",
    "wheels.wheel.phase_deg=25.0",
    "time.end=0.5",
    *PUSHED,
)
CASES["saturated"] = ("friction.law=saturated", "time.end=0.25")
CASES["viscous"] = ("friction.law=viscous", "friction.viscosity=5.0", "time.end=0.5")
CASES["no friction"] = ("friction.law=none", "time.end=0.5")
# all that moves and all that pushes, in SI units; measured: motion 9e-13, forces 9e-12, accelerations 6e-11
BOUND = 1e-9
QUANTITIES = (
    "position", "yaw", "spin_angle", "velocity", "yaw_rate", "spin_rate", "roller_axial_rate", "exchange_times",
    "normal_force", "friction_force", "servo_torque", "acceleration", "yaw_acceleration", "spin_acceleration",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_the_engine_moves_as_the_free_bodies_do(case):
    scene = load(BASE, (*MOVING, *CASES[case]))
    run = omnisim.simulate(scene)
    assert run.complete, run.attributes["status"]
    oracle = multibody(tomllib.loads(scene.text), run.time)
    wheel = {name: run[f"wheels/wheel/{name}"] for name in ("spin_angle", "spin_rate", "spin_acceleration")}
    ours = wheel | {
        "position": run["body/position"][:, :2],
        "velocity": run["body/velocity"][:, :2],
        "acceleration": run["body/acceleration"][:, :2],
        "yaw": run["body/yaw"],
        "yaw_rate": run["body/yaw_rate"],
        "yaw_acceleration": run["body/yaw_acceleration"],
        "normal_force": run["wheels/wheel/normal_force"],
        "servo_torque": run["wheels/wheel/servo_torque"],
        "friction_force": run["wheels/wheel/friction_force"],
        "roller_axial_rate": run["wheels/wheel/rollers/axial_rate"],
        "exchange_times": run["events/time"],
    }
    assert len(oracle["exchange_times"]) == len(ours["exchange_times"]) >= 1
    assert np.array_equal(oracle["contact_roller"], run["wheels/wheel/contact_roller"])
    worst = {name: np.abs(np.asarray(oracle[name]) - ours[name]).max() for name in QUANTITIES}
    assert max(worst.values()) < BOUND, worst
