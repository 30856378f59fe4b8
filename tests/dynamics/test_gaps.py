"""How far the next roller is from a plane: what is kept of an earlier look never says more than there is."""

import numpy as np
import pytest
from scenes import packed, reference_scene

from omnisim.contact.common_normal import ANY
from omnisim.dynamics.spatial.gaps import least_gap
from omnisim.dynamics.spatial.pose import body_of
from omnisim.dynamics.spatial.records import ORIENTATION, POSITION
from omnisim.dynamics.spatial.seen import keep_standing
from omnisim.dynamics.spatial.touching import standing, touching
from omnisim.dynamics.state import places

SCENES = ("spatial_kiwi_slope", "spatial_double_row")
MOVES, ROUNDING = 400, 1e-12  # m
POSES = 50


def apart(parameters, stand, w, rollers):
    """The least height of these rollers of wheel w, m."""
    lobes = range(parameters.space.hubs[w].lobes)
    return min(-touching(parameters, w, stand, lobe, ANY, i).depth for i in rollers for lobe in lobes)


def moved(rng, at, y, wheels):
    """The state y after a move of any size up to some centimetres and tenths of a radian, or down to nothing."""
    size = 10.0 ** rng.uniform(-5.0, -0.7)
    y = y.copy()
    y[POSITION + 2] = max(y[POSITION + 2] + 0.1 * size * rng.normal(), 0.03)
    y[ORIENTATION : ORIENTATION + 4] += 0.3 * size * rng.normal(size=4)
    y[at.spin_angle : at.spin_angle + wheels] += size * rng.normal(size=wheels)
    return y


@pytest.mark.long
@pytest.mark.parametrize("touches", [0, 1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_what_is_kept_of_an_earlier_look_is_never_more_than_the_gap(name, touches):
    """Of all rollers of a wheel in the air, else of the neighbours of those that touch."""
    parameters, run = packed(reference_scene(name))
    at, rng, mode = places(parameters), np.random.default_rng(5), run.mode[0]
    count, rows = int(parameters.wheels[0].rollers), int(parameters.space.hubs[0].row_count)
    mode.contacts = mode.rollers = touches
    mode.roller[:2], mode.slot[:2], mode.meeting[:2] = (0, rows), (0, 1), 0
    near = {(i + step) % count for i in mode.roller[:touches] for step in range(-rows, rows + 1)}
    rollers = sorted(near - set(mode.roller[:touches].tolist())) if touches else range(count)
    y, kept = run.y, 0
    for _ in range(MOVES):
        y = moved(rng, at, y, len(parameters.wheels))
        before = float(parameters.space.stands[0].clear_height)
        body = body_of(parameters, y)
        stand = standing(parameters, 0, body, y)
        keep_standing(parameters.space.stands[0], stand)
        assert least_gap(parameters, mode, 0, body) <= max(apart(parameters, stand, 0, rollers), 0.0) + ROUNDING
        kept += float(parameters.space.stands[0].clear_height) == before
    assert MOVES / 10 < kept < MOVES * 9 / 10


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_the_next_roller_to_touch_a_plane_is_a_neighbour_of_one_that_does(name):
    """However far the wheel sinks in, up to half of it, at any tilt: what others do is asked of these alone."""
    parameters, run = packed(reference_scene(name))
    at, rng = places(parameters), np.random.default_rng(5)
    count, rows = int(parameters.wheels[0].rollers), int(parameters.space.hubs[0].row_count)
    for _ in range(POSES):
        y = moved(rng, at, run.y, len(parameters.wheels))
        stand = standing(parameters, 0, body_of(parameters, y), y)
        order = np.argsort([apart(parameters, stand, 0, [i]) for i in range(count)])
        for touches in range(1, count // 2):
            away = np.abs(order[:touches] - order[touches])
            assert np.minimum(away, count - away).min() <= rows
