"""Ground as pictures show it is the ground that wheels roll on."""

import numpy as np
import pytest
from uneven import floor

from omnisim.contact.floor import surface
from omnisim.pictures.ground import heights, mesh, normals
from omnisim.scene.scene import load

RANDOM = np.random.default_rng(5)
HILLS = (RANDOM.uniform(-0.02, 0.02, (5, 7)), (-0.5, -0.4), (0.2, 0.25))
FLOORS = {
    "bumps": floor(bumps=[(0.1, 0.0, 0.03, 0.2), (-0.2, 0.3, -0.02, 0.15)]),
    "grid": floor(grid=HILLS),
    "steps": floor(steps=[(0.0, 0.1, 0.6, 0.8, 0.02, 0.005), (0.3, 0.0, 1.0, 0.0, -0.01, 0.02)]),
    "all": floor([(0.1, 0.0, 0.03, 0.2)], [(0.0, 0.1, 0.6, 0.8, 0.02, 0.005)], HILLS),
}


@pytest.mark.parametrize("name", FLOORS)
def test_heights_and_normals_are_those_of_the_kernels(name):
    ground = FLOORS[name]
    x, y = RANDOM.uniform(-1.0, 1.2, (2, 300))
    expected = [surface(ground, *place) for place in zip(x, y, strict=True)]
    assert np.abs(heights(ground, x, y) - [found.height for found in expected]).max() < 1e-15
    slopes = np.array([[-found.slope_x, -found.slope_y, 1.0] for found in expected])
    slopes /= np.linalg.norm(slopes, axis=1, keepdims=True)
    clear = np.ones(300, bool)  # where differences do not reach across an edge
    for step in ground.steps:
        s = (x - step[0]) * step[2] + (y - step[1]) * step[3]
        clear &= (np.abs(s) > 1e-4) & (np.abs(s - step[6]) > 1e-4)
    assert np.abs(normals(ground, x, y) - slopes)[clear].max() < 1e-7  # 3e-9


def test_a_mesh_has_lines_along_the_edges_of_a_step_and_reaches_far():
    config = load("cable_duct").config
    path = np.array([[0.0, 0.0], [1.0, 0.1]])
    points = mesh(config, path, 0.38)
    assert points.shape[-1] == 3 and np.ptp(points[..., 2]) == pytest.approx(0.01, abs=1e-12)
    assert np.ptp(points[..., 0]) > 8.0 and points.shape[0] * points.shape[1] < 70_000
    ahead = points[..., :2] @ [np.cos(np.radians(30.0)), np.sin(np.radians(30.0))]
    foot = 0.45 * np.cos(np.radians(30.0))
    assert np.abs(ahead[:, 0] - foot).min() < 1e-12
    assert mesh(load("kiwi_ramp").config, path, 0.2) is None
