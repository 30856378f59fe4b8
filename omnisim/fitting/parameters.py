"""What is estimated: each key of [free], and what a value of it sets in the scene or of the tracked point."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from omnisim.fitting.schema import Free, Tracked
from omnisim.scene.document import sentence
from omnisim.scene.problems import ConfigError, Problem, did_you_mean
from omnisim.scene.toml_text import MISSING, KeyPath, show_value, value_at
from omnisim.scene.validation import validate
from omnisim.studies.factors import places, with_values

TRACKED = "tracked."


class Point(NamedTuple):
    """The tracked point (m) and its heading (rad) in chassis axes."""

    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Parameter:
    """A key of [free]: targets are paths in the scene's data with what the scene has there if it is a factor, else
    None; without targets it is a key of [tracked]."""

    key: str
    start: float
    low: float
    high: float
    targets: tuple[tuple[KeyPath, Any], ...]

    @property
    def range(self) -> float:
        return self.high - self.low

    def settings(self, value: float) -> list[tuple[KeyPath, Any]]:
        """The paths in the scene's data that a value sets, and to what."""
        return [(path, value if nominal is None else multiplied(nominal, value)) for path, nominal in self.targets]


def multiplied(nominal: Any, factor: float) -> Any:
    """A number or a list of numbers times a factor."""
    return tuple(factor * entry for entry in nominal) if isinstance(nominal, Sequence) else factor * nominal


def parameters(free: Mapping[str, Free], data: dict[str, Any]) -> Iterator[Parameter | Problem]:
    """The Parameter of each key of [free], or what is wrong with it; data: of the scene."""
    taken: dict[KeyPath, str] = {}
    for key, entry in free.items():
        here = ("free", key)
        if not entry.low < entry.high:
            yield Problem(here, "must have from and to, the first below the second")
            continue
        if not entry.low <= entry.start <= entry.high:
            yield Problem((*here, "start"), f"must be between from = {entry.low:g} and to = {entry.high:g}")
            continue
        if key.startswith(TRACKED):
            yield tracked(key, entry)
            continue
        try:
            targets = tuple(aims(key, entry, data))
        except ValueError as error:
            yield Problem(here, str(error))
            continue
        twice = next((taken[path] for path, _ in targets if path in taken), None)
        if twice:
            yield Problem(here, f"sets what {twice} sets too")
            continue
        taken |= {path: key for path, _ in targets}
        made = Parameter(key, entry.start, entry.low, entry.high, targets)
        yield unfit(made, data) or made


def tracked(key: str, entry: Free) -> Parameter | Problem:
    name = key.removeprefix(TRACKED)
    if name not in Tracked.model_fields:
        known = [TRACKED + field for field in Tracked.model_fields]
        return Problem(("free", key), f"unknown key{did_you_mean(key, known) or '.'} Allowed: {', '.join(known)}")
    if entry.scale or entry.also:
        return Problem(("free", key), "takes start, from and to, and nothing else")
    return Parameter(key, entry.start, entry.low, entry.high, ())


def aims(key: str, entry: Free, data: dict[str, Any]) -> Iterator[tuple[KeyPath, Any]]:
    """The paths that an entry sets, each with the nominal value that it multiplies or None. Raises ValueError."""
    for one in (key, *entry.also):
        found, _ = places(one, data)
        for path in found:
            nominal = value_at(data, path)
            entries = nominal if isinstance(nominal, list | tuple) else (nominal,)
            numeric = all(isinstance(number, int | float) and not isinstance(number, bool) for number in entries)
            if entry.scale and not (numeric and entries):
                has = "nothing" if nominal is MISSING else show_value(nominal)
                raise ValueError(f"scale = true multiplies a number that the scene has, and {one} has {has}")
            if not entry.scale and nominal is not MISSING and (not numeric or isinstance(nominal, list | tuple)):
                raise ValueError(
                    f"{one} has {show_value(nominal)}, which is no number; with scale = true a factor on it"
                )
            yield path, nominal if entry.scale else None


def unfit(made: Parameter, data: dict[str, Any]) -> Problem | None:
    """The first of its values that the scene does not allow."""
    for name, value in (("from", made.low), ("to", made.high), ("start", made.start)):
        trial = with_values(data, made.settings(value))
        try:
            validate(trial)
        except ConfigError as error:
            return Problem(("free", made.key, name), f"no such scene: {sentence(error.problems[0], trial)}")
    return None


def point(base: Tracked, made: Sequence[Parameter], values: Sequence[float]) -> Point:
    """The tracked point with these values of the parameters."""
    found = base.model_dump() | {
        one.key.removeprefix(TRACKED): value for one, value in zip(made, values, strict=True) if not one.targets
    }
    return Point(found["x"], found["y"], math.radians(found["yaw_deg"]))
