"""From a fit file to a checked Fit: its scene, its logs, and what is estimated."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from omnisim.base.arguments import path_text
from omnisim.base.files import read_small
from omnisim.base.formatting import visible
from omnisim.fitting.logs import FitError, Log, log_problems, read_log
from omnisim.fitting.parameters import Parameter, Point, parameters, point
from omnisim.fitting.schema import FitConfig
from omnisim.scene.document import MOST_BYTES, Document, InputError, decoded, parsed
from omnisim.scene.packaged import packaged_data
from omnisim.scene.problems import Problem, did_you_mean, schema_problems
from omnisim.scene.scene import Scene, load
from omnisim.scene.toml_text import KeyPath, rewrite
from omnisim.scene.validation import tuples

TEXT = "<fit>"  # the source of one that no file says


@dataclass(frozen=True)
class Fit:
    """A checked fit.

    config      what the file says
    document    its text
    scene       with what the fit does not change
    parameters  what is estimated, in the order of the file
    logs        in the order of the file
    """

    config: FitConfig
    document: Document
    scene: Scene
    parameters: tuple[Parameter, ...]
    logs: tuple[Log, ...]

    @property
    def name(self) -> str:
        """Stem of the default output folder."""
        return Path(self.document.source).stem if self.document.source != TEXT else "fit"

    @property
    def start(self) -> np.ndarray:
        """(P,): where the search starts."""
        return np.array([one.start for one in self.parameters])

    @property
    def low(self) -> np.ndarray:
        return np.array([one.low for one in self.parameters])

    @property
    def high(self) -> np.ndarray:
        return np.array([one.high for one in self.parameters])

    @property
    def fitted(self) -> list[int]:
        """Numbers of the logs that the estimate is made of."""
        return [i for i, log in enumerate(self.logs) if log.use == "fit"]

    @cached_property
    def base(self) -> dict[str, Any]:
        """What the scene says, lists as tuples."""
        return tuples(self.scene.document.data)

    def settings(self, values: Sequence[float] | np.ndarray) -> list[tuple[KeyPath, Any]]:
        """The paths in the scene's data that values of the parameters set, and to what."""
        return [
            setting
            for one, value in zip(self.parameters, values, strict=True)
            for setting in one.settings(float(value))
        ]

    def point(self, values: Sequence[float] | np.ndarray) -> Point:
        """The tracked point with values of the parameters."""
        return point(self.config.tracked, self.parameters, [float(value) for value in values])

    def compared(self, log: Log) -> np.ndarray:
        """The rows of a log that are compared: the first, the last, and between them those that are the time `every`
        apart or more."""
        every = self.config.weights.every
        if every is None:
            return np.arange(len(log.time))
        slots = np.floor(log.time / every * (1.0 + 1e-9) + 1e-9)
        _, first = np.unique(slots, return_index=True)
        return np.unique([*first, len(log.time) - 1])


def load_fit(source: str | PathLike[str] | Mapping[str, Any]) -> Fit:
    """The fit in a file, or else the packaged one of that name, or that a dict says; files that it names stand beside
    it, or where a dict is used.

    Raises FitError or SceneError for everything that is wrong with it, its scene or its logs.
    """
    if isinstance(source, Mapping):
        data = dict(source)
        return _checked(Document(data, rewrite("", [], data), TEXT), Path())
    path = Path(path_text("fit", source, "a path, the name of a packaged fit, or a dict"))
    if not path.exists() and str(path) in packaged_fits():
        path = packaged_fits()[str(path)]
    shown = visible(str(path))
    try:
        text = decoded(read_small(path, MOST_BYTES), shown)
    except OSError as error:
        raise FitError(f"{shown}: {error.strerror}{hint(path)}") from None
    except InputError as error:
        raise FitError(str(error)) from None
    try:
        document = parsed(text, shown)
    except InputError as error:
        raise FitError(str(error)) from None
    return _checked(document, path.parent)


def hint(path: Path) -> str:
    """What to say where there is no such file."""
    return (
        ""
        if path.exists()
        else f"{did_you_mean(path.stem, packaged_fits()) or '.'} Packaged fits: {', '.join(packaged_fits())}"
    )


def packaged_fits() -> dict[str, Path]:
    """The fits that come with the package, beside their logs."""
    return {path.stem: path for path in sorted((packaged_data() / "measured").glob("*.toml"))}


def _checked(document: Document, folder: Path) -> Fit:
    data = tuples(document.data)
    try:
        config = FitConfig.model_validate(data)
    except ValidationError as error:
        raise FitError(document.told(schema_problems(error, data, FitConfig))) from None
    beside = folder / config.scene
    scene = load(beside if beside.exists() else config.scene)
    wheels = tuple(wheel.name for wheel in scene.config.wheels)
    found = list(parameters(config.free, scene.document.data))
    problems = [entry for entry in found if isinstance(entry, Problem)]
    for i, entry in enumerate(config.logs):
        problems += log_problems(entry, i, wheels)
    if not any(entry.use == "fit" for entry in config.logs):
        problems.append(Problem(("logs",), 'no log to fit; use = "fit" in one or more of them'))
    if scene.config.chassis is None:
        problems.append(Problem(("scene",), "a wheel without a chassis; a log is of a machine"))
    if problems:
        raise FitError(document.told(problems))
    logs: list[Log] = []
    for i, entry in enumerate(config.logs):
        log = read_log(entry, i, folder, wheels)
        if isinstance(log, Log):
            logs.append(log)
        else:
            problems += log
    if problems:
        raise FitError(document.told(problems))
    return Fit(config, document, scene, tuple(one for one in found if isinstance(one, Parameter)), tuple(logs))
