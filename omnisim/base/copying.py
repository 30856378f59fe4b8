"""Copies of what a march works on."""

from typing import Any, TypeVar

import numpy as np

from omnisim.base.records import copy_of

Kept = TypeVar("Kept", bound=np.ndarray | np.generic | tuple | float | None)


def copied(kept: Kept, count: int | None = None) -> Kept:
    """A copy of arrays, records, and NamedTuples of such; of arrays with room for more, the first `count` rows. What is
    None or a number stays that."""
    array: Any = kept
    if kept is None or isinstance(kept, int | float):
        return kept
    if isinstance(kept, tuple):
        return type(kept)(*(copied(part, count) for part in kept))
    if count is None:
        return copy_of(array) if array.dtype.names else array.copy()
    copy: Any = np.empty_like(array)
    copy[:count] = array[:count]
    return copy
