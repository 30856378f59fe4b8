"""Records of several kinds in one piece of memory."""

from functools import lru_cache
from typing import Any

import numpy as np

from omnisim.base.records import recorded

APART = 64  # bytes: each kind begins at a multiple of them

Part = tuple[np.dtype, tuple[int, ...]]  # of records, and how many of them along each axis


def cleared(*parts: Part) -> list[np.recarray]:
    """Records of zeros. To clear those of each part by themselves takes three times as long."""
    places, size = planned(*parts)
    memory = bytearray(size)
    found: list[Any] = [np.ndarray.__new__(np.recarray, shape, dtype, memory, at) for dtype, shape, at in places]
    return found


@lru_cache
def planned(*parts: Part) -> tuple[list[tuple[np.dtype, tuple[int, ...], int]], int]:
    """Dtype, shape and place in the memory of every part, and how many bytes that is."""
    places, size = [], 0
    for dtype, shape in parts:
        places.append((recorded(dtype), shape, size))
        size += -(-dtype.itemsize * int(np.prod(shape)) // APART) * APART
    return places, size
