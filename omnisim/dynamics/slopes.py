"""On which slopes a machine holds, drives up, or tips: estimates from statics.

Each wheel stands on the middle of a roller, whose bearing gives no torque, so that its contact holds along the
roller's axis a = -c h + s k alone, by a force f:

    sum f a = M g sin S u      n . sum f D x a = 0      |f| <= mu N, c R |f| <= tau      u: uphill, tau: of the drive

Such forces are there unless some twist of the machine lets gravity do more work than friction and drives can take
(duality of linear programs); it is enough to try those twists in which two of the contacts do not slide.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np

from omnisim.dynamics.parameters import SERVO, Parameters
from omnisim.dynamics.static_loads import centres, loads_under
from omnisim.scene.drive_schema import Drive
from omnisim.scene.drives import friction_torque
from omnisim.scene.plausibility import most_torque
from omnisim.scene.schema import Config

RUBBING = ("coulomb", "regularized", "saturated", "brush")  # laws with a coefficient
STEEPEST = math.radians(89.999)
HALVINGS = 40  # of a quarter turn, to 1e-12 rad
DIRECTIONS = 24
ROUNDING = 1e-12


class Slopes(NamedTuple):
    """The steepest slopes (rad) that a machine stands on: with locked wheels, by its drives, and until it tips."""

    holds: float
    climbs: float
    tips: float


class Footing(NamedTuple):
    """Of W contacts how they hold, a force along each (W, 3): x, y and moment about C; and the twists to try (K, 3)."""

    forces: np.ndarray
    twists: np.ndarray


def steepest(config: Config, parameters: Parameters, uphill_deg: float) -> Slopes:
    """The steepest slopes whose uphill direction lies so many degrees to the left of the machine's x axis."""
    uphill = np.array([math.cos(math.radians(uphill_deg)), math.sin(math.radians(uphill_deg))])
    found = footing(parameters)
    torques = np.array([driving_torque(wheel.drive) for wheel in config.wheels])
    friction = parameters.machine.friction if config.friction.law in RUBBING else 0.0
    locked, driven = (
        partial(stands, parameters, found, friction, most, uphill) for most in (np.full(len(torques), np.inf), torques)
    )
    holds = limit(locked)
    return Slopes(holds, holds if driven(min(holds, STEEPEST)) else limit(driven), tipping(parameters, uphill))


def least(config: Config, parameters: Parameters) -> Slopes:
    """The least of them over all directions, of which there are DIRECTIONS."""
    found = [steepest(config, parameters, 360.0 * i / DIRECTIONS) for i in range(DIRECTIONS)]
    return Slopes(*map(min, zip(*found, strict=True)))


def limit(stands: Callable[[float], bool]) -> float:
    """Where a predicate of the slope (rad) ceases to hold, by halving."""
    low, high = 0.0, STEEPEST
    if stands(high):
        return 0.5 * math.pi
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stands(middle) else (low, middle)
    return low


def footing(parameters: Parameters) -> Footing:
    wheels = parameters.wheels
    x, y = centres(parameters)
    along, across = -wheels.cos_psi, wheels.sin_psi  # of a, along h and k
    a_x = along * wheels.cos_heading - across * wheels.sin_heading
    a_y = along * wheels.sin_heading + across * wheels.cos_heading
    forces = np.stack([a_x, a_y, x * a_y - y * a_x], axis=1)
    _, sizes, axes = np.linalg.svd(forces, full_matrices=True)
    free = axes[np.count_nonzero(sizes > ROUNDING * sizes[0]) :]  # twists that no contact resists
    pairs = np.array([np.cross(one, other) for one, other in combinations([*forces, *free], 2)])
    lengths = np.linalg.norm(pairs, axis=1)
    twists = pairs[lengths > ROUNDING] / lengths[lengths > ROUNDING, None]
    return Footing(forces, np.concatenate([twists, -twists]))


def stands(
    parameters: Parameters, footing: Footing, friction: float, torques: np.ndarray, uphill: np.ndarray, slope: float
) -> bool:
    """Whether friction and torques (W,), N m, hold the machine on a slope (rad)."""
    machine, wheels = parameters.machine, parameters.wheels
    weight = machine.mass * math.hypot(machine.gravity, *machine.downhill)
    push = -weight * math.sin(slope) * uphill
    loads = loads_under(parameters, weight * math.cos(slope), push)
    most = np.minimum(friction * loads, torques / (wheels.radius * wheels.cos_psi))
    taken = np.abs(footing.twists @ footing.forces.T) @ most
    return bool(np.all(footing.twists[:, :2] @ push <= taken + ROUNDING * weight))


def tipping(parameters: Parameters, uphill: np.ndarray) -> float:
    """Slope (rad) at which the plumb line through C leaves the wheels; a machine that a servo holds never tips."""
    if parameters.machine.upright == SERVO:
        return 0.5 * math.pi
    ratios = [reach / out for reach, out in edges(parameters, -uphill) if out > ROUNDING]
    return math.atan2(max(min(ratios), 0.0), parameters.machine.height)


def edges(parameters: Parameters, downhill: np.ndarray) -> Iterator[tuple[float, float]]:
    """Of each edge of the hull of the wheel centres its distance from C, m, and how far its normal points downhill."""
    points = centres(parameters).T
    for one, other in combinations(points, 2):
        along = other - one
        for normal in (np.array([along[1], -along[0]]), np.array([-along[1], along[0]])):
            size = np.linalg.norm(normal)
            if size > 0.0 and np.all((points - one) @ normal <= ROUNDING * size):
                yield float(one @ normal / size), float(normal @ downhill / size)


def driving_torque(drive: Drive) -> float:
    """What is left of a drive's largest torque after its own friction, N m; infinite where nothing limits it."""
    return max(most_torque(drive) - friction_torque(drive), 0.0)
