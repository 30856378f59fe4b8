"""Rollers of every profile: where they are lowest, how that moves with the tilt, and how high they carry a wheel."""

import math
from itertools import pairwise

import numpy as np
import pytest
from roller_profiles import PROFILES, shape
from uneven import kind, rollers

from omnisim.cad.geometry import roller_frames
from omnisim.contact.support import next_region, region_guard, region_of, support
from omnisim.scene.generatrix import generatrix
from omnisim.scene.ground_schema import Profile, Row
from omnisim.scene.lobes import BEND, lobes
from omnisim.scene.rollers import drawn, heights, rolling

pytestmark = pytest.mark.short


def lowest(shapes, tilt):
    """u, r and height below the centre of the lowest point of all lobes."""
    across = math.sqrt(1.0 - tilt * tilt)
    found = [support(one, region_of(one, tilt), tilt, across) for one in shapes]
    return max(((low.u, low.r, low.r * across - low.u * tilt) for low in found), key=lambda point: point[2])


@pytest.mark.parametrize("name", PROFILES)
def test_the_lowest_point_is_that_of_a_fine_mesh(name):
    """20001 points along the generatrix, at 400 tilts."""
    u, r = drawn(kind(profile=shape(name)), 20001)
    shapes = rollers(shape(name))
    for tilt in np.linspace(-0.99, 0.99, 400):
        mesh = (r * math.sqrt(1.0 - tilt * tilt) - u * tilt).max()
        assert -1e-15 < lowest(shapes, tilt)[2] - mesh < 1e-10  # measured up to 4e-11: the sag of the mesh's chords


@pytest.mark.parametrize("name", PROFILES)
def test_the_lowest_point_is_on_the_generatrix(name):
    u, r = drawn(kind(profile=shape(name)), 20001)
    shapes = rollers(shape(name))
    for tilt in np.linspace(-0.99, 0.99, 400):
        at = lowest(shapes, tilt)
        assert np.hypot(u - at[0], r - at[1]).min() < 2e-6  # as far as points of the mesh are apart


@pytest.mark.parametrize("name", PROFILES)
def test_rates_by_the_tilt_are_those_of_central_differences_and_keep_the_normal(name):
    """Of every lobe in every region: u_rate, r_rate; along the surface u_rate (-N) + r_rate sqrt(1 - N^2) = 0."""
    for one in rollers(shape(name)):
        for tilt in np.random.default_rng(1).uniform(-0.95, 0.95, 200):
            region = region_of(one, tilt)
            here, ahead, behind = (
                support(one, region, x, math.sqrt(1.0 - x * x)) for x in (tilt, tilt + 1e-6, tilt - 1e-6)
            )
            scale = max(one.arcs[region, 2], one.radius)
            assert abs((ahead.u - behind.u) / 2e-6 - here.u_rate) < 1e-8 * scale  # measured 2e-10 of it
            assert abs((ahead.r - behind.r) / 2e-6 - here.r_rate) < 1e-8 * scale
            assert abs(here.r_rate * math.sqrt(1.0 - tilt * tilt) - here.u_rate * tilt) < 1e-14 * scale


@pytest.mark.parametrize("name", PROFILES)
def test_from_region_to_region_the_lowest_point_goes_on(name):
    """Where one ends its guard is 0, and the next has the same point."""
    for one in rollers(shape(name)):
        for region in range(one.regions - 1):
            tilt = one.tilts[region + 1]
            assert region_guard(one, region, tilt) == 0.0
            assert next_region(one, region, tilt) == region + 1 and next_region(one, region + 1, tilt) == region
            here, there = (
                support(one, k, tilt, math.sqrt(max(1.0 - tilt * tilt, 1e-18))) for k in (region, region + 1)
            )
            assert math.hypot(here.u - there.u, here.r - there.r) < 1e-14  # measured 3e-16


@pytest.mark.parametrize(("name", "count"), [("cylinder", 2), ("capsule", 2), ("sphere", 1), ("arc", 1), ("cone", 3),
                                            ("stepped", 6), ("points", 1)])  # fmt: skip
def test_a_roller_has_as_many_lobes_as_bulges_between_its_lines(name, count):
    assert len(lobes(generatrix(shape(name)))) == count


@pytest.mark.parametrize("name", ["cylinder", "capsule", "cone", "stepped"])
def test_what_lobes_have_instead_of_a_line_is_within_the_roller_and_near_it(name):
    """In every direction of every lobe: never outside the generatrix, and along lines at most 1.5 BEND of them in."""
    u, r = drawn(kind(profile=shape(name)), 4001)
    half = max(abs(u))
    depths = []
    for one in rollers(shape(name)):
        for tilt in np.sin(np.linspace(-0.5, 0.5, 3001)):
            low = support(one, region_of(one, tilt), tilt, math.sqrt(1.0 - tilt * tilt))
            line = np.interp(low.u, u, r) if name != "stepped" else r[np.abs(u) >= abs(low.u) - 1e-12].max()
            assert low.r <= line + 1e-9  # the sag of chords between points; measured 8e-10
            depths.append(line - low.r if one.regions and abs(low.u) < 0.5 * half else 0.0)
    assert max(depths) < 1.6 * BEND * half


@pytest.mark.parametrize("name", PROFILES)
def test_what_is_drawn_has_all_corners_in_order_and_the_ends(name):
    """Of any number of points: the two ends of every arc, along u, and no point twice."""
    u, r = drawn(kind(profile=shape(name)), 9)
    corners = [arc.at(tilt) for arc in generatrix(shape(name)) for tilt in (arc.start, arc.end)]
    drawn_points = np.column_stack([u, r])
    for corner in corners:
        assert np.hypot(*(drawn_points - corner).T).min() < 1e-16
    assert (np.diff(u) > -1e-16).all() and (np.hypot(np.diff(u), np.diff(r)) > 1e-6).all()


def test_points_of_a_circle_give_the_circle():
    u = np.linspace(-0.018, 0.018, 9)
    r = 0.01 - 0.05 + np.sqrt(0.05**2 - u**2)
    arcs = generatrix(Profile(kind="points", axial=tuple(u.tolist()), radius=tuple(r.tolist())))
    for arc in arcs[1:-1]:
        np.testing.assert_allclose([arc.u, arc.r, arc.radius], [0.0, -0.04, 0.05], rtol=0, atol=1e-14)  # measured 4e-15


def test_a_curve_through_points_passes_them_all_bulges_and_has_no_corner():
    profile = shape("points")
    arcs = generatrix(profile)[1:-1]
    joints = [arcs[0].at(arcs[0].start), *(arc.at(arc.end) for arc in arcs)]
    np.testing.assert_allclose(joints[::2], np.column_stack([profile.axial, profile.radius]), rtol=0, atol=1e-16)
    for before, after in pairwise(arcs):
        assert before.end == after.start and before.radius > 0.0 and before.start > before.end
        np.testing.assert_allclose(before.at(before.end), after.at(after.start), rtol=0, atol=1e-16)


# --- on a wheel -----------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0.0, 45.0])
@pytest.mark.parametrize("name", PROFILES)
def test_heights_over_a_turn_are_those_of_a_mesh_of_all_rollers(name, angle):
    """7 rollers in each of two rows: the lowest of 4001 circles about the axis of each, at 40 spin angles."""
    rows = (Row(offset=-0.02), Row(offset=0.02, phase_deg=20.0))
    wheel = kind(profile=shape(name), roller_angle_deg=angle, roller_count=7, roller_distance=0.06, rows=rows)
    u, r = drawn(wheel, 4001)
    turns = np.linspace(0.0, 2.0 * np.pi / 7, 40)
    expected = []
    for turn in turns:
        frames = roller_frames(wheel, phase=-turn)
        expected.append(-min((centre[2] + u * axis[2] - r * math.hypot(*axis[:2])).min() for centre, axis in frames))
    np.testing.assert_allclose(heights(wheel, turns), expected, rtol=0, atol=1e-7)  # m, measured up to 1e-9


def test_a_published_wheel_of_eight_spheres_rolls_between_71_38_and_75_90_mm():
    """Spheres of 16.5 mm on a ring of 59.4 mm: 59.4 cos(22.5 deg) + 16.5 and 59.4 + 16.5."""
    wheel = kind(profile=Profile(kind="sphere", radius=0.0165), roller_count=8, roller_distance=0.0594)
    found = rolling(wheel)
    assert found.highest == pytest.approx(0.0759, abs=1e-15)
    assert found.lowest == pytest.approx(0.0165 + 0.0594 * math.cos(math.pi / 8), abs=1e-12)
    assert f"{1e3 * found.lowest:.2f}" == "71.38"
