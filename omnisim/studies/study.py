"""From a study file to a checked Study: its scene, what varies, and the points at which the scene runs."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from omnisim.base.arguments import path_text
from omnisim.base.files import read_small
from omnisim.base.formatting import visible
from omnisim.scene.document import MOST_BYTES, Document, InputError, decoded, parsed
from omnisim.scene.problems import Problem, schema_problems
from omnisim.scene.scene import Scene, load
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath, rewrite
from omnisim.scene.validation import Variants, checked, settled, tuples, variants_of
from omnisim.studies.factors import Distribution, Factor, drawn_values, factors, settings, with_values
from omnisim.studies.schema import MOST_RUNS, StudyConfig

DISTRIBUTIONS = {"mean", "uniform", "loguniform"}  # what tells one in a table of [vary]
SAMPLED = ("random", "sobol", "latin")
TEXT = "<study>"  # the source of one that no file says
BEARINGS = "bearing"  # in the names of datasets that [output] bearing_loads gives


class StudyError(InputError):
    """What is wrong with a study, one line for each problem: file, line, key, value, what is allowed."""


@dataclass(frozen=True)
class Study:
    """A checked study.

    config    what the file says
    document  its text
    scene     the scene with `set` applied
    factors   what varies, in the order of the file
    """

    config: StudyConfig
    document: Document
    scene: Scene
    factors: tuple[Factor, ...]

    @property
    def name(self) -> str:
        """Stem of the default output file."""
        return Path(self.document.source).stem if self.document.source != TEXT else "study"

    @cached_property
    def kind(self) -> str:
        """Of the design."""
        return kind_of(self.config)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Of the results: along every factor of a grid, else the number of runs."""
        if self.kind == "grid":
            return tuple(len(factor.listed) for factor in self.factors)
        return (len(self.factors[0].listed) if self.kind == "zip" else int(self.config.design.count or 0),)

    @property
    def count(self) -> int:
        """Number of runs."""
        return math.prod(self.shape)

    @cached_property
    def shares(self) -> np.ndarray:
        """(count, draws) of a design that draws: for each draw the share of the whole, 0 to 1."""
        return drawn(self.kind, self.count, sum(factor.draws for factor in self.factors), self.config.design.seed)

    @cached_property
    def seeds(self) -> np.ndarray:
        """(count,): a seed for each run, whatever takes one."""
        return np.random.SeedSequence(self.config.design.seed).generate_state(self.count, np.uint64) >> np.uint64(1)

    def __getstate__(self) -> dict[str, Any]:
        """Without what follows from the rest, for other processes."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

    def values(self, run: int) -> list[list[Any]]:
        """The values of each factor in a run: one, or one for each of its targets."""
        if self.kind == "grid":
            places = np.unravel_index(run, self.shape)
            return [[factor.listed[int(place)]] for factor, place in zip(self.factors, places, strict=True)]
        if self.kind == "zip":
            return [[factor.listed[run]] for factor in self.factors]
        return drawn_values(self.factors, self.shares[run].tolist())

    @property
    def columns(self) -> list[list[Any]]:
        """The values of each factor in all runs of a design that is no grid, one run after the other; where it has one
        for each of its targets, these side by side."""
        if self.kind == "zip":
            return [list(factor.listed) for factor in self.factors]
        ends = np.cumsum([factor.draws for factor in self.factors])
        parts = np.split(self.shares, ends[:-1], axis=1)
        return [factor.at(part.ravel().tolist()) for factor, part in zip(self.factors, parts, strict=True)]

    def settings(self, run: int) -> list[tuple[KeyPath, Any]]:
        """The paths in the scene's data that a run sets, and their values."""
        return settings(self.factors, self.values(run))

    @cached_property
    def base(self) -> dict[str, Any]:
        """What the scene says, lists as tuples."""
        return tuples(self.scene.document.data)

    @cached_property
    def targets(self) -> list[KeyPath]:
        """All paths in the scene's data that runs set."""
        return [target for factor in self.factors for target in factor.targets]

    @cached_property
    def settled(self) -> dict[str, Any]:
        """What the scene says, with what does not vary validated."""
        return settled(self.base, self.targets)

    @cached_property
    def variants(self) -> Variants:
        """The scenes of all runs."""
        return variants_of(self.base, self.targets)

    def data(self, run: int) -> dict[str, Any]:
        """What the scene of a run says."""
        return self._varied(self.base, run)

    def checked(self, run: int) -> Config:
        """The scene of a run. Raises ConfigError where there is none."""
        return checked(self._varied(self.settled, run), self.variants)

    def _varied(self, data: dict[str, Any], run: int) -> dict[str, Any]:
        return with_values(data, [(path, tuples(value)) for path, value in self.settings(run)])


def kind_of(config: StudyConfig) -> str:
    """Of a design that names none: distributions with a count are drawn by chance, all else makes a grid."""
    drawn_keys = any(isinstance(entry, Mapping) and DISTRIBUTIONS & set(entry) for entry in config.vary.values())
    return config.design.kind or ("random" if drawn_keys and config.design.count else "grid")


def drawn(kind: str, count: int, draws: int, seed: int) -> np.ndarray:
    """(count, draws): points in the unit cube, by chance, in a Latin hypercube or in Sobol's sequence, scrambled."""
    random = np.random.default_rng(seed)
    if kind == "sobol":
        try:
            from scipy.stats import qmc  # here: only this design needs it
        except ModuleNotFoundError:
            raise StudyError("design.kind = \"sobol\" needs SciPy: pip install 'omnisim-engine[study]'") from None

        return qmc.Sobol(draws, rng=random).random(count)
    if kind == "latin":
        cells = random.permuted(np.tile(np.arange(count), (draws, 1)), axis=1).T
        return (cells + random.random((count, draws))) / count
    return random.random((count, draws))


def load_study(source: str | PathLike[str] | Mapping[str, Any]) -> Study:
    """The study in a file, or that a dict says.

    Raises StudyError or SceneError for everything that is wrong with it or its scene, TypeError for what is neither.
    """
    if isinstance(source, Mapping):
        data = dict(source)
        return _checked(Document(data, rewrite("", [], data), TEXT), Path())
    path = Path(path_text("sweep", source, "a path or a dict"))
    shown = visible(str(path))
    try:
        text = decoded(read_small(path, MOST_BYTES), shown)
    except OSError as error:
        raise StudyError(f"{shown}: {error.strerror}") from None
    try:
        return _checked(parsed(text, shown), path.parent)
    except InputError as error:
        raise error if isinstance(error, StudyError) else StudyError(str(error)) from None


def _checked(document: Document, folder: Path) -> Study:
    data = tuples(document.data)
    try:
        config = StudyConfig.model_validate(data)
    except ValidationError as error:
        raise StudyError(document.told(schema_problems(error, data, StudyConfig))) from None
    beside = folder / config.scene
    scene = load(beside if beside.exists() else config.scene, _settings(config))
    found = list(factors(config.vary, scene.document.data, kind_of(config) in SAMPLED))
    problems = [entry for entry in found if isinstance(entry, Problem)]
    varied = tuple(entry for entry in found if isinstance(entry, Factor))
    problems += [] if problems else design_problems(config, varied)
    if problems:
        raise StudyError(document.told(problems))
    study = Study(config, document, scene, varied)
    if study.kind in SAMPLED:
        _ = study.shares  # drawn now: what is in the way is told, and processes inherit them
    return study


def _settings(config: StudyConfig) -> dict[str, Any]:
    """The overrides for all runs; measures of bearings need their loads."""
    asked = any(BEARINGS in measure.dataset.rpartition("/")[2] for measure in config.measure.values())
    return {"output.bearing_loads": True} | config.settings if asked else config.settings


def design_problems(config: StudyConfig, varied: tuple[Factor, ...]) -> list[Problem]:
    """What is wrong with [design] for these factors."""
    design, kind = config.design, kind_of(config)
    if kind in SAMPLED:
        return [] if design.count else [Problem(("design", "count"), f'missing; "{kind}" takes a number of runs')]
    problems = [
        Problem(
            ("vary", factor.key),
            f"a distribution takes a design that draws, with count: {', '.join(SAMPLED)}",
        )
        for factor in varied
        if isinstance(factor.values, Distribution)
    ]
    if design.count is not None:
        problems.append(
            Problem(("design", "count"), f'"{kind}" makes its own number of runs; only designs that draw take one')
        )
    sizes = {factor.key: len(factor.values) for factor in varied if isinstance(factor.values, tuple)}
    if kind == "zip" and len(set(sizes.values())) > 1:
        told = ", ".join(f"{key} {size}" for key, size in sizes.items())
        problems.append(Problem(("vary",), f'"zip" takes lists of one length: {told}'))
    if kind == "grid" and not problems and math.prod(sizes.values()) > MOST_RUNS:
        problems.append(Problem(("vary",), f"a grid of {math.prod(sizes.values()):.3g} runs; at most {MOST_RUNS:.0g}"))
    return problems
