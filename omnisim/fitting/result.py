"""What a fit has found: estimates, errors of each log, and the folder with all of it."""

import json
import math
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np

from omnisim.base.files import write_whole
from omnisim.base.version import VERSION
from omnisim.fitting.fit_file import Fit
from omnisim.fitting.least_squares import Solution
from omnisim.fitting.logs import Log
from omnisim.fitting.paths import Errors, Path, errors, measured
from omnisim.fitting.uncertainty import LEVEL, Uncertainty
from omnisim.scene.document import by_name
from omnisim.scene.scene import Scene, changed
from omnisim.scene.toml_text import show_path

SCENE = "fitted.toml"
NUMBERS = "fit.json"


class Estimate(NamedTuple):
    """A value, its standard deviation, and the ends of its 95 % interval; NaN where they are not known."""

    value: float
    deviation: float
    low: float
    high: float


@dataclass(frozen=True)
class LogResult:
    """A log, its compared rows, and paths in these: simulated at the start of the search and with the estimates; by
    ideal kinematics at the start and fitted, None where wheels leave a motion open."""

    log: Log
    rows: np.ndarray
    before: Path
    after: Path
    ideal_nominal: Path | None
    ideal: Path | None

    @property
    def measured(self) -> Path:
        return measured(self.log, self.rows)

    def errors(self) -> dict[str, Errors | None]:
        """Of each path."""
        paths = {name: getattr(self, name) for name in ("before", "after", "ideal_nominal", "ideal")}
        return {name: path and errors(path, self.measured) for name, path in paths.items()}


@dataclass(frozen=True)
class FitResult:
    """What `fit` has found.

    fit          what was asked
    solution     how the search ended
    known        what the logs tell of the estimates
    logs         errors of each log, and its paths
    ideal        the values that ideal kinematics takes, None where wheels leave a motion open
    step_error   largest change of a place in any path if the step is halved, m; None of an interrupted search
    runs         simulated runs of the search
    early        of each run with the estimates that stopped before its log ended, which log, and how
    """

    fit: Fit
    solution: Solution
    known: Uncertainty
    logs: tuple[LogResult, ...]
    ideal: dict[str, float] | None
    step_error: float | None
    runs: int
    early: tuple[str, ...]

    @property
    def estimates(self) -> dict[str, Estimate]:
        """By the key of [free]."""
        columns = (self.solution.values, self.known.deviation, self.known.low, self.known.high)
        return {
            one.key: Estimate(*map(float, numbers)) for one, *numbers in zip(self.fit.parameters, *columns, strict=True)
        }

    @property
    def correlation(self) -> np.ndarray:
        """(P, P) of the estimates."""
        return self.known.correlation

    @property
    def status(self) -> str:
        if self.solution.interrupted:
            return "interrupted; the best so far"
        return "complete" if self.solution.converged else "not converged; the best so far"

    @cached_property
    def scene(self) -> Scene:
        """The scene with the estimates."""
        data = self.fit.scene.document.data
        settings = self.fit.settings(self.solution.values.tolist())
        return changed(self.fit.scene, {show_path(by_name(path, data)): value for path, value in settings})

    def numbers(self) -> dict[str, Any]:
        """What fit.json holds; lengths in m, angles in rad, unless a key of the scene has another unit."""
        return {
            "format": "omnisim-fit",
            "omnisim_version": VERSION,
            "status": self.status,
            "estimates": {key: told(entry) for key, entry in self.estimates.items()},
            "level": LEVEL,
            "correlation": [[finite(number) for number in row] for row in self.correlation.tolist()],
            "cannot_tell": list(self.known.untold),
            "correlated_rows": dict(zip(("position", "yaw"), map(finite, self.known.correlated_rows), strict=True)),
            "ideal_estimates": self.ideal,
            "tracked": self.tracked,
            "logs": [
                {"file": entry.log.file, "use": entry.log.use}
                | {name: error and told(error) for name, error in entry.errors().items()}
                for entry in self.logs
            ],
            "runs": self.runs,
            "early": list(self.early),
            "step_error": self.step_error,
        }

    @property
    def tracked(self) -> dict[str, float]:
        """The tracked point, as [tracked] has it."""
        x, y, yaw = self.fit.point(self.solution.values.tolist())
        return {"x": x, "y": y, "yaw_deg": math.degrees(yaw)}

    @property
    def scene_text(self) -> str:
        """What fitted.toml holds."""
        point = ", ".join(f"{key} = {value!r}" for key, value in self.tracked.items())
        keys = ", ".join(one.key for one in self.fit.parameters)
        head = [f"# Fitted to logs by omnisim {VERSION}: {keys}.", f"# The tracked point, in chassis axes: {point}"]
        return "\n".join([*head, self.scene.text])

    def files(self, folder: str | PathLike[str]) -> dict[FilePath, bytes]:
        """What a folder of this fit holds beside pictures: fitted.toml and fit.json."""
        numbers = json.dumps(self.numbers(), indent=2, allow_nan=False) + "\n"
        return {FilePath(folder) / SCENE: self.scene_text.encode(), FilePath(folder) / NUMBERS: numbers.encode()}

    def save(self, folder: str | PathLike[str], overwrite: bool = False) -> None:
        """Write them; the folder is made.

        Raises OSError, and FileExistsError unless it may overwrite.
        """
        FilePath(folder).mkdir(exist_ok=True)
        write_whole(self.files(folder), overwrite=overwrite)


def told(record: Any) -> dict[str, float | None]:
    """A record of numbers as JSON has it."""
    return {name: finite(value) for name, value in record._asdict().items()}


def finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
