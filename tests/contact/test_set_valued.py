"""The contact equation at zero slip."""

import numpy as np
import pytest

from omnisim.contact.frame import Slip
from omnisim.contact.mobility import Symmetric
from omnisim.contact.set_valued import contact_forces, slip_direction, sticking_force
from omnisim.dynamics.parameters import RESTING

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
    return Symmetric(matrix[0, 0], matrix[0, 1], matrix[1, 1])


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
    u_h, u_k, kappa = slip_direction(Symmetric(1.0, 0.2, 2.0), Slip(3.0, -4.0), 0.0)
    assert (u_h, u_k, kappa) == pytest.approx((0.6, -0.8, 5.0))


def disc_program(a, b, limits, sweeps=200000):
    """Least F.A F / 2 + b.F over discs |F_c| <= limit_c, by projected gradients: slow, and nothing else."""
    force, rate = np.zeros_like(b), 1.0 / np.linalg.eigvalsh(a)[-1]
    for _ in range(sweeps):
        step = (force - rate * (a @ force + b)).reshape(-1, 2)
        size = np.maximum(np.hypot(*step.T) / limits, 1.0)
        step = (step / size[:, None]).ravel()
        if np.abs(step - force).max() < 1e-15 * limits.max():
            break
        force = step
    return force


@pytest.mark.parametrize("count", [1, 2, 4, 7])
def test_coupled_contacts_at_rest_obey_gauss_and_coulomb(count):
    """Some of them stick and some slip off; those that slip off do so against their force."""
    rng, kinds = np.random.default_rng(8), set()
    for _ in range(20):
        root = rng.normal(size=(2 * count, 2 * count + 2))
        a, b, limits = root @ root.T, rng.normal(size=2 * count) * 10.0, rng.uniform(0.1, 4.0, count)
        contacts, mobility = blank(count), a.reshape(count, 2, count, 2).transpose(0, 2, 1, 3).copy()
        contacts.bias, contacts.limit, contacts.rest = b.reshape(-1, 2), limits, 1
        contact_forces(contacts, mobility)
        force = contacts.force.ravel().copy()
        assert np.abs(force - disc_program(a, b, limits)).max() < 1e-8 * limits.max()
        for c in range(count):
            slip_rate, pull = (a @ force + b)[2 * c : 2 * c + 2], force[2 * c : 2 * c + 2]
            sticks = np.hypot(*pull) < limits[c] * (1.0 - 1e-9)
            kinds.add(bool(sticks))
            scale = np.abs(a).max() * limits.max()
            if sticks:
                assert np.abs(slip_rate).max() < 1e-11 * scale
            else:
                assert abs(np.hypot(*pull) - limits[c]) < 1e-12 * limits[c]
                against = slip_rate @ pull + np.hypot(*slip_rate) * limits[c]
                assert abs(against) < 1e-11 * scale * limits[c]
    assert kinds == {True, False}


def test_a_contact_that_slips_keeps_its_force_and_loads_the_others():
    a = np.array([[2.0, 0.0, 0.5, 0.1], [0.0, 3.0, 0.2, 0.4], [0.5, 0.2, 2.5, 0.0], [0.1, 0.4, 0.0, 1.5]])
    contacts, mobility = blank(2), a.reshape(2, 2, 2, 2).transpose(0, 2, 1, 3).copy()
    contacts.bias, contacts.limit, contacts.rest = 1.0, 10.0, [1, 0]
    contacts.force[1] = [0.3, -0.4]
    contact_forces(contacts, mobility)
    assert contacts.force[1].tolist() == [0.3, -0.4]
    rate = a[:2] @ contacts.force.ravel() + 1.0
    assert np.abs(rate).max() < 1e-14


def blank(count):
    return np.zeros(count, RESTING).view(np.recarray)
