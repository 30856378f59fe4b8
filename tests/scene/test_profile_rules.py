"""Profiles that cannot be, or do not fit: one line for each, with file, line, key and what is allowed."""

import pytest
from scene_text import message

from omnisim.scene.scene import parse

pytestmark = pytest.mark.short
SCENE = """\
schema = 1
scene = { upright = "free" }
time = { end = 0.1, step = 1e-4 }
friction = { law = "none" }
chassis = { mass = 5.0, center_of_mass = [0.0, 0.0, 0.1], inertia = [0.05, 0.05, 0.06] }

[wheel_types.omni]
radius = 0.05
roller_distance = 0.042
roller_count = 8
roller_angle_deg = 0.0
disk = { mass = 0.2, hub_radius = 0.03, width = 0.03 }
roller = { density = 1100.0, bore_radius = 0.002 }
contact = { stiffness = 1e5, damping = 60.0 }
profile = PROFILE

[[wheels]]
name = "front"
type = "omni"
position = [0.2, 0.0]

[[wheels]]
name = "left"
type = "omni"
position = [-0.1, 0.15]

[[wheels]]
name = "right"
type = "omni"
position = [-0.1, -0.15]
"""
GOOD = {
    "cylinder": 'kind = "cylinder", radius = 0.008, half_length = 0.009, edge_radius = 0.001',
    "capsule": 'kind = "capsule", radius = 0.008, half_length = 0.011',
    "sphere": 'kind = "sphere", radius = 0.008',
    "cone": 'kind = "cone", radius = 0.008, end_radius = 0.005, half_length = 0.01',
    "stepped": 'kind = "stepped", radii = [0.008, 0.006], lengths = [0.005, 0.004]',
    "points": 'kind = "points", axial = [-0.01, -0.004, 0.003, 0.01], radius = [0.005, 0.0075, 0.008, 0.0055]',
}
# of a profile: what is changed, into what, the key that is told of, and what is said
BAD = [
    ("cylinder", "radius = 0.008, ", "", "profile.radius", 'missing; must be a finite number > 0; of "points" a list'),
    (
        "sphere",
        "radius = 0.008",
        "radius = [0.008]",
        "profile.radius",
        "must be a finite number > 0 with kind = 'sphere'",
    ),
    (
        "points",
        "radius = [0.005, 0.0075, 0.008, 0.0055]",
        "radius = 0.008",
        "profile.radius",
        "must be a list of finite",
    ),
    (
        "sphere",
        "radius = 0.008",
        "radius = 0.008, half_length = 0.01",
        "profile.half_length",
        "not a key of a profile with",
    ),
    ("sphere", "radius = 0.008", "raduis = 0.008", "profile.raduis", "unknown key; did you mean 'radius'?"),
    ("cylinder", '"cylinder"', '"cylindre"', "profile.kind", "did you mean 'cylinder'?"),
    ("cylinder", "edge_radius = 0.001", "edge_radius = 0.0085", "profile.edge_radius", "at most radius = 0.008"),
    (
        "capsule",
        "half_length = 0.011",
        "half_length = 0.007",
        "profile.half_length",
        "at least radius = 0.008: it includes",
    ),
    ("cone", "end_radius = 0.005", "end_radius = 0.008", "profile.end_radius", "must be less than radius = 0.008"),
    (
        "stepped",
        "[0.008, 0.006]",
        "[0.006, 0.008]",
        "profile.radii[1]",
        "less than the radius before it, 0.006: steps go down",
    ),
    ("stepped", "[0.005, 0.004]", "[0.005]", "profile.lengths", "must be as many as radii, 2, not 1"),
    ("stepped", "[0.008, 0.006]", "[]", "profile.radii", "must be a list of 1 to 8 finite numbers > 0"),
    (
        "points",
        "[-0.01, -0.004, 0.003, 0.01]",
        "[-0.01, 0.004, 0.003, 0.01]",
        "profile.axial[2]",
        "greater than the one before it, 0.004: points do not fold back",
    ),
    ("points", "[-0.01, -0.004, 0.003, 0.01]", "[0.0, 0.004, 0.006, 0.01]", "profile.axial", "from below 0 to above 0"),
    (
        "points",
        "[0.005, 0.0075, 0.008, 0.0055]",
        "[0.005, 0.006, 0.008, 0.0055]",
        "profile.radius[1]",
        "above 0.00638462, the line between its neighbours",
    ),
    (
        "points",
        "[0.005, 0.0075, 0.008, 0.0055]",
        "[0.005, 0.008, 0.0055]",
        "profile.radius",
        "must be as many as axial, 4, not 3",
    ),
    (
        "points",
        "[-0.01, -0.004, 0.003, 0.01]",
        "[-0.01, 0.01]",
        "profile.axial",
        "must be a list of 3 to 20 finite numbers",
    ),
    (
        "capsule",
        "half_length = 0.011",
        "half_length = 0.03",
        "profile",
        "too wide for 8 in a row: neighbours overlap by 0.0",
    ),
]


def scene(profile):
    return SCENE.replace("PROFILE", f"{{ {profile} }}")


@pytest.mark.parametrize("name", GOOD)
def test_a_profile_that_fits_is_taken(name):
    assert parse(scene(GOOD[name])).config.wheel_types["omni"].profile.kind == name


@pytest.mark.parametrize(("name", "old", "new", "key", "said"), BAD)
def test_a_profile_that_cannot_be_is_told_of_in_one_line(name, old, new, key, said):
    assert old in GOOD[name]
    lines = message(scene(GOOD[name].replace(old, new))).splitlines()
    assert len(lines) == 1 and f":15: wheel_types.omni.{key}" in lines[0] and said in lines[0], lines


def test_a_gap_that_drops_the_wheel_onto_its_hub_is_told_of():
    """Three spheres on a ring: halfway between two the wheel stands on its hub."""
    text = scene('kind = "sphere", radius = 0.008').replace("roller_count = 8", "roller_count = 3")
    (line,) = message(text).splitlines()
    assert (
        "wheel_types.omni.disk.hub_radius = 0.03: between two rollers the wheel drops to 0.029 m, onto its hub" in line
    )


def test_exact_rollers_that_are_cut_short_are_told_of_as_well():
    """Each over 5 of its 22.5 deg on either side, and of 60: between two the wheel stands on their rims."""
    text = scene('kind = "exact"').replace("roller_angle_deg", "covered_deg = 5.0\nroller_angle_deg")
    assert parse(text.replace("radius = 0.03", "radius = 0.02")).config.wheel_types["omni"].covered_deg == 5.0
    (line,) = message(text.replace("roller_count = 8", "roller_count = 3")).splitlines()
    assert "hub_radius = 0.03: between two rollers the wheel drops to 0.02868 m, onto its hub" in line


def test_a_bore_wider_than_its_roller_and_rollers_that_reach_the_axle_are_told_of():
    assert "less than 0.008, the roller's own radius" in message(scene(GOOD["sphere"]).replace("0.002", "0.009"))
    text = scene('kind = "sphere", radius = 0.043')
    assert "0.043 m thick on a ring of 0.042 m: rollers reach the axle" in message(text)


def test_rows_that_overlap_are_told_of():
    """Spheres of 8 mm, 7.3 mm apart along the ring (2 x 42 mm x sin 5 deg), 4 or 20 mm along the axle."""
    text = scene(GOOD["sphere"]).replace("roller_angle_deg", "rows = [{ offset = 0.004 }, ROW]\nroller_angle_deg")
    (line,) = message(text.replace("ROW", "{ phase_deg = 10.0 }")).splitlines()
    assert "wheel_types.omni.rows" in line and "rollers of two rows overlap by 0.00766 m; expected offsets" in line
    assert parse(text.replace("ROW", "{ offset = -0.016, phase_deg = 10.0 }")).config.wheel_types["omni"].rollers == 16


def test_upright_machines_have_the_exact_profile_alone():
    text = scene(GOOD["sphere"]).replace('"free"', '"servo"')
    assert "wheel_types.omni.profile = {kind = 'sphere', radius = 0.008}: is of machines free in space" in message(text)
