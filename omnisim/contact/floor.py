"""Ground that is no plane: bumps, a grid of heights and steps, which add up to the height H(x, y).

    bump    height exp(-((x - x0)^2 + (y - y0)^2) / radius^2)              height < 0: a pit
    grid    heights at nodes; between them the bicubic spline with two continuous derivatives, level at the border
            and beyond it
    step    up by `height` across a straight line, s metres beyond it:

            z                      _________  height       0                                                 s < 0
            |                  .-'                         height - e + sqrt(e^2 - (w - s)^2)           0 <= s < w
            |                 / | e: edge_radius           height                                       w <= s
            |                |  |
            |  ______________|  +  axis of the edge        height <= e:  w = sqrt(height (2 e - height)), an arc alone
            +----------------0--w-----------------> s      height >  e:  w = e, a vertical face below the arc

A step down is the same one seen from the other side: the line is always the foot of its face.

A roller may touch the ground before a step and its edge at once, and both are contacts: so a floor has `pieces`, 0
for all that is level ground, bump or grid, and one for each step, its edge with the face below.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.kernel import kernel
from omnisim.contact.height_grid import grid_bounds, grid_hollowness, grid_surface, spline_nodes
from omnisim.contact.surface import Surface, add, level_ground

GROUND = 0  # the piece that is no step
SKIRT = 4.0 * math.exp(-1.5)  # curvature of a bump where it is hollow most, by height / radius^2


class Floor(NamedTuple):
    """What kernels know of a floor, lengths in m. Arrays may be empty."""

    bumps: np.ndarray  # (B, 4): x, y, height, radius
    steps: np.ndarray  # (S, 7): a point of the line x, y, the direction that goes up x, y, height > 0, e, w
    nodes: np.ndarray  # (rows, columns, 4): height, its differences along x, along y, and both, each for one cell
    origin: np.ndarray  # (2,): x, y of node [0, 0]; columns count along x, rows along y
    spacing: np.ndarray  # (2,): of nodes along x and y
    level: float  # of the ground before all steps
    stairs: float  # all steps together
    highest: float  # nothing of the floor is above
    bend: float  # nowhere but on steps does the ground rise faster from its tangent plane: second derivative, 1/m
    hollow: float  # about the largest curvature of hollow ground, 1/m


# --- in Python ------------------------------------------------------------------------------------


def floor_of(
    bumps: np.ndarray, steps: np.ndarray, heights: np.ndarray, origin: tuple[float, float], spacing: tuple[float, float]
) -> Floor:
    """A Floor of bumps (B, 4) as in Floor, steps (S, 6): x, y, unit direction x, y, height, edge radius, and a grid of
    heights (rows, columns), which may be empty."""
    bumps, steps = np.array(bumps, float).reshape(-1, 4), np.array(steps, float).reshape(-1, 6)
    down = steps[:, 4] < 0.0
    level = float(steps[down, 4].sum())
    steps[down, 2:5] *= -1.0
    height, edge = steps[:, 4], steps[:, 5]
    width = np.where(height < edge, np.sqrt(np.maximum(height * (2.0 * edge - height), 0.0)), edge)
    nodes = spline_nodes(np.array(heights, float))
    grid = grid_bounds(nodes, spacing)
    stairs = float(height.sum())
    return Floor(
        bumps,
        np.ascontiguousarray(np.column_stack([steps, width])),
        nodes,
        np.array(origin, float),
        np.array(spacing, float),
        level,
        stairs,
        level + stairs + float(np.maximum(bumps[:, 2], 0.0).sum()) + grid.highest,
        hollowness(bumps) + grid.bend,
        hollowness(bumps) + grid_hollowness(nodes, spacing),
    )


def hollowness(bumps: np.ndarray) -> float:
    """Bound of the curvature where bumps (B, 4) are hollow, 1/m: pits at their bottom, bumps at their skirt."""
    height, radius = bumps[:, 2], bumps[:, 3]
    return float((np.where(height < 0.0, -2.0, SKIRT) * height / radius**2).sum())


# --- kernels --------------------------------------------------------------------------------------


@kernel
def bump_surface(bump, x, y):
    """The Surface of a row of Floor.bumps."""
    scale = 1.0 / bump[3]
    dx, dy = (x - bump[0]) * scale, (y - bump[1]) * scale
    height = bump[2] * math.exp(-(dx * dx + dy * dy))
    slope, bend = -2.0 * height * scale, 2.0 * height * scale * scale
    return Surface(
        height,
        slope * dx,
        slope * dy,
        bend * (2.0 * dx * dx - 1.0),
        2.0 * bend * dx * dy,
        bend * (2.0 * dy * dy - 1.0),
    )


@kernel
def highest_around(floor, x, y, reach):
    """What nothing of the floor within this reach of a place is above, m: exp(-q) < (1 + q / 4)^-4."""
    found = floor.highest
    for bump in floor.bumps:
        if bump[2] > 0.0:
            dx, dy = x - bump[0], y - bump[1]
            apart = max(math.sqrt(dx * dx + dy * dy) - reach, 0.0) / bump[3]
            square = (1.0 + 0.25 * apart * apart) ** 2
            found -= bump[2] * (1.0 - 1.0 / (square * square))
    return found


@kernel
def beyond(step, x, y):
    """s: how far a place is beyond the line of a row of Floor.steps, m."""
    return (x - step[0]) * step[2] + (y - step[1]) * step[3]


@kernel
def off_edge(step, s):
    """How far from its arc a place at s is, m; < 0 on the arc."""
    return max(-s, s - step[6])


@kernel
def step_surface(step, x, y):
    """The Surface of a row of Floor.steps."""
    s = beyond(step, x, y)
    if off_edge(step, s) >= 0.0:
        return level_ground(step[4] if s > 0.0 else 0.0)
    ahead = step[6] - s
    rise = math.sqrt(step[5] * step[5] - ahead * ahead)
    slope, bend = ahead / rise, -step[5] * step[5] / (rise * rise * rise)
    return Surface(
        step[4] - step[5] + rise,
        slope * step[2],
        slope * step[3],
        bend * step[2] * step[2],
        bend * step[2] * step[3],
        bend * step[3] * step[3],
    )


@kernel
def smooth_ground(floor, x, y):
    """The Surface without steps."""
    found = level_ground(floor.level)
    for bump in floor.bumps:
        found = add(found, bump_surface(bump, x, y))
    if floor.nodes.size > 0:
        found = add(found, grid_surface(floor.nodes, floor.origin, floor.spacing, x, y))
    return found


@kernel
def surface(floor, x, y):
    """The Surface at x, y."""
    return around(floor, -1, x, y)


@kernel
def around(floor, edge, x, y):
    """The Surface at x, y without the step of this number."""
    found = smooth_ground(floor, x, y)
    for k in range(len(floor.steps)):
        if k != edge:
            found = add(found, step_surface(floor.steps[k], x, y))
    return found


@kernel
def flattened(floor, x, y):
    """The Surface at x, y without rounded edges: each step is up already at its line."""
    found = smooth_ground(floor, x, y)
    for step in floor.steps:
        if beyond(step, x, y) >= 0.0:
            found = add(found, level_ground(step[4]))
    return found


@kernel
def pieces(floor):
    """How many pieces the floor has: GROUND, and step k as piece k + 1."""
    return 1 + len(floor.steps)


@kernel
def inside_piece(floor, piece, x, y):
    """How far x, y is inside a piece, m; < 0 outside. Where two edges cross, the first has the place."""
    found = math.inf
    for k in range(piece - 1 if piece else len(floor.steps)):
        step = floor.steps[k]
        found = min(found, off_edge(step, beyond(step, x, y)))
    if piece:
        step = floor.steps[piece - 1]
        s = beyond(step, x, y)
        found = min(found, step[6] - s)
        if step[4] < step[5]:
            found = min(found, s)
    return found
