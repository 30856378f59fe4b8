"""Stage 3: the friction laws, against their closed forms."""

import numpy as np
import pytest
from scenes import packed, reference_scene, standing

from omnisim.contact.frame import Slip
from omnisim.contact.friction import friction_factor
from omnisim.contact.kinematics import streaming
from omnisim.dynamics.state import places_in
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state

pytestmark = pytest.mark.short

NORMAL = 7.0
SLIPS = [(0.3, -0.4), (1e-3, 0.0), (0.0, -2e-2), (0.0, 0.0)]


def law(name, **keys):
    overrides = [f"friction.law={name}", *(f"friction.{key}={value!r}" for key, value in keys.items())]
    return packed(reference_scene("testbench_psi0", *overrides))[0].machine


def force(machine, v, saturated=0, stream=(0.0, 0.0)):
    return -friction_factor(machine, saturated, NORMAL, Slip(*v), Slip(*stream)) * np.array(v)


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


BRUSH = {"coefficient": 0.4, "creep_stiffness": 6.0, "slip_speed": 0.01}
CREEPS = [(1e-3, 0.0), (0.02, -0.03), (-0.05, 0.04), (0.3, -0.4)]  # at 0.7 m/s: all slide beyond 0.14 m/s


@pytest.mark.parametrize("v", CREEPS)
def test_a_brush_adheres_in_part_and_slides_beyond_a_slip_ratio_of_3_mu_by_its_stiffness(v):
    machine, stream = law("brush", **BRUSH), (0.6, -0.36)
    sigma = np.hypot(*v) / np.sqrt(0.6**2 + 0.36**2 + 0.01**2)
    theta = 6.0 * sigma / (3.0 * 0.4)
    part = 3.0 * theta - 3.0 * theta**2 + theta**3 if theta < 1.0 else 1.0
    expected = -0.4 * NORMAL * part * np.array(v) / np.hypot(*v)
    np.testing.assert_allclose(force(machine, v, stream=stream), expected, rtol=1e-14, atol=0)


def test_a_brush_is_linear_at_small_slip_and_has_no_force_at_none():
    machine, stream = law("brush", **BRUSH), (0.6, -0.36)
    slope = 6.0 * NORMAL / np.sqrt(0.6**2 + 0.36**2 + 0.01**2)
    np.testing.assert_allclose(force(machine, (1e-9, 0.0), stream=stream), [-slope * 1e-9, 0.0], rtol=1e-6, atol=0)
    assert np.all(force(machine, (0.0, 0.0), stream=stream) == 0.0)


def test_a_brush_at_rest_has_the_slip_speed_for_the_speed_with_which_it_rolls():
    machine = law("brush", **BRUSH)
    np.testing.assert_allclose(force(machine, (1e-9, 0.0)), [-6.0 * NORMAL * 1e-9 / 0.01, 0.0], rtol=1e-5, atol=0)
    np.testing.assert_allclose(force(machine, (0.0, 3e-3)), [0.0, -0.4 * NORMAL], rtol=1e-15, atol=0)


def test_a_brush_slides_without_a_kink_in_its_slope_or_its_curvature():
    """S = 1 - (1 - theta)^3 up to theta = 1: by differences of 1e-3 across it, third derivatives times those."""
    machine, full = law("brush", **BRUSH), 3.0 * 0.4 * 0.01 / 6.0

    def size(theta):
        return -force(machine, (theta * full, 0.0))[0] / (0.4 * NORMAL)

    d = 1e-3
    slope = (size(1.0 + d) - size(1.0 - d)) / (2.0 * d)
    curvature = (size(1.0 + d) - 2.0 * size(1.0) + size(1.0 - d)) / d**2
    assert abs(slope) < d**2 and abs(curvature) < 2.0 * d  # (d^3 / 2 d, d^3 / d^2); of 3 and 6 at small slip


def test_without_a_coefficient_a_brush_has_no_force():
    machine = law("brush", **BRUSH | {"coefficient": 0.0})
    assert np.all(force(machine, (0.1, 0.2)) == 0.0) and np.all(force(machine, (0.0, 0.0)) == 0.0)


@pytest.mark.parametrize("name", ["regularized", "viscous", "brush"])
def test_no_slip_relaxes_faster_than_its_factor_says(name):
    """g is the largest eigenvalue of -dF/dv; for brush with the contact point as fast over the floor, v_r = v_P - v."""
    keys = {"regularized": {"coefficient": 0.4, "slip_speed": 0.05}, "viscous": {"viscosity": 2.5}}
    stiffest = {"coefficient": 0.4, "creep_stiffness": 3 * 0.4, "slip_speed": 0.01}  # the least that is allowed
    rng, d, largest = np.random.default_rng(5), 1e-7, 0.0
    for own in [keys[name]] if name in keys else [BRUSH, stiffest]:
        machine = law(name, **own)
        for _ in range(300):
            point, v = rng.normal(size=2), rng.normal(size=2) * 10.0 ** rng.uniform(-3, 0)

            def there(v, machine=machine, point=point):
                return force(machine, v, stream=point - v)

            columns = [(there(v + step) - there(v - step)) / (2.0 * d) for step in d * np.eye(2)]
            rate = np.linalg.eigvals(-np.transpose(columns)).real.max()
            largest = max(largest, rate / friction_factor(machine, 0, NORMAL, Slip(*v), Slip(*(point - v))))
    assert largest < 1.0 + 1e-6  # differences


@pytest.mark.parametrize("tracking", ["explicit", "implicit"])
@pytest.mark.parametrize("name", ["testbench_psi30", "skew"])
def test_the_contact_runs_over_its_roller_as_fast_as_it_moves_less_the_slip(name, tracking):
    """The point O - R n + l k in the world, differenced along the motion, less the slip."""
    scene = reference_scene(name if name != "skew" else "../oracle/skew", f"solver.tracking={tracking}")
    parameters, run = standing(scene)
    at = places_in(parameters)

    def look(y, w):
        body = body_motion(parameters, y)
        wheel = parameters.wheels[w]
        state = contact_state(parameters, run.mode[w], w, 0, body, y)
        turned = np.arctan2(wheel.sin_heading, wheel.cos_heading) + y[2]
        axes = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
        return state, axes, y[:2] + axes @ (wheel.offset[0], wheel.offset[1] + state.contact.l)

    for w in range(len(parameters.wheels)):
        state, axes, _ = look(run.y, w)
        d = 1e-6
        before, after = (look(run.y + side * d * run.slopes[0], w)[2] for side in (-1.0, 1.0))
        expected = axes.T @ (after - before) / (2.0 * d) - state.slip
        assert np.abs(expected).max() > 0.1 and run.y[at.spin_rate + w] != 0.0
        np.testing.assert_allclose(streaming(parameters.wheels[w], state), expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize("v", SLIPS)
def test_without_friction_there_is_no_force(v):
    assert np.all(force(law("none"), v) == 0.0)
