"""From a scene file and overrides to a checked, frozen Scene, or to a SceneError that says what to change."""

import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from omnisim.base.arguments import path_text, shown
from omnisim.base.files import is_hdf5, read_small
from omnisim.base.formatting import visible
from omnisim.scene.problems import ConfigError, Problem, did_you_mean
from omnisim.scene.schema import FRICTION_KEYS, Config
from omnisim.scene.toml_text import (
    DEEPEST,
    MISSING,
    KeyPath,
    TooDeep,
    assign,
    is_deeper,
    locate,
    long_key,
    rewrite,
    shortened,
    show_path,
    show_value,
    split_key,
    value_at,
)
from omnisim.scene.validation import validate
from omnisim.scene.values import is_name

Overrides = Iterable[str] | Mapping[str, Any]  # ["time.end=1"], or {"time.end": 1}, or {"time": {"end": 1}}
SOURCE = "a path or the name of a packaged scene"
MOST_BYTES = 8 << 20  # of a scene file: tables of a hundred thousand rows
MOST_PROBLEMS = 20  # that a message tells


class SceneError(ValueError):
    """What is wrong with a scene, one line for each problem: file, line, key, value, what is allowed."""


@dataclass(frozen=True)
class Scene:
    """A checked scene, as `load` and `load_text` make it.

        scene = omnisim.load("youbot", {"friction.coefficient": 0.3})
        omnisim.simulate(scene)

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
        from omnisim.scene.plausibility import doubts  # here: it computes, and not everyone asks

        return tuple(_report(doubts(self.config), self._written).splitlines())

    def __repr__(self) -> str:
        config = self.config
        time = self.config.time
        friction = self.config.friction
        step = f"step {time.step:g} s" if config.solver.error is None else f"error {config.solver.error:g}"
        kinds = ", ".join(
            f"{name}: {kind.roller_count} rollers at {kind.roller_angle_deg:g} deg, radius {kind.radius:g} m"
            for name, kind in config.wheel_types.items()
        )
        drives = Counter(wheel.drive.kind for wheel in config.wheels)
        law = ", ".join([friction.law, *(f"{key} {getattr(friction, key):g}" for key in FRICTION_KEYS[friction.law])])
        body = f"a chassis of {config.chassis.mass:g} kg" if config.chassis else "no chassis"
        return (
            f"<Scene {config.title!r} from {self.source}\n"
            f"  wheels    {', '.join(wheel.name for wheel in config.wheels)} ({kinds}); {body}\n"
            f"  drives    {', '.join(f'{count} {kind}' for kind, count in drives.items())}\n"
            f"  friction  {law}\n"
            f"  time      {time.end:g} s by {config.solver.method}, {step}, rows every {time.output_interval:g} s>"
        )


@dataclass(frozen=True)
class _Written:
    """A scene as it was handed over: what it says, overrides applied; its text without them; its source; overrides."""

    data: dict[str, Any]
    text: str
    source: str
    applied: "tuple[_Override, ...]"


@dataclass(frozen=True)
class _Override:
    """One value set: who says so, its path, and the topmost path that it created or replaced."""

    origin: str
    path: KeyPath
    value: Any
    top: KeyPath


def load(source: str | PathLike[str], overrides: Overrides = ()) -> Scene:
    """The scene in a file, TOML or trajectory, or else the packaged one of that name, with overrides applied.

        omnisim.load("youbot", {"friction.coefficient": 0.3, "wheels.front_left.spin_rate": 2.0})
        omnisim.load("scene.toml", {"time": {"end": 1.0}})       tables of keys: each is set, the others stay
        omnisim.load("scene.toml", ["friction.coefficient=0.3"])           as --set takes them

    Raises SceneError for everything that is wrong with the source, its text, the overrides or the scene, TypeError
    where an argument is none of these.
    """
    source = path_text("load", source, SOURCE)
    path = Path(source)
    source = visible(str(source))
    try:
        if path.exists() and not (path.is_dir() and source in packaged_scenes()):
            return parse(_text(path, source), source, overrides)
    except OSError as error:
        raise SceneError(f"{source}: cannot read this file: {error.strerror}") from None
    if source not in packaged_scenes():
        raise SceneError(_not_found(path, source))
    return parse(_decode(_packaged(source).read_bytes(), source), source, overrides)


def load_text(text: str, overrides: Overrides = ()) -> Scene:
    """The scene in a TOML text, with overrides as `load` takes them. Messages call it "<text>".

    Raises SceneError for everything that is wrong with it, TypeError for what is no text.
    """
    if not isinstance(text, str):
        raise TypeError(f"load_text takes the text of a scene, not {shown(text)}")
    return parse(text, overrides=overrides)


def as_scene(function: str, scene: Scene | str | PathLike[str]) -> Scene:
    """A Scene, or what `load` makes of its source; `function` is who was given it."""
    return scene if isinstance(scene, Scene) else load(path_text(function, scene, f"a Scene, {SOURCE}"))


def changed(scene: Scene, overrides: Overrides) -> Scene:
    """The scene with overrides on top of those that it has."""
    return scene if overrides == () else parse(scene.text, scene.source, overrides)


def parse(text: str, source: str = "<text>", overrides: Overrides = ()) -> Scene:
    """The scene in a TOML text; `source` names it in messages. Raises SceneError."""
    try:
        line = long_key(text)
        data = {} if line else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise SceneError(_syntax(error, text, source)) from None
    if line or is_deeper(data, DEEPEST):
        raise SceneError(f"{source}:{line or _deep_line(text)}: keys are nested more than {DEEPEST} deep")
    applied = []
    for origin, path, value in _values(overrides):
        applied.append(_apply(data, origin, path, value))
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


def _text(path: Path, source: str) -> str:
    """The TOML text in a file, or in the trajectory that a file is."""
    if not is_hdf5(path):
        return _decode(read_small(path, MOST_BYTES), source)
    from omnisim.base.trajectory_file import TrajectoryError, stored_scene  # here: a text needs no HDF5

    try:
        return stored_scene(path)
    except TrajectoryError as error:
        raise SceneError(str(error)) from None


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


def _deep_line(text: str) -> int:
    try:
        locate(text)
    except TooDeep as error:
        return error.line
    return 1


# --- overrides ------------------------------------------------------------------------------------


def _values(overrides: Overrides) -> Iterator[tuple[str, KeyPath, Any]]:
    """Who says it, the path with wheels by name, and the value of each override."""
    if isinstance(overrides, Mapping):
        yield from _entries(overrides, ())
        return
    if isinstance(overrides, str) or not isinstance(overrides, Iterable):
        raise TypeError(f"overrides must be a dict or a list of texts 'KEY=VALUE', not {shown(overrides)}")
    for argument in overrides:
        if not isinstance(argument, str):
            raise TypeError(f"an override must be a text 'KEY=VALUE', not {shown(argument)}")
        yield _argument(argument)


def _entries(table: Mapping[str, Any], above: KeyPath) -> Iterator[tuple[str, KeyPath, Any]]:
    """The values in a dict of dotted keys, tables in it taken apart."""
    for key, value in table.items():
        try:
            path = (*above, *split_key(key))
        except (TypeError, ValueError):
            raise SceneError(f"overrides: {shown(key)} is no key; must be dotted, such as 'time.step'") from None
        if isinstance(value, Mapping):
            yield from _entries(value, path)
        else:
            yield "overrides", path, _plain(value, path)


def _plain(value: Any, path: KeyPath) -> Any:
    """A value as TOML knows it: numbers and arrays of NumPy become Python's."""
    value = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(value, list | tuple):
        return [_plain(entry, path) for entry in value]
    if isinstance(value, Mapping):
        return {str(key): _plain(entry, path) for key, entry in value.items()}
    if not isinstance(value, bool | int | float | str):
        raise SceneError(f"overrides: {show_path(path)} = {shown(value)} is nothing that a scene can hold")
    return value


def _argument(argument: str) -> tuple[str, KeyPath, Any]:
    """What `--set argument` says."""
    key, equals, value = argument.partition("=")
    argument = visible(shortened(argument, 100))
    try:
        path = split_key(key.strip())
    except ValueError:
        equals = ""
    if not equals:
        raise SceneError(f"--set {argument}: must be KEY=VALUE with a dotted key, such as time.step=0.001")
    return f"--set {argument}", path, _read_value(value.strip())


def _apply(data: dict[str, Any], origin: str, path: KeyPath, value: Any) -> _Override:
    """Sets a value in the parsed scene; `origin` is who says so."""
    if is_deeper(value, DEEPEST - len(path)):
        raise SceneError(f"{origin}: keys are nested more than {DEEPEST} deep")
    path = _with_index(data, path, origin)
    top = _topmost_new(data, path, origin)
    assign(data, path, value)
    return _Override(origin, path, value, top)


def _read_value(text: str) -> Any:
    """A TOML value if it is exactly one, else the text itself."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if len(parsed) == 1 else text


def _with_index(data: dict[str, Any], path: KeyPath, origin: str) -> KeyPath:
    """Wheels are written by name and stored in a list."""
    if path[0] != "wheels" or len(path) == 1:
        return path
    wheels = data.get("wheels")
    wheels = wheels if isinstance(wheels, list) else []
    names: list[Any] = [wheel.get("name") if isinstance(wheel, dict) else None for wheel in wheels]
    if path[1] not in names:
        known = [name for name in names if is_name(name)]
        hint = (did_you_mean(path[1], known) or ".") + f" Wheels: {', '.join(known) or 'none'}"
        raise SceneError(f"{origin}: no wheel is called '{path[1]}'{hint}")
    if len(path) == 2:
        allowed = f"a key of the wheel, such as {show_path(path)}.spin_rate=1.0"
        raise SceneError(f"{origin}: must set {allowed}")
    return ("wheels", names.index(path[1]), *path[2:])


def _topmost_new(data: dict[str, Any], path: KeyPath, origin: str) -> KeyPath:
    table: Any = data
    for depth, part in enumerate(path):
        if isinstance(part, int):
            table = table[part]
            continue
        if not isinstance(table, dict):
            name = show_path(_by_name(path[:depth], data))
            raise SceneError(f"{origin}: {name} = {show_value(table)} is not a table and has no keys")
        if part not in table:
            return path[: depth + 1]
        table = table[part]
    return path


# --- messages -------------------------------------------------------------------------------------


def _report(problems: Iterable[Problem], written: _Written) -> str:
    """One line for each problem in the order of the file, those of overrides first."""
    problems = list(problems)
    data = written.data
    if not problems:
        return ""  # the text is not scanned in vain
    places = {path: (line, f"{written.source}:{line}") for path, line in locate(written.text).items()}
    for override in written.applied:
        top = override.top
        places = {path: place for path, place in places.items() if path[: len(top)] != top}
        places[top] = (0, override.origin)
    lines = []
    for problem in problems:
        line, place = _nearest(places, problem.path)
        lines.append((line, f"{place}: {_key_and_value(problem.path, data)}: {problem.message}"))
    told = [message for _, message in sorted(lines, key=lambda entry: entry[0])]
    more = [f"{written.source}: and more of this"] if len(told) > MOST_PROBLEMS else []
    return "\n".join([*told[:MOST_PROBLEMS], *more])


def _nearest(places: dict[KeyPath, tuple[int, str]], path: KeyPath) -> tuple[int, str]:
    """The place of a key; of its table when it is missing."""
    while path not in places:
        path = path[:-1]
    return places[path]


def _key_and_value(path: KeyPath, data: dict[str, Any]) -> str:
    name = show_path(_by_name(path, data))
    value = value_at(data, path)
    return name if value is MISSING else f"{name} = {show_value(value)}"


def _by_name(path: KeyPath, data: dict[str, Any]) -> KeyPath:
    """Wheels by name, as --set takes them, if they have one."""
    if len(path) > 1 and path[0] == "wheels":
        wheel = data["wheels"][path[1]]
        if isinstance(wheel, dict) and is_name(wheel.get("name")):
            return ("wheels", wheel["name"], *path[2:])
    return path
