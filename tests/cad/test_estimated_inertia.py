"""Inertias that a scene leaves out, against integrals over fine meshes of the same shapes."""

import numpy as np
import pytest
from helpers.stages import either
from roller_profiles import PROFILES, shape
from scene_text import message, replaced
from uneven import kind as roller_kind
from vehicles import VEHICLE

import omnisim
from omnisim.cad import mesh
from omnisim.cad.geometry import spheres_within
from omnisim.scene.estimates import estimates
from omnisim.scene.rollers import drawn, reach, roller_solid, thickest
from omnisim.scene.scene import packaged_scenes, packaged_wheels, parse
from omnisim.scene.solids import disk_solid
from omnisim.scene.wheel_schema import Disk, Roller

pytestmark = pytest.mark.short
STATIONS, CORNERS = 801, 640


def integrals(*parts):
    """Volume, and moments of inertia about and across z, of closed meshes: those of -1 are holes.

    By the divergence theorem every triangle makes a tetrahedron with the origin, whose vertices are 0, a, b, c:
    int 1 = det / 6, int x^2 = det / 60 (a^2 + b^2 + c^2 + ab + bc + ca).
    """
    volume, squares = 0.0, np.zeros(3)
    for sign, (vertices, faces) in parts:
        a, b, c = vertices[faces].transpose(1, 0, 2)
        det = sign * np.einsum("fi,fi->f", a, np.cross(b, c))
        volume += det.sum() / 6.0
        squares += det @ (a * a + b * b + c * c + a * b + b * c + c * a) / 60.0
    x, y, z = squares
    return volume, x + y, 0.5 * (x + y) + z


def drum(radius, low, high):
    ends = np.array([low, high])
    return mesh.revolved(ends, np.full(2, radius), ends, CORNERS)


def bored_roller(kind):
    """The profile as far as it is thicker than the bore, less the bore."""
    bore = kind.roller.bore_radius
    u, r = drawn(kind, STATIONS)
    if r[0] < bore:
        most = r.argmax()
        first, last = (np.interp(bore, r[half], u[half]) for half in (np.s_[: most + 1], np.s_[: most - 1 : -1]))
        u, r = np.array([first, *u[r > bore], last]), np.array([bore, *r[r > bore], bore])
    round_ = r > mesh.POINTED * kind.radius
    body = mesh.revolved(u[round_], r[round_], u[[0, -1]], CORNERS)
    return [(1, body)] + ([(-1, drum(bore, u[0], u[-1]))] if bore else [])


def parts_of(disk):
    half, inner = 0.5 * disk.width, 0.5 * disk.width - disk.plate_thickness
    parts = [(1, drum(disk.hub_radius, -half, half))]
    if disk.bore_radius:
        parts.append((-1, drum(disk.bore_radius, -half, half)))
    for low, high in ((-half, -inner), (inner, half)) if disk.plate_radius else ():
        parts += [(1, drum(disk.plate_radius, low, high)), (-1, drum(disk.hub_radius, low, high))]
    return parts


TYPES = {
    f"{name} {key}": kind
    for name in (*packaged_scenes(), *packaged_wheels())
    for key, kind in omnisim.load(name).config.wheel_types.items()
}


@pytest.mark.parametrize("name", either(TYPES, list(TYPES)[::8]))
def test_the_solid_of_a_packaged_roller_is_that_of_its_mesh(name):
    kind = TYPES[name]
    assert roller_solid(kind) == pytest.approx(integrals(*bored_roller(kind)), rel=1e-4)  # measured up to 3.6e-5


SHAPED_DISKS = [name for name, kind in TYPES.items() if kind.disk.hub_radius]


@pytest.mark.parametrize("name", SHAPED_DISKS)
def test_the_inertias_of_a_packaged_disk_that_has_a_shape_are_those_of_its_mesh(name):
    disk = TYPES[name].disk
    volume, axle, diameter = integrals(*parts_of(disk))
    found = disk.mass * axle / volume, disk.mass * diameter / volume
    assert (disk.inertia_axle, disk.inertia_diameter) == pytest.approx(found, rel=1e-4)  # measured up to 2.7e-5


@pytest.mark.parametrize("bore", either([0.0, 0.002, 0.007], [0.002]))
@pytest.mark.parametrize("name", PROFILES)
def test_the_solid_of_a_roller_of_any_profile_is_that_of_its_mesh(name, bore):
    kind = roller_kind(profile=shape(name), roller=Roller(bore_radius=bore))
    assert roller_solid(kind) == pytest.approx(integrals(*bored_roller(kind)), rel=1e-4)  # measured up to 4e-5


@pytest.mark.parametrize("name", PROFILES)
def test_the_mesh_of_a_roller_of_any_profile_is_closed_and_has_its_solid(name):
    trimesh = pytest.importorskip("trimesh", reason="needs trimesh")
    kind = roller_kind(profile=shape(name))
    body, solid = trimesh.Trimesh(*mesh.roller(kind), process=False), roller_solid(kind)
    assert body.is_watertight and body.is_winding_consistent
    found = body.volume, body.moment_inertia[2, 2], body.moment_inertia[0, 0]
    assert found[:2] == pytest.approx(solid[:2], rel=1e-3)
    assert found[2] == pytest.approx(solid[2], rel=5e-3)  # of points, whose middle is not that of the mesh; else 1e-3


@pytest.mark.parametrize("name", PROFILES)
def test_spheres_carry_a_wheel_nearly_as_its_rollers_do(name):
    """Those of a URDF: never farther out where an upright wheel touches, and short by little, at edges by more."""
    kind = roller_kind(profile=shape(name), roller_count=8)
    spheres = spheres_within(kind)
    sines = np.linspace(-1.0, 1.0, 201) * np.sin(np.pi / 8)
    short = reach(kind, sines) - (np.multiply.outer(sines, spheres.places) + spheres.radii).max(axis=1)
    assert short.min() > -1e-15 and len(spheres.radii) <= 9
    edged = name in ("cylinder", "sharp cylinder", "cone", "points")  # measured 0.058, 0.082, 0.027, 0.025
    assert short.max() < (0.1 if edged else 0.02) * thickest(kind)


PLATED = {"hub_radius": 0.03, "width": 0.05, "bore_radius": 0.01, "plate_radius": 0.06, "plate_thickness": 0.003}


@pytest.mark.parametrize("shape", [{"hub_radius": 0.03, "width": 0.05}, {"bore_radius": 0.01}, PLATED])
def test_the_solid_of_a_disk_is_that_of_the_meshes_of_hub_bore_and_plates(shape):
    disk = Disk(mass=0.4, **({"hub_radius": 0.03, "width": 0.05} | shape))
    assert disk_solid(disk) == pytest.approx(integrals(*parts_of(disk)), rel=1e-4)  # measured up to 3.3e-5


DISK = "disk = { mass = 0.4, inertia_axle = 4e-4, inertia_diameter = 2.2e-4 }"
SHAPED = "disk = { mass = 0.4, hub_radius = 0.03, width = 0.05, plate_radius = 0.06, plate_thickness = 0.003 }"


def test_a_disk_of_hub_and_plates_has_the_inertias_of_its_meshes_and_says_what_it_is():
    config = parse(replaced(VEHICLE, DISK, SHAPED)).config
    disk = config.wheel_types["mecanum"].disk
    volume, axle, diameter = integrals(*parts_of(disk))
    assert disk.inertia_axle == pytest.approx(0.4 * axle / volume, rel=1e-4)  # measured 1.6e-5
    assert disk.inertia_diameter == pytest.approx(0.4 * diameter / volume, rel=1e-4)  # measured 1.0e-5
    told = "a cylinder, radius 0.03 m and plates of radius 0.06 m, 0.003 m thick, 0.4 kg"
    assert told in [found.of for found in estimates(config)]


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("bore_radius", 0.03, "must be less than hub_radius = 0.03"),
        ("plate_radius", 0.03, "must be more than hub_radius = 0.03"),
        ("plate_thickness", 0.026, "must be at most width / 2 = 0.025, at each end"),
    ],
)
def test_a_disk_that_cannot_be_built_is_one_line(key, value, said):
    given = {"hub_radius": 0.03, "width": 0.05, "plate_radius": 0.06, "plate_thickness": 0.003} | {key: value}
    disk = f"disk = {{ mass = 0.4, {', '.join(f'{name} = {size}' for name, size in given.items())} }}"
    text = message(replaced(VEHICLE, DISK, disk))
    assert "\n" not in text and f"wheel_types.mecanum.disk.{key} = {value}: {said}" in text


def test_plates_need_a_hub_to_stand_on():
    plates = "disk = { mass = 0.4, inertia_axle = 4e-4, inertia_diameter = 2.2e-4, plate_radius = 0.06 }"
    text = message(replaced(VEHICLE, DISK, plates))
    assert "disk.hub_radius: missing; with plates it must be a finite number > 0" in text and "\n" not in text
