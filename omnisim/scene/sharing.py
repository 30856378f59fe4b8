"""A table that says the same as one of a scene before is that object: what follows from a table is kept by it."""

from collections.abc import Mapping
from functools import reduce
from hashlib import blake2b
from typing import Any
from weakref import WeakValueDictionary

from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath
from omnisim.scene.values import Table

Said = tuple[KeyPath, bytes]  # where a table stands, places in lists left out, and a digest of what it says

_known: WeakValueDictionary[Said, Table] = WeakValueDictionary()  # as long as somebody holds them


def modelled(data: Mapping[str, Any]) -> Config:
    """`Config.model_validate` of data whose lists are tuples; tables of scenes before that are still held, and the
    whole of such a scene, are not validated again. Raises ValidationError."""
    unknown: dict[KeyPath, Said] = {}
    config = Config.model_validate(_with_known(data, (), unknown))
    for path, said in unknown.items():
        model = reduce(_part, path, config)
        if isinstance(model, Table):
            _known[said] = model
    return config


def _with_known(value: Any, path: KeyPath, unknown: dict[KeyPath, Said]) -> Any:
    """What stands at this path, with models in the place of known tables; the others are added to `unknown`."""
    if isinstance(value, dict):
        said = tuple(part for part in path if isinstance(part, str)), digest(value)
        found = _known.get(said)
        if found is not None:
            return found
        unknown[path] = said
        return {key: _with_known(entry, (*path, key), unknown) for key, entry in value.items()}
    if isinstance(value, tuple) and value and isinstance(value[0], dict):
        return tuple(_with_known(entry, (*path, i), unknown) for i, entry in enumerate(value))
    return value


def digest(value: dict[str, Any]) -> bytes:
    """Of what a table says: a long text is not kept. 0.0 is not -0.0, nor is 1 what 1.0 is."""
    return blake2b(repr(value).encode()).digest()


def _part(model: Any, key: Any) -> Any:
    """A part of a model by its key in the file."""
    if not isinstance(model, Table):
        return model[key]
    return getattr(model, next(name for name, field in type(model).model_fields.items() if key in (name, field.alias)))
