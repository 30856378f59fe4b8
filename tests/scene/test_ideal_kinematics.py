"""Ideal wheels: their spin rates in a given motion, and back."""

import math

import numpy as np
import pytest
from vehicles import VEHICLE

from omnisim.scene.ideal_kinematics import inverse, rms_distance, undetermined, wheel_rows
from omnisim.scene.scene import parse

pytestmark = pytest.mark.short

OMNI = "roller_angle_deg = 0"


def machine(*pairs):
    text = VEHICLE
    for old, new in zip(pairs[::2], pairs[1::2], strict=True):
        text = text.replace(old, new)
    return parse(text).config


def test_a_mecanum_machine_turns_its_wheels_as_the_textbook_says():
    rows = wheel_rows(machine())  # fl, fr, rl, rr; R = 0.05 m, half base and half track 0.2 and 0.1 m
    assert rows @ (1.0, 0.0, 0.0) == pytest.approx([20.0, 20.0, 20.0, 20.0])
    assert rows @ (0.0, 1.0, 0.0) == pytest.approx([-20.0, 20.0, 20.0, -20.0])
    assert rows @ (0.0, 0.0, 1.0) == pytest.approx([-6.0, 6.0, -6.0, 6.0])


def test_an_omni_wheel_turns_with_the_speed_along_its_heading():
    rows = wheel_rows(machine("roller_angle_deg = 45.0", OMNI, 'name = "fl"', 'name = "fl", heading_deg = 90'))
    assert rows[0] == pytest.approx([0.0, 20.0, 4.0], abs=1e-13)
    assert rows[1] == pytest.approx([20.0, 0.0, 2.0])


def test_a_contact_point_slips_across_the_axis_of_its_roller_only():
    config = machine('name = "rl"', 'name = "rl", heading_deg = 25')
    wheel, kind = config.wheels[2], config.wheel_types["mecanum"]
    vx, vy, yaw_rate = twist = np.array([0.3, -0.7, 1.1])
    heading, psi = np.radians(wheel.heading_deg), -np.radians(kind.roller_angle_deg)
    h, k = np.array([np.cos(heading), np.sin(heading)]), np.array([-np.sin(heading), np.cos(heading)])
    axis = -np.cos(psi) * h + np.sin(psi) * k  # of the roller at the floor
    centre = np.array([vx - yaw_rate * wheel.position[1], vy + yaw_rate * wheel.position[0]])
    slip = centre - kind.radius * (wheel_rows(config)[2] @ twist) * h
    assert slip @ axis == pytest.approx(0.0, abs=1e-15)


def test_a_wheel_whose_rows_stand_beside_its_centre_stands_there():
    """As one whose centre is in the middle of its rows; rows that balance change nothing."""
    heading = 'name = "rl", heading_deg = 25'
    for offsets, aside in (((-0.01, 0.01), 0.0), ((0.01, 0.03), 0.02)):
        rows = "rows = [{{offset = {}}}, {{offset = {}, phase_deg = 30.0}}]".format(*offsets)
        config = machine("roller_count = 6", f"roller_count = 6\n{rows}", 'name = "rl"', heading)
        moved = [
            np.add(wheel.position, aside * np.array([-np.sin(turn), np.cos(turn)]))
            for wheel in config.wheels
            for turn in [np.radians(wheel.heading_deg)]
        ]
        own = machine('name = "rl"', heading)
        wheels = [w.model_copy(update={"position": tuple(p)}) for w, p in zip(own.wheels, moved, strict=True)]
        expected = wheel_rows(own.model_copy(update={"wheels": tuple(wheels)}))
        np.testing.assert_allclose(wheel_rows(config), expected, rtol=1e-14, atol=1e-15)


def test_the_inverse_gives_the_motion_back():
    config, twist = machine(), np.array([0.3, -0.7, 1.1])
    rows = wheel_rows(config)
    assert inverse(rows, rms_distance(config)) @ (rows @ twist) == pytest.approx(twist)
    assert inverse(rows, rms_distance(config)) == pytest.approx(np.linalg.pinv(rows), abs=1e-15)  # m


def test_what_spin_rates_leave_open_has_names():
    config = machine()
    rows, distance = wheel_rows(config), rms_distance(config)
    assert distance == pytest.approx(np.hypot(0.2, 0.1))
    assert undetermined(rows, distance) == undetermined(rows[:3], distance) == ()
    assert undetermined(rows[:2], distance) == ("sideways motion", "rotation")
    assert undetermined(rows[[0, 3]], distance) == ("forward motion", "sideways motion")
    assert undetermined(rows[:1], distance) == ("forward motion", "sideways motion", "rotation")
    omni = wheel_rows(machine("roller_angle_deg = 45.0", OMNI))
    assert undetermined(omni, distance) == ("sideways motion",)


def test_omni_wheels_that_point_at_the_origin_do_not_feel_its_rotation():
    pairs = ["roller_angle_deg = 45.0", OMNI]
    for name, x, y in (("fl", 0.2, 0.1), ("fr", 0.2, -0.1), ("rl", -0.2, 0.1), ("rr", -0.2, -0.1)):
        pairs += [f'name = "{name}"', f'name = "{name}", heading_deg = {math.degrees(math.atan2(y, x))!r}']
    config = machine(*pairs)
    assert undetermined(wheel_rows(config), rms_distance(config)) == ("rotation",)
    assert inverse(wheel_rows(config), rms_distance(config)) is None


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_the_size_of_the_machine_does_not_matter(size):
    config = machine()
    scaled = wheel_rows(config) * (1.0, 1.0, size)
    assert inverse(scaled, rms_distance(config) * size) is not None
