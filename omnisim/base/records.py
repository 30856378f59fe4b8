"""Records as Python makes and reads them: what kernels know by field.

An array of np.record is at once what a recarray wants; viewing others as one takes longer than all the rest. NumPy
would fill and copy records field by field, so their bytes are packed and copied here.
"""

import struct
from collections.abc import Sequence
from functools import lru_cache
from math import prod
from operator import itemgetter
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

CODES = {"f8": "d", "i8": "q", "u4": "I"}  # of numbers, for struct


class Packer(NamedTuple):
    """How rows become records: what reads all values of a row, which of them are several numbers, and their bytes."""

    values: Any
    several: tuple[bool, ...]
    bytes: struct.Struct


class AsNumPy:
    """The `data` of a record that has none of its own: as NumPy has it."""

    def __get__(self, record: Any, kind: type) -> Any:
        return np.record.data.__get__(record, kind)


class Record(np.record):  # type: ignore[misc]  # not final when it runs
    """A record that kernels are given by itself. At each call Numba asks every record for its `data`, and for that
    NumPy spells out all of its fields, 2 us long. These have it ready."""

    data = AsNumPy()


class LeanRecord(Record):  # type: ignore[misc]
    """A Record of a dtype that `without` made: Python's type tells it from others, as that of kernels does."""


class LeanRecords(np.recarray):
    """Several of them."""


def single(dtype: np.dtype, memory: Any, at: int = 0) -> Record:
    """The Record in this memory, which may be an array of one, from a byte on."""
    kind = LeanRecord if lean(dtype) else Record
    array: Any = np.ndarray.__new__(np.ndarray, (1,), of_class(kind, dtype), memory, at)
    found = array[0]
    vars(found)["data"] = np.frombuffer(memory, np.uint8, dtype.itemsize, at).data
    return found


def blank(dtype: np.dtype, *shape: int) -> np.recarray:
    """Records of zeros."""
    return np.zeros(shape, recorded(dtype)).view(np.recarray)


def records(dtype: np.dtype, rows: Sequence[dict]) -> np.recarray:
    """Rows with a value for every field: a number, or a list of as many as the field has."""
    values, several, packed = packer(dtype)
    content = bytearray()
    for row in rows:
        numbers: list[Any] = []
        for value, many in zip(values(row), several, strict=True):
            if many:
                numbers.extend(value)
            else:
                numbers.append(value)
        content += packed.pack(*numbers)
    return np.frombuffer(content, recorded(dtype)).view(np.recarray)


def copy_of(array: Any) -> Any:
    """A copy of a record or of records in one piece."""
    if not array.size:
        return array.copy()
    content = bytearray(array.tobytes())
    if isinstance(array, np.void):
        return single(array.dtype, content)
    return np.frombuffer(content, array.dtype).reshape(array.shape).view(type(array))


def plain(record: np.record) -> Any:
    """A copy of a record for Python, which reads all of its fields at once as fast as one or two of the record: whoever
    reads a record by its fields reads it too."""
    return SimpleNamespace(**dict(zip(record.dtype.names or (), record.item(), strict=True)))


def recorded(dtype: np.dtype) -> np.dtype:
    """Of np.record with these fields."""
    return of_class(np.record, dtype)


def without(dtype: np.dtype, *names: str) -> np.dtype:
    """The same fields, of which these are 0 in every record. They have a title that says so, which is part of the type
    that kernels are compiled for: what is done with them there is left out, see compiler.py."""
    fields: Any = dtype.fields
    everything = list(dtype.names or ())
    return np.dtype(
        {
            "names": everything,
            "formats": [dtype[name] for name in everything],
            "offsets": [fields[name][1] for name in everything],
            "titles": [zero_title(name) if name in names else None for name in everything],
            "itemsize": dtype.itemsize,
        }
    )


@lru_cache
def lean(dtype: np.dtype) -> bool:
    """Whether some fields are known to be 0 in every record."""
    return len(dtype.fields or ()) > len(dtype.names or ())  # titles count among the former


def zero_title(name: str) -> str:
    """Title of a field of this name that is 0 in every record."""
    return f"{name} is 0"


@lru_cache
def of_class(kind: type[np.record], dtype: np.dtype) -> np.dtype:
    """Of records of a class, with these fields."""
    return np.dtype((kind, dtype))


@lru_cache
def packer(dtype: np.dtype) -> Packer:
    names = dtype.names or ()
    several = tuple(bool(dtype[name].names or dtype[name].shape) for name in names)
    return Packer(itemgetter(*names), several, struct.Struct(f"={code(dtype)}"))


def code(dtype: np.dtype) -> str:
    """What struct calls a dtype, bytes between its fields included."""
    if dtype.subdtype:
        base, shape = dtype.subdtype
        return code(base) * prod(shape)
    if dtype.fields is None:
        return CODES[dtype.str[1:]]
    told, at = "", 0
    fields = (dtype.fields[name][:2] for name in dtype.names or ())  # which a title would list once more
    for field, offset in sorted(fields, key=itemgetter(1)):
        told += "x" * (offset - at) + code(field)
        at = offset + field.itemsize
    return told + "x" * (dtype.itemsize - at)
