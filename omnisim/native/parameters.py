"""Parameters: numbers of a scene that a machine can be given when it is native code already.

What a machine begins with is packed from the scene by Python, and much of it takes arithmetic that is not part of the
library: masses and lengths enter inverse inertias, sines, loads. A number to which all that it changes is proportional
needs none. Which these are is not declared but found: the scene is packed anew with each of its numbers scaled, over
the range that the parameter is then given.
"""

import tomllib
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from omnisim.native.memory import Memory, machine_of
from omnisim.native.units import unit_of
from omnisim.scene.problems import ConfigError
from omnisim.scene.scene import Scene, SceneError, changed

FACTORS = (0.8, 0.5, 0.25), (1.25, 2.0, 4.0)  # by which a number is scaled, down and up, the last that the scene allows
ROUNDING = 1e-15  # relative
LEAST_NUMBER = 1e-300  # what is smaller is no float but a whole number
FIXED = ("schema", "time", "solver")  # tables that say what is computed, not of what


class Parameter(NamedTuple):
    """A number of the scene by its key, between `least` and `most`. by: what it is multiplied with to give the number
    at each place in the memory, bytes."""

    name: str
    unit: str
    start: float
    least: float
    most: float
    by: dict[int, float]

    @property
    def description(self) -> str:
        return f"{self.name} of the scene"


def parameters_of(scene: Scene, stages: Any, memory: Memory) -> list[Parameter]:
    """All of a scene. memory: of its machine; stages: of its method."""
    content = words(memory)
    found = []
    for name, value in numbers(tomllib.loads(scene.text)):
        if value != 0.0 and name.partition(".")[0] not in FIXED:
            parameter = tried(scene, stages, content, name, value)
            if parameter is not None:
                found.append(parameter)
    return found


def tried(scene: Scene, stages: Any, content: np.ndarray, name: str, value: float) -> Parameter | None:
    """The parameter of this name, None if the machine is not proportional to it."""
    places = None
    bounds = []
    for side in FACTORS:
        bound = 1.0
        for factor in side:
            try:
                changed_scene = changed(scene, [f"{name}={value * factor!r}"])
                scaled = words(Memory(machine_of(changed_scene.config, stages)))
            except (SceneError, ConfigError):  # beyond what the scene allows
                break
            there = proportional(content, scaled, factor)
            if there is None or (places is not None and not np.array_equal(there, places)):
                return None
            places, bound = there, factor
        bounds.append(value * bound)
    if places is None or not len(places) or bounds[0] == value or bounds[1] == value:
        return None
    by = {8 * int(word): float(content[word] / value) for word in places}
    return Parameter(name, unit_of(scene.config, name), value, min(bounds), max(bounds), by)


def proportional(content: np.ndarray, scaled: np.ndarray, factor: float) -> np.ndarray | None:
    """Which words of the memory have changed, None unless they are floats that have grown by the factor."""
    if len(content) != len(scaled):
        return None
    there = np.flatnonzero(content.view(np.int64) != scaled.view(np.int64))
    before, after = content[there], scaled[there]
    if not np.all(np.isfinite(before) & np.isfinite(after) & (np.abs(before) > LEAST_NUMBER)):
        return None
    return there if np.all(np.abs(after - factor * before) <= ROUNDING * np.abs(after)) else None


def words(memory: Memory) -> np.ndarray:
    """The memory at the start as floats, whatever they are."""
    return np.frombuffer(memory.start, np.float64)


def numbers(table: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[str, float]]:
    """Keys and values of all floats in a scene's tables; of tables in a list by their names."""
    if isinstance(table, dict):
        for key, value in table.items():
            yield from numbers(value, (*path, key))
    elif isinstance(table, list):
        for entry in table:
            if isinstance(entry, dict) and "name" in entry:
                yield from numbers(entry, (*path, entry["name"]))
    elif isinstance(table, float):
        yield ".".join(path), table
