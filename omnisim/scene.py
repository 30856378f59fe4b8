"""From a scene file and overrides to a checked, frozen Scene, or to a SceneError that says what to change."""

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from omnisim.config import Config, is_name
from omnisim.problems import ConfigError, Problem, did_you_mean
from omnisim.toml_text import (
    MISSING,
    KeyPath,
    assign,
    locate,
    rewrite,
    show_path,
    show_value,
    split_key,
    value_at,
)
from omnisim.validation import validate


class SceneError(ValueError):
    """What is wrong with a scene, one line for each problem: file, line, key, value, what is allowed."""


@dataclass(frozen=True)
class Scene:
    """A checked scene.

    config  what the file says, in its units
    text    the whole TOML with overrides applied: loading it repeats the run
    name    stem of default output files
    source  the path, or the name of a packaged scene
    """

    config: Config
    text: str
    name: str
    source: str
    _written: "_Written" = field(repr=False, compare=False)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What is hardly meant, one line each: file, line, key, value, what is expected. See plausibility.py."""
        from omnisim.plausibility import doubts  # here: it computes, and not everyone asks

        return tuple(_report(doubts(self.config), self._written).splitlines())


@dataclass(frozen=True)
class _Written:
    """A scene as it was handed over: what it says, overrides applied; its text without them; its source; overrides."""

    data: dict[str, Any]
    text: str
    source: str
    applied: "tuple[_Override, ...]"


@dataclass(frozen=True)
class _Override:
    """One `--set KEY=VALUE`: the value, its path, and the topmost path that it created or replaced."""

    argument: str
    path: KeyPath
    value: Any
    top: KeyPath


def load(source: str | Path, overrides: Iterable[str] = ()) -> Scene:
    """The scene in a file, or else the packaged scene of that name, with `KEY=VALUE` overrides applied.

    Raises SceneError for everything that is wrong with the source, its text, the overrides or the scene.
    """
    source = str(source)
    path = Path(source)
    try:
        if path.exists() and not (path.is_dir() and source in packaged_scenes()):
            return parse(_decode(path.read_bytes(), source), source, overrides)
    except OSError as error:
        raise SceneError(f"{source}: cannot read this file: {error.strerror}") from None
    if source not in packaged_scenes():
        raise SceneError(_not_found(path, source))
    return parse(_decode(_packaged(source).read_bytes(), source), source, overrides)


def parse(text: str, source: str = "<text>", overrides: Iterable[str] = ()) -> Scene:
    """The scene in a TOML text; `source` names it in messages. Raises SceneError."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(_syntax(error, text, source)) from None
    applied = []
    for argument in overrides:
        applied.append(_apply(data, argument))
    written = _Written(data, text, source, tuple(applied))
    try:
        config = validate(data)
    except ConfigError as error:
        raise SceneError(_report(error.problems, written)) from None
    if applied:
        text = rewrite(text, [(override.path, override.value) for override in applied], data)
    return Scene(config, text, "scene" if source == "<text>" else Path(source).stem, source, written)


def packaged_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(entry.name[:-5] for entry in _packaged().iterdir() if entry.name.endswith(".toml"))


def _packaged(name: str | None = None) -> Any:
    from importlib.resources import files  # here: slow to import, and a scene file does not need it

    folder = files("omnisim.data")
    return folder if name is None else folder / f"{name}.toml"


def _decode(content: bytes, source: str) -> str:
    try:
        return content.decode("utf-8-sig")  # some editors write a byte order mark, which TOML does not allow
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise SceneError(f"{source}:{line}: not a text in UTF-8, as TOML must be: {error.reason}") from None


def _not_found(path: Path, source: str) -> str:
    known = packaged_scenes()
    if path.suffix == ".toml" or len(path.parts) > 1:
        hint = f"; did you mean the packaged scene '{path.stem}'?" if path.stem in known else ""
        return f"{source}: there is no such file{hint}"
    hint = did_you_mean(source, known) or "."
    names = ", ".join(known) or "none"
    return f"{source}: no file and no packaged scene has this name{hint} Packaged scenes: {names}"


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


# --- overrides ------------------------------------------------------------------------------------


def _apply(data: dict[str, Any], argument: str) -> _Override:
    """Sets what `--set argument` says in the parsed scene."""
    key, equals, value = argument.partition("=")
    try:
        path = split_key(key.strip())
    except ValueError:
        equals = ""
    if not equals:
        raise SceneError(f"--set {argument}: must be KEY=VALUE with a dotted key, such as time.step=0.001")
    path = _with_index(data, path, argument)
    top = _topmost_new(data, path, argument)
    override = _Override(argument, path, _read_value(value.strip()), top)
    assign(data, path, override.value)
    return override


def _read_value(text: str) -> Any:
    """A TOML value if it is exactly one, else the text itself."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if len(parsed) == 1 else text


def _with_index(data: dict[str, Any], path: KeyPath, argument: str) -> KeyPath:
    """Wheels are written by name and stored in a list."""
    if path[0] != "wheels" or len(path) == 1:
        return path
    wheels = data.get("wheels")
    wheels = wheels if isinstance(wheels, list) else []
    names = [wheel.get("name") if isinstance(wheel, dict) else None for wheel in wheels]
    if path[1] not in names:
        known = [name for name in names if is_name(name)]
        hint = (did_you_mean(path[1], known) or ".") + f" Wheels: {', '.join(known) or 'none'}"
        raise SceneError(f"--set {argument}: no wheel is called '{path[1]}'{hint}")
    if len(path) == 2:
        allowed = f"a key of the wheel, such as {show_path(path)}.spin_rate=1.0"
        raise SceneError(f"--set {argument}: must set {allowed}")
    return ("wheels", names.index(path[1]), *path[2:])


def _topmost_new(data: dict[str, Any], path: KeyPath, argument: str) -> KeyPath:
    table: Any = data
    for depth, part in enumerate(path):
        if isinstance(part, int):
            table = table[part]
            continue
        if not isinstance(table, dict):
            name = show_path(_by_name(path[:depth], data))
            raise SceneError(f"--set {argument}: {name} = {show_value(table)} is not a table and has no keys")
        if part not in table:
            return path[: depth + 1]
        table = table[part]
    return path


# --- messages -------------------------------------------------------------------------------------


def _report(problems: Iterable[Problem], written: _Written) -> str:
    """One line for each problem in the order of the file, those of overrides first."""
    problems, data = list(problems), written.data
    if not problems:
        return ""  # the text is not scanned in vain
    places = {path: (line, f"{written.source}:{line}") for path, line in locate(written.text).items()}
    for override in written.applied:
        top = override.top
        places = {path: place for path, place in places.items() if path[: len(top)] != top}
        places[top] = (0, f"--set {override.argument}")
    lines = []
    for problem in problems:
        line, place = _nearest(places, problem.path)
        lines.append((line, f"{place}: {_key_and_value(problem.path, data)}: {problem.message}"))
    return "\n".join(message for _, message in sorted(lines, key=lambda entry: entry[0]))


def _nearest(places: dict[KeyPath, tuple[int, str]], path: KeyPath) -> tuple[int, str]:
    """The place of a key; of its table when it is missing."""
    while path not in places:
        path = path[:-1]
    return places[path]


def _key_and_value(path: KeyPath, data: dict[str, Any]) -> str:
    name, value = show_path(_by_name(path, data)), value_at(data, path)
    return name if value is MISSING else f"{name} = {show_value(value)}"


def _by_name(path: KeyPath, data: dict[str, Any]) -> KeyPath:
    """Wheels by name, as --set takes them, if they have one."""
    if len(path) > 1 and path[0] == "wheels":
        wheel = data["wheels"][path[1]]
        if isinstance(wheel, dict) and is_name(wheel.get("name")):
            return ("wheels", wheel["name"], *path[2:])
    return path
