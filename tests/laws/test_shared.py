"""A wheel that comes to rest on two rollers, under every law: it stays there, whatever the step and the method."""

import math

import numpy as np
import pytest
from scenes import final_state, reference_scene

import omnisim

# Coasting, with a yaw rate that brings the wheel to rest on the edge of two rollers.
COASTING = ("initial.yaw_rate=6.0", "initial.velocity=[0.3, 0.2]", "wheels.wheel.spin_rate=-1.0",
            "time.end=4.0", "time.output_interval=0.05", "solver.method=radau5")  # fmt: skip
LAWS = {
    "coulomb": ("friction.law=coulomb",),
    "saturated": ("friction.law=saturated", "friction.slip_speed=1e-2"),
    "regularized": ("friction.law=regularized", "friction.slip_speed=1e-4"),
    "viscous": ("friction.law=viscous", "friction.viscosity=300", "time.end=14.0"),
}


def run(*overrides):
    trajectory = omnisim.simulate(reference_scene("testbench_psi30", *COASTING, *overrides))
    assert trajectory.complete, trajectory.attributes["status"]
    return trajectory


@pytest.mark.parametrize("law", LAWS)
def test_a_coasting_wheel_comes_to_rest_on_two_rollers(law):
    trajectory = run(*LAWS[law], "time.step=5e-4")
    begin = trajectory["events/time"][trajectory["events/kind"] == "share_begin"][-1]
    resting = trajectory.time > begin
    share = trajectory["wheels/wheel/contact_share"]
    assert resting.sum() > 10 and np.all(share[trajectory.time < begin - 0.1] == 1.0)
    assert np.all((share[resting] >= 0.0) & (share[resting] < 1.0))
    assert np.all(trajectory["wheels/wheel/spin_rate"][resting] == 0.0)
    assert np.all(trajectory["wheels/wheel/spin_acceleration"][resting] == 0.0)
    assert np.ptp(trajectory["wheels/wheel/spin_angle"][resting]) == 0.0
    assert np.abs(trajectory["wheels/wheel/contact_angle"][resting] - math.pi / 4).max() < 1e-12  # the one at +alpha
    assert (
        np.abs(trajectory["wheels/wheel/contact_angle"]).max() < math.pi / 4 + 1e-12
    )  # no roller carries beyond its end
    assert np.abs(trajectory["energy/balance"]).max() < 1e-9 * trajectory["energy/kinetic"][0]  # measured up to 3e-10
    finer = run(*LAWS[law], "time.step=1e-4")
    assert np.abs(final_state(trajectory) - final_state(finer)).max() < 1e-7  # measured 2.6e-9, 1.1e-9, 3.6e-9, 2.0e-8
    assert np.abs(share - finer["wheels/wheel/contact_share"])[trajectory.time > begin + 0.1].max() < 1e-7


def test_the_share_under_coulomb_friction_is_the_limit_of_regularized_ones():
    end = ("time.end=2.5", "time.step=5e-4")
    coulomb = run(*LAWS["coulomb"], *end)["wheels/wheel/contact_share"][-1]
    errors = []
    for speed in (1e-3, 1e-4, 1e-5):
        law = ("friction.law=regularized", f"friction.slip_speed={speed}")
        errors.append(abs(run(*law, *end)["wheels/wheel/contact_share"][-1] - coulomb))
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.all((ratios > 5.0) & (ratios < 20.0)), errors  # first order in the slip speed


def test_a_wheel_on_an_edge_at_the_start_rests_on_both_if_both_push_back():
    """A yaw torque twists the wheel that stands on two skew rollers: each would roll it onto the other."""
    trajectory = omnisim.simulate(reference_scene(
        "testbench_psi30", "friction.law=coulomb", "initial.velocity=[0, 0]", "initial.yaw_rate=0",
        "wheels.wheel.spin_rate=0", "wheels.wheel.roller_rates=0", "wheels.wheel.phase_deg=0",
        "wheels.wheel.spin_angle_deg=45", "wrench.times=[0.0]", "wrench.yaw_torque=[0.3]", "time.end=0.2",
        "time.step=1e-3", "time.output_interval=0.01",
    ))  # fmt: skip
    assert trajectory.complete, trajectory.attributes["status"]
    first = {name: trajectory[f"events/{name}"][0] for name in ("time", "kind")}
    assert first == {"time": 0.0, "kind": "share_begin"}
    share = trajectory["wheels/wheel/contact_share"]
    assert np.abs(share - 0.5).max() < 1e-9, "the scene is symmetric"
    assert not trajectory["wheels/wheel/spin_rate"].any()


def test_a_long_rest_costs_nothing_but_time():
    """The reference wheel continued to a minute: rolling, rocking, at rest, in one run."""
    trajectory = omnisim.simulate(reference_scene("testbench_psi30", "time.end=60.0", "time.step=2e-4"))
    assert trajectory.complete, trajectory.attributes["status"]
    kinds = list(trajectory["events/kind"])
    assert kinds.count("share_begin") >= 1 and kinds.count("exchange") < 2000
    assert np.abs(trajectory["energy/balance"]).max() < 1e-8 * trajectory["energy/kinetic"][0]
