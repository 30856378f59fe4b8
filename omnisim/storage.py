"""Trajectory <-> HDF5. The only place that knows h5py.

The layout is the one that HDF5 tools and netCDF share: every axis of every dataset carries a dimension scale,
so xarray opens a file as a tree with both of its engines. Datasets are not compressed: shuffle + gzip makes the
file of a smooth motion 20 % smaller, but takes 15 times as long.

Every dataset has a checksum. That of numbers is HDF5's own filter, fletcher32, which needs chunks. Of text it would
only see the references to the characters, so text has the CRC-32 of these as an attribute; the scene has it too.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import Any
from zlib import crc32

import h5py
import numpy as np

from omnisim.arguments import path_text
from omnisim.files import write_whole
from omnisim.text import visible
from omnisim.trajectory import ATTRIBUTES, EVENT, FORMAT, FORMAT_VERSION, Quantity, Trajectory, layout

TEXT = h5py.string_dtype()  # variable length, UTF-8
CHUNK = 1 << 20  # bytes, about: what HDF5 caches of a dataset
LIBRARY = ("v110", "v110")  # HDF5 of 2016: a dataset in one chunk has no index, and metadata have checksums as well
CHECKSUM, SCENE_CHECKSUM = "crc32", "scene_crc32"  # attributes: of a dataset of text, of the root
NO_MATCH = "it does not match its checksum"


class TrajectoryError(ValueError):
    """A file that is no readable trajectory; the message is one line that starts with its path."""


def write(trajectory: Trajectory, path: str | PathLike[str], overwrite: bool = False) -> None:
    """Write a trajectory, whole or not at all: whatever goes wrong, a file that was there stays as it was.

    Raises FileExistsError unless it may overwrite, OSError with the path and the reason (disk full, folder missing or
    read-only, not a regular file), and ValueError when the data have been changed into what is no trajectory any more,
    NaN for one.
    """
    write_whole({Path(path): image(trajectory)}, overwrite)


def image(trajectory: Trajectory) -> memoryview:
    """The file as bytes. Raises ValueError as `write` does."""
    trajectory.validate()
    buffer = BytesIO()  # HDF5 writing to a full disk crashes the process, bytes written by Python do not
    with h5py.File(buffer, "w", track_order=True, libver=LIBRARY) as file:
        _fill(file, trajectory)
    return buffer.getbuffer()


def read(path: str | PathLike[str]) -> Trajectory:
    """Read a trajectory file; datasets and attributes this version does not know are left alone.

    Raises TrajectoryError, one line, when the file is missing, a folder, no HDF5 file, no trajectory, of a
    newer format, truncated, damaged or incomplete, and TypeError for what is no path.
    """
    return _opened(path_text("open_trajectory", path), _load)


def stored_scene(path: str | PathLike[str]) -> str:
    """The TOML text of the scene that a trajectory file is the run of. Raises TrajectoryError as `read` does."""
    return _opened(path, _scene)


def _opened(path: str | PathLike[str], get: Callable[[h5py.File], Any]) -> Any:
    """What `get` finds in a trajectory file, or TrajectoryError."""
    name = visible(str(path))
    try:
        if os.path.exists(path) and not os.path.isdir(path) and not os.path.isfile(path):
            raise TrajectoryError(f"{name}: not a regular file")
        with open(path, "rb"):
            pass
        if not h5py.is_hdf5(path):
            raise TrajectoryError(f"{name}: not an HDF5 file")
        with h5py.File(path, "r") as file:
            _check_format(file, name)
            return get(file)
    except TrajectoryError:
        raise
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise TrajectoryError(f"{name}: {error.strerror}") from error
    except Exception as error:  # a damaged file makes h5py raise nearly anything
        reason = visible(str(error).partition("\n")[0])
        raise TrajectoryError(f"{name}: truncated or damaged ({reason})") from error


def _fill(file: h5py.File, trajectory: Trajectory) -> None:
    for name, value in trajectory.attributes.items():
        file.attrs.create(name, value, dtype=TEXT if ATTRIBUTES[name] in (str, tuple) else None)
    file.attrs[SCENE_CHECKSUM] = checksum(trajectory.attributes["scene"])
    for quantity in trajectory.quantities:
        _create(file, quantity, trajectory.data[quantity.path])
    for quantity in trajectory.quantities:
        if not quantity.is_scale:
            for dimension, axis in zip(file[quantity.path].dims, quantity.axes, strict=True):
                dimension.attach_scale(file[axis])


def _create(file: h5py.File, quantity: Quantity, array: np.ndarray) -> None:
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
    dataset.attrs["units"] = quantity.units
    dataset.attrs["description"] = quantity.description
    if quantity.is_scale:
        dataset.make_scale(name)
    elif EVENT in quantity.axes and name != "time":
        # Makes /events/time a coordinate of the events. Without it xarray shows /time in its place, a
        # coordinate of the root that every group inherits.
        dataset.attrs["coordinates"] = "time"


def _chunk(array: np.ndarray) -> tuple[int, ...]:
    """All of a small array, else so many rows that there is little of the last chunk to fill."""
    pieces = math.ceil(array.nbytes / CHUNK)
    return (math.ceil(len(array) / pieces), *array.shape[1:])


def checksum(*texts: str) -> np.uint32:
    """CRC-32 of texts in UTF-8, each with a zero byte after it."""
    return np.uint32(crc32("".join(f"{text}\0" for text in texts).encode()))


def _check_format(file: h5py.File, path: str) -> None:
    name = file.attrs.get("format")
    if not isinstance(name, str) or name != FORMAT:
        raise TrajectoryError(f"{path}: HDF5, but no omnisim trajectory (attribute format is not {FORMAT!r})")
    version = int(file.attrs["format_version"])
    if version > FORMAT_VERSION:
        raise TrajectoryError(f"{path}: format version {version}, but this omnisim reads up to {FORMAT_VERSION}")


def _load(file: h5py.File) -> Trajectory:
    """What the file holds of a trajectory; Trajectory itself finds what is missing or wrong."""
    attributes = {name: file.attrs[name] for name in ATTRIBUTES if name in file.attrs}
    if "scene" in attributes:
        attributes["scene"] = _scene(file)
    table = layout(tuple(attributes.get("wheels", ())))
    data = {path: _array(file[path], row) for path, row in table.items() if path in file}
    return Trajectory(attributes, data)


def _scene(file: h5py.File) -> str:
    scene = str(file.attrs["scene"])
    if file.attrs.get(SCENE_CHECKSUM, checksum(scene)) != checksum(scene):
        raise ValueError(f"attribute scene: {NO_MATCH}")
    return scene


def _array(dataset: h5py.Dataset, quantity: Quantity) -> np.ndarray:
    """All values; ValueError if they are not those that were written. Older files have no checksums."""
    try:
        array = dataset.asstr()[...].astype(str) if quantity.dtype == "str" else dataset[...]
    except Exception as error:
        reason = NO_MATCH if "filter" in str(error) else str(error)
        raise ValueError(f"dataset {quantity.path}: {reason}") from error
    if quantity.dtype == "str" and dataset.attrs.get(CHECKSUM) not in (None, checksum(*array.ravel().tolist())):
        raise ValueError(f"dataset {quantity.path}: {NO_MATCH}")
    return array
