"""Where the mass of a machine is: the chassis, and each wheel with its rollers as one body at the wheel centre."""

import math
from collections.abc import Sequence
from operator import mul

from omnisim.scene.schema import Config


def point_masses(config: Config) -> tuple[list[float], list[tuple[float, float, float]]]:
    """Masses (kg) and centres of mass (chassis axes, m) of the wheels in their order, and of the chassis."""
    types = [config.type_of(wheel) for wheel in config.wheels]
    masses = [kind.disk.mass + kind.rollers * kind.roller.mass for kind in types]
    points = [(*wheel.position, kind.radius) for wheel, kind in zip(config.wheels, types, strict=True)]
    if config.chassis is not None:
        masses.append(config.chassis.mass)
        points.append(config.chassis.center_of_mass)
    return masses, points


def common_centre(masses: Sequence[float], points: Sequence[Sequence[float]]) -> tuple[float, ...]:
    """The centre of mass of so many masses at these points."""
    whole = math.fsum(masses)
    return tuple(moment / whole for moment in exact_moments(masses, points))


def exact_moments(masses: Sequence[float], points: Sequence[Sequence[float]]) -> list[float]:
    """Sum of m p, rounded once: what cancels in a symmetric machine cancels to the last bit."""
    return [math.fsum(map(mul, masses, column)) for column in zip(*points, strict=True)]
