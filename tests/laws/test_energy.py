"""Conservation laws: energy, momentum, and the symmetry of a mirror."""

import numpy as np
import pytest
from scenes import REFERENCE_CASES, simulate

FREE = ("friction.law=none", "time.step=1e-4")


@pytest.mark.parametrize("name", REFERENCE_CASES)
def test_energy_is_conserved_without_friction_drive_and_wrench(name):
    kinetic = simulate(name, *FREE)["energy/kinetic"]
    assert np.abs(kinetic / kinetic[0] - 1.0).max() < 1e-12  # measured 1.2e-14, 1.8e-14


@pytest.mark.parametrize("name", REFERENCE_CASES)
def test_without_friction_the_wheel_moves_straight_on_and_its_rollers_keep_their_rates(name):
    run = simulate(name, *FREE)
    velocity, rates = run["body/velocity"], run["wheels/wheel/rollers/axial_rate"]
    assert np.all(velocity == velocity[0])
    assert np.all(rates == rates[0])


def test_the_works_account_for_all_energy_of_a_driven_and_pushed_wheel():
    run = simulate(
        "testbench_psi30",
        "time.step=2e-5",
        "time.end=2.0",
        "wheels.wheel.drive={kind='torque', times=[0.0, 1.0], torque=[0.5, -0.4]}",
        "wrench.times=[0.0, 2.0]",
        "wrench.force=[[0.3, -0.2, 2.0], [-0.5, 0.4, -3.0]]",
        "wrench.yaw_torque=[0.02, -0.03]",
    )
    works = np.abs(run["energy/drive_work"]) + np.abs(run["energy/wrench_work"])
    assert works.max() > 0.5  # there is work to account for
    assert np.abs(run["energy/balance"]).max() < 1e-9  # J; measured 9.6e-13


@pytest.mark.parametrize("name", REFERENCE_CASES)
@pytest.mark.parametrize("law", ["regularized", "saturated", "viscous"])
def test_friction_never_does_positive_work(name, law):
    loss = simulate(name, f"friction.law={law}", "friction.viscosity=3.0", "time.step=2e-4")["energy/friction_loss"]
    assert np.all(np.diff(loss) >= 0.0)
    assert loss[-1] > 0.0


def test_a_constant_push_without_friction_gives_the_parabola():
    run = simulate("testbench_psi0", *FREE, "time.step=1e-3", "wrench.times=[0.0]", "wrench.force=[[0.2, -0.1, 0.0]]")
    mass, t = 0.5 + 6 * 0.03, run.time[:, None]
    expected = np.array([0.5, 0.3]) * t + 0.5 * np.array([0.2, -0.1]) / mass * t**2
    assert np.abs(run["body/position"][:, :2] - expected).max() < 1e-13  # measured 9.1e-14


def test_a_torque_ramp_without_friction_gives_the_cubic_spin():
    """psi = 0 and no yaw: the rollers' axes stay in the wheel plane and the wheel is a flywheel of inertia J_k."""
    run = simulate(
        "testbench_psi0", *FREE, "initial.yaw_rate=0.0", "wheels.wheel.roller_rates=0.0",
        "wheels.wheel.drive={kind='torque', times=[0.0, 2.0], torque=[0.0, 0.04]}",
    )  # fmt: skip
    inertia = 4e-4 + 6 * (0.03 * 0.04**2 + 9e-6)
    t = run.time
    expected = np.radians(5.729577951308233) + 12.0 * t + 0.02 / inertia * t**3 / 6.0
    assert np.abs(run["wheels/wheel/spin_angle"] - expected).max() < 1e-11  # measured 3.0e-13


def test_the_mirrored_scene_gives_the_mirrored_motion():
    """Mirror at the x z plane: y, yaw and psi change sign, spin and x do not."""
    plain = simulate("testbench_psi30", "time.end=2.0", "initial.velocity=[0.6, 0.15]", "initial.yaw_rate=0.5")
    mirror = simulate(
        "testbench_psi30", "time.end=2.0", "initial.velocity=[0.6, -0.15]", "initial.yaw_rate=-0.5",
        "wheels.wheel.mirrored=true",
    )  # fmt: skip
    flip = np.array([1.0, -1.0, 1.0])
    assert np.abs(plain["body/position"] - flip * mirror["body/position"]).max() < 1e-14  # measured 0, all three
    assert np.abs(plain["body/yaw"] + mirror["body/yaw"]).max() < 1e-14
    assert np.abs(plain["wheels/wheel/spin_angle"] - mirror["wheels/wheel/spin_angle"]).max() < 1e-14


def test_the_world_rotated_gives_the_motion_rotated():
    plain = simulate("testbench_psi30", "time.end=2.0")
    angle = 1.234
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    velocity = (turn @ [0.6, 0.15]).tolist()
    turned = simulate(
        "testbench_psi30", "time.end=2.0", f"initial.velocity={velocity}", f"initial.yaw_deg={float(np.degrees(angle))}"
    )
    assert (
        np.abs(turned["body/position"][:, :2] - plain["body/position"][:, :2] @ turn.T).max() < 1e-12
    )  # measured 5.4e-15
    assert np.abs(turned["body/yaw"] - plain["body/yaw"] - angle).max() < 1e-12
