"""Copies of what a march works on."""

from typing import Any, TypeVar

import numpy as np

Kept = TypeVar("Kept", bound=np.ndarray | np.generic | tuple | None)


def copied(kept: Kept, count: int | None = None) -> Kept:
    """A copy of arrays, records, and NamedTuples of such; of arrays with room for more, the first `count` rows. What is
    None stays None."""
    array: Any = kept
    if kept is None:
        return kept
    if isinstance(kept, tuple):
        return type(kept)(*(copied(part, count) for part in kept))
    if count is None:
        return array.copy()
    copy: Any = np.empty_like(array)
    copy[:count] = array[:count]
    return copy
