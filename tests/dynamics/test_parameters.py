"""A scene becomes numbers in one place."""

import math

import numpy as np
import pytest
from scenes import packed, reference_scene

from omnisim.dynamics.input_tables import lines
from omnisim.dynamics.parameters import DRIVE_INPUT, FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE

pytestmark = pytest.mark.short


def value(parameters, channel, t):
    piece = int(np.searchsorted(parameters.starts, t, side="right")) - 1
    start, slope = parameters.inputs[piece, channel]
    return start + slope * (t - parameters.starts[piece])


def test_inertias_are_those_of_disk_and_rollers_together():
    machine, wheel = (
        packed(reference_scene("testbench_psi30"))[0].machine,
        packed(reference_scene("testbench_psi30"))[0].wheels[0],
    )
    assert machine.mass == pytest.approx(2.0 + 4 * 0.15, rel=1e-15)
    assert wheel.axle_inertia == pytest.approx(0.008 + 4 * (0.15 * 0.068**2 + 0.00012 * 0.75), rel=1e-14)
    assert machine.yaw_inertia == pytest.approx(
        0.0045 + 4 * (0.15 * 0.068**2 / 2 + 0.00012 * (1 - 0.75 / 2)), rel=1e-14
    )


def test_the_inertias_equal_the_sum_over_the_rollers_one_by_one():
    """The inertia tensor of the wheel at any spin angle, less the rollers' own axial part, is diag(J_t, J_k, J_t)."""
    parameters, _ = packed(reference_scene("testbench_psi30"))
    wheel = parameters.wheels[0]
    for spin in (0.0, 0.3):
        tensor = np.diag([0.0045, 0.008, 0.0045])
        for i in range(4):
            q = i * math.pi / 2 - spin
            d = np.array([math.sin(q), 0.0, -math.cos(q)])  # axes h, k, n
            t = np.array([-math.cos(q), 0.0, -math.sin(q)])
            a = wheel.cos_psi * t + wheel.sin_psi * np.array([0.0, 1.0, 0.0])
            across = 0.00012 * (np.eye(3) - np.outer(a, a))
            tensor += across + 0.15 * 0.068**2 * (np.eye(3) - np.outer(d, d))
        np.testing.assert_allclose(
            np.diag(tensor)[[1, 2]], [wheel.axle_inertia, parameters.machine.yaw_inertia], rtol=1e-12
        )
        assert abs(tensor[1, 2]) < 1e-18


def test_mirrored_changes_the_sign_of_psi_and_nothing_else():
    plain = packed(reference_scene("testbench_psi30"))[0].wheels[0]
    mirrored = packed(reference_scene("testbench_psi30", "wheels.wheel.mirrored=true"))[0].wheels[0]
    for name in plain.dtype.names:
        sign = -1.0 if name in ("sin_psi", "tan_psi") else 1.0
        assert np.all(mirrored[name] == sign * plain[name])


def test_tables_are_linear_between_and_held_outside():
    times, torque = [0.5, 1.0, 2.0], [1.0, 3.0, -1.0]
    scene = reference_scene("testbench_psi0", f"wheels.wheel.drive={{kind='torque', times={times}, torque={torque}}}")
    parameters, _ = packed(scene)
    for t in np.linspace(0.0, 3.0, 61):
        assert value(parameters, DRIVE_INPUT, t) == pytest.approx(np.interp(t, times, torque), abs=1e-15)


def test_two_equal_times_are_a_jump_with_the_new_value_from_there_on():
    scene = reference_scene(
        "testbench_psi0", "wheels.wheel.drive={kind='torque', times=[0.0, 1.0, 1.0, 2.0], torque=[0.0, 1.0, 5.0, 6.0]}"
    )
    parameters, _ = packed(scene)
    assert value(parameters, DRIVE_INPUT, 1.0 - 1e-9) == pytest.approx(1.0, abs=1e-8)
    assert value(parameters, DRIVE_INPUT, 1.0) == 5.0


def test_a_jump_at_the_start_or_a_table_that_begins_before_it_starts_after_the_jump():
    scene = reference_scene(
        "testbench_psi0", "wheels.wheel.drive={kind='torque', times=[-1.0, 0.0, 0.0, 2.0], torque=[9.0, 9.0, 1.0, 3.0]}"
    )
    parameters, _ = packed(scene)
    assert value(parameters, DRIVE_INPUT, 0.0) == 1.0
    assert value(parameters, DRIVE_INPUT, 1.0) == 2.0
    assert list(parameters.starts) == [0.0, 2.0]


def test_tables_with_different_knots_share_one_sequence_of_pieces():
    scene = reference_scene(
        "testbench_psi0",
        "wheels.wheel.drive={kind='torque', times=[0.0, 1.5], torque=[0.0, 3.0]}",
        "wrench.times=[0.5, 1.0]",
        "wrench.force=[[1.0, 2.0, 3.0], [2.0, 0.0, -3.0]]",
        "wrench.yaw_torque=[0.5, 0.5]",
    )
    parameters, _ = packed(scene)
    assert list(parameters.starts) == [0.0, 0.5, 1.0, 1.5]
    for t in np.linspace(0.0, 2.0, 41):
        assert value(parameters, DRIVE_INPUT, t) == pytest.approx(np.interp(t, [0.0, 1.5], [0.0, 3.0]), abs=1e-14)
        assert value(parameters, FORCE_X, t) == pytest.approx(np.interp(t, [0.5, 1.0], [1.0, 2.0]), abs=1e-14)
        assert value(parameters, FORCE_Y, t) == pytest.approx(np.interp(t, [0.5, 1.0], [2.0, 0.0]), abs=1e-14)
        assert value(parameters, FORCE_Z, t) == pytest.approx(np.interp(t, [0.5, 1.0], [3.0, -3.0]), abs=1e-14)
        assert value(parameters, YAW_TORQUE, t) == 0.5


def test_a_line_is_flat_before_the_first_knot_and_beyond_the_last():
    values, slopes = lines(np.array([0.0, 1.0]), np.array([[2.0], [4.0]]), np.array([-1.0, 0.0, 1.0, 2.0]))
    assert values.tolist() == [[2.0], [2.0], [4.0], [4.0]]
    assert slopes.tolist() == [[0.0], [2.0], [0.0], [0.0]]
