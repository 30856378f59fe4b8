"""Contensou's law on a wheel: spinning on the spot in closed form, sliding eased by spinning, energy."""

import math

import numpy as np
import pytest
from scenes import packed, reference_scene

import omnisim

PATCH = 0.004
LAW = ("friction.contact_torque=contensou", f"friction.patch_radius={PATCH}", "friction.slip_speed=1e-6",
       "solver.method=radau5")  # fmt: skip
SPOT = ("initial.velocity=[0, 0]", "wheels.wheel.spin_rate=0", "wheels.wheel.roller_rates=0",
        "wheels.wheel.phase_deg=0", "wheels.wheel.spin_angle_deg=0", "initial.yaw_rate=5.0")  # fmt: skip


def run(name, *overrides):
    trajectory = omnisim.simulate(reference_scene(name, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


def test_a_wheel_that_spins_on_the_spot_is_braked_by_3_pi_16_mu_n_a():
    """I_z theta'' = -3 pi / 16 mu N a until it stands, less (eps / a theta')^2 of it for the slip speed eps."""
    machine = packed(reference_scene("testbench_psi0"))[0].machine
    torque = 3.0 * math.pi / 16.0 * machine.friction * machine.mass * machine.gravity * PATCH
    stop = 5.0 * machine.yaw_inertia / torque
    trajectory = run("testbench_psi0", *SPOT, *LAW, "time.step=1e-3", "time.end=0.5", "time.output_interval=0.05")
    before = trajectory.time < stop
    expected = 5.0 - torque / machine.yaw_inertia * trajectory.time[before]
    expected += (1e-6 / PATCH) ** 2 * (1.0 / expected - 1.0 / 5.0)
    rate = trajectory["body/yaw_rate"]
    assert np.abs(rate[before] - expected).max() < 1e-10  # measured 5.4e-13
    assert stop < 0.4 and abs(rate[-1]) < 1e-12
    assert trajectory["wheels/wheel/contact_torque"][0] == pytest.approx(-torque, rel=1e-8)
    assert np.abs(trajectory["energy/balance"]).max() < 1e-9 * trajectory["energy/kinetic"][0]  # measured 2.3e-11


def test_without_the_law_nothing_brakes_it():
    trajectory = run("testbench_psi0", *SPOT, "time.step=1e-3", "time.end=0.5", "time.output_interval=0.05")
    assert np.abs(trajectory["body/yaw_rate"] - 5.0).max() < 1e-12
    assert not trajectory["wheels/wheel/contact_torque"].any()


def test_spinning_eases_sliding():
    """While it slides the friction force is mu N without a patch, and less with one, by Phi(v / a w)."""
    scene = ("time.step=1e-4", "time.end=0.05", "time.output_interval=0.01", "initial.yaw_rate=40.0")
    plain, patch = run("testbench_psi30", *scene), run("testbench_psi30", *scene, *LAW[:2])
    force = [np.hypot(*t["wheels/wheel/friction_force"][0]) for t in (plain, patch)]
    slip = np.hypot(*patch["wheels/wheel/slip_velocity"][0])
    assert force[1] < force[0]
    k = abs(patch["body/yaw_rate"][0]) * PATCH / slip  # the joint rate adds little to the yaw rate at a small angle
    assert force[1] / force[0] == pytest.approx(1.0 - k * k / 10.0, abs=0.05)


@pytest.mark.parametrize("method", ["rk4", "radau5"])
def test_sliding_and_spinning_lose_what_the_file_says(method):
    trajectory = run(
        "testbench_psi30", *LAW[:2], f"solver.method={method}", "initial.yaw_rate=20.0", "time.step=2e-4",
        "time.end=2.0",
    )  # fmt: skip
    assert np.diff(trajectory["energy/friction_loss"]).min() >= 0.0
    assert np.abs(trajectory["energy/balance"]).max() < 1e-9 * trajectory["energy/kinetic"][0]  # measured 8e-11, 2e-14


@pytest.mark.short
@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (("friction.law=coulomb", *LAW[:2]), "only 'regularized' has one"),
        (LAW[:1], "friction.patch_radius: missing; contact_torque = 'contensou' needs a finite number > 0"),
        (("friction.contact_torque=contensu",), "did you mean 'contensou'?"),
    ],
)
def test_what_cannot_have_a_contact_torque_says_so(overrides, words):
    with pytest.raises(omnisim.SceneError) as error:
        reference_scene("testbench_psi0", *overrides)
    assert words in str(error.value)
