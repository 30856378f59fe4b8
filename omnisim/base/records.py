"""Records as Python makes and reads them: what kernels know by field.

An array of np.record is at once what a recarray wants; viewing others as one takes longer than all the rest.
"""

from types import SimpleNamespace
from typing import Any

import numpy as np


def blank(dtype: np.dtype, *shape: int) -> np.recarray:
    """Records of zeros."""
    return np.zeros(shape, (np.record, dtype)).view(np.recarray)


def records(dtype: np.dtype, rows: list[dict]) -> np.recarray:
    """Rows with a value for every field."""
    values = [tuple([row[name] for name in dtype.names or ()]) for row in rows]
    return np.array(values, (np.record, dtype)).view(np.recarray)


def plain(record: np.record) -> Any:
    """A copy of a record for Python, which reads all of its fields at once as fast as one or two of the record: whoever
    reads a record by its fields reads it too."""
    return SimpleNamespace(**dict(zip(record.dtype.names or (), record.item(), strict=True)))
