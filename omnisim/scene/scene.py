"""From a scene file and overrides to a checked, frozen Scene, or to a SceneError that says what to change."""

import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from omnisim.base.arguments import path_text, shown
from omnisim.base.files import is_hdf5, read_small
from omnisim.base.formatting import visible
from omnisim.scene.document import MOST_BYTES, Document, InputError, Override, by_name, decoded, parsed
from omnisim.scene.heights import GRID_FILE, kept_heights
from omnisim.scene.packaged import packaged_file as _packaged
from omnisim.scene.packaged import packaged_scenes, packaged_wheels, taken_over
from omnisim.scene.problems import ConfigError, did_you_mean
from omnisim.scene.schema import FRICTION_KEYS, Config
from omnisim.scene.toml_text import (
    DEEPEST,
    KeyPath,
    assign,
    is_deeper,
    rewrite,
    shortened,
    show_path,
    show_value,
    split_key,
)
from omnisim.scene.validation import validate
from omnisim.scene.values import is_name

Overrides = Iterable[str] | Mapping[str, Any]  # ["time.end=1"], or {"time.end": 1}, or {"time": {"end": 1}}
SOURCE = "a path or the name of a packaged scene"


class SceneError(InputError):
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
    document: Document = field(repr=False, compare=False)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """What is hardly meant, one line each: file, line, key, value, what is expected. See plausibility.py."""
        from omnisim.scene.plausibility import doubts  # here: it computes, and not everyone asks

        return tuple(self.document.told(doubts(self.config)).splitlines())

    def __repr__(self) -> str:
        config = self.config
        time = self.config.time
        friction = self.config.friction
        step = f"step {time.step:g} s" if config.solver.error is None else f"error {config.solver.error:g}"
        kinds = ", ".join(
            f"{name}: {kind.rollers} rollers at {kind.roller_angle_deg:g} deg, radius {kind.radius:g} m"
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
        if path.exists() and not (path.is_dir() and source in _packaged_names()):
            return parse(_text(path, source), source, overrides, path.parent)
    except OSError as error:
        raise SceneError(f"{source}: cannot read this file: {error.strerror}") from None
    if source not in _packaged_names():
        raise SceneError(_not_found(path, source))
    packaged = Path(_packaged(source))
    return parse(_decode(packaged.read_bytes(), source), source, overrides, packaged.parent)


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


def parse(text: str, source: str = "<text>", overrides: Overrides = (), folder: Path | None = None) -> Scene:
    """The scene in a TOML text; `source` names it in messages. Files that it names stand in `folder`, by default that
    of the source. Raises SceneError."""
    try:
        document = parsed(text, source)
    except InputError as error:
        raise SceneError(str(error)) from None
    applied = [_apply(document.data, origin, path, value) for origin, path, value in _values(overrides)]
    document = replace(document, applied=tuple(applied))
    edits: list[tuple[KeyPath, Any]] = [(override.path, override.value) for override in applied]
    try:
        for path, value in taken_over(document.data):
            assign(document.data, path, value)
            edits.append((path, value))
        config = validate(document.data)
        if heights := kept_heights(config, Path(source).parent if folder is None else folder):
            assign(document.data, GRID_FILE, heights)
            edits.append((GRID_FILE, heights))
            config = validate(document.data)
    except ConfigError as error:
        raise SceneError(document.told(error.problems)) from None
    if edits:
        text = rewrite(text, edits, document.data)
    return Scene(config, text, "scene" if source == "<text>" else Path(source).stem, source, document)


def _packaged_names() -> list[str]:
    return packaged_scenes() + packaged_wheels()


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
        return decoded(content, source)
    except InputError as error:
        raise SceneError(str(error)) from None


def _not_found(path: Path, source: str) -> str:
    known = _packaged_names()
    if path.suffix == ".toml" or len(path.parts) > 1:
        hint = f"; did you mean the packaged scene '{path.stem}'?" if path.stem in known else ""
        return f"{source}: there is no such file{hint}"
    hint = did_you_mean(source, known) or "."
    names = ", ".join(packaged_scenes()) or "none"
    return f"{source}: no file and no packaged scene has this name{hint} Packaged scenes: {names}"


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


def _apply(data: dict[str, Any], origin: str, path: KeyPath, value: Any) -> Override:
    """Sets a value in the parsed scene; `origin` is who says so."""
    if is_deeper(value, DEEPEST - len(path)):
        raise SceneError(f"{origin}: keys are nested more than {DEEPEST} deep")
    path = with_index(data, path, origin)
    top = _topmost_new(data, path, origin)
    assign(data, path, value)
    return Override(origin, path, value, top)


def _read_value(text: str) -> Any:
    """A TOML value if it is exactly one, else the text itself."""
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if len(parsed) == 1 else text


def with_index(data: dict[str, Any], path: KeyPath, origin: str) -> KeyPath:
    """Wheels are written by name and stored in a list. Raises SceneError for one that is not there."""
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
            name = show_path(by_name(path[:depth], data))
            raise SceneError(f"{origin}: {name} = {show_value(table)} is not a table and has no keys")
        if part not in table:
            return path[: depth + 1]
        table = table[part]
    return path
