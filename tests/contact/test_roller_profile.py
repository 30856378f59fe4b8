"""The roller's profile and its lowest point."""

import math

import numpy as np
import pytest
from scenes import wheel_record

from omnisim.base.vector import Vec3
from omnisim.contact.roller_profile import (
    axial_coordinate,
    length,
    profile_radius,
    support_parameter,
    support_point,
    tip_radius,
)

pytestmark = pytest.mark.short

WHEELS = {
    "figure 1, psi 30": {},
    "psi 0": {"psi_deg": 0.0, "rollers": 6},
    "psi -45, 12 rollers": {"psi_deg": -45.0, "rollers": 12, "roller_distance": 0.085},
    "psi 80": {"psi_deg": 80.0},
    "pointed tips": {"roller_distance": 0.1 * math.cos(math.pi / 4)},
    "three rollers": {"rollers": 3, "roller_distance": 0.045},
}


@pytest.fixture(params=WHEELS.values(), ids=WHEELS.keys())
def wheel(request):
    return wheel_record(**request.param)


def surface(wheel, q, angle):
    """Points of the surface in the roller's frame, the axis first."""
    u = np.array([axial_coordinate(wheel, x) for x in q])
    r = np.array([profile_radius(wheel, x) for x in q])
    ones = np.ones_like(angle)
    return np.stack([np.outer(u, ones), np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))], axis=-1)


def test_the_roller_of_an_upright_wheel_reaches_exactly_R_below_its_centre(wheel):
    for q in np.linspace(-wheel.alpha, wheel.alpha, 21):
        c, s = wheel.cos_psi, wheel.sin_psi
        axis = np.array([-c * math.cos(q), s, -c * math.sin(q)])  # h, k, n
        centre_height = -wheel.roller_distance * math.cos(q)
        lowest = centre_height + support_point(wheel, Vec3(*axis)).z
        assert abs(lowest + wheel.radius) < 1e-15 * 10, (q, lowest + wheel.radius)


def test_the_profile_parameter_of_the_lowest_point_is_the_azimuth_of_the_roller(wheel):
    for q in np.linspace(-wheel.alpha, wheel.alpha, 11):
        assert abs(support_parameter(wheel, -wheel.cos_psi * math.sin(q)) - q) < 1e-12


def test_no_point_of_the_surface_lies_below_the_closed_form_at_any_tilt(wheel):
    q = np.linspace(-wheel.alpha, wheel.alpha, 801)
    points = surface(wheel, q, np.linspace(0.0, 2.0 * np.pi, 721)).reshape(-1, 3)
    grid_error = 0.5 * (np.pi / 720) ** 2 * profile_radius(wheel, 0.0) + 0.5 * (wheel.alpha / 800) ** 2 * wheel.radius
    rng = np.random.default_rng(1)
    for axis in rng.normal(size=(40, 3)):
        axis /= np.linalg.norm(axis)
        across = np.linalg.svd(axis[None])[2][1:]
        brute = (points @ np.array([axis, *across])[:, 2]).min()
        exact = support_point(wheel, Vec3(*axis))
        assert exact.z <= brute + 1e-15  # never above the brute-force minimum ...
        assert brute - exact.z < grid_error  # ... which the grid can miss by half a spacing; measured up to 70 % of it


def test_the_lowest_point_lies_on_the_surface(wheel):
    for axis in np.random.default_rng(2).normal(size=(40, 3)):
        axis /= np.linalg.norm(axis)
        point = np.array(support_point(wheel, Vec3(*axis)))
        q = support_parameter(wheel, axis[2])
        along = point @ axis
        assert abs(along - axial_coordinate(wheel, q)) < 1e-14
        assert abs(np.linalg.norm(point - along * axis) - profile_radius(wheel, q)) < 1e-14


def test_a_roller_standing_on_end_touches_with_its_rim(wheel):
    for side in (1.0, -1.0):
        point = support_point(wheel, Vec3(0.0, 0.0, side))
        assert abs(point.z + 0.5 * length(wheel)) < 1e-14
        assert abs(math.hypot(point.x, point.y) - tip_radius(wheel)) < 1e-14


def test_the_papers_length_holds_for_psi_0_and_for_pointed_tips_only():
    def paper(wheel):
        return 2.0 * wheel.radius * wheel.sin_alpha / wheel.cos_psi

    straight, pointed, general = (
        wheel_record(**WHEELS[name]) for name in ("psi 0", "pointed tips", "figure 1, psi 30")
    )
    assert length(straight) == pytest.approx(paper(straight), rel=1e-14)
    assert length(pointed) == pytest.approx(paper(pointed), rel=1e-14)
    assert abs(length(general) / paper(general) - 1.0) > 0.005  # measured 0.0096


def test_a_pointed_tip_has_no_radius_and_a_cut_one_has():
    assert tip_radius(wheel_record(**WHEELS["pointed tips"])) < 1e-16
    assert tip_radius(wheel_record(**WHEELS["figure 1, psi 30"])) == pytest.approx(
        (0.1 - 0.068 / math.cos(math.pi / 4)) * math.sqrt(1 - 0.75 * 0.5), rel=1e-14
    )
