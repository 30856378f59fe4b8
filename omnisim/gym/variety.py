"""What differs from episode to episode: keys of the scene drawn anew, as a table [vary] of a study says it."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from omnisim.base.arguments import shown
from omnisim.scene.document import Document, sentence
from omnisim.scene.problems import ConfigError, Problem
from omnisim.scene.scene import Scene, SceneError
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import rewrite
from omnisim.scene.validation import checked, tuples
from omnisim.studies.factors import Distribution, Factor, drawn_values, factors, settings, with_values
from omnisim.studies.schema import VARIES
from omnisim.studies.study import StudyError

LAST = np.nextafter(1.0, 0.0)  # a share of the whole


class Variety:
    """The scenes that a scene and a table [vary] make. Raises StudyError for what is wrong with the table."""

    def __init__(self, scene: Scene, vary: Mapping[str, Any] | None):
        if not isinstance(vary, Mapping | None):
            raise StudyError(f"vary: must be a table of keys of the scene, each with {VARIES}, not {shown(vary)}")
        table = {"vary": dict(vary or {})}
        found = list(factors(table["vary"], scene.document.data, True))
        problems = [entry for entry in found if isinstance(entry, Problem)]
        if problems:
            raise StudyError(Document(table, rewrite("", [], table), "<vary>").told(problems))
        self.scene = scene
        self.base = tuples(scene.document.data)
        self.factors = tuple(entry for entry in found if isinstance(entry, Factor))
        self.draws = sum(factor.draws for factor in self.factors)

    def drawn(self, random: np.random.Generator) -> Config:
        """A scene by chance; the same object where nothing varies. Raises SceneError for one that is impossible."""
        return self.at(random.random(self.draws).tolist()) if self.factors else self.scene.config

    def at(self, shares: list[float]) -> Config:
        """The scene at these shares of the whole of each draw, 0 to 1."""
        values = settings(self.factors, drawn_values(self.factors, shares))
        data = with_values(self.base, [(path, tuples(value)) for path, value in values])
        try:
            return checked(data)
        except ConfigError as error:
            told = "; ".join(sentence(problem, data) for problem in error.problems)
            raise SceneError(f"<vary>: a scene that is drawn is impossible: {told}") from None

    def ends(self) -> list[tuple[str, Config]]:
        """For each factor scenes with it at its ends, or at each value of a list, all others in their middle."""
        found = []
        begun = 0
        for factor in self.factors:
            count = 0 if isinstance(factor.values, Distribution) else len(factor.listed)
            for share in [(i + 0.5) / count for i in range(count)] or [0.0, float(LAST)]:
                shares = [0.5] * self.draws
                shares[begun : begun + factor.draws] = [share] * factor.draws
                found.append((factor.key, self.at(shares)))
            begun += factor.draws
        return found
