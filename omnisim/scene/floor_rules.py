"""The rules of ground that is no plane, and what is doubtful about it."""

import math
from collections.abc import Iterator

import numpy as np

from omnisim.scene.heights import heights_of
from omnisim.scene.problems import Problem
from omnisim.scene.rollers import bending, thickest
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath

SKIRT = 4.0 * math.exp(-1.5)  # curvature of a bump where it is hollow most, by height / radius^2


def floor_rules(config: Config) -> Iterator[Problem]:
    """Only machines free in space stand on it."""
    if config.upright == "free":
        return
    for key in ("bumps", "grid", "steps"):
        if key in config.floor.model_fields_set:
            yield Problem(("floor", key), 'is for machines free in space: it needs upright = "free" in [scene]')


def narrow_bumps(config: Config) -> Iterator[Problem]:
    """No bump is thinner than a roller, no pit narrower."""
    most = max((thickest(kind) for kind in config.wheel_types.values()), default=0.0)
    for index, (_, _, height, radius) in enumerate(config.floor.bumps):
        if radius < most:
            what = "bump" if height > 0.0 else "pit"
            allowed = f"at least {most:g}, that of a roller, which touches a narrower {what} in several places"
            yield Problem(("floor", "bumps", index, 3), f"radius of a {what}; must be {allowed}")


def hollow_ground(config: Config) -> Iterator[Problem]:
    """Ground that is more hollow than rollers are curved along their axis: it may meet one in several places."""
    if config.upright != "free":
        return
    longest = max(bending(kind) for kind in config.wheel_types.values())
    grid = config.floor.grid
    hollows: list[tuple[KeyPath, float]] = [
        (("floor", "bumps", i), (-2.0 if height < 0.0 else SKIRT) * height / radius**2)
        for i, (_, _, height, radius) in enumerate(config.floor.bumps)
    ]
    if grid is not None:
        hollows.append((("floor", "grid", "spacing"), steepest_bend(heights_of(grid.file), grid.spacing)))
    for path, hollow in hollows:
        if hollow * longest > 1.0:
            expected = f"at least {longest:.3g} m, that of the rollers along their axes"
            why = "else one may touch in several places, of which only the deepest carries"
            message = f"its hollow is curved with a radius of {1.0 / hollow:.3g} m; expected {expected}: {why}"
            yield Problem(path, message)


def steepest_bend(heights: np.ndarray, spacing: tuple[float, float]) -> float:
    """The largest second difference of heights (rows, columns) along x or y, 1/m."""
    bends = [np.diff(heights, 2, axis) / length**2 for axis, length in ((1, spacing[0]), (0, spacing[1]))]
    return max(float(bend.max()) if bend.size else 0.0 for bend in bends)
