"""The contact equation at zero slip."""

import numpy as np
import pytest

from omnisim.contact.coulomb import slip_direction, sticking_force
from omnisim.contact.kinematics import Slip

pytestmark = pytest.mark.short


def random_equations(count=200):
    rng = np.random.default_rng(6)
    for _ in range(count):
        root = rng.normal(size=(2, 2)) * 10.0 ** rng.uniform(-2, 2)
        yield (
            root @ root.T + 1e-3 * np.eye(2),
            rng.normal(size=2) * 10.0 ** rng.uniform(-3, 3),
            10.0 ** rng.uniform(-3, 3),
        )


def entries(matrix):
    return matrix[0, 0], matrix[0, 1], matrix[1, 1]


def test_the_sticking_force_cancels_the_slip_acceleration():
    for a, b, _ in random_equations():
        force = np.array(sticking_force(entries(a), Slip(*b)))
        assert np.abs(a @ force + b).max() < 1e-9 * np.abs(b).max() * np.linalg.cond(a)


def test_slip_from_rest_goes_where_it_accelerates():
    for a, b, limit in random_equations():
        u_h, u_k, kappa = slip_direction(entries(a), Slip(*b), limit)
        u = np.array([u_h, u_k])
        residual = b - limit * a @ u - kappa * u
        assert abs(u @ u - 1.0) < 1e-14
        assert np.abs(residual).max() < 1e-9 * (np.abs(b).max() + limit * np.abs(a).max())
        leaves = np.linalg.norm(np.linalg.solve(a, b)) > limit
        assert (kappa > 0.0) == leaves, "it slips off exactly when the sticking force leaves the cone"


def test_the_direction_found_attracts():
    """Across it the slip turns back: the smallest eigenvalue of limit A + kappa I is positive."""
    for a, b, limit in random_equations():
        kappa = slip_direction(entries(a), Slip(*b), limit).kappa
        assert np.linalg.eigvalsh(limit * a + kappa * np.eye(2)).min() > 0.0


def test_without_friction_slip_follows_the_acceleration():
    u_h, u_k, kappa = slip_direction((1.0, 0.2, 2.0), Slip(3.0, -4.0), 0.0)
    assert (u_h, u_k, kappa) == pytest.approx((0.6, -0.8, 5.0))
