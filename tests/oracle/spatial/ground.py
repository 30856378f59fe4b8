"""The ground of the spatial oracle: a height H(x, y) over its base plane, with its gradient and its Hessian, and steps.

Axes of the floor: x, y in the base plane, z its normal, tilted or not. nu = (-grad H, 1) / |..| is the upward normal.
A `part` is anything with these three functions and a `top`; the ground is the sum of its parts. A step adds a level;
its edge is a surface of its own, a straight cylinder with the face below it, and stands on level ground only.
"""

from math import asin, cos, exp, pi, radians, sin, sqrt
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from scipy.interpolate import CubicSpline


class Part(Protocol):
    """Height (m), gradient (2,), Hessian (2, 2) (1/m) at (x, y); and a height that it nowhere exceeds."""

    def height(self, x: float, y: float) -> float: ...

    def gradient(self, x: float, y: float) -> np.ndarray: ...

    def hessian(self, x: float, y: float) -> np.ndarray: ...

    @property
    def top(self) -> float: ...


class Bump(NamedTuple):
    """H = peak exp(-rho^2), rho^2 = ((x - x0)^2 + (y - y0)^2) / radius^2; a pit, where peak < 0."""

    x: float
    y: float
    peak: float
    radius: float

    def height(self, x: float, y: float) -> float:
        return self.peak * exp(-((x - self.x) ** 2 + (y - self.y) ** 2) / self.radius**2)

    def gradient(self, x: float, y: float) -> np.ndarray:
        return -2.0 / self.radius**2 * self.height(x, y) * np.array([x - self.x, y - self.y])

    def hessian(self, x: float, y: float) -> np.ndarray:
        arm = np.array([x - self.x, y - self.y])
        return self.height(x, y) * (4.0 / self.radius**4 * np.outer(arm, arm) - 2.0 / self.radius**2 * np.eye(2))

    @property
    def top(self) -> float:
        return max(self.peak, 0.0)


class Grid:
    """Splines through heights (rows, columns), level at the border and beyond: columns along x, rows along y."""

    def __init__(self, heights: np.ndarray, origin: list[float], spacing: list[float]) -> None:
        self.heights = np.array(heights, dtype=float)
        self.x, self.y = (origin[i] + spacing[i] * np.arange(self.heights.shape[1 - i]) for i in (0, 1))
        along_x = CubicSpline(self.x, self.heights, axis=1, bc_type="clamped").c  # (4, columns - 1, rows)
        self.cubics = CubicSpline(self.y, along_x, axis=2, bc_type="clamped").c  # (4, rows - 1, 4, columns - 1)

    def rate(self, x: float, y: float, by_x: int, by_y: int) -> float:
        """H differentiated so often by x and by y."""
        (i, along_x), (j, along_y) = (powers(nodes, *at) for nodes, at in ((self.x, (x, by_x)), (self.y, (y, by_y))))
        return float(along_y @ self.cubics[:, j, :, i] @ along_x)

    def height(self, x: float, y: float) -> float:
        return self.rate(x, y, 0, 0)

    def gradient(self, x: float, y: float) -> np.ndarray:
        return np.array([self.rate(x, y, 1, 0), self.rate(x, y, 0, 1)])

    def hessian(self, x: float, y: float) -> np.ndarray:
        both = self.rate(x, y, 1, 1)
        return np.array([[self.rate(x, y, 2, 0), both], [both, self.rate(x, y, 0, 2)]])

    @property
    def top(self) -> float:
        return 1.5 * max(float(self.heights.max()), 0.0)  # splines overshoot


def powers(nodes: np.ndarray, at: float, derivative: int) -> tuple[int, np.ndarray]:
    """The cell in which a place is, and the derivative of (t^3, t^2, t, 1), t from its first node; 0 beyond all."""
    inside = min(max(at, nodes[0]), nodes[-1])
    cell = min(int(np.searchsorted(nodes, inside, side="right")) - 1, len(nodes) - 2)
    t = inside - nodes[cell]
    rows = [t**3, t**2, t, 1.0], [3.0 * t**2, 2.0 * t, 1.0, 0.0], [6.0 * t, 2.0, 0.0, 0.0]
    return cell, np.array(rows[derivative]) * (derivative == 0 or inside == at)


class Step:
    """Up by `rise` > 0 across the line through `point` towards `up`; the upper edge an arc of radius e.

    nu = cos(angle) z - sin(angle) up along the arc, from its top, angle 0, to where it meets the face or the ground.
    A step down is one up, seen from the other side, on ground that is lower by as much.
    """

    def __init__(self, point: list[float], direction_deg: float, height: float, edge_radius: float) -> None:
        turned = radians(direction_deg) + (pi if height < 0.0 else 0.0)
        self.point, self.rise, self.e = np.array([*point, 0.0]), abs(height), edge_radius
        self.up, self.lower = np.array([cos(turned), sin(turned), 0.0]), min(height, 0.0)
        self.faced = self.rise > edge_radius
        self.width = edge_radius if self.faced else sqrt(self.rise * (2.0 * edge_radius - self.rise))
        self.last = asin(self.width / edge_radius)
        self.centre = self.point + self.width * self.up + (self.rise - edge_radius) * np.array([0.0, 0.0, 1.0])

    def beyond(self, place: np.ndarray) -> float:
        return float((place - self.point) @ self.up)

    def level(self, x: float, y: float) -> float:
        return self.lower + (self.rise if self.beyond(np.array([x, y, 0.0])) > 0.0 else 0.0)

    def normal(self, angle: float) -> np.ndarray:
        return cos(angle) * np.array([0.0, 0.0, 1.0]) - sin(angle) * self.up

    def off(self, place: np.ndarray) -> bool:
        """Whether a place is not on the arc."""
        return not 0.0 <= self.beyond(place) < self.width


class Ground(NamedTuple):
    parts: list[Part]
    steps: list[Step]

    @classmethod
    def of(cls, floor: dict, folder: Path = Path()) -> "Ground":
        """The ground of a scene's table [floor]; the file of a grid is .npy, in this folder."""
        parts: list[Part] = [Bump(*bump) for bump in floor.get("bumps", [])]
        if "grid" in floor:
            grid = floor["grid"]
            parts.append(Grid(np.load(folder / grid["file"]), grid.get("origin", [0.0, 0.0]), grid["spacing"]))
        steps = [Step(**step) for step in floor.get("steps", [])]
        if steps and parts:
            raise ValueError("the edges of the oracle's steps stand on level ground")
        return cls(parts, steps)

    @property
    def flat(self) -> bool:
        return not self.parts

    @property
    def top(self) -> float:
        return sum(part.top for part in self.parts) + sum(step.lower + step.rise for step in self.steps)

    def height(self, x: float, y: float) -> float:
        return sum(part.height(x, y) for part in self.parts) + sum(step.level(x, y) for step in self.steps)

    def gradient(self, x: float, y: float) -> np.ndarray:
        return sum((part.gradient(x, y) for part in self.parts), np.zeros(2))

    def hessian(self, x: float, y: float) -> np.ndarray:
        return sum((part.hessian(x, y) for part in self.parts), np.zeros((2, 2)))

    def normal(self, x: float, y: float) -> np.ndarray:
        return unit(np.array([*-self.gradient(x, y), 1.0]))

    def below(self, step: Step, x: float, y: float) -> float:
        """Level on which a step rises: that of all others there, and how much lower it lies itself."""
        return step.lower + sum(other.level(x, y) for other in self.steps if other is not step)


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.sqrt(vector @ vector)
