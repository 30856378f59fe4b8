"""Friction in the rollers' bearings: closed forms of a roller that runs down, energy, and what it costs."""

import numpy as np
import pytest
from scenes import packed, reference_scene

import omnisim
from omnisim.march.stiffness import explanation

STILL = (
    "friction.law=none", "initial.velocity=[0, 0]", "initial.yaw_rate=0", "wheels.wheel.spin_rate=0",
    "wheels.wheel.roller_rates=3.0", "time.end=1.0", "time.output_interval=0.05", "time.step=1e-3",
)  # fmt: skip
ROLLER = "wheel_types.omni.roller"
INERTIA = reference_scene("testbench_psi0").config.wheel_types["omni"].roller.inertia_axial


def run(*overrides):
    """The rollers of the wheel at rest turn at 3 rad/s; psi = 0, so their axes lie in the wheel plane."""
    trajectory = omnisim.simulate(reference_scene("testbench_psi0", *STILL, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


@pytest.mark.parametrize(("method", "bound"), [("rk4", 1e-9), ("radau5", 1e-12)])
def test_viscous_bearings_stop_rollers_exponentially(method, bound):
    trajectory = run(f"{ROLLER}.bearing_viscosity=1e-4", f"solver.method={method}")
    expected = 3.0 * np.exp(-1e-4 / INERTIA * trajectory.time)
    error = np.abs(trajectory["wheels/wheel/rollers/axial_rate"] - expected[:, None]).max()
    assert error < bound  # measured 7.1e-10 and 1.9e-13
    assert np.abs(trajectory["energy/balance"]).max() < 1e-12  # measured 2.6e-13 of 1.6e-4 J


def test_a_coulomb_torque_stops_rollers_linearly_down_to_its_rate_of_reversal():
    """Ia p' = -T p / sqrt(p^2 + e^2) has sqrt(p^2 + e^2) - e asinh(e / p) = its start - T t / Ia."""
    torque, width = 3e-5, 0.1
    trajectory = run(f"{ROLLER}.bearing_torque={torque}", f"{ROLLER}.bearing_rate={width}", "solver.method=radau5")
    rate = trajectory["wheels/wheel/rollers/axial_rate"][:, 0]

    def left(p):
        return np.sqrt(p * p + width * width) - width * np.arcsinh(width / p)

    running = rate > 1e-3
    assert running.sum() > 10 and rate[-1] < 1e-3
    error = np.abs(left(rate) - left(3.0) + torque / INERTIA * trajectory.time)[running]
    assert error.max() < 1e-10  # measured 3.3e-12


def test_bearings_turn_motion_into_heat_and_nothing_else():
    """A skew wheel, driven and sliding: balance of energy, and the loss in the bearings only grows."""
    trajectory = omnisim.simulate(reference_scene(
        "testbench_psi30", f"{ROLLER}.bearing_viscosity=2e-5", f"{ROLLER}.bearing_torque=1e-4",
        "wheels.wheel.drive={kind='torque', torque=0.05}", "time.end=2.0", "time.step=2e-4",
    ))  # fmt: skip
    assert trajectory.complete
    loss = trajectory["energy/bearing_loss"]
    assert np.diff(loss).min() > 0.0 and loss[-1] > 1e-3
    assert np.abs(trajectory["energy/balance"]).max() < 1e-8 * trajectory["energy/kinetic"][0]  # measured 1.8e-9


def test_with_vanishing_bearing_friction_the_motion_is_that_without():
    spans = ("time.end=1.0", "time.step=2e-4", "time.output_interval=0.1")
    free = omnisim.simulate(reference_scene("testbench_psi30", *spans))
    held = omnisim.simulate(reference_scene("testbench_psi30", *spans, f"{ROLLER}.bearing_viscosity=1e-16"))
    for path in ("body/position", "body/yaw", "wheels/wheel/rollers/axial_rate", "wheels/wheel/servo_torque"):
        assert np.abs(free[path] - held[path]).max() < 1e-10, path  # measured up to 7.6e-12


@pytest.mark.short
def test_only_bearing_friction_brings_the_rollers_in_the_air_into_the_state():
    plain, bearing = (
        len(packed(reference_scene("testbench_psi30", "wheel_types.omni.roller_count=40", *extra))[1].y)
        for extra in ((), (f"{ROLLER}.bearing_torque=1e-5",))
    )
    assert (plain, bearing) == (13, 13 - 2 + 40 + 1)


@pytest.mark.short
def test_bearings_too_stiff_for_an_explicit_method_are_refused_at_the_start_with_the_step_that_would_do():
    scene = reference_scene("testbench_psi0", *STILL, f"{ROLLER}.bearing_torque=1e-2", f"{ROLLER}.bearing_rate=1e-4")
    trajectory = omnisim.simulate(scene)
    assert len(trajectory.time) == 1 and "time.step < 8.4e-08 s" in trajectory.attributes["status"]
    assert trajectory.attributes["stop_time"] == 0.0 and list(trajectory["events/kind"]) == ["stop"]
    assert "bearings stop rollers at up to 1.7e+07 1/s" in explanation(scene.config, packed(scene)[0])
