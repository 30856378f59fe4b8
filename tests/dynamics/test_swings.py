"""How a machine free in space swings: closed forms."""

import math

import numpy as np
import pytest

from omnisim.dynamics.packing import pack
from omnisim.dynamics.spatial.swings import fastest_swing, matrices, swings
from omnisim.scene.scene import load


def parameters_of(name, *overrides):
    return pack(load(name, overrides).config)


def test_heave_pitch_and_roll_of_a_machine_on_three_wheels():
    """sqrt(3 k / M), and sqrt(3/2 k r^2 / I) of wheels on a circle of radius r; damping by c / k."""
    parameters = parameters_of("kiwi_ramp")
    k, c, mass = 1e5, 60.0, float(parameters.machine.mass)
    across = float(parameters.space.body.inertia[0, 0])
    squares = [3.0 * k / mass, *[1.5 * k * 0.125**2 / across] * 2]
    found = swings(parameters)
    assert {swing.name for swing in found} == {"heave", "roll", "pitch"}
    rates = [2.0 * math.pi * swing.frequency for swing in found]
    assert rates == pytest.approx(sorted(map(math.sqrt, squares)), rel=1e-6)  # 3e-8: digits of the places in the scene
    assert [swing.damping for swing in found] == pytest.approx([0.5 * c / k * rate for rate in rates], rel=1e-9)


def test_a_machine_on_springs_heaves_as_two_masses():
    parameters = parameters_of("cable_duct")
    rubber, spring, hub, mass = 4 * 2e5, 4 * 6000.0, 4 * (0.3 + 0.7), 20.0
    whole = np.array([[spring / mass, -spring / mass], [-spring / hub, (spring + rubber) / hub]])
    expected = np.sqrt(np.linalg.eigvals(whole)) / (2.0 * math.pi)
    found = [swing.frequency for swing in swings(parameters)]
    for frequency in expected:
        assert min(abs(other / frequency - 1.0) for other in found) < 1e-12


@pytest.mark.parametrize("name", ["kiwi_ramp", "cable_duct", "rocker"])
def test_matrices_are_symmetric_and_nothing_moves_without_mass_or_resistance(name):
    for matrix, least in zip(matrices(parameters_of(name), 1.0), (1e-6, 0.0, 1.0), strict=True):
        assert np.abs(matrix - matrix.T).max() == 0.0
        assert np.linalg.eigvalsh(matrix)[0] > least


def test_the_fastest_rate_is_that_of_overdamped_rubber():
    """c / m where damping rules: two rollers of each wheel carry a machine in heave, pitch and roll."""
    parameters = parameters_of("kiwi_ramp", "wheel_types.omni.contact.damping=1e6")
    across = float(parameters.space.body.inertia[0, 0])
    stiffest = max(6e6 / float(parameters.machine.mass), 3e6 * 0.125**2 / across)
    assert fastest_swing(parameters) == pytest.approx(stiffest, rel=1e-4)
