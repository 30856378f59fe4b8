"""The ground of the spatial oracle: a height H(x, y) over its base plane, with its gradient and its Hessian.

Axes of the floor: x, y in the base plane, z its normal, tilted or not. nu = (-grad H, 1) / |..| is the upward normal.
A `part` is anything with these three functions and a `top`; the ground is the sum of its parts.
"""

from math import exp
from typing import NamedTuple, Protocol

import numpy as np


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


class Ground(NamedTuple):
    parts: list[Part]

    @classmethod
    def of(cls, floor: dict) -> "Ground":
        """The ground of a scene's table [floor]."""
        unknown = floor.keys() & {"grid", "steps"}
        if unknown:
            raise ValueError(f"the oracle has no {' and '.join(sorted(unknown))} on its floor")
        return cls([Bump(*bump) for bump in floor.get("bumps", [])])

    @property
    def flat(self) -> bool:
        return not self.parts

    @property
    def top(self) -> float:
        return sum(part.top for part in self.parts)

    def height(self, x: float, y: float) -> float:
        return sum(part.height(x, y) for part in self.parts)

    def gradient(self, x: float, y: float) -> np.ndarray:
        return sum((part.gradient(x, y) for part in self.parts), np.zeros(2))

    def hessian(self, x: float, y: float) -> np.ndarray:
        return sum((part.hessian(x, y) for part in self.parts), np.zeros((2, 2)))

    def normal(self, x: float, y: float) -> np.ndarray:
        return unit(np.array([*-self.gradient(x, y), 1.0]))


def unit(vector: np.ndarray) -> np.ndarray:
    return vector / np.sqrt(vector @ vector)
