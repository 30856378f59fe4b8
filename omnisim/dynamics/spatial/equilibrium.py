"""A machine free in space at rest on the ground: the pose in which rubber and springs carry its weight.

Friction holds it: every contact force is vertical, N / (nu . up) for the normal force N = stiffness delta. So on a
slope the load of a wheel is what it is while the machine neither slides nor tips. Heave, pitch, roll and the carriers'
s are found by Newton's method; x, y and yaw of the origin are given. Rubber that is stiff lets few wheels touch, and
which of them is not known: so it begins soft, and stiffens until it is what it is.

Without gravity nothing presses it onto the ground: it begins level, at height 0 or as low as the ground lets it.
"""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.calls import direct
from omnisim.base.kernel import kernel
from omnisim.base.vector import cross, dot, plus, times
from omnisim.contact.common_normal import ANY
from omnisim.contact.floor import flattened
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.carriers import place_carrier
from omnisim.dynamics.spatial.pose import add_push, body_of, inward, mounted, outward, vector
from omnisim.dynamics.spatial.records import BASE, ORIENTATION, POSITION
from omnisim.dynamics.spatial.touching import meetings, standing, touching
from omnisim.dynamics.state import places

SOFTEST = 0.25  # of the smallest wheel radius: how far it sinks in with the softest rubber
STIFFER = 4.0  # times, from one round to the next
LEAST_STIFFER = 1.001  # the same after rounds that failed
MOST_NEWTON = 60  # iterations of a round
MOST_HALVINGS = 30
BALANCED = 1e-11  # of the weight, and of its moment at the arm of the machine
ROUNDING = 2e-15  # of lengths: stiff rubber makes forces of it
NUDGE, PART = 1e-6, 1e-3  # m and rad, of differences, at most; and of how far rubber is pressed in, which they keep in
STEEPEST = 0.5  # rad, of a correction
SEARCHED = 1000  # wheel radii, up and down from the ground below the wheels, until it carries the machine
BESIDE = np.linspace(-1.0, 1.0, 5)  # wheel radii from a hub, along x and y: where that ground is looked at


class NoEquilibriumError(Exception):
    """A machine that does not stand where it is put."""


class Fineness(NamedTuple):
    """Of Newton's method: length of differences (m and rad), and what may be unbalanced, of the weight."""

    nudge: float
    enough: float


@kernel
def weigh(parameters, y, softness, loads):
    """Forces of gravity and ground on a machine at rest in state y, about C along chassis axes, into `pushes`; normal
    forces of the wheels into loads (W,), N. softness: of the rubber, 1 or more."""
    space = parameters.space
    body = body_of(parameters, y)
    down = inward(body.rotation, vector(space.body.gravity, 0))
    size = math.sqrt(dot(down, down))
    weightless = size == 0.0  # then forces act along normals
    up = down if weightless else times(-1.0 / size, down)
    for j in range(len(space.pushes)):
        for i in range(6):
            space.pushes[j, i] = 0.0
    add_push(space.pushes[BASE], cross(vector(space.body.moment, 0), down), times(space.body.base_mass, down))
    if len(space.carriers) > 0:
        for j in range(len(space.carriers)):
            carrier = space.carriers[j]
            centre = place_carrier(carrier, space.motions[j], y[places(parameters).joint + j])
            weight = times(carrier.mass, down)
            add_push(space.pushes[1 + j], cross(centre, weight), weight)
    for w in range(len(parameters.wheels)):
        loads[w] = 0.0
        stand = standing(parameters, w, body, y)
        axes = mounted(stand.hub)
        push = space.pushes[1 + space.hubs[w].carrier]
        for i in range(parameters.wheels[w].rollers):
            for meeting in range(meetings(space, w)):
                touched = touching(parameters, w, stand, meeting, ANY, i)
                if touched.depth > 0.0 and touched.within > 0.0:
                    normal = outward(axes, touched.normal)
                    load = space.hubs[w].stiffness / softness * touched.depth
                    force = times(load, normal) if weightless else times(load / dot(normal, up), up)
                    point = plus(stand.hub.centre, outward(axes, plus(touched.roller.centre, touched.lever)))
                    loads[w] += load
                    add_push(push, cross(point, force), force)


def find_equilibrium(parameters: Parameters, state_at, carriers: int) -> tuple[np.ndarray, np.ndarray]:
    """Height (m), pitch, roll (rad) and s of the carriers (3 + C,), and the loads of the wheels (W,), N.

    state_at: the state y (n,) of such numbers, at rest. Raises NoEquilibriumError.
    """
    space = parameters.space
    assert space is not None
    radius = float(min(parameters.wheels.radius))
    weight = float(parameters.machine.mass * np.linalg.norm(space.body.gravity))
    loads = np.zeros(len(parameters.wheels))
    x = np.zeros(3 + carriers)
    stiffness = float(np.sum(space.hubs.stiffness))
    if weight == 0.0:
        touched = ROUNDING * radius * stiffness
        if carried(parameters, state_at(x), 1.0, loads) > touched:
            x[0] = lowest_touch(parameters, state_at, 1.0, loads, touched)
        return x, np.zeros(len(loads))
    arm = float(np.abs(np.asarray(space.hubs.centre)).max())
    softness = max(1.0, SOFTEST * radius * stiffness / weight)
    scale = weight * np.array([1.0, arm, arm] + [1.0] * carriers)

    def lacking(x: np.ndarray) -> np.ndarray:
        direct(weigh, parameters, state_at(x), softness, loads)
        return unbalanced(parameters, x[3:]) / scale

    def at_rest(x: np.ndarray) -> np.ndarray:
        pressed = softness * weight / stiffness
        fine = Fineness(min(NUDGE, PART * pressed), max(BALANCED, ROUNDING * radius / pressed))
        return settled(lacking, newton(lacking, x, fine), scale, fine)

    x[0] = lowest_touch(parameters, state_at, softness, loads, weight)
    x = at_rest(x)
    factor = STIFFER
    while softness > 1.0:
        before, softness = softness, max(1.0, softness / factor)
        try:
            x, factor = at_rest(x), STIFFER
        except NoEquilibriumError:
            softness, factor = before, math.sqrt(factor)
            if factor < LEAST_STIFFER:
                raise
    lacking(x)
    return x, loads.copy()


def settled(lacking, x: np.ndarray, scale: np.ndarray, fine: Fineness) -> np.ndarray:
    """The same, or where it comes to rest if it would fall from there: a machine that balances on two wheels."""
    slope = scale[:, None] * difference(lacking, x, fine.nudge)
    growth, ways = np.linalg.eigh(0.5 * (slope + slope.T))
    if growth[-1] <= 0.0:
        return x
    way = ways[:, -1] / np.abs(ways[:, -1]).max()
    for far in np.geomspace(1e-6, STEEPEST, 60):
        for there in (x + far * way, x - far * way):
            if (scale * lacking(there)) @ (there - x) < 0.0:
                return newton(lacking, there, fine)
    raise NoEquilibriumError("it tips over")


def difference(lacking, x: np.ndarray, nudge: float) -> np.ndarray:
    """Jacobian of `lacking`."""
    columns = [(lacking(x + one) - lacking(x - one)) / (2.0 * nudge) for one in nudge * np.eye(len(x))]
    return np.array(columns).T


def unbalanced(parameters: Parameters, s: np.ndarray) -> np.ndarray:
    """What `weigh` has left: force upwards (N), moments about two level axes (N m), force along s of every carrier."""
    space = parameters.space
    assert space is not None
    total = space.pushes.sum(axis=0)
    found = np.zeros(3 + len(s))
    found[0] = total[5]
    found[1], found[2] = total[1], total[0]  # pitch is about y, roll about x
    for j, carrier in enumerate(space.carriers):
        axis, push = np.asarray(carrier.axis), space.pushes[1 + j]
        if carrier.turns:
            about = push[:3] - np.cross(carrier.point, push[3:])
            found[3 + j] = axis @ about
        else:
            found[3 + j] = axis @ push[3:] - carrier.preload
        found[3 + j] -= carrier.stiffness * s[j]
    return found


def lowest_touch(parameters: Parameters, state_at, softness: float, loads: np.ndarray, weight: float) -> float:
    """Height at which the ground carries the whole weight of a level machine, m."""
    space = parameters.space
    assert space is not None
    level = np.zeros(2 + len(space.carriers))

    def holds(height: float) -> bool:
        return carried(parameters, state_at(np.array([height, *level])), softness, loads) >= weight

    step = float(min(parameters.wheels.radius))
    start = highest_below(parameters, state_at(np.array([0.0, *level]))) + step
    high = next((start + i * step for i in range(SEARCHED) if not holds(start + i * step)), None)
    low = next((start - i * step for i in range(SEARCHED) if holds(start - i * step)), None)
    if high is None or low is None:
        raise NoEquilibriumError("nothing carries it")
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def carried(parameters: Parameters, y: np.ndarray, softness: float, loads: np.ndarray) -> float:
    """What all wheels carry in state y, N."""
    direct(weigh, parameters, y, softness, loads)
    return float(loads.sum())


def highest_below(parameters: Parameters, state: np.ndarray) -> float:
    """The highest ground that is seen below the wheels of a level machine in this state (n,), m."""
    space = parameters.space
    assert space is not None
    if not space.body.uneven:
        return 0.0
    real, _, _, along_z = state[ORIENTATION : ORIENTATION + 4]
    cos, sin = real * real - along_z * along_z, 2.0 * real * along_z
    heights = []
    for hub, wheel in zip(space.hubs, parameters.wheels, strict=True):
        x, y = hub.centre[:2] @ [[cos, sin], [-sin, cos]] + state[POSITION : POSITION + 2]
        beside = float(wheel.radius) * BESIDE
        heights += [direct(flattened, space.floor, x + dx, y + dy).height for dx in beside for dy in beside]
    return max(heights)


def newton(lacking, x: np.ndarray, fine: Fineness) -> np.ndarray:
    """Root of `lacking` near x."""
    found = lacking(x)
    for _ in range(MOST_NEWTON):
        size = np.abs(found).max()
        if size <= fine.enough:
            return x
        slope = difference(lacking, x, fine.nudge)
        try:
            change = -np.linalg.solve(slope, found)
        except np.linalg.LinAlgError:
            change = -np.linalg.pinv(slope) @ found
        change /= max(1.0, np.abs(change).max() / STEEPEST)
        part = 1.0
        for _ in range(MOST_HALVINGS):
            there = lacking(x + part * change)
            if np.linalg.norm(there) < np.linalg.norm(found) or size <= 100.0 * fine.enough:
                break
            part *= 0.5
        else:
            break
        x, found = x + part * change, there
    if np.abs(found).max() <= 1e3 * fine.enough:
        return x
    raise NoEquilibriumError("it does not come to rest there")
