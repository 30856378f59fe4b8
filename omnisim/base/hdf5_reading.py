"""HDF5 files, opened to be read only if that will come to an end, however damaged they are.

Texts of variable length stand in heaps, a header of 16 bytes before each. That of free room holds its whole length;
where damage has made it 0 the HDF5 library looks at the same header for ever.
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from os import PathLike
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import h5py

HEAP = b"GCOL\x01\0\0\0"  # signature and version of a global heap collection, before its size
HEADER = 16  # bytes, of a heap and of each of its objects
WRAPS = 2**64  # where sizes begin at 0 again
FREE = 0  # the index of free room


def open_to_read(path: str | PathLike[str]) -> h5py.File:
    """Raises OSError as h5py does, and for a heap that has no end."""
    import h5py  # here: whoever only asks for a name needs no HDF5

    with open(path, "rb") as file:
        if file.read(1):
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                if any(_is_endless(content, place) for place in _heaps(content)):
                    raise OSError("a heap of texts has no end")
    return h5py.File(path, "r")


def _heaps(content: mmap.mmap) -> Iterator[int]:
    """Where heaps begin."""
    place = content.find(HEAP)
    while 0 <= place <= len(content) - HEADER:
        yield place
        place = content.find(HEAP, place + 1)


def _is_endless(content: mmap.mmap, heap: int) -> bool:
    """Whether the library, which goes from object to object of a heap, would stay at one of them."""
    (size,) = struct.unpack_from("<Q", content, heap + len(HEAP))
    end = min(heap + size, len(content))
    place = heap + HEADER
    while place + HEADER <= end:
        index, length = struct.unpack_from("<H6xQ", content, place)
        step = length if index == FREE else HEADER + -(-length // 8) * 8
        if step % WRAPS == 0:
            return True
        place += step
    return False
