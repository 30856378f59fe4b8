"""Named paths, and what an environment makes of a table."""

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="needs Gymnasium: pip install -e '.[test]'")
path = pytest.importorskip("omnisim.gym").path
paths = pytest.importorskip("omnisim.gym.paths")
pytestmark = pytest.mark.short
LENGTHS = {"line": 2.0, "square": 4.0, "circle": np.pi, "figure_eight": 6.0972}  # of size 1, m; Gerono's from a table


@pytest.mark.parametrize("name", LENGTHS)
def test_a_named_path_has_its_length_and_takes_the_time_of_its_speed(name):
    table = path(name, size=2.0, speed=0.8)
    steps = np.linalg.norm(np.diff(table[:, 1:3], axis=0), axis=1)
    assert abs(steps.sum() / (2.0 * LENGTHS[name]) - 1.0) < 1e-5  # measured: 2.4e-6
    assert abs(table[-1, 0] - 1.5 * 2.0 * LENGTHS[name] / 0.8) < 1e-3
    speeds = steps / np.diff(table[:, 0])
    assert 0.799 < speeds.max() <= 0.8 and speeds[[0, -1]].max() < 0.02


@pytest.mark.parametrize("name", LENGTHS)
def test_a_named_path_begins_at_the_origin_in_the_direction_of_x(name):
    table = path(name)
    assert np.abs(table[0]).max() < 1e-15
    assert np.hypot(*table[-1, 1:3]) < 1e-12 or name == "line"


@pytest.mark.parametrize("name", ["circle", "figure_eight"])
def test_the_heading_of_a_round_path_is_its_direction(name):
    table = path(name)[100:-100]
    along = np.diff(table[:, 1:3], axis=0)
    heading = (table[1:, 3] + table[:-1, 3]) / 2.0
    across = along[:, 1] * np.cos(heading) - along[:, 0] * np.sin(heading)
    assert np.abs(across / np.linalg.norm(along, axis=1)).max() < 1e-3  # rad, of rows 5 mm apart; measured: 1.8e-4


def test_rates_and_what_lies_ahead_are_those_of_the_table():
    table = path("circle")
    found = paths.sampled(table, 0.02, (0.1, 5.0))
    assert found.steps == 472 and found.poses.shape == (473, 3, 3) and found.rates.shape == (473, 3)
    poses = found.poses[:, 0]
    assert np.abs(found.poses[:-5, 1] - poses[5:]).max() < 1e-14  # measured: 9e-16
    assert np.array_equal(found.poses[-1, 2], table[-1, 1:])  # it rests at its end
    moved = np.cumsum(0.02 * found.rates, axis=0)
    assert np.abs(moved[:-1] - 0.01 * found.rates[:-1] - poses[:-1]).max() < 1e-4  # trapezoids; measured: 2.5e-5


@pytest.mark.parametrize("options", [{"size": 0.0}, {"size": np.inf}, {"speed": -1.0}, {"speed": "fast"}])
def test_a_size_and_a_speed_are_above_zero(options):
    with pytest.raises(ValueError, match="must be a finite number > 0"):
        path("circle", **options)
