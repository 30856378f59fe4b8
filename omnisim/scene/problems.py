"""What is wrong with a scene, in the words of the scene file instead of the validator's."""

import difflib
import math
from collections.abc import Iterable, Iterator
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from omnisim.scene.schema import Config
from omnisim.scene.toml_text import MISSING, KeyPath, value_at
from omnisim.scene.values import Name, Table

MOST = 200  # errors of pydantic that are looked at: a file of nonsense has as many as keys


class Problem(NamedTuple):
    """One defect of a scene: the key it is about (wheels and entries by index), what is allowed, and the key that asks
    for it, which is shown where not even its table is there."""

    path: KeyPath
    message: str
    asking: KeyPath = ()


class ConfigError(ValueError):
    """All `problems` found in a scene; the caller knows the text and can say where they stand."""

    def __init__(self, problems: Iterable[Problem]):
        self.problems = tuple(problems)
        super().__init__("\n".join(f"{problem.path}: {problem.message}" for problem in self.problems))


def did_you_mean(word: Any, known: Iterable[str]) -> str:
    """A hint to append to a message, or nothing."""
    close = _closest(word, known)
    return f"; did you mean '{close}'?" if close else ""


def _closest(word: Any, known: Iterable[str]) -> str | None:
    known = {name.lower(): name for name in known}
    close = difflib.get_close_matches(str(word).lower(), list(known), 1)
    return known[close[0]] if close else None


class _Place(NamedTuple):
    """Where a pydantic location lands in the models: `rest` is what lies deeper than any key."""

    path: KeyPath
    table: type[Table]  # that the last key of the path belongs to
    field: FieldInfo | None  # that it names; None when unknown
    nested: type[Table] | None  # the table that stands there
    rest: KeyPath


def _place(location: KeyPath, root: type[Table] = Config) -> _Place:
    table: type[Table] = root
    field: FieldInfo | None = None
    nested: type[Table] | None = root
    path: KeyPath = ()
    rest = location
    while rest and nested:
        table = nested
        path = (*path, rest[0])
        rest = rest[1:]
        field = _fields(table).get(str(path[-1]))
        nested, many = _nested(field.annotation) if field else (None, False)
        if many and rest:
            path = (*path, rest[0])
            rest = rest[1:]
        elif many:
            nested = None
    return _Place(path, table, field, nested, rest)


def _fields(table: type[Table]) -> dict[str, FieldInfo]:
    return {field.alias or name: field for name, field in table.model_fields.items()}


def _nested(annotation: Any) -> tuple[type[Table] | None, bool]:
    """The table that a field holds, and whether it holds many of them."""
    for part in (annotation, *get_args(annotation)):
        if isinstance(part, type) and issubclass(part, Table):
            return part, get_origin(annotation) in (tuple, dict)
    return None, False


def _allowed(place: _Place) -> str:
    if place.nested:
        return f"a table with the keys {', '.join(_fields(place.nested))}"
    return (place.field and place.field.description) or "a known key"


def misplaced(path: KeyPath) -> Problem | None:
    """What is wrong with a path that no scene file can have."""
    place = _place(path)
    if place.field is None:
        return _unknown_key(place)
    return Problem(place.path, "is not a table and has no keys") if place.rest else None


def allowed_at(path: KeyPath) -> str:
    """What the scene file allows at a path."""
    return _allowed(_place(path))


def schema_problems(error: ValidationError, data: Any, root: type[Table] = Config) -> Iterator[Problem]:
    """The problems behind pydantic's errors: one for each defect of `data`, which was meant to be a `root`."""
    items = [(item["type"], item["loc"]) for item in error.errors(include_url=False, include_input=False)][:MOST]
    # Missing keys that an unknown one nearly spells are no second defect.
    unknown = {location for kind, location in items if kind == "extra_forbidden"}
    meant = {(*path[:-1], _closest(path[-1], _fields(_place(path, root).table))) for path in unknown}
    for location in _deepest((location for _, location in items), root):
        place = _place(location, root)
        if location in unknown:
            yield _unknown_key(place)
        elif location[-1] == "[key]":
            yield Problem(location[:-1], f"must be {get_args(Name)[1].description}")
        elif value_at(data, place.path) is not MISSING:
            yield _wrong_value(data, place)
        elif place.path not in meant:
            yield Problem(place.path, f"missing; must be {_allowed(place)}")


def _unknown_key(place: _Place) -> Problem:
    known = _fields(place.table)
    hint = did_you_mean(place.path[-1], known) or "."
    return Problem(place.path, f"unknown key{hint} Allowed: {', '.join(known)}")


def _deepest(locations: Iterable[KeyPath], root: type[Table]) -> Iterable[KeyPath]:
    """One location for each defect: the deepest. A union reports once for every type that it tried, and a
    list of tables that it is too short when the tables in it are wrong."""
    best: dict[KeyPath, KeyPath] = {}
    for location in sorted(locations, key=len, reverse=True):
        best.setdefault(_place(location, root).path, location)
    parents = {path[:end] for path in best for end in range(len(path))}
    return [location for path, location in best.items() if path not in parents]


def _wrong_value(data: Any, place: _Place) -> Problem:
    path = place.path
    for index in (part for part in place.rest if isinstance(part, int)):
        if value_at(data, (*path, index)) is not MISSING:
            path = (*path, index)
    value = value_at(data, path)
    hint = ""
    if isinstance(value, str):
        annotation = place.field.annotation if place.field else None
        kinds = [kind for kind in (annotation, *get_args(annotation)) if get_origin(kind) is Literal]
        if kinds:
            hint = did_you_mean(value, get_args(kinds[0]))
        elif "number" in _allowed(place) and (number := _number_in(value)) is not None:
            hint = f"; did you mean {number}?"
    return Problem(path, f"must be {_allowed(place)}{hint}")


def _number_in(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None
