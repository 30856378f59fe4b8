"""Trajectory <-> HDF5.

The layout is the one that HDF5 tools and netCDF share: every axis of every dataset carries a dimension scale,
so xarray opens a file as a tree with both of its engines. Datasets are not compressed: shuffle + gzip makes the
file of a smooth motion 20 % smaller, but takes 15 times as long.

Every dataset has a checksum. That of numbers is HDF5's own filter, fletcher32, which needs chunks. Of text it would
only see the references to the characters, so text has the CRC-32 of these as an attribute; the scene has it too.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from omnisim.base.files import write_whole
from omnisim.base.trajectory_file import CHECKSUM, NO_MATCH, SCENE_CHECKSUM, checksum, opened, scene_text
from omnisim.results.layout import ATTRIBUTES, EVENT_NUMBER, Quantity, Recorded, layout

T = TypeVar("T")
TEXT = h5py.string_dtype()  # variable length, UTF-8
TEXT_TYPE, SCALAR = h5py.h5t.py_create(TEXT, logical=True), h5py.h5s.create(h5py.h5s.SCALAR)  # HDF5's own
CHUNK = 1 << 20  # bytes, about: what HDF5 caches of a dataset
LIBRARY = ("v110", "v110")  # HDF5 of 2016: a dataset in one chunk has no index, and metadata have checksums as well


def write(trajectory: Recorded, path: str | PathLike[str], overwrite: bool = False) -> None:
    """Write a trajectory, whole or not at all: whatever goes wrong, a file that was there stays as it was.

    Raises FileExistsError unless it may overwrite, OSError with the path and the reason (disk full, folder missing or
    read-only, not a regular file), and ValueError when the data have been changed into what is no trajectory any more,
    NaN for one.
    """
    write_whole({Path(path): image(trajectory)}, overwrite)


def image(trajectory: Recorded) -> memoryview:
    """The file as bytes. Raises ValueError as `write` does."""
    trajectory.validate()
    buffer = BytesIO()  # HDF5 writing to a full disk crashes the process, bytes written by Python do not
    with h5py.File(buffer, "w", track_order=True, libver=LIBRARY) as file:
        _fill(file, trajectory)
    return buffer.getbuffer()


def _fill(file: h5py.File, trajectory: Recorded) -> None:
    for name, value in trajectory.attributes.items():
        file.attrs.create(name, value, dtype=TEXT if ATTRIBUTES[name] in (str, tuple) else None)
    file.attrs[SCENE_CHECKSUM] = checksum(trajectory.attributes["scene"])
    made = {each.path: _create(file, each, trajectory.data[each.path]) for each in trajectory.quantities}
    for quantity in trajectory.quantities:
        if not quantity.is_scale:
            for dimension, axis in zip(made[quantity.path].dims, quantity.axes, strict=True):
                dimension.attach_scale(made[axis])


def _create(file: h5py.File, quantity: Quantity, array: np.ndarray) -> h5py.Dataset:
    *folders, name = quantity.path.split("/")
    group = file
    for folder in folders:
        group = group[folder] if folder in group else group.create_group(folder, track_order=True)
    if quantity.dtype == "str":
        dataset = group.create_dataset(name, data=array.astype(object), dtype=TEXT)
        dataset.attrs[CHECKSUM] = checksum(*array.tolist())
    elif array.size:
        dataset = group.create_dataset(name, data=array, chunks=_chunk(array), fletcher32=True)
    else:
        dataset = group.create_dataset(name, data=array)
    describe(dataset, units=quantity.units, description=quantity.description)
    if quantity.is_scale:
        dataset.make_scale(name)
    elif EVENT_NUMBER in quantity.axes and name != "time":
        # Makes /events/time a coordinate of the events. Without it xarray shows /time in its place, a
        # coordinate of the root that every group inherits.
        describe(dataset, coordinates="time")
    return dataset


def describe(dataset: h5py.Dataset, **texts: str) -> None:
    """Give a new dataset these attributes; `attrs`, which finds type and size anew, takes twice as long."""
    for name, text in texts.items():
        h5py.h5a.create(dataset.id, name.encode(), TEXT_TYPE, SCALAR).write(np.array(text, dtype=TEXT))


def _chunk(array: np.ndarray) -> tuple[int, ...]:
    """All of a small array, else so many rows that there is little of the last chunk to fill."""
    pieces = math.ceil(array.nbytes / CHUNK)
    return (math.ceil(len(array) / pieces), *array.shape[1:])


def read(path: str | PathLike[str], make: Callable[[dict[str, Any], dict[str, np.ndarray]], T]) -> T:
    """What `make` makes of the attributes and datasets of a trajectory file, those that this version knows.

    Raises TrajectoryError as `opened` does, and where `make` finds something missing or wrong.
    """
    return opened(path, lambda file: make(*_parts(file)))


def _parts(file: h5py.File) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    attributes = {name: file.attrs[name] for name in ATTRIBUTES if name in file.attrs}
    if "scene" in attributes:
        attributes["scene"] = scene_text(file)
    table = layout(tuple(attributes.get("wheels", ())))
    data = {path: _array(file[path], row) for path, row in table.items() if path in file}
    return attributes, data


def _array(dataset: h5py.Dataset, quantity: Quantity) -> np.ndarray:
    """All values; ValueError if they are not those that were written. Older files have no checksums."""
    try:
        array = dataset.asstr()[...].astype(str) if quantity.dtype == "str" else dataset[...]
    except Exception as error:
        refused = any(word in str(error) for word in ("filter", "Fletcher32"))  # as new and older libraries tell it
        reason = NO_MATCH if refused else str(error)
        raise ValueError(f"dataset {quantity.path}: {reason}") from error
    if quantity.dtype == "str" and dataset.attrs.get(CHECKSUM) not in (None, checksum(*array.ravel().tolist())):
        raise ValueError(f"dataset {quantity.path}: {NO_MATCH}")
    return array
