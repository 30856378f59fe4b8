"""The rules of a machine as a whole: its bodies, what carries it, and whether its wheels can follow the command.

They need every mass and inertia, and wheels with types and places, so they come after the rules of rules.py.
"""

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

from omnisim.scene.masses import common_centre, point_masses
from omnisim.scene.problems import Problem
from omnisim.scene.roller_rules import DECIMAL_TOLERANCE
from omnisim.scene.schema import Config

LINE_TOLERANCE = 1e-6  # area of a hull / (its longest distance)^2: below, its points lie on a line
EDGE_TOLERANCE = 1e-9  # distance from the hull / its longest distance: below, a point lies on its edge

Points = tuple[tuple[float, float], ...]


def _inertia_rules(config: Config) -> Iterator[Problem]:
    """Moments of inertia that a mass distribution can have: flat discs are the limit of rollers, plates of chassis."""
    for name, wheel_type in config.wheel_types.items():
        path = ("wheel_types", name, "roller")
        roller = wheel_type.roller
        limit = 2 * roller.inertia_transverse
        if roller.inertia_axial <= limit * (1 + DECIMAL_TOLERANCE):
            continue
        if "inertia_axial" in roller.model_fields_set:
            allowed = f"2 * inertia_transverse = {limit!r}: no body has more"
            yield Problem((*path, "inertia_axial"), f"must be at most {allowed}")
        else:
            allowed = f"half of the inertia_axial that the profile gives, {roller.inertia_axial:.6g}: no body has less"
            yield Problem((*path, "inertia_transverse"), f"must be at least {allowed}")
    inertia = config.chassis.inertia if config.chassis else ()
    for axis, moment in enumerate(inertia):
        limit = sum(inertia) - moment
        if moment > limit * (1 + DECIMAL_TOLERANCE):
            allowed = f"the sum of the other two = {limit:.12g}: no body has more"
            yield Problem(("chassis", "inertia", axis), f"must be at most {allowed}")


def _upright_rules(config: Config) -> Iterator[Problem]:
    """Contacts carry roll and pitch of a chassis whose common centre of mass lies between three wheels or more."""
    if config.upright != "contacts":
        return
    given = "upright" in config.world.model_fields_set
    path = ("scene", "upright") if given else ("chassis",)
    what = "" if given else 'upright = "contacts", the default with a chassis, '
    points = tuple(wheel.position for wheel in config.wheels)
    contacts = {1: "one contact", 2: "two contacts"}.get(len(points))
    if not config.chassis:
        yield Problem(path, 'must be "servo" without a chassis: one contact cannot carry roll and pitch')
    elif contacts:
        yield Problem(path, f'{what}needs three wheels or more: {contacts} cannot carry roll and pitch; use "servo"')
    elif _on_a_line(points):
        where = "the wheel centres lie on one line, and contacts on a line cannot carry roll and pitch"
        yield Problem(path, f'{what}needs wheels around the machine: {where}; use "servo"')
    else:
        yield from _balance_rules(config)


def _balance_rules(config: Config) -> Iterator[Problem]:
    if where := outside(config):
        yield Problem(("chassis", "center_of_mass"), f"{where}; the machine would tip")


def outside(config: Config) -> str:
    """How far the common centre of mass lies outside of the wheels; empty if it does not, or if they are on a line."""
    points = tuple(wheel.position for wheel in config.wheels)
    if len(points) < 3 or _on_a_line(points):
        return ""
    x, y, _ = common_centre(*point_masses(config))
    hull = _hull(points)
    edges = [(_beyond((x, y), points[a], points[b]), a, b) for a, b in zip(hull, hull[1:] + hull[:1], strict=True)]
    distance, a, b = max(edges)
    if distance <= EDGE_TOLERANCE * _span(points):
        return ""
    names = f"'{config.wheels[a].name}' to '{config.wheels[b].name}'"
    where = f"the common centre of mass, at [{x:.6g}, {y:.6g}], lies outside of the wheels"
    return f"{where}: {distance:.3g} m beyond the line from {names}"


def _command_rules(config: Config) -> Iterator[Problem]:
    """The rates of the wheels that follow the command give back the motion that it asks for."""
    if not config.command:
        return
    from omnisim.scene import ideal_kinematics  # here: NumPy is slow to import, and few scenes need it

    follows = [wheel.drive.follows_command for wheel in config.wheels]
    rows = ideal_kinematics.wheel_rows(config)[follows]
    distance = ideal_kinematics.rms_distance(config)
    motions = ideal_kinematics.undetermined(rows, distance)
    if motions:
        names = ", ".join(wheel.name for wheel in config.wheels if wheel.drive.follows_command)
        what = f"the rates of the wheels that follow it ({names}) do not determine vx, vy and yaw_rate"
        hands = ideal_kinematics.handedness(config)
        cure = f"; {hands.told}; expected {hands.cure}" if hands else ""
        yield Problem(("command",), f"singular: {what}; they leave open: {', '.join(motions)}{cure}")


@lru_cache
def _span(points: Points) -> float:
    return max(math.dist(a, b) for a in points for b in points)


@lru_cache
def _on_a_line(points: Points) -> bool:
    corner, *others = [points[index] for index in _hull(points)]
    area = sum(_cross(corner, a, b) for a, b in pairwise(others)) / 2
    return area <= LINE_TOLERANCE * _span(points) ** 2


@lru_cache
def _hull(points: Points) -> list[int]:
    """Indices of the corners of the convex hull, counterclockwise (Andrew's monotone chain)."""
    order = sorted(range(len(points)), key=points.__getitem__)
    return _chain(points, order)[:-1] + _chain(points, order[::-1])[:-1]


def _chain(points: Points, order: list[int]) -> list[int]:
    chain: list[int] = []
    for index in order:
        while len(chain) > 1 and _cross(points[chain[-2]], points[chain[-1]], points[index]) <= 0:
            chain.pop()
        chain.append(index)
    return chain


def _cross(o: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    """Twice the area of a triangle, m^2: positive when it is counterclockwise."""
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def _beyond(point: tuple[float, float], a: tuple[float, float], b: tuple[float, float]) -> float:
    """How far a point lies to the right of the line from a to b, m."""
    return -_cross(a, b, point) / math.dist(a, b)


MACHINE_RULES = (_inertia_rules, _upright_rules, _command_rules)
