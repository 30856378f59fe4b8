"""A height over x and y with its first and second derivatives, and how heights add up."""

from typing import NamedTuple

from omnisim.base.kernel import kernel


class Surface(NamedTuple):
    """Height (m), its slopes, and its second derivatives (1/m)."""

    height: float
    slope_x: float
    slope_y: float
    xx: float
    xy: float
    yy: float


@kernel
def add(a, b):
    """The Surface of two that add up."""
    return Surface(
        a.height + b.height, a.slope_x + b.slope_x, a.slope_y + b.slope_y, a.xx + b.xx, a.xy + b.xy, a.yy + b.yy
    )


@kernel
def level_ground(height):
    return Surface(height, 0.0, 0.0, 0.0, 0.0, 0.0)
