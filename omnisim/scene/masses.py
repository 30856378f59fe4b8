"""Where the mass of a machine is: the chassis, and each wheel with its rollers as one body at the wheel centre."""

import math
from collections.abc import Sequence
from operator import mul

from omnisim.base.keeping import kept
from omnisim.scene.schema import Chassis, Config
from omnisim.scene.wheel_schema import WheelType

CLEARANCE = 0.5  # of the smallest wheel radius: how high a chassis box lies where the scene does not say


@kept
def point_masses(config: Config) -> tuple[list[float], list[tuple[float, float, float]]]:
    """Masses (kg) and centres of mass (chassis axes, m) of the wheels in their order, and of the chassis.

    A wheel is one body with its rollers and the hub of its suspension; rows of rollers that do not balance about its
    middle put its centre of mass aside.
    """
    types = [config.type_of(wheel) for wheel in config.wheels]
    masses, points = [], []
    for wheel, kind in zip(config.wheels, types, strict=True):
        rolling = wheel_mass(kind)
        mass = rolling + (wheel.suspension.mass if wheel.suspension else 0.0)
        shift = row_shift(kind)
        x, y = wheel.position
        if shift:
            heading, aside = math.radians(wheel.heading_deg), shift * rolling / mass
            x, y = x - aside * math.sin(heading), y + aside * math.cos(heading)
        masses.append(mass)
        points.append((x, y, kind.radius))
    if config.chassis is not None:
        masses.append(config.chassis.mass)
        points.append(config.chassis.center_of_mass)
    return masses, points


def share_of_weight(config: Config) -> float:
    """Of one wheel, N."""
    return config.world.gravity * math.fsum(point_masses(config)[0]) / len(config.wheels)


@kept
def wheel_mass(kind: WheelType) -> float:
    """Of a wheel with its rollers, kg."""
    return kind.disk.mass + kind.rollers * kind.roller.mass


@kept
def row_shift(kind: WheelType) -> float:
    """o: of the centre of mass of a wheel from its middle along the axle, m."""
    moment = kind.roller_count * kind.roller.mass * math.fsum(row.offset for row in kind.rows)
    return moment / wheel_mass(kind) if moment else 0.0


def chassis_box(config: Config) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
    """Two opposite corners of the chassis, chassis axes, m; None where the scene gives no size."""
    chassis = config.chassis
    if chassis is None or "size" not in chassis.model_fields_set:
        return None
    length, width, height = chassis.size
    low = clearance(config, chassis)
    return (-0.5 * length, -0.5 * width, low), (0.5 * length, 0.5 * width, low + height)


def clearance(config: Config, chassis: Chassis) -> float:
    """Between the chassis box and the floor, m."""
    if "ground_clearance" in chassis.model_fields_set:
        return chassis.ground_clearance
    return CLEARANCE * min(config.type_of(wheel).radius for wheel in config.wheels)


def common_centre(masses: Sequence[float], points: Sequence[Sequence[float]]) -> tuple[float, ...]:
    """The centre of mass of so many masses at these points."""
    whole = math.fsum(masses)
    return tuple(moment / whole for moment in exact_moments(masses, points))


def exact_moments(masses: Sequence[float], points: Sequence[Sequence[float]]) -> list[float]:
    """Sum of m p, rounded once: what cancels in a symmetric machine cancels to the last bit."""
    return [math.fsum(map(mul, masses, column)) for column in zip(*points, strict=True)]
