"""Stage 2: slip velocity and inverse mass, against rigid-body velocities built vector by vector."""

import numpy as np
import pytest
from scenes import packed, reference_scene, standing

from omnisim.contact.frame import Motion, WheelTwist
from omnisim.contact.kinematics import joint_rate, slip_acceleration, slip_velocity
from omnisim.contact.mobility import inverse_mass
from omnisim.contact.tracking import explicit_contact, roller_axis
from omnisim.dynamics.state import places_in
from omnisim.dynamics.twist import body_motion
from omnisim.dynamics.wheel import contact_state, external_wrench

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
        twist = WheelTwist(v_h, v_k, spin_rate, yaw_rate)
        slip = slip_velocity(wheel, contact, twist, joint_rate(axis, roller_rate, twist))
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


@pytest.mark.parametrize("psi", [0.0, 30.0, -45.0, 80.0])
def test_the_slip_acceleration_is_a_f_plus_b(psi):
    """A and b against differences of the slip velocity along the motion that the right-hand side gives."""
    rng = np.random.default_rng(5)
    for _ in range(10):
        vx, vy, yaw_rate, spin_rate, yaw = rng.normal(size=5).round(6)
        scene = reference_scene(
            "testbench_psi30", f"wheel_types.omni.roller_angle_deg={psi!r}", f"initial.velocity=[{vx}, {vy}]",
            f"initial.yaw_rate={yaw_rate}", f"initial.yaw_deg={100 * yaw}", f"wheels.wheel.spin_rate={5 * spin_rate}",
            f"wheels.wheel.spin_angle_deg={rng.uniform(-44, 44)}", "wheels.wheel.roller_rates=[3.0, -2.0, 5.0, 1.0]",
            "wheels.wheel.drive={kind='torque', torque=0.7}", "wrench.times=[0.0]", "wrench.force=[[0.4, -0.3, 2.0]]",
            "wrench.yaw_torque=[0.06]", "friction.slip_speed=0.5",
        )  # fmt: skip
        parameters, run = standing(scene)

        def state_at(y, parameters=parameters, run=run):
            return contact_state(parameters, run.mode[0], 0, 0, body_motion(parameters, y), y)

        step, slope = 1e-5, run.slopes[0]
        ahead, back = (np.array(state_at(run.y + h * slope).slip) for h in (step, -step))
        wrench, state = external_wrench(parameters, 0, 0.0, body_motion(parameters, run.y)), state_at(run.y)
        wheel, machine = parameters.wheels[0], parameters.machine
        gyroscopic = wheel.axial_inertia * rollers_along_h(parameters, run)
        free = Motion(
            wrench.x / machine.mass, wrench.y / machine.mass,
            (0.7 - state.twist.yaw * gyroscopic) / wheel.axle_inertia,
            (wrench.yaw + state.twist.spin * gyroscopic) / machine.yaw_inertia, 0.0,
        )  # fmt: skip
        b = slip_acceleration(wheel, state, free)
        hh, hk, kk = inverse_mass(parameters.machine, wheel, state.axis, state.contact)
        force = -run.monitors[0].factor[0] * np.array(state.slip)
        expected = np.array([[hh, hk], [hk, kk]]) @ force + np.array(b)
        scale = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose((ahead - back) / (2 * step), expected, rtol=0, atol=1e-7 * scale)


def rollers_along_h(parameters, run):
    """sum p_i (a_i . h), roller by roller."""
    wheel, at = parameters.wheels[0], places_in(parameters)
    rates = run.rates[0].copy()
    rates[run.mode[0].roller % 4] = run.y[at.roller_rate]
    q = wheel.phase + 2 * wheel.alpha * np.arange(4) - run.y[at.spin_angle]
    return -wheel.cos_psi * np.sum(rates * np.cos(q))
