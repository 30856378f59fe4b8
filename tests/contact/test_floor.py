"""Ground that is no plane: its heights, their derivatives, and what is told of it from afar."""

import math
from itertools import pairwise

import numpy as np
import pytest
from uneven import floor

from omnisim.contact.floor import highest_around, inside_piece, pieces, surface
from omnisim.contact.patch import Coordinates, patch

BUMPS = [[0.1, 0.0, 0.012, 0.06], [0.3, 0.1, -0.01, 0.1]]
STEP = [0.5, 0.0, 0.6, 0.8, 0.005, 0.002]
HEIGHTS = np.random.default_rng(1).normal(size=(6, 7)) * 0.002
GRID = (HEIGHTS, (-0.25, -0.5), (0.125, 0.25))
UNEVEN = floor(BUMPS, [STEP], GRID)
LOW_STEP = [0.0, 0.0, 1.0, 0.0, 0.002, 0.005]
HIGH_STEP = [0.0, 0.0, 1.0, 0.0, 0.02, 0.005]


def places(count, seed=2):
    return np.random.default_rng(seed).uniform(-0.4, 0.7, size=(count, 2))


def off_lines(x, y, distance):
    """Whether a place is farther than this from all lines where derivatives jump."""
    along, across = (x + 0.25) / 0.125, (y + 0.5) / 0.25
    cells = min(abs(along - round(along)) * 0.125, abs(across - round(across)) * 0.25)
    return min(cells, inside_piece(UNEVEN, 0, x, y)) > distance


def test_derivatives_are_those_of_the_height():
    """Differences over 1e-5 m, off the edge: 3e-9 from the slopes, 2e-7 /m from the second derivatives."""
    worst, h = np.zeros(2), 1e-5
    for x, y in filter(lambda place: off_lines(*place, 2.0 * h), places(300)):
        here = surface(UNEVEN, x, y)
        by_x = np.subtract(surface(UNEVEN, x + h, y), surface(UNEVEN, x - h, y)) / (2.0 * h)
        by_y = np.subtract(surface(UNEVEN, x, y + h), surface(UNEVEN, x, y - h)) / (2.0 * h)
        bends = np.subtract([by_x[1], by_x[2], by_y[1], by_y[2]], [here.xx, here.xy, here.xy, here.yy])
        slopes = [by_x[0] - here.slope_x, by_y[0] - here.slope_y]
        worst = np.maximum(worst, [np.abs(slopes).max(), np.abs(bends).max()])
    assert worst[0] < 1e-8 and worst[1] < 1e-6


def test_a_grid_has_the_heights_of_its_nodes_exactly():
    grid = floor(grid=GRID)
    found = [[surface(grid, -0.25 + 0.125 * i, -0.5 + 0.25 * j).height for i in range(7)] for j in range(6)]
    assert np.array_equal(found, HEIGHTS)


def test_second_derivatives_are_continuous_from_cell_to_cell():
    """1e-12 m on either side of all inner lines of nodes: 2e-11 of second derivatives of 1.6 /m."""
    grid, worst, largest = floor(grid=GRID), 0.0, 0.0
    for t in np.random.default_rng(3).uniform(0.0, 1.0, 20):
        for i in range(1, 6):
            x, y = -0.25 + 0.125 * i, -0.5 + 1.25 * t
            worst = max(worst, *np.abs(np.subtract(surface(grid, x + 1e-12, y), surface(grid, x - 1e-12, y))))
            largest = max(largest, abs(surface(grid, x, y).xx))
        for j in range(1, 5):
            x, y = -0.25 + 0.75 * t, -0.5 + 0.25 * j
            worst = max(worst, *np.abs(np.subtract(surface(grid, x, y + 1e-12), surface(grid, x, y - 1e-12))))
    assert worst < 1e-9 * largest


def test_a_grid_is_level_beyond_its_border_and_meets_it_without_a_kink():
    grid = floor(grid=GRID)
    for t in (0.01, 0.3, 0.77):
        y, x = -0.5 + 1.25 * t, -0.25 + 0.75 * t
        for inside, outside in (
            ((-0.25, y), (-3.0, y)),
            ((0.5, y), (9.0, y)),
            ((x, -0.5), (x, -2.0)),
            ((x, 0.75), (x, 1.0)),
        ):
            at_border, away = surface(grid, *inside), surface(grid, *outside)
            assert (away.height, away.slope_x, away.slope_y) == (at_border.height, at_border.slope_x, at_border.slope_y)
        assert surface(grid, -3.0, y).slope_x == surface(grid, -3.0, y).xx == surface(grid, x, 7.0).slope_y == 0.0
    corner = surface(grid, 5.0, 5.0)
    assert corner.height == HEIGHTS[-1, -1] and not any(corner[1:])


def test_the_spline_of_finer_grids_approaches_a_smooth_ground_to_fourth_order():
    """cos(pi x) cos(2 pi y), level at the border: errors 1.1e-3, 6.4e-5, 3.6e-6; 17 and 18 times less."""
    errors = []
    for n in (8, 16, 32):
        x = np.linspace(0.0, 1.0, n + 1)
        grid = floor(grid=(np.cos(math.tau * x)[:, None] * np.cos(math.pi * x), (0.0, 0.0), (1.0 / n, 1.0 / n)))
        errors.append(
            max(
                abs(surface(grid, a, b).height - math.cos(math.pi * a) * math.cos(math.tau * b))
                for a, b in np.random.default_rng(4).uniform(size=(400, 2))
            )
        )
    assert all(3.9 < math.log2(a / b) < 4.3 for a, b in pairwise(errors))


def test_nothing_of_a_floor_is_above_its_highest_nor_bends_up_more_than_its_bend():
    """Without its step, whose edge has a bend of its own: 10 mm of 19 mm, 3.2 of 8.3 / m."""
    ground = floor(BUMPS, grid=GRID)
    places = np.random.default_rng(5).uniform(-0.6, 0.9, size=(4000, 2))
    found = [surface(ground, x, y) for x, y in places]
    highest = max(one.height for one in found)
    bend = max(np.linalg.eigvalsh([[one.xx, one.xy], [one.xy, one.yy]])[-1] for one in found)
    assert 0.5 * ground.highest < highest < ground.highest
    assert 0.2 * ground.bend < bend < ground.bend
    assert UNEVEN.highest == pytest.approx(ground.highest + 0.005, abs=1e-15) and UNEVEN.stairs == 0.005


def test_nothing_around_a_place_is_above_what_is_highest_there():
    """Far from all bumps that is level ground; at the top of one, it is that top."""
    ground = floor(BUMPS)
    for x, y in np.random.default_rng(6).uniform(-0.6, 0.9, size=(100, 2)):
        over = highest_around(ground, x, y, 0.03)
        near = [(x + 0.03 * r * math.cos(a), y + 0.03 * r * math.sin(a)) for r in (0.0, 0.5, 1.0) for a in range(6)]
        assert max(surface(ground, *place).height for place in near) <= over <= ground.highest
    assert abs(highest_around(ground, 9.0, 9.0, 0.03)) < 1e-15  # measured 1.3e-18 m
    assert highest_around(ground, 0.1, 0.0, 0.03) == ground.highest == 0.012


def test_a_low_step_is_an_arc_from_its_line_to_level_ground():
    """height 2 mm, edge 5 mm: w = sqrt(h (2 e - h)) = 4 mm."""
    step = floor(steps=[LOW_STEP])
    assert [surface(step, s, 9.0).height for s in (-1.0, -1e-15, 0.004, 1.0)] == [0.0, 0.0, 0.002, 0.002]
    for s in (1e-12, 0.001, 0.0025, 0.004 - 1e-12):
        assert surface(step, s, 9.0).height == pytest.approx(-0.003 + math.sqrt(0.005**2 - (0.004 - s) ** 2), abs=1e-17)
    assert surface(step, 0.004 - 1e-9, 0.0).slope_x == pytest.approx(1e-9 / 0.005, rel=1e-6)


def test_a_high_step_is_an_arc_over_a_vertical_face():
    step = floor(steps=[HIGH_STEP])
    assert surface(step, -1e-15, 0.0).height == 0.0
    assert surface(step, 1e-15, 0.0).height == pytest.approx(0.015, abs=1e-8)
    on_arc = surface(step, 0.005 * (1.0 - math.sin(0.3)), 0.0)
    assert on_arc.height == pytest.approx(0.015 + 0.005 * math.cos(0.3), abs=1e-17)


def test_a_step_down_is_the_same_step_from_the_other_side():
    """Down by 2 mm along x is up by 2 mm along -x, from a floor 2 mm lower; the line is the foot of both."""
    down = floor(steps=[[0.1, 0.2, 0.6, 0.8, -0.002, 0.005]])
    up = floor(steps=[[0.1, 0.2, -0.6, -0.8, 0.002, 0.005]])
    for x, y in places(50):
        assert surface(down, x, y).height == pytest.approx(surface(up, x, y).height - 0.002, abs=1e-18)
        assert surface(down, x, y)[1:] == surface(up, x, y)[1:]
    assert surface(down, -1.0, 0.0).height == 0.0 and surface(down, 1.0, 0.2).height == -0.002


def test_parts_of_a_floor_add_up():
    alone = [floor(BUMPS), floor(steps=[STEP]), floor(grid=GRID)]
    for x, y in places(50):
        total = np.sum([surface(one, x, y) for one in alone], axis=0)
        assert np.allclose(surface(UNEVEN, x, y), total, rtol=0.0, atol=1e-13)


def test_every_place_is_in_one_piece():
    """Where two edges cross, in the first; of a step with a face, places before its line are not asked for its edge."""
    crossing = floor(steps=[STEP, [0.5, 0.0, 0.0, 1.0, 0.02, 0.003]])
    assert pieces(crossing) == 3
    counts = [0, 0, 0]
    for x, y in np.random.default_rng(6).uniform((0.49, -0.01), (0.51, 0.01), size=(500, 2)):
        beyond_lines = [True, (x - 0.5) * 0.6 + y * 0.8 > 0.0, y > 0.0]
        inside = [k for k in range(3) if beyond_lines[k] and inside_piece(crossing, k, x, y) > 0.0]
        assert len(inside) == 1
        counts[inside[0]] += 1
    assert min(counts) > 20


@pytest.mark.parametrize("piece", [0, 1])
def test_a_patch_is_the_surface_with_its_tangents_and_their_derivatives(piece):
    """Differences over 1e-6: 2e-9 from all derivatives, which are about 1."""
    h, worst = 1e-6, 0.0
    for a, b in np.random.default_rng(7).uniform((0.1, -0.02), (1.0, 0.02), size=(50, 2)):
        at = Coordinates(a, b)
        here = patch(UNEVEN, piece, at)
        first = [patch(UNEVEN, piece, Coordinates(a + d, b)) for d in (h, -h)]
        last = [patch(UNEVEN, piece, Coordinates(a, b + d)) for d in (h, -h)]
        if piece:
            assert surface(UNEVEN, here.point.x, here.point.y).height == pytest.approx(here.point.z, abs=1e-15)
        elif inside_piece(UNEVEN, 0, *here.point[:2]) < 1e-5:
            continue
        for pair, along, p_rate, q_rate in (
            (first, here.reach * np.array(here.p), here.p_first, here.q_first),
            (last, np.array(here.q), here.p_last, here.q_last),
        ):
            for index, rate in ((0, along), (1, p_rate), (2, q_rate)):
                found = np.subtract(pair[0][index], pair[1][index]) / (2.0 * h)
                worst = max(worst, float(np.abs(found - rate).max()))
    assert worst < 2e-8
