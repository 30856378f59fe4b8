"""From what tomllib returns to a Config, or to every problem found."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from omnisim.scene.estimates import complete, shape_rules
from omnisim.scene.floor_rules import floor_rules, narrow_bumps
from omnisim.scene.machine_rules import MACHINE_RULES
from omnisim.scene.problems import ConfigError, Problem, schema_problems
from omnisim.scene.profile_rules import profile_rules
from omnisim.scene.rules import RULES
from omnisim.scene.schema import Config
from omnisim.scene.spatial_rules import spatial_rules
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.values import Table

Rule = Callable[[Config], Iterator[Problem]]


def validate(data: Mapping[str, Any]) -> Config:
    """The scene in `data` (what tomllib returns), complete, or ConfigError with every problem found."""
    return checked(tuples(data))


def checked(data: Mapping[str, Any]) -> Config:
    """The same of data whose lists are tuples; what is a model in it already, as `settled` has it, stays that one.

    Rules across keys compare values, bumps and estimates need shapes, and rules of the machine its parts: each stage
    waits for the one before.
    """
    try:
        config = Config.model_validate(data)
    except ValidationError as error:
        raise ConfigError(schema_problems(error, data)) from None
    _obey((*RULES, shape_rules, spatial_rules, floor_rules, profile_rules), config)
    _obey((narrow_bumps,), config)
    config = complete(config)
    _obey(MACHINE_RULES, config)
    return config


def _obey(rules: Iterable[Rule], config: Config) -> None:
    problems = [problem for rule in rules for problem in rule(config)]
    if problems:
        raise ConfigError(problems)


def settled(data: Mapping[str, Any], paths: Iterable[KeyPath]) -> dict[str, Any]:
    """The data of a scene, lists as tuples, with models in the place of all tables that none of these paths leads into:
    variants that differ there have them in common. Raises ValidationError for what is no scene."""
    return _settled(data, Config.model_validate(data), list(paths))


def _settled(data: Any, model: Any, paths: list[KeyPath]) -> Any:
    """The same of what stands somewhere in the data, and in the model of it."""
    if not paths:
        return model
    if () in paths or not isinstance(data, dict | tuple):
        return data
    entries: Iterable[tuple[Any, Any]] = data.items() if isinstance(data, dict) else enumerate(data)
    if isinstance(model, Table):
        names = {field.alias or name: name for name, field in type(model).model_fields.items()}
        model = {key: getattr(model, names[key]) for key, _ in entries}
    found = {key: _settled(entry, model[key], [path[1:] for path in paths if path[0] == key]) for key, entry in entries}
    return found if isinstance(data, dict) else tuple(found.values())


def tuples(value: Any) -> Any:
    """Lists become tuples: strict models take no list for a tuple, and frozen ones should hold none."""
    if isinstance(value, dict):
        return {key: tuples(entry) for key, entry in value.items()}
    return tuple(tuples(entry) for entry in value) if isinstance(value, list) else value
