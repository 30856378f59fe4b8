"""From what tomllib returns to a Config, or to every problem found."""

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from omnisim.config import Config
from omnisim.machine_rules import MACHINE_RULES
from omnisim.problems import ConfigError, schema_problems
from omnisim.rules import RULES


def validate(data: Mapping[str, Any]) -> Config:
    """The scene in `data` (what tomllib returns), or ConfigError with every problem found.

    Rules across keys compare values, and those of the machine need its parts: each stage waits for the one before.
    """
    data = _tuples(data)
    try:
        config = Config.model_validate(data)
    except ValidationError as error:
        raise ConfigError(schema_problems(error, data)) from None
    for rules in (RULES, MACHINE_RULES):
        problems = [problem for rule in rules for problem in rule(config)]
        if problems:
            raise ConfigError(problems)
    return config


def _tuples(value: Any) -> Any:
    """Lists become tuples: strict models take no list for a tuple, and frozen ones should hold none."""
    if isinstance(value, dict):
        return {key: _tuples(entry) for key, entry in value.items()}
    return tuple(_tuples(entry) for entry in value) if isinstance(value, list) else value
