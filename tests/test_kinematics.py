"""Stage 2: slip velocity and inverse mass, against rigid-body velocities built vector by vector."""

import numpy as np
import pytest
from scenes import packed, reference_scene

from omnisim.contact.kinematics import inverse_mass, joint_rate, slip_velocity
from omnisim.contact.tracking import explicit_contact, roller_axis

pytestmark = pytest.mark.short

UP = np.array([0.0, 0.0, 1.0])
H, K = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])


def case(psi, q):
    parameters, _ = packed(reference_scene("testbench_psi30", f"wheel_types.omni.roller_angle_deg={psi!r}"))
    wheel = parameters.wheels[0]
    cos_q, sin_q = np.cos(q), np.sin(q)
    return parameters.machine, wheel, roller_axis(wheel, cos_q, sin_q), explicit_contact(wheel, cos_q, sin_q)


def slip_by_vectors(wheel, q, velocity, spin_rate, yaw_rate, roller_rate):
    """Velocity of the roller's material point at the contact, from O to O_B to P."""
    d = -np.cos(q) * UP + np.sin(q) * H
    axis = wheel.cos_psi * np.cross(K, d) + wheel.sin_psi * K
    w = spin_rate * K + yaw_rate * UP
    l = wheel.roller_distance * np.tan(q) * wheel.tan_psi
    lever = -wheel.radius * UP + l * K - wheel.roller_distance * d  # P - O_B
    w_roller = w + (roller_rate - w @ axis) * axis
    return velocity + np.cross(w, wheel.roller_distance * d) + np.cross(w_roller, lever)


@pytest.mark.parametrize("psi", [0.0, 30.0, -45.0, 80.0])
def test_the_slip_velocity_is_that_of_the_material_point_and_horizontal(psi):
    rng = np.random.default_rng(3)
    for _ in range(20):
        v_h, v_k, spin_rate, yaw_rate, roller_rate = rng.normal(size=5)
        q = rng.uniform(-np.pi / 4, np.pi / 4)
        _, wheel, axis, contact = case(psi, q)
        joint = joint_rate(axis, roller_rate, spin_rate, yaw_rate)
        slip = slip_velocity(wheel, contact, v_h, v_k, spin_rate, yaw_rate, joint)
        expected = slip_by_vectors(wheel, q, v_h * H + v_k * K, spin_rate, yaw_rate, roller_rate)
        np.testing.assert_allclose([*slip, 0.0], expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("psi", [0.0, 30.0, -45.0])
def test_the_inverse_mass_is_the_slip_acceleration_of_a_unit_force(psi):
    """The Jacobian by differences of the vector formula, the mass matrix written out here once more."""
    for q in (-0.7, -0.2, 0.0, 0.5):
        machine, wheel, axis, contact = case(psi, q)
        speeds = np.eye(5)
        columns = [slip_by_vectors(wheel, q, a * H + b * K, c, d, e)[:2] for a, b, c, d, e in speeds]
        jacobian = np.column_stack(columns)
        inertia = [machine.mass, machine.mass, wheel.axle_inertia, machine.yaw_inertia, wheel.axial_inertia]
        expected = jacobian @ np.diag(1.0 / np.array(inertia)) @ jacobian.T
        hh, hk, kk = inverse_mass(machine, wheel, axis, contact)
        np.testing.assert_allclose([[hh, hk], [hk, kk]], expected, rtol=1e-12, atol=1e-13)
        assert hh + kk <= machine.slip_mobility  # the bound that the march uses first
