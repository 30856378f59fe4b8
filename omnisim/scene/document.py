"""A TOML text as a user wrote it: what it says, and where everything in it stands, for messages."""

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from omnisim.scene.problems import Problem
from omnisim.scene.toml_text import (
    DEEPEST,
    MISSING,
    KeyPath,
    TooDeep,
    is_deeper,
    locate,
    long_key,
    show_path,
    show_value,
    value_at,
)
from omnisim.scene.values import is_name

MOST_BYTES = 8 << 20  # of a file: tables of a hundred thousand rows
MOST_PROBLEMS = 20  # that a message tells


class InputError(ValueError):
    """What is wrong with a text, one line for each problem: file, line, key, value, what is allowed."""


class Override(NamedTuple):
    """One value set: who says so, its path, and the topmost path that it created or replaced."""

    origin: str
    path: KeyPath
    value: Any
    top: KeyPath


@dataclass(frozen=True)
class Document:
    """A text as it was handed over: what it says, overrides applied; its text without them; its source; overrides."""

    data: dict[str, Any]
    text: str
    source: str
    applied: tuple[Override, ...] = ()

    def told(self, problems: Iterable[Problem]) -> str:
        """One line for each problem in the order of the file, those of overrides first."""
        problems = list(problems)
        if not problems:
            return ""  # the text is not scanned in vain
        places = {path: (line, f"{self.source}:{line}") for path, line in locate(self.text).items()}
        for override in self.applied:
            top = override.top
            places = {path: place for path, place in places.items() if path[: len(top)] != top}
            places[top] = (0, override.origin)
        lines = []
        for problem in problems:
            line, place = _nearest(places, problem.path, problem.asking)
            lines.append((line, f"{place}: {sentence(problem, self.data)}"))
        told = [message for _, message in sorted(lines, key=lambda entry: entry[0])]
        more = [f"{self.source}: and more of this"] if len(told) > MOST_PROBLEMS else []
        return "\n".join([*told[:MOST_PROBLEMS], *more])


def parsed(text: str, source: str) -> Document:
    """The Document of a text; `source` names it in messages. Raises InputError for what is no TOML."""
    try:
        line = long_key(text)
        data = {} if line else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(_syntax(error, text, source)) from None
    if line or is_deeper(data, DEEPEST):
        raise InputError(f"{source}:{line or _deep_line(text)}: keys are nested more than {DEEPEST} deep")
    return Document(data, text, source)


def decoded(content: bytes, source: str) -> str:
    """The text in the bytes of a file. Raises InputError."""
    try:
        return content.decode("utf-8-sig")  # some editors write a byte order mark, which TOML does not allow
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{source}:{line}: not a text in UTF-8, as TOML must be: {error.reason}") from None


def by_name(path: KeyPath, data: dict[str, Any]) -> KeyPath:
    """Wheels by name, as --set takes them, if they have one."""
    if len(path) > 1 and path[0] == "wheels":
        wheel = data["wheels"][path[1]]
        if isinstance(wheel, dict) and is_name(wheel.get("name")):
            return ("wheels", wheel["name"], *path[2:])
    return path


def _nearest(places: dict[KeyPath, tuple[int, str]], path: KeyPath, asking: KeyPath) -> tuple[int, str]:
    """The place of a key; of its table when it is missing; of what asks for it when that is missing too."""
    while path not in places:
        path = path[:-1]
    return places[path] if path or not asking else _nearest(places, asking, ())


def sentence(problem: Problem, data: dict[str, Any]) -> str:
    """Key, value, and what is allowed."""
    name = show_path(by_name(problem.path, data))
    value = value_at(data, problem.path)
    return f"{name}: {problem.message}" if value is MISSING else f"{name} = {show_value(value)}: {problem.message}"


def _syntax(error: Exception, text: str, source: str) -> str:
    """tomllib gives the position at the end of its sentence, in words; a few errors have none."""
    if isinstance(error, RecursionError):
        return f"{source}: not valid TOML: nested too deeply"
    found = re.fullmatch(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", str(error), re.DOTALL)
    if not found:
        return f"{source}: not valid TOML: {error}"
    lines = text.splitlines() or [""]
    line = int(found[2] or len(lines))
    column = f", column {found[3]}" if found[3] else ", end of the file"
    shown = show_value(lines[min(line, len(lines)) - 1].strip())
    return f"{source}:{line}: not valid TOML: {found[1]} (line {line}{column}): {shown}"


def _deep_line(text: str) -> int:
    try:
        locate(text)
    except TooDeep as error:
        return error.line
    return 1
