"""Copies of what a march works on, from one piece of memory."""

import copy
import pickle
from typing import NamedTuple

import numpy as np
import pytest

from omnisim.base.copying import Template
from omnisim.base.records import blank, copy_of, records, single

pytestmark = pytest.mark.short
PAIR = np.dtype([("number", "f8"), ("three", "f8", 3), ("count", "i8"), ("seed", "u4")])  # 44 bytes


class Inner(NamedTuple):
    record: np.record
    nothing: np.ndarray | None
    flags: np.ndarray


class Outer(NamedTuple):
    numbers: np.ndarray
    rows: np.recarray
    inner: Inner
    empty: np.ndarray
    none: None
    real: float
    count: int
    columns: np.ndarray
    scalar: np.float64
    whole: np.int64
    plain: np.ndarray


def original() -> Outer:
    row = {"number": 0.1, "three": [-0.0, np.nan, np.inf], "count": -7, "seed": 3}
    return Outer(
        np.linspace(0.1, 0.7, 5),
        records(PAIR, [row, row | {"number": 1 / 3}, row | {"count": 2**62}]),
        Inner(single(PAIR, records(PAIR, [row])), None, np.array([[True, False, True]])),
        np.zeros((0, 4)),
        None,
        0.3,
        5,
        np.asfortranarray(np.arange(6, dtype=np.uint32).reshape(2, 3)),
        np.float64(1 / 7),
        np.int64(-3),
        np.zeros((2, 2), PAIR),
    )


def leaves(value: object) -> list:
    """What stands in a NamedTuple, in order."""
    return [leaf for part in value for leaf in leaves(part)] if type(value) in (Outer, Inner) else [value]


def arrays(value: object) -> list:
    """Those of them that can be written into."""
    return [leaf for leaf in leaves(value) if isinstance(leaf, np.ndarray | np.void)]


def told(value: object) -> list:
    """All that can be said of its parts, to the last bit."""
    parts = [(type(leaf), np.asarray(leaf)) for leaf in leaves(value)]
    return [(kind, array.dtype, array.dtype.type, array.shape, array.tobytes()) for kind, array in parts]


def overwrite(value: object) -> None:
    """Other bytes everywhere."""
    for array in arrays(value):
        if array.dtype.names:
            for name in array.dtype.names:
                array[name] = 77
        else:
            array[...] = ~array if array.dtype == bool else 77


def test_a_copy_is_the_original_to_the_last_bit_each_part_of_its_kind_type_and_shape():
    copy = Template(original()).copy()
    assert type(copy) is Outer and type(copy.inner) is Inner
    assert told(copy) == told(original())
    assert copy.rows.number[1] == 1 / 3 and copy.inner.record.count == -7  # by their fields, as kernels read them


def test_what_is_written_into_a_copy_stays_in_it():
    first = original()
    template = Template(first)
    one, another = template.copy(), template.copy()
    overwrite(one)
    assert told(first) == told(another) == told(template.copy()) == told(original()) != told(one)


def test_what_is_written_into_one_array_of_a_copy_stays_in_that():
    for place in range(len(arrays(original()))):
        copy = Template(original()).copy()
        overwrite(Inner(arrays(copy)[place], None, np.zeros(0)))
        changed = [a.tobytes() != b.tobytes() for a, b in zip(arrays(copy), arrays(original()), strict=True)]
        assert sum(changed) == changed[place] == bool(np.size(arrays(copy)[place]))


def test_what_becomes_of_the_original_changes_no_copy():
    first = original()
    template = Template(first)
    before = template.copy()
    overwrite(first)
    assert told(before) == told(template.copy()) == told(original()) != told(first)


def test_arrays_of_a_copy_can_be_written_and_begin_where_their_numbers_may():
    first = original()
    first.numbers.flags.writeable = False
    for array in arrays(Template(first).copy()):
        whole = np.asarray(array)
        assert whole.flags.writeable and whole.flags.aligned and whole.flags.c_contiguous
        assert whole.size == 0 or whole.__array_interface__["data"][0] % 16 == 0  # as malloc gives memory


def test_what_has_no_numbers_has_copies_too():
    class Bare(NamedTuple):
        empty: np.ndarray
        none: None

    empty = np.zeros((0, 3))
    copy = Template(Bare(empty, None)).copy()
    assert copy.empty.shape == (0, 3) and copy.none is None


def test_rows_of_records_without_a_row_stay_records():
    class Rows(NamedTuple):
        rows: np.recarray

    rows = blank(PAIR, 0)
    copy = Template(Rows(rows)).copy().rows
    assert (type(copy), copy.dtype, copy.number.shape) == (np.recarray, rows.dtype, (0,))


def test_a_single_record_shows_the_memory_it_stands_in_and_its_copies_their_own():
    row = {"number": 0.1, "three": [1.0, 2.0, 3.0], "count": -7, "seed": 3}
    one = single(PAIR, bytearray(8) + records(PAIR, [row]).tobytes(), 8)
    others = copy_of(one), copy.deepcopy(one), pickle.loads(pickle.dumps(one))
    one["count"] = 5
    one.number = 1 / 3
    assert bytes(one.data) == one.tobytes() and (one.count, one["number"]) == (5, 1 / 3)
    others[0].seed = 4
    for other, seed in zip(others, (4, 3, 3), strict=True):
        assert bytes(other.data) == other.tobytes() and (other.count, other.number, other.seed) == (-7, 0.1, seed)
    assert one.seed == 3
