"""Records as Python makes and reads them: what kernels know by field."""

from types import SimpleNamespace

import numpy as np


def records(dtype: np.dtype, rows: list[dict]) -> np.recarray:
    """Rows with a value for every field."""
    return np.array([tuple([row[name] for name in dtype.names]) for row in rows], dtype).view(np.recarray)


def plain(record: np.record) -> SimpleNamespace:
    """A copy of a record for Python, which reads all of its fields at once as fast as one or two of the record."""
    return SimpleNamespace(**dict(zip(record.dtype.names, record.item(), strict=True)))
