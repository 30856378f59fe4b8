"""The rules of wheel types: rollers with tips, and rows of them that take turns."""

import math
from collections.abc import Iterator

from omnisim.scene.problems import Problem
from omnisim.scene.schema import Config
from omnisim.scene.wheel_schema import WheelType

DECIMAL_TOLERANCE = 1e-12  # relative, for limits that a scene reaches exactly but types in decimals
ONLY_FREE = 'only upright = "free" in [scene] has wheels that stand on rollers of two rows at once, or on none'


def wheel_type_rules(config: Config) -> Iterator[Problem]:
    """Tips with r(alpha) >= 0."""
    for name, wheel_type in config.wheel_types.items():
        path = ("wheel_types", name)
        limit = wheel_type.radius * math.cos(wheel_type.covered)
        exact = wheel_type.profile.kind == "exact"
        if exact and wheel_type.roller_distance > limit * (1 + DECIMAL_TOLERANCE):
            shares = {math.pi / wheel_type.roller_count: "pi / roller_count"}
            shares[math.pi / wheel_type.rollers] = _shared("pi", wheel_type)
            angle = shares.get(wheel_type.covered, "covered_deg")
            allowed = f"radius * cos({angle}) = {limit!r}: there the tips of the rollers are points"
            yield Problem((*path, "roller_distance"), f"must be at most {allowed}")


def row_rules(config: Config) -> Iterator[Problem]:
    """Of an upright machine one roller of a wheel carries at a time, whichever way it is turned."""
    for name, kind in config.wheel_types.items() if config.upright != "free" else ():
        pitch, path = 360.0 / kind.rollers, ("wheel_types", name)
        if not kind.spread:
            apart = f"must take turns, their phase_deg {_shared('360', kind)} = {pitch:.12g} apart"
            yield Problem((*path, "rows"), f"{apart}; {ONLY_FREE}")
        elif kind.covered != math.pi / kind.rollers:
            allowed = f"must be absent or {_shared('180', kind)} = {0.5 * pitch:.12g}"
            yield Problem((*path, "covered_deg"), f"{allowed}; {ONLY_FREE}")


def _shared(angle: str, kind: WheelType) -> str:
    """Its part for each roller, as an expression of the keys."""
    return f"{angle} / (roller_count * {len(kind.rows)})" if len(kind.rows) > 1 else f"{angle} / roller_count"
