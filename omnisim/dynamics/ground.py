"""From the floor of a scene to that of the kernels."""

import numpy as np

from omnisim.base.trigonometry import exact_cos_sin
from omnisim.contact.floor import Floor, floor_of
from omnisim.scene.heights import heights_of
from omnisim.scene.schema import Config


def floor_of_scene(config: Config) -> Floor | None:
    """The Floor of a scene; None if it is a plane."""
    floor = config.floor
    if floor.is_plane:
        return None
    steps = [(*step.point, *exact_cos_sin(step.direction_deg), step.height, step.edge_radius) for step in floor.steps]
    grid = floor.grid
    heights = np.zeros((0, 0)) if grid is None else heights_of(grid.file)
    place = ((0.0, 0.0), (1.0, 1.0)) if grid is None else (grid.origin, grid.spacing)
    return floor_of(np.array(floor.bumps), np.array(steps), heights, *place)
