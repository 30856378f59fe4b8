"""Stage 3: sliding and spinning at once, against quadrature."""

import numpy as np
import pytest

from omnisim.contact.contensou import FAINT, SPINNING_TORQUE, patch_factors

pytestmark = pytest.mark.short

NEAR = [1.0 + sign * 10.0**power for power in range(-12, -2) for sign in (-1.0, 1.0)]
BRANCH = [1.0 / FAINT - 1e-9, 1.0 / FAINT + 1e-9]
RATIOS = np.sort([*np.logspace(-12, 12, 97), *np.linspace(0.02, 6.0, 300), *NEAR, *BRANCH])  # v / (a omega)
LINEAR = np.array([3.0 * np.pi / 8.0, 0.2])  # Phi of s for s -> 0, and Psi of 1 / s for s -> infinity


def factors(ratios):
    """Rows Phi, Psi."""
    return np.array([patch_factors(ratio, 1.0) for ratio in ratios])


def lines(ratio, count=40):
    """Gauss-Legendre angles and weights of the lines through the centre of rotation that meet the patch."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = np.arcsin(1.0 / max(ratio, 1.0))
    return half * nodes, half * weights


def patch_integrals(ratio):
    """Phi and Psi as defined: pressure against the direction of the local slip, point by point.

    On lines through the centre of rotation, since across it the direction jumps.
    """
    nodes, weights = np.polynomial.legendre.leggauss(40)
    angle, width = (column[:, None] for column in lines(ratio))
    foot = ratio * np.sin(angle)  # of the perpendicular from the middle onto the line
    chord = np.sqrt((1.0 - foot) * (1.0 + foot))
    along = chord * np.sin(0.5 * np.pi * nodes)
    pressure = 1.5 / np.pi * chord * np.cos(0.5 * np.pi * nodes)
    length = chord * np.cos(0.5 * np.pi * nodes) * 0.5 * np.pi * weights
    area = np.abs(along + ratio * np.cos(angle)) * width * length
    x, y = foot * np.cos(angle) + along * np.sin(angle), foot * np.sin(angle) - along * np.cos(angle)
    slip = np.array([ratio - y, x])  # spinning at 1 rad/s about (0, ratio)
    direction = slip / np.hypot(*slip)
    force, torque = direction[0], x * direction[1] - y * direction[0]
    return np.array([np.sum(pressure * force * area), np.sum(pressure * torque * area)])


def line_integrals(ratio):
    """Phi and Psi after one integration along every line: no cancellation, so good to the last digits of either."""
    angle, width = lines(ratio)
    square = 1.0 - (ratio * np.sin(angle)) ** 2
    force = 0.75 * ratio * np.sum(square * np.cos(angle) ** 2 * width)
    return np.array([force, 0.1875 * np.sum(square**2 * width)])


def test_the_closed_form_is_the_integral_over_the_patch():
    error = np.abs(factors(RATIOS) - [patch_integrals(ratio) for ratio in RATIOS])
    assert error.max() < 2e-14  # measured 8.0e-15


def test_small_factors_have_their_digits():
    expected = np.array([line_integrals(ratio) for ratio in RATIOS])
    error = np.abs(factors(RATIOS) / expected - 1.0)
    assert error[:, 0].max() < 1e-14  # measured 4.4e-15
    assert error[:, 1].max() < 1e-13  # measured 2.0e-14


def test_pure_sliding_and_pure_spinning():
    assert patch_factors(0.3, 0.0) == (1.0, 0.0)
    assert patch_factors(0.0, 0.3) == (0.0, SPINNING_TORQUE)


def test_slow_sliding_and_faint_spinning_are_opposed_in_proportion():
    slow = [patch_factors(1e-9, 1.0)[0], patch_factors(1.0, 1e-9)[1]]
    np.testing.assert_allclose(slow, 1e-9 * LINEAR, rtol=1e-15)  # measured 0 and 0


def test_only_the_ratio_of_the_speeds_counts():
    for ratio in (1e-3, 0.9, 1.1, 1e3):
        assert patch_factors(ratio, 1.0) == patch_factors(ratio * 2.0**-900, 2.0**-900)


def test_both_derive_from_one_dissipation():
    """v Phi + a omega Psi is homogeneous of degree one, and its derivatives are Phi and Psi."""
    h = 1e-3
    stencil = np.array([1.0, -8.0, 8.0, -1.0]) / (12.0 * h)
    for v, u in [(0.01, 1.0), (0.5, 1.0), (1.0, 0.8), (1.0, 0.3), (1.0, 0.01)]:
        steps = h * np.array([-2.0, -1.0, 1.0, 2.0])
        along_v = [np.dot((v + step, u), patch_factors(v + step, u)) for step in steps]
        along_u = [np.dot((v, u + step), patch_factors(v, u + step)) for step in steps]
        error = np.abs([stencil @ along_v, stencil @ along_u] - np.array(patch_factors(v, u)))
        assert error.max() < 1e-11  # measured 5.7e-13


def test_spinning_takes_from_the_force_and_sliding_from_the_torque():
    growth = np.diff(factors(RATIOS), axis=0)
    assert growth[:, 0].min() > -2e-15  # rounding at Phi = 1; measured -6.7e-16
    assert growth[:, 1].max() <= 0.0


def test_the_common_linear_fractions_miss_a_third_of_the_friction():
    """v / (v + 8 a omega / 3 pi) for Phi and its like for Psi: right at both ends, in the slopes there, not between."""
    ratios = np.logspace(-2, 2, 401)
    force = ratios / (ratios + 1.0 / LINEAR[0])
    torque = SPINNING_TORQUE / (1.0 + ratios * SPINNING_TORQUE / LINEAR[1])
    error = np.max(factors(ratios) - np.transpose([force, torque]), axis=0)
    np.testing.assert_allclose(error, [0.344, 0.231], rtol=0, atol=1e-3)  # mu N and mu N a; measured 0.3437, 0.2307
