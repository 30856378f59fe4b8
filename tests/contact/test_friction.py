"""Stage 3: the friction laws, against their closed forms."""

import numpy as np
import pytest
from scenes import packed, reference_scene

from omnisim.contact.frame import Slip
from omnisim.contact.friction import friction_factor

pytestmark = pytest.mark.short

NORMAL = 7.0
SLIPS = [(0.3, -0.4), (1e-3, 0.0), (0.0, -2e-2), (0.0, 0.0)]


def law(name, **keys):
    overrides = [f"friction.law={name}", *(f"friction.{key}={value!r}" for key, value in keys.items())]
    return packed(reference_scene("testbench_psi0", *overrides))[0].machine


def force(machine, v, saturated=0):
    return -friction_factor(machine, saturated, NORMAL, Slip(*v)) * np.array(v)


@pytest.mark.parametrize("v", SLIPS)
def test_regularized_friction_is_smooth_and_bounded_by_the_cone(v):
    machine = law("regularized", coefficient=0.4, slip_speed=0.05)
    expected = -0.4 * NORMAL * np.array(v) / np.sqrt(np.dot(v, v) + 0.05**2)
    np.testing.assert_allclose(force(machine, v), expected, rtol=1e-15, atol=0)
    assert np.linalg.norm(force(machine, v)) <= 0.4 * NORMAL


@pytest.mark.parametrize("v", SLIPS)
def test_saturated_friction_is_linear_inside_the_slip_speed_and_on_the_cone_outside(v):
    machine = law("saturated", coefficient=0.4, slip_speed=0.05)
    speed = np.linalg.norm(v)
    expected = -0.4 * NORMAL * np.array(v) / max(speed, 0.05)
    np.testing.assert_allclose(force(machine, v, saturated=int(speed > 0.05)), expected, rtol=1e-15, atol=0)


def test_both_branches_of_the_saturated_law_meet_at_the_slip_speed():
    machine, v = law("saturated", coefficient=0.4, slip_speed=0.05), (0.03, -0.04)
    np.testing.assert_allclose(force(machine, v, 0), force(machine, v, 1), rtol=1e-14)


def test_the_sliding_branch_stays_finite_at_zero_slip():
    machine = law("saturated", coefficient=0.4, slip_speed=0.05)
    assert np.all(force(machine, (0.0, 0.0), saturated=1) == 0.0)


@pytest.mark.parametrize("v", SLIPS)
def test_viscous_friction_ignores_the_normal_force(v):
    machine = law("viscous", viscosity=2.5)
    np.testing.assert_allclose(force(machine, v), -2.5 * np.array(v), rtol=1e-15, atol=0)


@pytest.mark.parametrize("v", SLIPS)
def test_without_friction_there_is_no_force(v):
    assert np.all(force(law("none"), v) == 0.0)
