"""On which slopes a machine holds, rests without power, drives up, or tips: estimates from statics.

Each wheel stands on the middle of a roller, with N and a force along the roller's axis a = -c h + s k and across it,
along b = s h + c k. The moments about a and about the axle k, of rolling resistance M, |M| <= f N, of the roller's
bearing T and of the drive tau, balance the force at their levers, the roller's radius h_0 and R:

    h_0 F_b = M . a + T        R F_h = M . k + tau,  F_h = s F_b - c F_a        F_a^2 + F_b^2 <= (mu N)^2

Wheels that are locked hold along their rollers by what rubs, across them by at most (f N + T) / h_0. Wheels that roll
uphill turn with w = phi' k + chi' a against M = -f N w / |w|, phi' and chi' those of ideal wheels. The sums of such
forces are a convex set of wrenches, which has to hold the weight's. Without power a machine rests unless some twist
lets gravity do more work than wheels take that roll, sum f N |w| + T |chi'| + T_m |phi'|, T_m of the motor.
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
TINY = 1e-7  # of the largest: lengths that count as none
TURNS = 80  # of weights for the twist that takes least


class Slopes(NamedTuple):
    """The steepest slopes (rad) that a machine stands on: with locked wheels, without power, driving up, until it
    tips."""

    holds: float
    rests: float
    climbs: float
    tips: float


class Footing(NamedTuple):
    """Of W contacts (W, 3) each: unit forces along a and b as x, y and moment about C, which by the machine's twist are
    also the velocities there; phi' and chi' of rolling wheels by the twist."""

    along: np.ndarray
    across: np.ndarray
    spins: np.ndarray
    turns: np.ndarray


Forces = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]  # by the loads (W,): a wrench (3,), and what may be more


def steepest(config: Config, parameters: Parameters, uphill_deg: float) -> Slopes:
    """The steepest slopes whose uphill direction lies so many degrees to the left of the machine's x axis."""
    uphill = np.array([math.cos(math.radians(uphill_deg)), math.sin(math.radians(uphill_deg))])
    found = footing(parameters)
    torques = np.array([driving_torque(wheel.drive) for wheel in config.wheels])
    motors = np.array([friction_torque(wheel.drive) for wheel in config.wheels])
    friction = parameters.machine.friction if config.friction.law in RUBBING else 0.0
    holds = limit(partial(stands, parameters, uphill, partial(locked, parameters, found, friction)))
    driven = partial(stands, parameters, uphill, partial(driving, parameters, found, friction, torques, uphill))
    climbs = holds if driven(min(holds, STEEPEST)) else limit(driven)
    rests = min(holds, resting(parameters, found, motors, uphill))
    return Slopes(holds, rests, climbs, tipping(parameters, uphill))


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
    heading, left = (wheels.cos_heading, wheels.sin_heading), (-wheels.sin_heading, wheels.cos_heading)
    h, k = (np.stack([e_x, e_y, x * e_y - y * e_x], axis=1) for e_x, e_y in (heading, left))
    cos, sin = wheels.cos_psi[:, None], wheels.sin_psi[:, None]
    spins, turns = (h - sin / cos * k) / wheels.radius[:, None], k / (cos * thickness(parameters)[:, None])
    return Footing(sin * k - cos * h, sin * h + cos * k, spins, turns)


def thickness(parameters: Parameters) -> np.ndarray:
    """h_0: radius of a roller in its middle, m (W,)."""
    return parameters.wheels.radius - parameters.wheels.roller_distance


def weight_of(parameters: Parameters) -> float:
    return parameters.machine.mass * math.hypot(parameters.machine.gravity, *parameters.machine.downhill)


def loads_on(parameters: Parameters, uphill: np.ndarray, slope: float) -> np.ndarray:
    """Normal forces (W,), N, of the machine at rest on a slope (rad)."""
    weight = weight_of(parameters)
    x, y = -weight * math.sin(slope) * uphill
    return loads_under(parameters, weight * math.cos(slope), (x, y))


# --- forces that may be ---------------------------------------------------------------------------


def stands(parameters: Parameters, uphill: np.ndarray, forces: Forces, slope: float) -> bool:
    """Whether the contacts hold the machine on a slope (rad)."""
    weight = weight_of(parameters)
    held, more = forces(loads_on(parameters, uphill, slope))
    needed = np.array([*(weight * math.sin(slope) * uphill), 0.0])
    return within((needed - held) / weight, more / weight)


def within(wrench: np.ndarray, segments: np.ndarray) -> bool:
    """Whether a wrench (3,) lies in the sum of the segments (G, 3) from -g to g: a convex body whose faces are normal
    to two of them, or if all lie in a plane or on a line to what is normal to that."""
    lengths = np.linalg.norm(segments, axis=1)
    units = segments[lengths > ROUNDING] / lengths[lengths > ROUNDING, None]
    _, sizes, axes = np.linalg.svd(np.concatenate([units, np.zeros((3, 3))]))
    units = np.concatenate([units, axes[sizes <= ROUNDING]])
    one, other = np.triu_indices(len(units), 1)
    normals = np.cross(units[one], units[other])
    sizes = np.linalg.norm(normals, axis=1)
    normals = normals[sizes > ROUNDING] / sizes[sizes > ROUNDING, None]
    return bool(np.all(np.abs(normals @ wrench) <= np.abs(normals @ segments.T).sum(axis=1) + ROUNDING))


def locked(
    parameters: Parameters, footing: Footing, friction: float, loads: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of wheels that do not turn: a hexagon for the circle of friction as far as rollers resist, from within."""
    wheels = parameters.wheels
    rubbing = friction * loads
    resisting = (wheels.rolling_resistance * loads + wheels.bearing_torque) / thickness(parameters)
    across = np.minimum(resisting, rubbing)
    edge = np.sqrt(rubbing**2 - across**2)
    side, tip = 0.5 * across[:, None] * footing.across, 0.5 * (rubbing - edge)[:, None] * footing.along
    return np.zeros(3), np.concatenate([edge[:, None] * footing.along, tip + side, tip - side])


def driving(
    parameters: Parameters,
    footing: Footing,
    friction: float,
    torques: np.ndarray,
    uphill: np.ndarray,
    loads: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Of wheels that roll uphill by drives of at most these torques (W,), N m."""
    wheels, cos, sin = parameters.wheels, parameters.wheels.cos_psi, parameters.wheels.sin_psi
    spin, turn = footing.spins[:, :2] @ uphill, footing.turns[:, :2] @ uphill
    rate = np.sqrt(spin**2 + turn**2 + 2.0 * sin * spin * turn)  # |w|, as k . a = s
    moment = -wheels.rolling_resistance * loads / np.maximum(rate, ROUNDING)
    bearing = -wheels.bearing_torque * np.sign(np.where(np.abs(turn) > ROUNDING * rate, turn, 0.0))
    rubbing = friction * loads
    across = np.clip((moment * (turn + sin * spin) + bearing) / thickness(parameters), -rubbing, rubbing)
    middle = (sin * across - moment * (spin + sin * turn) / wheels.radius) / cos
    reach, rest = torques / (wheels.radius * cos), np.sqrt(rubbing**2 - across**2)
    low, high = np.clip(middle - reach, -rest, rest), np.clip(middle + reach, -rest, rest)
    held = 0.5 * (low + high) @ footing.along + across @ footing.across
    return held, 0.5 * (high - low)[:, None] * footing.along


# --- rolling without power ------------------------------------------------------------------------


def resting(parameters: Parameters, footing: Footing, motors: np.ndarray, uphill: np.ndarray) -> float:
    """Slope (rad) from which on wheels roll by themselves, whose motors rub with these torques (W,), N m."""
    weight, slope = weight_of(parameters), 0.0
    for _ in range(HALVINGS):
        drag = least_drag(parameters, footing, motors, loads_on(parameters, uphill, slope), uphill)
        before, slope = slope, math.asin(min(drag / weight, 1.0))
        if abs(slope - before) <= ROUNDING:
            break
    return slope


def least_drag(
    parameters: Parameters, footing: Footing, motors: np.ndarray, loads: np.ndarray, uphill: np.ndarray
) -> float:
    """The least work (J/m = N) that rolling wheels take by the way downhill, whatever else the machine does.

    A sum of lengths |A t| over twists t that go 1 m downhill: in turn the twist with the least sum of (A t)^2 / |A t|
    and the lengths there (Weiszfeld).
    """
    wheels, spins, turns = parameters.wheels, footing.spins, footing.turns
    rolling = np.stack([spins + wheels.sin_psi[:, None] * turns, wheels.cos_psi[:, None] * turns], axis=1)  # w
    single = np.stack([np.concatenate([turns, spins]), np.zeros((2 * len(wheels), 3))], axis=1)
    costs = np.concatenate([wheels.rolling_resistance * loads, wheels.bearing_torque, motors])
    rows, costs = np.concatenate([rolling, single])[costs > 0.0], costs[costs > 0.0]
    downhill, drag, lengths = np.array([*-uphill, 0.0]), math.inf, np.ones(len(rows))
    for _ in range(TURNS):
        matrix = np.einsum("j,jia,jib->ab", costs / lengths, rows, rows)
        twist = np.linalg.pinv(matrix, hermitian=True) @ downhill
        if np.abs(matrix @ twist - downhill).max() > TINY:
            return 0.0  # some way downhill takes nothing
        lengths = np.linalg.norm(rows @ (twist / (downhill @ twist)), axis=1)
        before, drag = drag, float(costs @ lengths)
        if abs(before - drag) <= ROUNDING * drag:
            break
        lengths = np.maximum(lengths, TINY * lengths.max())
    return drag


# --- tipping --------------------------------------------------------------------------------------


def tipping(parameters: Parameters, uphill: np.ndarray) -> float:
    """Slope (rad) at which the plumb line through C leaves the wheels; a machine that a servo holds never tips."""
    if parameters.machine.upright == SERVO:
        return 0.5 * math.pi
    ratios = [reach / out for reach, out in edges(parameters, -uphill) if out > ROUNDING]
    return math.atan2(max(min(ratios, default=0.0), 0.0), parameters.machine.height)


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
