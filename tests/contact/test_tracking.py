"""Stage 1: both contact trackings find the lowest point of the roller that touches."""

import math

import numpy as np
import pytest
from scenes import wheel_record

from omnisim.base.vector import Vec3
from omnisim.contact.frame import Frame, WheelTwist, axis_vector
from omnisim.contact.roller_profile import support_point
from omnisim.contact.tracking import (
    explicit_contact,
    explicit_touches,
    implicit_contact,
    implicit_touches,
    rho_rate,
    roller_axis,
)

pytestmark = pytest.mark.short

PSI = (0.0, 30.0, -45.0, 80.0)
UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(params=PSI, ids=lambda psi: f"psi {psi:g}")
def wheel(request):
    return wheel_record(psi_deg=request.param)


def frame(yaw):
    """h and k in world components."""
    return np.array([math.cos(yaw), math.sin(yaw), 0.0]), np.array([-math.sin(yaw), math.cos(yaw), 0.0])


def pose(wheel, q, yaw):
    """Frame, axis, rho and d of a roller at azimuth q."""
    h, _ = frame(yaw)
    d = -math.cos(q) * UP + math.sin(q) * h
    return Frame(math.cos(yaw), math.sin(yaw)), roller_axis(wheel, math.cos(q), math.sin(q)), Vec3(*-d), d


def angles(wheel):
    return zip(np.linspace(-wheel.alpha, wheel.alpha, 9), np.linspace(-3.0, 3.0, 9), strict=True)


def test_the_explicit_contact_point_is_the_lowest_point_of_the_exact_roller(wheel):
    for q, yaw in angles(wheel):
        heading, axis, _, d = pose(wheel, q, yaw)
        h, k = frame(yaw)
        a = np.array(axis_vector(heading, axis))
        lever = np.array(support_point(wheel, Vec3(*a)))  # P - O_B
        contact = explicit_contact(wheel, math.cos(q), math.sin(q))
        expected = wheel.roller_distance * d + lever  # P - O = -R n + l k
        np.testing.assert_allclose(-wheel.radius * UP + contact.l * k, expected, rtol=0, atol=2e-16 * 10)
        arm = np.cross(a, lever)
        np.testing.assert_allclose([contact.arm_h, contact.arm_k], [arm @ h, arm @ k], rtol=0, atol=1e-15)


def test_the_implicit_contact_is_the_explicit_one_when_rho_is_exact(wheel):
    for q, yaw in angles(wheel):
        heading, axis, rho, _ = pose(wheel, q, yaw)
        explicit = explicit_contact(wheel, math.cos(q), math.sin(q))
        implicit = implicit_contact(wheel, heading, axis, rho)
        np.testing.assert_allclose(implicit, explicit, rtol=0, atol=5e-16)


def test_with_the_misprint_of_the_paper_the_contact_point_would_hang_above_the_floor(wheel):
    heading, axis, rho, d = pose(wheel, 0.2, 0.7)
    contact = implicit_contact(wheel, heading, axis, rho)
    _, k = frame(0.7)
    centre = wheel.radius * UP + wheel.roller_distance * d  # O_B above the floor
    mended = centre + wheel.roller_distance * np.array(rho) - wheel.radius * UP + contact.l * k
    printed = centre + wheel.roller_distance * np.array(rho) - wheel.roller_distance * UP + contact.l * k
    assert abs(mended[2]) < 1e-16
    assert printed[2] == pytest.approx(wheel.radius - wheel.roller_distance, rel=1e-12)


def test_the_rate_of_rho_solves_the_three_differentiated_conditions(wheel):
    spin_rate, yaw_rate = 3.0, -1.7
    for q, yaw in angles(wheel):
        heading, axis, rho, _ = pose(wheel, q, yaw)
        _, k = frame(yaw)
        a, w, r = np.array(axis_vector(heading, axis)), spin_rate * k + yaw_rate * UP, np.array(rho)
        rate = np.array(rho_rate(heading, axis, WheelTwist(0.0, 0.0, spin_rate, yaw_rate), rho))
        assert abs(rate @ a + r @ np.cross(w, a)) < 1e-14
        assert abs(rate @ k + r @ np.cross(w, k)) < 1e-14
        assert abs(rate @ r) < 1e-14
        np.testing.assert_allclose(rate, np.cross(w, r), rtol=0, atol=1e-13)  # rho is fixed in the wheel


def test_both_contact_conditions_hold_for_the_same_one_roller_all_around(wheel):
    for q0 in np.linspace(-3.1, 3.1, 101):
        rollers = [q0 + 2.0 * wheel.alpha * i for i in range(wheel.rollers)]
        explicit = [bool(explicit_touches(wheel, math.cos(q))) for q in rollers]
        implicit = []
        for q in rollers:
            _, axis, rho, _ = pose(wheel, q, 0.4)
            implicit.append(bool(implicit_touches(wheel, axis, rho)))
        assert explicit == implicit
        assert sum(explicit) == 1


def test_on_a_common_edge_both_neighbours_touch(wheel):
    for q in (wheel.alpha, -wheel.alpha):
        _, axis, rho, _ = pose(wheel, q, 0.0)
        assert explicit_touches(wheel, math.cos(q))
        assert implicit_touches(wheel, axis, rho)


def test_the_contact_jumps_along_the_axle_at_an_exchange_by_the_closed_form(wheel):
    alpha = wheel.alpha
    before = explicit_contact(wheel, math.cos(-alpha), math.sin(-alpha)).l
    after = explicit_contact(wheel, math.cos(alpha), math.sin(alpha)).l
    jump = 2.0 * wheel.roller_distance * math.tan(alpha) * wheel.tan_psi
    assert after - before == pytest.approx(jump, rel=1e-14, abs=1e-18)
