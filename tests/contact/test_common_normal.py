"""Where a roller touches uneven ground: against constructed contacts, closed forms, and searches of another kind."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize
from uneven import AHEAD, BEHIND, WITHIN, barrel, exact_roller, floor, placed, unit, vec

from omnisim.contact.common_normal import ANY, Roller, look, room, touch
from omnisim.contact.floor import surface
from omnisim.contact.patch import Coordinates
from omnisim.contact.support import support

MECANUM, OMNI = exact_roller(0.05, 0.039, 6, 45.0), exact_roller(0.05, 0.04, 9, 0.0)
BARREL, BALL = barrel(0.011, 0.06, 0.015), barrel(0.012, 0.012, 0.0119)
ROLLERS = {"mecanum": MECANUM, "omni": OMNI, "barrel": BARREL}
RANDOM = np.random.default_rng(1)
HILLS = floor(grid=(RANDOM.normal(size=(6, 7)) * 0.004, (-0.3, -0.3), (0.1, 0.12)))
GROUNDS = {
    "bump": floor([[0.0, 0.0, 0.012, 0.06]]),
    "steep bump": floor([[0.0, 0.0, 0.03, 0.05]]),
    "pit wider than rollers are long": floor([[0.0, 0.0, -0.01, 0.06]]),
    "hills": HILLS,
}
LOW, HIGH = [0.5, 0.0, 0.6, 0.8, 0.002, 0.005], [0.5, 0.0, 0.6, 0.8, 0.02, 0.003]
EDGES = {
    "low step": (floor(steps=[LOW]), 0.92),
    "high step": (floor(steps=[HIGH]), 1.57),
    "step on a hill": (floor([[0.5, 0.0, 0.02, 0.15]], [LOW]), 0.92),
}


def axes(count, seed=2):
    """Random axes, up to 30 deg from the horizontal."""
    random = np.random.default_rng(seed)
    z, turn = random.uniform(-0.5, 0.5, count), random.uniform(0.0, math.tau, count)
    return np.stack([np.sqrt(1.0 - z * z) * np.cos(turn), np.sqrt(1.0 - z * z) * np.sin(turn), z], axis=1)


def touched(ground, piece, roller, centre, axis, region=ANY):
    return touch(ground, piece, roller, region, vec(centre), vec(axis))


def errors(ground, piece, roller, axis, at, depth):
    """By how much depth (m) and normal of a contact made at `at` are missed; its region."""
    centre, nu, region = placed(ground, piece, at, roller, axis, depth)
    found = touched(ground, piece, roller, centre, axis)
    assert found.converged and found.region == region
    assert room(ground, piece, Roller(roller, vec(centre), vec(axis))) == 0.0 or depth < 0.0
    return abs(found.depth - depth), float(np.abs(np.array(found.nu) - nu).max())


@pytest.mark.parametrize("roller", ROLLERS.values(), ids=ROLLERS.keys())
@pytest.mark.parametrize("ground", GROUNDS.values(), ids=GROUNDS.keys())
def test_a_contact_that_is_made_on_smooth_ground_is_found_again(ground, roller):
    """Apart and overlapping by up to 0.3 mm, on the profile and on both rims: 2e-17 m, 8e-16 in the normal."""
    random = np.random.default_rng(3)
    worst = np.zeros(2)
    for axis in axes(400):
        at, depth = Coordinates(*random.uniform(-0.12, 0.12, 2)), random.uniform(-3e-4, 3e-4)
        worst = np.maximum(worst, errors(ground, 0, roller, axis, at, depth))
    assert worst[0] < 1e-15 and worst[1] < 1e-13


@pytest.mark.parametrize("roller", ROLLERS.values(), ids=ROLLERS.keys())
@pytest.mark.parametrize("edge", EDGES.values(), ids=EDGES.keys())
def test_a_contact_that_is_made_on_an_edge_is_found_again(edge, roller):
    """1.2e-16 m, 3e-14 in the normal, which turns once over 5 mm."""
    ground, most = edge
    random = np.random.default_rng(4)
    worst = np.zeros(2)
    for axis in axes(400):
        at, depth = Coordinates(random.uniform(0.0, most), random.uniform(-0.05, 0.05)), random.uniform(-3e-4, 3e-4)
        worst = np.maximum(worst, errors(ground, 1, roller, axis, at, depth))
    assert worst[0] < 1e-15 and worst[1] < 1e-12


def test_the_jacobian_of_newton_is_that_of_its_residual():
    """Differences over 1e-6: 2e-10 of entries of about 1, on ground and on an edge, profile and rims."""
    ground, h, worst = floor([[0.4, 0.1, 0.012, 0.1]], [LOW], (np.ones((3, 3)), (0.0, 0.0), (0.3, 0.3))), 1e-6, 0.0
    random = np.random.default_rng(5)
    for axis in axes(200):
        for piece in (0, 1):
            first = random.uniform(0.1, 0.8) if piece else random.uniform(0.3, 0.45)
            at, centre = Coordinates(first, random.uniform(-0.02, 0.02)), vec(random.normal((0.48, 0.0, 1.02), 0.004))
            roller = Roller(OMNI, centre, vec(axis))
            here = look(ground, piece, roller, ANY, at)
            pairs = [
                [look(ground, piece, roller, ANY, Coordinates(at.first + s * a, at.last + s * b)) for s in (1, -1)]
                for a, b in ((h, 0.0), (0.0, h))
            ]
            if len({one.low.region for pair in pairs for one in pair}) > 1:
                continue  # a kink between
            (ff, lf), (fl, ll) = (((p.first - m.first) / (2 * h), (p.last - m.last) / (2 * h)) for p, m in pairs)
            entries = here.first_first, here.last_first, here.first_last, here.last_last
            worst = max(worst, float(np.abs(np.subtract(entries, (ff, lf, fl, ll))).max()))
    assert worst < 1e-8


def test_a_ball_on_a_bump_is_as_deep_as_the_nearest_point_of_a_fine_mesh_says():
    """Its middle searched on meshes of 401 x 401 that shrink around the nearest point: 4e-18 m."""
    ground, worst = GROUNDS["bump"], 0.0
    for x, y in np.random.default_rng(6).uniform(-0.08, 0.08, size=(8, 2)):
        centre = np.array([x, y, surface(ground, x, y).height + 0.0121])
        found = touched(ground, 0, BALL, centre, unit([0.6, -0.8, 0.05]))
        middle, half = np.array([x, y]), 0.02
        while half > 1e-9:
            grid = np.stack(np.meshgrid(*(m + np.linspace(-half, half, 401) for m in middle)), axis=-1).reshape(-1, 2)
            heights = 0.012 * np.exp(-(grid**2).sum(axis=1) / 0.06**2)
            distances = np.sqrt(((grid - centre[:2]) ** 2).sum(axis=1) + (heights - centre[2]) ** 2)
            middle, half = grid[distances.argmin()], 0.02 * half
        worst = max(worst, abs(found.depth - (0.012 - distances.min())))
    assert worst < 1e-9


def test_on_an_inclined_plane_it_is_the_closed_form_of_a_plane():
    """A ramp of 0.3 in the middle of a grid, whose border is too far away to matter: 1.5e-15 m."""
    x = np.arange(61) * 0.05
    ramp = floor(grid=(np.broadcast_to(0.3 * x, (61, 61)), (-1.5, -1.5), (0.05, 0.05)))
    nu, worst = unit([-0.3, 0.0, 1.0]), 0.0
    regions = set()
    for axis in axes(100):
        centre = np.array([0.02, -0.03, 0.45 + 0.3 * 0.02]) + 0.0105 * nu
        found = touched(ramp, 0, OMNI, centre, axis)
        tilt = float(nu @ axis)
        low = support(OMNI, found.region, tilt, math.sqrt(1.0 - tilt**2))
        expected = low.r * math.sqrt(1.0 - tilt**2) - low.u * tilt - 0.0105
        worst = max(worst, abs(found.depth - expected), abs(found.tilt - tilt))
        regions.add(found.region)
    assert worst < 1e-13 and regions == {BEHIND, WITHIN, AHEAD}


@pytest.mark.parametrize(
    ("roller", "name"),
    [(OMNI, "bump"), *(pytest.param(MECANUM, name, marks=pytest.mark.long) for name in ("steep bump", "hills"))],
)
def test_apart_it_is_the_shortest_way_between_both_surfaces_as_a_search_finds_it(roller, name):
    """A search over u (by the tilt there) and angle on the roller, x and y on the ground, from 20 starts: 1.6e-13 m."""
    ground, worst = GROUNDS[name], 0.0
    random = np.random.default_rng(7)
    for axis in axes(3, seed=8):
        x, y = random.uniform(-0.06, 0.06, 2)
        centre, _, _ = placed(ground, 0, Coordinates(x, y), roller, axis, -1e-3)
        side = unit(np.cross(axis, (0.0, 0.0, 1.0)))
        down = np.cross(axis, side)

        def squared(at, axis=axis, centre=centre, side=side, down=down):
            tilt, turn, x, y = at
            low = support(roller, WITHIN, tilt, math.sqrt(1.0 - tilt * tilt))
            point = centre + low.u * axis + low.r * (math.cos(turn) * down + math.sin(turn) * side)
            return 1e6 * float(((point - (x, y, surface(ground, x, y).height)) ** 2).sum())  # mm^2

        starts = random.normal((0.0, 0.0, x, y), (0.1, 1.0, 0.01, 0.01), size=(20, 4))
        limits = [(roller.tilts[2], roller.tilts[1]), (None, None), (None, None), (None, None)]
        tight = {"ftol": 1e-16, "gtol": 1e-12}
        nearest = min(minimize(squared, start, bounds=limits, options=tight).fun for start in starts)
        worst = max(worst, abs(1e-3 * math.sqrt(nearest) + touched(ground, 0, roller, centre, axis).depth))
    assert worst < 1e-11


def test_a_roller_along_an_edge_is_apart_from_it_by_axis_to_axis_less_both_radii():
    """A cylinder (an arc of 100 m) before and over a step: 5e-15 m."""
    cylinder, ground = barrel(0.01, 100.0, 0.02), floor(steps=[HIGH])
    along, up_step, worst = np.array([-0.8, 0.6, 0.0]), np.array([0.6, 0.8, 0.0]), 0.0
    edge = np.array([0.5, 0.0, 0.017]) + 0.003 * up_step  # a point of the edge's axis
    for angle in (0.05, 0.4, 0.9, 1.3, 1.55):
        for depth in (-1e-3, 2e-4):
            away = math.cos(angle) * np.array([0.0, 0.0, 1.0]) - math.sin(angle) * up_step
            found = touched(ground, 1, cylinder, edge + (0.013 - depth) * away + 0.03 * along, along)
            assert found.converged and found.inside > 0.0
            worst = max(worst, abs(found.depth - depth), float(np.abs(np.array(found.nu) - away).max()) * 0.01)
    assert worst < 1e-13


def test_a_roller_that_runs_into_a_wall_touches_its_face():
    """Its axis 12 mm above the floor, below the arc of a step of 20 mm: depth 0.1 mm, normal against the step."""
    cylinder, ground = barrel(0.01, 100.0, 0.02), floor(steps=[HIGH])
    centre = np.array([0.5, 0.0, 0.012]) - 0.0099 * np.array([0.6, 0.8, 0.0])
    found = touched(ground, 1, cylinder, centre, (-0.8, 0.6, 0.0))
    assert found.converged and found.inside > 0.0
    assert found.depth == pytest.approx(1e-4, abs=1e-14)
    assert found.nu == pytest.approx((-0.6, -0.8, 0.0), abs=1e-15)
    assert found.point.z == pytest.approx(0.012, abs=1e-15)


def test_a_roller_at_the_foot_of_a_step_touches_the_ground_and_the_edge_at_once():
    """Radius 10 mm, sunk by 0.1 mm into both: its axis is where both say, and neither hides the other."""
    cylinder, ground = barrel(0.01, 100.0, 0.02), floor(steps=[LOW])
    below, reach = 0.0099 + 0.003, 0.0149  # edge axis 3 mm below the floor, 5 mm radius
    s = 0.004 - math.sqrt(reach**2 - below**2)
    centre = np.array([0.5 + 0.6 * s, 0.8 * s, 0.0099])
    found = [touched(ground, piece, cylinder, centre, (-0.8, 0.6, 0.0)) for piece in (0, 1)]
    assert [one.depth for one in found] == pytest.approx([1e-4, 1e-4], abs=1e-13)
    assert all(one.converged and one.inside > 0.0 for one in found)
    assert found[0].nu == (0.0, 0.0, 1.0) and found[1].nu.z == pytest.approx(below / reach, abs=1e-14)


def test_a_contact_goes_over_from_an_edge_to_the_ground_above_without_a_jump():
    """On either side of the end of the arc, 1e-6 m from it, both pieces have the same contact, one of them inside."""
    for ground, _ in EDGES.values():
        for axis in axes(20, seed=9):
            centre, nu, _ = placed(ground, 1, Coordinates(0.0, 0.01), OMNI, axis, 1e-4)
            for dx in (-1e-6, 1e-6):
                found = [
                    touched(ground, piece, OMNI, centre + dx * np.array([0.6, 0.8, 0.0]), axis) for piece in (0, 1)
                ]
                assert sum(one.inside > 0.0 for one in found) == 1  # it is on one of them, never on both or none
                assert abs(found[0].depth - found[1].depth) < 1e-9 and np.abs(np.array(found[0].nu) - nu).max() < 1e-3


def test_in_a_frozen_region_the_contact_goes_on_smoothly():
    """Tilted over its rim in steps of 1e-4 rad: the depth in the profile's region has third differences of 3e-15 m, and
    in whichever region holds the lowest point of 1e-10 m, which is a kink."""

    def at_angle(angle, region):
        axis = np.array([math.cos(angle), 0.0, math.sin(angle)])
        return touched(GROUNDS["bump"], 0, OMNI, np.array([0.0, 0.0, 0.012 + 0.0099]), axis, region)

    start = next(angle for angle in np.arange(0.3, 1.0, 1e-3) if at_angle(angle, ANY).region == BEHIND)
    angles = start + 1e-4 * np.arange(-15, 6)
    jumps = [np.abs(np.diff([at_angle(angle, region).depth for angle in angles], 3)).max() for region in (WITHIN, ANY)]
    assert jumps[0] < 1e-13 < 1e-11 < jumps[1]


def test_of_several_common_normals_in_a_narrow_pit_the_deepest_is_found():
    """A roller that reaches both walls of a pit: as deep as any that 400 looks from around it are near."""
    ground = floor([[0.0, 0.0, -0.02, 0.03]])
    assert ground.hollow * 0.089 > 1.0
    for axis in axes(10, seed=10) * (1.0, 1.0, 0.3):
        axis, centre = unit(axis), np.array([0.002, -0.001, surface(ground, 0.0, 0.0).height + 0.0145])
        found = touched(ground, 0, MECANUM, centre, axis)
        assert found.converged
        roller, deepest = Roller(MECANUM, vec(centre), vec(axis)), -math.inf
        for x, y in np.random.default_rng(11).uniform(-0.03, 0.03, size=(400, 2)):
            here = look(ground, 0, roller, ANY, Coordinates(x, y))
            if math.hypot(here.first, here.last) < 1e-5:  # about a common normal
                deepest = max(deepest, -float(np.dot(here.gap, here.low.nu)))
        assert found.depth > deepest - 1e-6


def test_what_is_told_to_have_room_does_not_touch():
    """Of 2000 rollers above hills and before a step none that touches is told to; of the 1803 others 1604 are."""
    ground, random, clear, apart = floor([[0.5, 0.1, 0.012, 0.06]], [LOW]), np.random.default_rng(12), 0, 0
    for axis in axes(1000, seed=13):
        centre = random.uniform((0.4, -0.1, 0.0), (0.6, 0.2, 0.08))
        for piece in (0, 1):
            told = room(ground, piece, Roller(OMNI, vec(centre), vec(axis))) > 0.0
            found = touched(ground, piece, OMNI, centre, axis)
            touches = found.converged and found.inside > 0.0 and found.depth > 0.0
            assert not (told and touches)
            clear, apart = clear + told, apart + (not touches)
    assert clear > 0.6 * apart


def test_the_room_above_a_level_top_ends_where_a_roller_touches_it():
    """So that an event has a root to find there, not a jump."""
    ground, height = floor([], [LOW]), 0.05
    for axis in axes(20, seed=14):
        deep = touched(ground, 0, OMNI, (1.0, 0.0, height), axis).depth
        roller = Roller(OMNI, vec((1.0, 0.0, height + deep + 1e-9)), vec(axis))
        assert abs(room(ground, 0, roller) - 1e-9) < 1e-16, axis
        assert room(ground, 0, roller._replace(centre=vec((1.0, 0.0, height + deep - 1e-9)))) == 0.0


def test_a_roller_that_is_nowhere_has_no_contact():
    found = touch(GROUNDS["hills"], 0, OMNI, ANY, vec((math.nan, 0.0, 0.0)), vec((1.0, 0.0, 0.0)))
    assert not found.converged
    assert not touch(EDGES["low step"][0], 1, OMNI, ANY, vec((math.nan, 0.0, 0.0)), vec((1.0, 0.0, 0.0))).converged
