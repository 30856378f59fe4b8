"""Spectra of ripple: amplitudes that are put in come out, at the order of their rollers."""

import numpy as np
import pytest

from omnisim.results.ripple import RippleError, longest_way, spectrum

ROLLERS = 6
PITCH = 2.0 * np.pi / ROLLERS


def at_order(orders, amplitudes, order):
    return amplitudes[np.argmin(np.abs(orders - order))]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_ripple_of_a_wheel_that_speeds_up_stands_at_its_order(direction):
    time = np.linspace(0.0, 3.0, 601)
    angle = direction * (4.0 * time + 2.0 * time**2)  # 4 to 16 rad/s
    wave = 0.010 * np.cos(angle / PITCH * 2.0 * np.pi) + 0.003 * np.sin(2.0 * angle / PITCH * 2.0 * np.pi)
    orders, amplitudes = spectrum(angle, ROLLERS, 0.5 * time + wave)
    assert at_order(orders, amplitudes, 1.0) == pytest.approx(0.010, rel=1e-3)  # 5e-5 off
    assert at_order(orders, amplitudes, 2.0) == pytest.approx(0.003, rel=1e-3)  # 7e-5 off
    between = (np.abs(orders - 1.5) < 0.2) | (np.abs(orders - 2.5) < 0.2)
    assert amplitudes[between].max() < 1e-5  # 2e-6
    assert orders[0] > 0.0 and orders[-1] <= 5.0


def test_what_repeats_with_every_roller_of_a_row_stands_at_one_over_the_rows():
    """As does what repeats with every roller of all rows, at 1: amplitudes are as large as they were put in."""
    angle = np.linspace(0.0, 60.0, 6001)
    wave = 0.010 * np.cos(0.5 * angle / PITCH * 2.0 * np.pi) + 0.003 * np.sin(angle / PITCH * 2.0 * np.pi)
    orders, amplitudes = spectrum(angle, ROLLERS, 0.1 * angle + wave, 2)
    assert at_order(orders, amplitudes, 0.5) == pytest.approx(0.010, rel=1e-3)  # 3e-5 off
    assert at_order(orders, amplitudes, 1.0) == pytest.approx(0.003, rel=1e-3)  # 1e-4 off
    assert orders[-1] <= 5.0
    with pytest.raises(RippleError, match="fewer than 5 rollers of a row"):
        spectrum(angle[angle < 9.9 * PITCH], ROLLERS, wave[angle < 9.9 * PITCH], 2)


def test_a_ramp_alone_has_no_ripple():
    angle = np.linspace(0.0, 40.0, 801)
    _, amplitudes = spectrum(angle, ROLLERS, 3.0 + 2.0 * angle)
    assert amplitudes.max() < 1e-11  # 2e-13


def test_the_longest_way_ends_where_the_wheel_turns_back_or_rests():
    assert longest_way(np.array([0.0, 1.0, 2.0, 2.0, 2.0, 1.0])) == (0, 2)
    assert longest_way(np.array([0.0, 1.0, 0.0, -1.0, -2.0])) == (1, 4)
    assert longest_way(np.zeros(5)) == (0, 0)
    assert longest_way(np.zeros(1)) == (0, 0)


@pytest.mark.parametrize(
    ("angle", "reason"),
    [
        (np.zeros(50), "fewer than 5 rollers"),
        (np.array([1.0]), "fewer than 5 rollers"),
        (np.linspace(0.0, 4.9 * PITCH, 500), "fewer than 5 rollers"),
        (np.linspace(0.0, 100 * PITCH, 301), "has 3 rows for each roller, too few"),
    ],
)
def test_what_has_no_spectrum_says_why(angle, reason):
    with pytest.raises(RippleError, match=reason):
        spectrum(angle, ROLLERS, angle)
