"""From what tomllib returns to a Config, or to every problem found."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import wraps
from typing import Any, NamedTuple

from pydantic import ValidationError

from omnisim.base.keeping import UNKNOWN, Ask, Common, alone, kept
from omnisim.scene.estimates import complete, shape_rules
from omnisim.scene.floor_rules import floor_rules, narrow_bumps
from omnisim.scene.machine_rules import MACHINE_RULES
from omnisim.scene.problems import ConfigError, Problem, schema_problems
from omnisim.scene.profile_rules import profile_rules
from omnisim.scene.rules import RULES
from omnisim.scene.schema import Config
from omnisim.scene.sharing import modelled
from omnisim.scene.spatial_rules import spatial_rules
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.values import Table

Rule = Callable[[Config], Iterator[Problem]]
Asked = Callable[[Config], tuple[Problem, ...]]


def asked(*rules: Rule) -> tuple[Asked, ...]:
    """The same rules, each of which tells all that it finds."""

    def telling(rule: Rule) -> Asked:
        return wraps(rule)(lambda config: tuple(rule(config)))

    return tuple(map(telling, rules))


OF_KEYS = asked(*RULES, shape_rules, spatial_rules, floor_rules, profile_rules)
OF_SHAPES = asked(narrow_bumps)
OF_MACHINES = asked(*MACHINE_RULES)


class Variants(NamedTuple):
    """Who tells what variants of a scene have in common: of what a file gives, and of what `complete` makes of it."""

    given: Ask[Config] = alone
    complete: Ask[Config] = alone


NO_OTHERS = Variants()


def validate(data: Mapping[str, Any]) -> Config:
    """The scene in `data` (what tomllib returns), complete, or ConfigError with every problem found. Of two that say
    the same the second is the first, if that is still held."""
    return _lawful_once(_modelled(modelled, tuples(data)))


def checked(data: Mapping[str, Any], variants: Variants = NO_OTHERS) -> Config:
    """The same of data whose lists are tuples; what is a model in it already, as `settled` has it, stays that one.
    variants: it is one of them.

    Rules across keys compare values, bumps and estimates need shapes, and rules of the machine its parts: each stage
    waits for the one before.
    """
    return _lawful(_modelled(Config.model_validate, data), variants)


def _modelled(model: Callable[[Mapping[str, Any]], Config], data: Mapping[str, Any]) -> Config:
    """What `model` makes of the data of a scene, or ConfigError."""
    try:
        return model(data)
    except ValidationError as error:
        raise ConfigError(schema_problems(error, data)) from None


def _lawful(config: Config, variants: Variants = NO_OTHERS) -> Config:
    """The same scene, complete, or ConfigError with every rule that it breaks."""
    _obey(OF_KEYS, config, variants.given)
    _obey(OF_SHAPES, config, variants.given)
    config = complete(config)
    _obey(OF_MACHINES, config, variants.complete)
    return config


_lawful_once = kept(_lawful)


def _obey(rules: Iterable[Asked], config: Config, ask: Ask[Config]) -> None:
    problems = [problem for rule in rules for problem in ask(rule, config)]
    if problems:
        raise ConfigError(problems)


def variants_of(data: Mapping[str, Any], paths: Iterable[KeyPath]) -> Variants:
    """Of scenes that differ from this one (data whose lists are tuples) where these paths lead."""
    try:
        sample = _unknown(Config.model_validate(data), list(paths))
        given = Common(sample)
    except (ValidationError, LookupError):  # they are no scenes
        return NO_OTHERS
    try:
        return Variants(given, Common(_completed(sample)))
    except TypeError:  # what it lacks follows from what nobody knows
        return Variants(given)


def _unknown(value: Any, paths: list[KeyPath]) -> Any:
    """A part of a scene with UNKNOWN where these paths lead; of a table that is not there as a whole."""
    if () in paths or value is None:
        return UNKNOWN
    below = {path[0]: [other[1:] for other in paths if other[0] == path[0]] for path in paths}
    if isinstance(value, Table):
        names = {field.alias or name: name for name, field in type(value).model_fields.items()}
        changes = {names[str(key)]: _unknown(getattr(value, names[str(key)]), own) for key, own in below.items()}
        return value.model_copy(update=changes)
    entries = dict(value) if isinstance(value, dict) else dict(enumerate(value))
    entries |= {key: _unknown(entries[key], own) for key, own in below.items()}
    return entries if isinstance(value, dict) else tuple(entries.values())


def _completed(sample: Config) -> Config:
    """The same of a scene with UNKNOWN in it; so is its chassis, if what that lacks is."""
    try:
        return complete(sample)
    except TypeError:
        return complete(sample.model_copy(update={"chassis": None})).model_copy(update={"chassis": UNKNOWN})


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
