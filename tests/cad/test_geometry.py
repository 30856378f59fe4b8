"""The shape of rollers: volume and inertia, room between them, ripple of other shapes, closed meshes."""

import math

import numpy as np
import pytest
from helpers.stages import either
from scenes import wheel_record

import omnisim
from omnisim.cad import mesh
from omnisim.cad.geometry import (
    SHORTFALL,
    few_spheres,
    gap,
    hub_radius,
    of_type,
    profile,
    ripple,
    roller_frames,
    shapes,
    shortfall,
    solid,
    support,
)
from omnisim.contact.roller_profile import length, profile_radius
from omnisim.dynamics.packing import pack
from omnisim.scene.rollers import gap_between_rows, gap_in_row

pytestmark = pytest.mark.short
SCENES = ("youbot", "kiwi", "six_rollers", "thirty_two_rollers")


def kind_of(scene):
    return next(iter(omnisim.load(scene).config.wheel_types.values()))


def test_the_record_of_a_type_has_the_geometry_of_its_wheels():
    config = omnisim.load("youbot").config
    of_kind, of_wheel = of_type(config.wheel_types["mecanum"]), pack(config).wheels[0]
    names = ("radius", "roller_distance", "rollers", "alpha", "cos_psi", "sin_psi", "tan_psi", "axle_inertia")
    assert all(of_kind[name] == of_wheel[name] for name in names)


def test_the_inertia_of_youbots_rollers_is_that_of_the_solid_at_uniform_density():
    roller, body = kind_of("youbot").roller, solid(of_type(kind_of("youbot")))
    density = roller.mass / body.volume
    assert density * body.axial == pytest.approx(roller.inertia_axial, rel=1e-3)  # measured 4.2e-5: given with 4 digits
    assert density * body.transverse == pytest.approx(roller.inertia_transverse, rel=1e-3)  # measured 3.8e-5


def test_a_straight_roller_has_the_closed_volume_of_a_solid_bounded_by_an_arc():
    """psi = 0: r = sqrt(R^2 - u^2) - R1, of which the integral of r^2 is elementary."""
    wheel = of_type(kind_of("six_rollers"))
    big, distance, u = wheel.radius, wheel.roller_distance, 0.5 * length(wheel)
    arc = u * math.sqrt(big**2 - u**2) + big**2 * math.asin(u / big)
    exact = 2.0 * math.pi * (big**2 * u - u**3 / 3.0 + distance**2 * u - distance * arc)
    assert solid(wheel).volume == pytest.approx(exact, rel=1e-13)  # measured 6e-15


# --- room between rollers -------------------------------------------------------------------------


def surface(wheel, frame, stations=101, corners=180):
    """Points (P, 3) of a roller, its end discs included."""
    u, r = profile(wheel, np.linspace(-wheel.alpha, wheel.alpha, stations))
    inner = np.linspace(0.0, r[-1], 12)
    u, r = np.concatenate([np.full(12, u[0]), u, np.full(12, u[-1])]), np.concatenate([inner, r, inner[::-1]])
    turn = 2.0 * np.pi * np.arange(corners) / corners
    points = np.stack([np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn)), np.outer(u, np.ones(corners))], axis=-1)
    return mesh.placed(mesh.Mesh(points.reshape(-1, 3), np.empty((0, 3), int)), *frame).vertices


@pytest.mark.parametrize(("scene", "pitches"), [("youbot", 1), ("youbot", 2), ("kiwi", 2), ("thirty_two_rollers", 1)])
def test_the_gap_is_the_smallest_distance_of_points_on_two_rollers_and_never_above_it(scene, pitches):
    from scipy.spatial import cKDTree

    kind = kind_of(scene)
    wheel, frames = of_type(kind), roller_frames(kind)
    near, _ = cKDTree(surface(wheel, frames[0])).query(surface(wheel, frames[pitches]))
    found = gap(wheel, pitches)
    assert found <= near.min() + 1e-15
    assert near.min() - found < 1e-5  # of a grid; measured 0 to 3.4e-6


@pytest.mark.parametrize("angle", either([0.0, 25.0, -25.0], []))
def test_the_gap_between_rows_is_the_smallest_distance_of_points_on_their_rollers(angle):
    """Neighbours ahead and behind on the other row are not equally far where rollers stand aslant."""
    from scipy.spatial import cKDTree

    rows = "wheel_types.omni.rows=[{offset=-0.009}, {offset=0.012, phase_deg=20.0}]"
    aslant = f"wheel_types.omni.roller_angle_deg={angle!r}"
    kind = omnisim.load("kiwi", ["wheel_types.omni.roller_count=9", rows, aslant]).config.wheel_types["omni"]
    first, *others = (surface(of_type(kind), frame) for frame in roller_frames(kind))
    near = [cKDTree(first).query(other)[0].min() for other in others]
    assert -1e-15 <= min(near[::2]) - gap_between_rows(kind) < 2e-5  # of a grid
    assert -1e-15 <= min(near[1::2]) - gap_in_row(kind) < 2e-5


def test_rows_are_counted_in_order_of_azimuth():
    """In the file, in kernels, in meshes: roller i stands 2 pi i / N_r from the first row's roller 0."""
    rows = "wheel_types.omni.rows=[{offset=1, phase_deg=5}, {offset=2, phase_deg=-15}, {offset=3, phase_deg=85}]"
    kind = omnisim.load("kiwi", ["wheel_types.omni.roller_count=6", rows]).config.wheel_types["omni"]
    centres = np.array([centre for centre, _ in roller_frames(kind)])
    np.testing.assert_array_equal(centres[:, 1], np.tile([1.0, 3.0, 2.0], 6))
    azimuths = np.unwrap(np.arctan2(centres[:, 0], -centres[:, 2]))
    np.testing.assert_allclose(azimuths, np.radians(5.0 + 20.0 * np.arange(18)), rtol=1e-14)


@pytest.mark.parametrize("scene", ["kiwi", "six_rollers"])
def test_straight_rollers_in_one_row_overlap_unless_their_tips_are_points(scene):
    wheel = of_type(kind_of(scene))
    assert gap(wheel) < 0.0
    pointed = wheel_record(rollers=6, psi_deg=0.0, roller_distance=0.1 * math.cos(math.pi / 6))
    assert abs(gap(pointed)) < 1e-15  # tip to tip; measured 7e-18


def test_the_hub_touches_the_middle_of_every_roller_and_enters_none():
    for scene in SCENES:
        kind = kind_of(scene)
        points = np.concatenate([surface(of_type(kind), frame) for frame in roller_frames(kind)])
        nearest = np.hypot(points[:, 0], points[:, 2]).min()
        assert nearest >= hub_radius(of_type(kind)) - 1e-15
        assert nearest == pytest.approx(hub_radius(of_type(kind)), rel=1e-12)  # measured 2e-16


# --- ripple ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", SCENES)
def test_the_exact_roller_carries_the_wheel_at_one_height(scene):
    wheel = of_type(kind_of(scene))
    found = np.array(ripple(wheel, shapes(wheel)["exact"]))
    np.testing.assert_allclose(found, wheel.radius, rtol=1e-14)


@pytest.mark.parametrize("scene", SCENES)
def test_spheres_touch_the_profile_from_within_and_a_cylinder_holds_the_roller(scene):
    wheel = of_type(kind_of(scene))
    found = {name: ripple(wheel, reach) for name, reach in shapes(wheel).items()}
    assert found["3 spheres"].highest == pytest.approx(wheel.radius, rel=1e-12)
    assert found["cylinder"].lowest == pytest.approx(wheel.radius, rel=1e-12)
    assert found["cylinder"].mean > wheel.radius > found["3 spheres"].mean


@pytest.mark.parametrize("scene", SCENES)
def test_a_few_spheres_reach_as_far_as_the_profile_but_for_a_quarter_of_a_percent_of_the_radius(scene):
    """From the middle to the rim of the end; beyond it they bulge out of the end disc or fall short of its rim.

    Below: one sphere less would fall short by more. On the wheel, the shortfall is that of the closed form.
    """
    wheel = of_type(kind_of(scene))
    spheres, allowed = few_spheres(wheel), SHORTFALL * wheel.radius
    count, rim = len(spheres.radii), wheel.cos_psi * math.sin(wheel.alpha)

    def reach(sines):
        return (np.multiply.outer(sines, spheres.places) + spheres.radii).max(axis=-1)

    sines = np.linspace(-rim, rim, 2001)
    error = reach(sines) - [support(wheel, sine) for sine in sines]
    assert error.max() < 1e-15
    assert -allowed <= error.min() < -0.4 * allowed  # measured -0.45 to -0.99 of it
    found = ripple(wheel, reach)
    assert found.highest == pytest.approx(wheel.radius, rel=1e-6)
    assert wheel.radius - found.lowest == pytest.approx(shortfall(wheel, count), rel=1e-9)
    assert shortfall(wheel, count - 1) > allowed


def test_the_ripple_of_an_ellipse_is_that_of_a_search_over_its_points():
    """youBot: centre heights 46.658 to 47.506 mm, by the lowest of points on the ellipsoids of all rollers."""
    kind = kind_of("youbot")
    wheel = of_type(kind)
    half, middle = 0.5 * length(wheel), profile_radius(wheel, 0.0)
    t, turn = np.meshgrid(np.linspace(-0.5 * np.pi, 0.5 * np.pi, 301), np.linspace(0.0, 2.0 * np.pi, 241))
    across = middle * np.cos(t)
    points = np.stack([across * np.cos(turn), across * np.sin(turn), half * np.sin(t)], axis=-1).reshape(-1, 3)
    body = mesh.Mesh(points, np.empty((0, 3), int))
    heights = []
    for phase in np.linspace(0.0, wheel.alpha, 21):
        frames = roller_frames(kind, phase=phase)
        heights.append(-min(mesh.placed(body, *frame).vertices[:, 2].min() for frame in frames))
    found = ripple(wheel, shapes(wheel)["ellipse"])
    assert found.lowest == pytest.approx(min(heights), abs=1e-6)  # measured 1.1e-7, by the grid
    assert found.highest == pytest.approx(max(heights), abs=1e-6)  # measured 5.8e-8


def test_how_far_a_roller_reaches_is_symmetric():
    wheel = of_type(kind_of("youbot"))
    assert support(wheel, 1.0) == pytest.approx(0.5 * length(wheel), rel=1e-15)
    assert support(wheel, 0.0) == pytest.approx(profile_radius(wheel, 0.0), rel=1e-15)
    for sine in (0.1, 0.5, 0.9):
        assert support(wheel, sine) == pytest.approx(support(wheel, -sine), rel=1e-15)


# --- meshes ---------------------------------------------------------------------------------------


@pytest.fixture
def trimesh():
    return pytest.importorskip("trimesh", reason="needs trimesh")


@pytest.mark.parametrize("scene", SCENES)
def test_the_mesh_of_a_roller_is_closed_and_has_the_volume_and_inertia_of_the_profile(trimesh, scene):
    wheel, part = of_type(kind_of(scene)), mesh.roller(kind_of(scene))
    body = trimesh.Trimesh(*part, process=False)
    assert body.is_watertight and body.is_winding_consistent
    exact = solid(wheel)
    assert body.volume == pytest.approx(exact.volume, rel=1e-3)  # measured 2.7e-4 to 4.3e-4 below
    inertia = [exact.transverse, exact.transverse, exact.axial]
    np.testing.assert_allclose(np.diag(body.moment_inertia), inertia, rtol=1e-3)  # measured up to 8.4e-4


def test_a_pointed_roller_is_closed_as_well(trimesh):
    kind = kind_of("six_rollers").model_copy(update={"roller_distance": 0.05 * math.cos(math.pi / 6)})
    body = trimesh.Trimesh(*mesh.roller(kind), process=False)
    assert body.is_watertight and body.volume == pytest.approx(solid(of_type(kind)).volume, rel=1e-3)


@pytest.mark.parametrize("suffix", [".stl", ".obj"])
@pytest.mark.long
def test_a_whole_wheel_is_read_back_closed_with_all_its_rollers_and_a_hub(trimesh, tmp_path, suffix):
    kind, path = kind_of("youbot"), tmp_path / f"wheel{suffix}"
    mesh.write(mesh.whole(kind), path, "rolling radius 0.0475 m")
    assert b"0.0475 m" in path.read_bytes()[:80]
    body = trimesh.load(path, force="mesh")
    assert body.is_watertight and len(body.split()) == kind.roller_count + 1
    width = 2.0 * support(of_type(kind), math.sin(math.radians(45.0)))
    np.testing.assert_allclose(body.extents, [0.095, width, 0.095], atol=1e-8)  # measured 1.4e-9


@pytest.mark.parametrize("scene", SCENES)
def test_the_mesh_stands_on_the_rim_of_its_wheel(scene):
    vertices = mesh.placed(mesh.roller(kind_of(scene)), *roller_frames(kind_of(scene))[0]).vertices
    assert vertices[:, 2].min() == pytest.approx(-kind_of(scene).radius, rel=1e-12)
