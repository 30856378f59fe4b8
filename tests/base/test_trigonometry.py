"""Cosine and sine of the kernels against those of the C library."""

import math

import numpy as np
import pytest

from omnisim.base.trigonometry import angle_of, cos_sin

pytestmark = pytest.mark.short


def test_cosine_and_sine_are_right_to_rounding():
    angles = np.random.default_rng(0).uniform(-1.0, 1.0, 20_000) * np.repeat([1.0, 10.0, 1e3, 1e5], 5_000)
    found = np.array([cos_sin(angle) for angle in angles])
    apart = np.abs(found - np.column_stack([np.cos(angles), np.sin(angles)]))
    assert apart.max() < 2.3e-16  # measured: 2.2e-16, one rounding of 1


def test_small_sines_keep_their_relative_accuracy():
    angles = 10.0 ** np.arange(-300.0, 0.0)
    sines = np.array([cos_sin(angle)[1] for angle in angles])
    assert np.abs(sines / np.sin(angles) - 1.0).max() < 2.3e-16  # measured: 2.2e-16


def test_multiples_of_a_quarter_turn_stay_close_to_it():
    for quarters in range(-9, 10):
        cos, sin = cos_sin(0.5 * math.pi * quarters)
        exact = [(1, 0), (0, 1), (-1, 0), (0, -1)][quarters % 4]
        assert max(abs(cos - exact[0]), abs(sin - exact[1])) < 1e-15  # measured: 5e-16, of the angle itself


def test_cosine_is_even_and_sine_is_odd_to_the_last_bit():
    for angle in np.random.default_rng(1).uniform(0.0, 100.0, 1000):
        (cos, sin), (mirrored_cos, mirrored_sin) = cos_sin(angle), cos_sin(-angle)
        assert (mirrored_cos, mirrored_sin) == (cos, -sin)


def test_what_is_no_number_has_no_cosine():
    assert all(math.isnan(value) for value in cos_sin(math.nan))


def test_small_angles_and_others_are_those_of_atan2():
    angles = np.concatenate([np.linspace(-math.pi, math.pi, 2001), np.logspace(-300, -1, 600), [0.0, 0.02999, 0.03001]])
    for angle in angles:
        for size in (1.0, 3e-5):
            cos, sin = size * math.cos(angle), size * math.sin(angle)
            assert angle_of(cos, sin) == pytest.approx(math.atan2(sin, cos), rel=4e-16, abs=0.0)  # measured 3.3e-16
    assert angle_of(0.0, 1.0) == 0.5 * math.pi and angle_of(-1.0, 1e-9) == math.atan2(1e-9, -1.0)
