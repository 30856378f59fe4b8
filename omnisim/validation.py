"""From what tomllib returns to a Config, or to every problem found.

A key or word that a later version learns moves from NOT_YET to the models.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from omnisim.config import Config
from omnisim.problems import ConfigError, Problem, allowed_at, schema_problems
from omnisim.rules import RULES
from omnisim.toml_text import MISSING, value_at

# Keys and words of the contract that this version does not simulate: path, words (none: anything there), and
# what it has instead (None: the field says).
ONE_BARE_WHEEL = "it simulates one wheel without a chassis"
NOT_YET = (
    (("chassis",), (), ONE_BARE_WHEEL),
    (("wheels", 1), (), ONE_BARE_WHEEL),
    (("scene", "upright"), ("contacts",), None),
)


def validate(data: Mapping[str, Any]) -> Config:
    """The scene in `data` (what tomllib returns), or ConfigError with every problem found."""
    data = _tuples(data)
    problems = list(_not_yet(data))
    try:
        config = Config.model_validate(data)
    except ValidationError as error:
        known = {problem.path for problem in problems}
        problems += (problem for problem in schema_problems(error, data) if problem.path not in known)
    if not problems:  # rules compare values, so the values come first
        problems = [problem for rule in RULES for problem in rule(config)]
    if problems:
        raise ConfigError(problems)
    return config


def _tuples(value: Any) -> Any:
    """Lists become tuples: strict models take no list for a tuple, and frozen ones should hold none."""
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value


def _not_yet(data: Any) -> Iterator[Problem]:
    for path, words, instead in NOT_YET:
        value = value_at(data, path)
        if value is not MISSING and (not words or value in words):
            yield Problem(path, f"not in this version; {instead or f'must be {allowed_at(path)}'}")
