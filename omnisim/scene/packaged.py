"""What comes with the package: scenes, and wheels that are sold, which other scenes may name."""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from omnisim.scene.problems import ConfigError, Problem, did_you_mean
from omnisim.scene.toml_text import MISSING, KeyPath

WHEELS = "wheels"  # their folder
FROM = "from"  # the key of a wheel type that names one


def packaged_data() -> Path:
    """The folder of all that: an installation has it in the package, a clone beside it."""
    package = Path(__file__).parents[1]
    return next(folder for folder in (package / "data", package.parent / "data") if folder.is_dir())


def packaged_scenes() -> list[str]:
    """Names of the scenes that come with the package, but those of a wheel that is sold."""
    return _names(packaged_data())


def packaged_wheels() -> list[str]:
    """Names of the wheels that come with the package, each a scene with one type of wheel."""
    return _names(packaged_data() / WHEELS)


def packaged_file(name: str) -> str:
    """The path of a packaged scene or wheel."""
    folder = packaged_data()
    return str((folder if name in packaged_scenes() else folder / WHEELS) / f"{name}.toml")


def packaged_text(name: str) -> str:
    """What stands in it."""
    with open(packaged_file(name), encoding="utf-8", newline="") as file:
        return file.read()


def taken_over(data: Any) -> list[tuple[KeyPath, Any]]:
    """Keys and values that wheel types take over from the packaged wheels that they name, and MISSING for that name.

    data: a parsed scene, which need not be valid. Raises ConfigError for the name of no wheel.
    """
    types = data.get("wheel_types") if isinstance(data, dict) else None
    edits: list[tuple[KeyPath, Any]] = []
    for name, table in types.items() if isinstance(types, dict) else ():
        wheel = table.get(FROM) if isinstance(table, dict) else None
        if isinstance(wheel, str):
            path = ("wheel_types", name)
            edits += _left_out(path, table, _keys(wheel, (*path, FROM)))
            edits.append(((*path, FROM), MISSING))
    return edits


def _keys(wheel: str, path: KeyPath) -> dict[str, Any]:
    """The table of a packaged wheel."""
    known = packaged_wheels()
    if wheel not in known:
        hint = did_you_mean(wheel, known) or f"; must be one of {', '.join(known)}"
        raise ConfigError([Problem(path, f"no packaged wheel has this name{hint}")])
    table: dict[str, Any] = tomllib.loads(packaged_text(wheel))["wheel_types"][wheel]
    return table


def _left_out(path: KeyPath, table: dict[str, Any], whole: dict[str, Any]) -> Iterator[tuple[KeyPath, Any]]:
    """What of `whole` the table does not give, tables in it likewise."""
    for key, value in whole.items():
        if key not in table:
            yield (*path, key), value
        elif isinstance(value, dict) and isinstance(table[key], dict):
            yield from _left_out((*path, key), table[key], value)


def _names(folder: Path) -> list[str]:
    return sorted(entry.name[:-5] for entry in folder.iterdir() if entry.name.endswith(".toml"))
