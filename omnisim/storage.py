"""Trajectory <-> HDF5. The only place that knows h5py.

The layout is the one that HDF5 tools and netCDF share: every axis of every dataset carries a dimension scale,
so xarray opens a file as a tree with both of its engines. Datasets are contiguous: shuffle + gzip makes the
file of a smooth motion 20 % smaller, but takes 15 times as long.
"""

from __future__ import annotations

from io import BytesIO
from os import PathLike
from pathlib import Path

import h5py
import numpy as np

from omnisim.arguments import path_text
from omnisim.files import write_whole
from omnisim.trajectory import ATTRIBUTES, EVENT, FORMAT, FORMAT_VERSION, Quantity, Trajectory, layout

TEXT = h5py.string_dtype()  # variable length, UTF-8


class TrajectoryError(ValueError):
    """A file that is no readable trajectory; the message is one line that starts with its path."""


def write(trajectory: Trajectory, path: str | PathLike[str]) -> None:
    """Write a trajectory, whole or not at all: whatever goes wrong, a file that was there stays as it was.

    Raises OSError with the path and the reason (disk full, folder missing or read-only, not a regular file),
    and ValueError when the data have been changed into what is no trajectory any more, NaN for one.
    """
    trajectory.validate()
    image = BytesIO()  # HDF5 writing to a full disk crashes the process, bytes written by Python do not
    with h5py.File(image, "w", track_order=True) as file:
        _fill(file, trajectory)
    write_whole({Path(path): image.getbuffer()})


def read(path: str | PathLike[str]) -> Trajectory:
    """Read a trajectory file; datasets and attributes this version does not know are left alone.

    Raises TrajectoryError, one line, when the file is missing, a folder, no HDF5 file, no trajectory, of a
    newer format, truncated, damaged or incomplete, and TypeError for what is no path.
    """
    path = path_text("open_trajectory", path)
    try:
        with open(path, "rb"):
            pass
        if not h5py.is_hdf5(path):
            raise TrajectoryError(f"{path}: not an HDF5 file")
        with h5py.File(path, "r") as file:
            _check_format(file, path)
            return _load(file)
    except TrajectoryError:
        raise
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise TrajectoryError(f"{path}: {error.strerror}") from error
    except Exception as error:  # a damaged file makes h5py raise nearly anything
        reason = str(error).partition("\n")[0]
        raise TrajectoryError(f"{path}: truncated or damaged ({reason})") from error


def _fill(file: h5py.File, trajectory: Trajectory) -> None:
    for name, value in trajectory.attributes.items():
        file.attrs.create(name, value, dtype=TEXT if ATTRIBUTES[name] in (str, tuple) else None)
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


def _check_format(file: h5py.File, path: str | PathLike[str]) -> None:
    name = file.attrs.get("format")
    if not isinstance(name, str) or name != FORMAT:
        raise TrajectoryError(f"{path}: HDF5, but no omnisim trajectory (attribute format is not {FORMAT!r})")
    version = int(file.attrs["format_version"])
    if version > FORMAT_VERSION:
        raise TrajectoryError(f"{path}: format version {version}, but this omnisim reads up to {FORMAT_VERSION}")


def _load(file: h5py.File) -> Trajectory:
    """What the file holds of a trajectory; Trajectory itself finds what is missing or wrong."""
    attributes = {name: file.attrs[name] for name in ATTRIBUTES if name in file.attrs}
    table = layout(tuple(attributes.get("wheels", ())))
    data = {path: _array(file[path], row) for path, row in table.items() if path in file}
    return Trajectory(attributes, data)


def _array(dataset: h5py.Dataset, quantity: Quantity) -> np.ndarray:
    return dataset.asstr()[...].astype(str) if quantity.dtype == "str" else dataset[...]
