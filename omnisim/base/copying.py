"""Copies of what a march works on."""

from typing import TypeVar

import numpy as np

Kept = TypeVar("Kept", bound=np.ndarray | np.void | tuple)


def copied(kept: Kept, count: int | None = None) -> Kept:
    """A copy of arrays, records, and NamedTuples of such; of arrays with room for more, the first `count` rows."""
    if isinstance(kept, tuple):
        return type(kept)(*(copied(part, count) for part in kept))
    if count is None:
        return kept.copy()
    copy = np.empty_like(kept)
    copy[:count] = kept[:count]
    return copy
