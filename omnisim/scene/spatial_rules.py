"""The rules of machines free in space: what they need, and what only they may have."""

from collections.abc import Iterator

from omnisim.scene.problems import Problem, did_you_mean
from omnisim.scene.schema import Config

POSE = ("height", "pitch_deg", "roll_deg", "vertical_velocity", "pitch_rate", "roll_rate")
OF_TYPES = ("contact", "profile")


def spatial_rules(config: Config) -> Iterator[Problem]:
    """Of `upright = "free"`, or of its absence."""
    if config.upright == "free":
        yield from _needed(config)
        yield from _rocker_rules(config)
    else:
        yield from _misplaced(config)


def _needed(config: Config) -> Iterator[Problem]:
    if config.chassis is None:
        yield Problem(("scene", "upright"), 'must be "servo" without a chassis: a machine free in space needs one')
    for key, value, allowed in (("formulation", config.solver.formulation, "reduced"),
                                ("tracking", config.solver.tracking, "explicit")):  # fmt: skip
        if value != allowed:
            yield Problem(("solver", key), f'must be "{allowed}" with upright = "free"')
    for name, kind in config.wheel_types.items():
        path = ("wheel_types", name)
        if kind.contact is None:
            what = "a table { stiffness, damping } of the rubber between roller and floor (N/m, N s/m)"
            yield Problem((*path, "contact"), f'missing; upright = "free" needs {what}')


def _rocker_rules(config: Config) -> Iterator[Problem]:
    names = [wheel.name for wheel in config.wheels]
    taken: set[str] = set()
    for index, rocker in enumerate(config.axles):
        path = ("axles", index, "wheels")
        for name in rocker.wheels:
            if name not in names:
                hint = did_you_mean(name, names)
                yield Problem(path, f"no wheel is called '{name}'{hint or '.'} Wheels: {', '.join(names)}")
            elif name in taken:
                yield Problem(path, f"wheel '{name}' is on two axles, or twice on one")
            elif config.wheels[names.index(name)].suspension is not None:
                yield Problem(path, f"wheel '{name}' has a suspension of its own; it cannot be on a rocker as well")
            taken.add(name)


def _misplaced(config: Config) -> Iterator[Problem]:
    only = 'is of machines free in space: it needs upright = "free" in [scene]'
    for name, kind in config.wheel_types.items():
        for key in OF_TYPES:
            if key in kind.model_fields_set:
                yield Problem(("wheel_types", name, key), only)
    for index, wheel in enumerate(config.wheels):
        if wheel.suspension is not None:
            yield Problem(("wheels", index, "suspension"), only)
    if config.axles:
        yield Problem(("axles",), only)
    for key in POSE:
        if key in config.initial.model_fields_set:
            yield Problem(("initial", key), only)
