"""The frame of a contact and the twists in it, against vectors in space."""

import math

import numpy as np
import pytest
from scenes import wheel_record

from omnisim.base.vector import Vec2
from omnisim.contact.frame import (
    Axis,
    Frame,
    WheelTwist,
    axes,
    axis_vector,
    frame_by,
    outward,
    rate_along,
    rate_change,
    rate_vector,
    spoke,
    tangential,
    turn_of,
    turning_velocity,
)
from omnisim.dynamics.twist import Acceleration, Twist, wheel_motion, wheel_twist

pytestmark = pytest.mark.short
RANDOM = np.random.default_rng(4).normal(size=(10, 12))


def frame(angle):
    return Frame(math.cos(angle), math.sin(angle))


def mounted(angle, offset):
    """The record of a wheel there on the machine."""
    wheel = wheel_record()
    wheel.cos_heading, wheel.sin_heading, wheel.offset = math.cos(angle), math.sin(angle), offset
    return wheel


@pytest.mark.parametrize("numbers", RANDOM)
def test_axes_of_a_frame_are_orthonormal_and_components_along_them_are_products_with_them(numbers):
    turned = frame(numbers[0])
    h, k, n = np.array(axes(turned))
    np.testing.assert_allclose(np.cross(h, k), n, atol=1e-15)
    along = tangential(turned, Vec2(*numbers[1:3]))
    np.testing.assert_allclose(along, [h[:2] @ numbers[1:3], k[:2] @ numbers[1:3]], atol=1e-15)
    np.testing.assert_allclose(outward(turned, along), numbers[1:3], atol=1e-15)
    np.testing.assert_allclose(
        axis_vector(turned, Axis(*numbers[3:6])), numbers[3] * h + numbers[4] * k + numbers[5] * n
    )
    np.testing.assert_allclose(spoke(turned, 0.6, 0.8), 0.8 * h - 0.6 * n)
    assert math.remainder(turn_of(turned) - numbers[0], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("numbers", RANDOM)
def test_frames_follow_one_another(numbers):
    np.testing.assert_allclose(
        frame_by(frame(numbers[0]), frame(numbers[1])), frame(numbers[0] + numbers[1]), atol=1e-15
    )


@pytest.mark.parametrize("numbers", RANDOM)
def test_points_of_a_wheel_have_the_velocities_of_a_rigid_body(numbers):
    wheel, turned, twist, l = wheel_record(psi_deg=30.0), frame(numbers[0]), WheelTwist(*numbers[1:5]), numbers[5]
    h, k, n = np.array(axes(turned))
    rate = np.array(rate_vector(turned, twist))
    np.testing.assert_allclose(rate, twist.spin * k + twist.yaw * n)
    velocity = np.cross(rate, l * k - wheel.radius * n)
    np.testing.assert_allclose(turning_velocity(wheel, twist, l), [velocity @ h, velocity @ k], atol=1e-15)
    axis = Axis(*numbers[6:9])
    assert rate_along(twist, axis) == pytest.approx(rate @ np.array(axis_vector(turned, axis)), abs=1e-14)


@pytest.mark.parametrize("numbers", RANDOM)
def test_a_wheel_moves_with_its_machine(numbers):
    """Velocity v + w x e and acceleration a + w' x e + w x (w x e) of its centre; its rate turns with k, k' = w x k."""
    heading, offset = numbers[0], numbers[1:3]
    twist, change, spin_rate, spin = Twist(*numbers[3:6]), Acceleration(*numbers[6:9]), numbers[9], numbers[10]
    h, k, n = np.array(axes(frame(heading)))
    e, w = offset[0] * h + offset[1] * k, twist.yaw * n
    velocity = np.array([twist.x, twist.y, 0.0]) + np.cross(w, e)
    acceleration = np.array([change.x, change.y, 0.0]) + np.cross(change.yaw * n, e) + np.cross(w, np.cross(w, e))
    found = wheel_twist(mounted(heading, offset), twist, spin_rate)
    moved = wheel_motion(mounted(heading, offset), twist, change, spin, 0.0)
    np.testing.assert_allclose(found, [velocity @ h, velocity @ k, spin_rate, twist.yaw], atol=1e-14)
    np.testing.assert_allclose(moved, [acceleration @ h, acceleration @ k, spin, change.yaw, 0.0], atol=1e-14)
    expected = spin * k + spin_rate * np.cross(w, k) + change.yaw * n
    np.testing.assert_allclose(rate_change(frame(heading), found, moved), expected, atol=1e-14)
