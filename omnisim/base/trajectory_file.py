"""A trajectory file as far as every room needs it: opened and checked, and the scene that it is the run of."""

from __future__ import annotations

import os
from collections.abc import Callable
from os import PathLike
from typing import TYPE_CHECKING, TypeVar
from zlib import crc32

import numpy as np

from omnisim.base.files import is_hdf5
from omnisim.base.formatting import visible
from omnisim.base.hdf5_reading import open_to_read

if TYPE_CHECKING:
    import h5py

FORMAT = "omnisim-trajectory"
FORMAT_VERSION = 1
STUDY = "omnisim-study"  # the format of files that hold many runs
CHECKSUM, SCENE_CHECKSUM = "crc32", "scene_crc32"  # attributes: of a dataset of text, of the root
NO_MATCH = "it does not match its checksum"
T = TypeVar("T")


class TrajectoryError(ValueError):
    """A file that is no readable trajectory; the message is one line that starts with its path."""


def stored_scene(path: str | PathLike[str]) -> str:
    """The TOML text of the scene that a trajectory file is the run of. Raises TrajectoryError as `opened` does."""
    return opened(path, scene_text)


def opened(path: str | PathLike[str], get: Callable[[h5py.File], T]) -> T:
    """What `get` finds in a trajectory file, or TrajectoryError, one line.

    Raised when the file is missing, a folder, no HDF5 file, no trajectory, of a newer format, truncated or damaged.
    """
    import h5py  # here: whoever only names the format needs no HDF5

    name = visible(str(path))
    try:
        if os.path.exists(path) and not os.path.isdir(path) and not os.path.isfile(path):
            raise TrajectoryError(f"{name}: not a regular file")
        with open(path, "rb"):
            pass
        if not h5py.is_hdf5(path):
            raise TrajectoryError(f"{name}: not an HDF5 file")
        with open_to_read(path) as file:
            _check_format(file, name)
            return get(file)
    except TrajectoryError:
        raise
    except (FileNotFoundError, IsADirectoryError, PermissionError) as error:
        raise TrajectoryError(f"{name}: {error.strerror}") from error
    except Exception as error:  # a damaged file makes h5py raise nearly anything
        reason = visible(str(error).partition("\n")[0])
        raise TrajectoryError(f"{name}: truncated or damaged ({reason})") from error


def format_of(path: str | PathLike[str]) -> str:
    """What an HDF5 file says that it is; empty for a file that says nothing or is none."""
    if not is_hdf5(path):
        return ""
    try:
        with open_to_read(path) as file:
            return str(file.attrs.get("format", ""))
    except OSError:
        return ""


def _check_format(file: h5py.File, path: str) -> None:
    name = file.attrs.get("format")
    if isinstance(name, str) and name == STUDY:
        raise TrajectoryError(f"{path}: a study, which is no trajectory; omnisim plot shows it")
    if not isinstance(name, str) or name != FORMAT:
        raise TrajectoryError(f"{path}: HDF5, but no omnisim trajectory (attribute format is not {FORMAT!r})")
    version = int(file.attrs["format_version"])
    if version > FORMAT_VERSION:
        raise TrajectoryError(f"{path}: format version {version}, but this omnisim reads up to {FORMAT_VERSION}")


def scene_text(file: h5py.File) -> str:
    """The TOML text of the scene. Raises ValueError if it is not the one that was written."""
    scene = str(file.attrs["scene"])
    if file.attrs.get(SCENE_CHECKSUM, checksum(scene)) != checksum(scene):
        raise ValueError(f"attribute scene: {NO_MATCH}")
    return scene


def checksum(*texts: str) -> np.uint32:
    """CRC-32 of texts in UTF-8, each with a zero byte after it."""
    return np.uint32(crc32("".join(f"{text}\0" for text in texts).encode()))
