"""Copies of what a march works on."""

from collections.abc import Callable
from typing import Any, Generic, TypeVar

import numpy as np

from omnisim.base.blocks import APART
from omnisim.base.records import copy_of, single

Kept = TypeVar("Kept", bound=np.ndarray | np.generic | tuple | float | None)
Tuple = TypeVar("Tuple", bound=tuple)


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


class Template(Generic[Tuple]):
    """What is copied again and again, a NamedTuple as `copied` takes it: all numbers stand in one piece of memory, so
    that copies take half as long. What becomes of the original changes no copy."""

    def __init__(self, original: Tuple):
        self._content = bytearray()
        self._made: Callable[[bytearray], Tuple] = self._maker(original)

    def copy(self) -> Tuple:
        """A copy, all of whose arrays lie in memory of its own."""
        return self._made(self._content.copy())

    def _maker(self, part: Any) -> Callable[[bytearray], Any]:
        """What makes a copy of a part, from the memory in which its numbers stand."""
        if part is None or isinstance(part, int | float | np.number):
            return lambda _: part
        if isinstance(part, tuple):
            makers, made = [self._maker(each) for each in part], type(part)._make  # type: ignore[attr-defined]
            return lambda memory: made([maker(memory) for maker in makers])
        kind, array = type(part), np.asarray(part)  # whose attributes are read quicker than those of a recarray
        shape, dtype, at, new = array.shape, array.dtype, len(self._content), np.ndarray.__new__
        self._content += array.tobytes().ljust(-(-array.nbytes // APART) * APART)
        if isinstance(part, np.void):
            return lambda memory: single(dtype, memory, at)
        return lambda memory: new(kind, shape, dtype, memory, at)
