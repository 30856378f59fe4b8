"""Dead reckoning of ideal wheels, and the measured robots' own formulas."""

import numpy as np
import pytest

import omnisim
from omnisim.fitting.ideal import dead_reckoned
from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows

pytestmark = pytest.mark.short


def test_a_constant_twist_is_an_arc_however_few_rows():
    """A tenth of a turn a second along 0.3 m/s: a circle of radius v / w, closed after ten seconds."""
    config = omnisim.load("youbot").config
    yaw_rate = 0.2 * np.pi
    rates = wheel_rows(config) @ [0.3, 0.0, yaw_rate]
    for rows in (11, 101):
        time = np.linspace(0.0, 10.0, rows)
        position, yaw = dead_reckoned(config, np.outer(time, rates))
        radius = 0.3 / yaw_rate
        circle = radius * np.column_stack([np.sin(yaw_rate * time), 1.0 - np.cos(yaw_rate * time)])
        np.testing.assert_allclose(position, circle, atol=1e-14)
        np.testing.assert_allclose(yaw, yaw_rate * time, atol=1e-14)


def test_without_yaw_an_arc_is_a_chord():
    config = omnisim.load("omni3").config
    time = np.linspace(0.0, 2.0, 5)
    position, yaw = dead_reckoned(config, np.outer(time, wheel_rows(config) @ [0.1, -0.2, 0.0]))
    np.testing.assert_allclose(position, np.outer(time, [0.1, -0.2]), atol=1e-15)
    np.testing.assert_allclose(yaw, 0.0, atol=1e-15)


L1 = L2 = 0.2
L = 0.195
OMNI4 = 0.03 * np.array([
    np.array([1, -1, 1, -1]) / 4, np.array([-1, -1, 1, 1]) / 4, -np.ones(4) / (2 * (L1 + L2)),
])  # fmt: skip
OMNI3 = 0.051 * np.array([
    np.array([-1, 1, 0]) / np.sqrt(3), np.array([-1, -1, 2]) / 3, -np.ones(3) / (3 * L),
])  # fmt: skip


@pytest.mark.parametrize(("name", "formula"), [("omni4", OMNI4), ("omni3", OMNI3)])
def test_the_scenes_of_the_measured_robots_have_their_authors_kinematics(name, formula):
    """vx, vy, w from wheel rates, as the authors of the data set write them; places in scenes have nine digits."""
    config = omnisim.load(name).config
    np.testing.assert_allclose(inverse(wheel_rows(config), rms_distance(config)), formula, atol=2e-9)  # 1e-9 measured
