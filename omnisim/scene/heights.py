"""The heights of a floor's grid: read from a file beside the scene, and kept in the scene itself.

A text that is loaded elsewhere, such as the scene of a trajectory, must find the same heights: in the place of the
file's name it has a data URL, the compressed .npy file in base64.
"""

import base64
import binascii
import gzip
import io
import zlib
from functools import lru_cache
from pathlib import Path

import numpy as np

from omnisim.base.files import read_small
from omnisim.base.formatting import visible
from omnisim.scene.problems import ConfigError, Problem
from omnisim.scene.schema import Config
from omnisim.scene.toml_text import KeyPath, show_value

GRID_FILE: KeyPath = ("floor", "grid", "file")
KEPT = "data:application/gzip;base64,"
NPY = b"\x93NUMPY"
MOST_HEIGHTS = 10**6
MOST_BYTES = 64 << 20  # of a file of heights


def kept_heights(config: Config, folder: Path) -> str | None:
    """What a scene has to keep in the place of a file's name; None if there is no grid, or it has it already.

    Raises ConfigError for a file in this folder that holds no heights.
    """
    grid = config.floor.grid
    if grid is None:
        return None
    try:
        if grid.file.startswith(KEPT):
            heights_of(grid.file)
            return None
        return kept(read_heights(folder / grid.file))
    except OSError as error:
        raise ConfigError([Problem(GRID_FILE, f"cannot be read: {error.strerror or error}")]) from None
    except ValueError as error:
        raise ConfigError([Problem(GRID_FILE, str(error))]) from None


def kept(heights: np.ndarray) -> str:
    """Heights as a scene keeps them."""
    file = io.BytesIO()
    np.save(file, heights)
    return KEPT + base64.b64encode(gzip.compress(file.getvalue(), mtime=0)).decode("ascii")


@lru_cache(maxsize=4)
def heights_of(url: str) -> np.ndarray:
    """The heights (rows, columns) that a scene keeps, m. Raises ValueError."""
    try:
        packed = base64.b64decode(url.removeprefix(KEPT), validate=True)
        content = gzip.GzipFile(fileobj=io.BytesIO(packed)).read(MOST_BYTES)
    except (OSError, EOFError, zlib.error, binascii.Error):
        raise ValueError("its heights are damaged") from None
    return checked_heights(from_npy(content))


def read_heights(path: Path) -> np.ndarray:
    """The heights (rows, columns) in a CSV or .npy file, m. Raises OSError, and ValueError for what is no height."""
    content = read_small(path, MOST_BYTES)
    return checked_heights(from_npy(content) if content.startswith(NPY) else from_csv(content))


def from_npy(content: bytes) -> np.ndarray:
    try:
        found = np.load(io.BytesIO(content), allow_pickle=False)
    except (ValueError, EOFError, OSError):
        raise ValueError("no readable .npy file of numbers") from None
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "iuf":
        raise ValueError("must hold numbers")
    return found.astype(float)


def from_csv(content: bytes) -> np.ndarray:
    """Rows of numbers, with commas between them."""
    lines = content.decode("utf-8-sig", "replace").rstrip().splitlines()
    rows = [[number(cell, i, j) for j, cell in enumerate(line.split(","), 1)] for i, line in enumerate(lines, 1)]
    for i, row in enumerate(rows, 1):
        if len(row) != len(rows[0]):
            raise ValueError(f"line {i} has {len(row)} heights, and line 1 has {len(rows[0])}; must be as many in all")
    return np.array(rows, dtype=float, ndmin=2)


def number(cell: str, line: int, column: int) -> float:
    """The height in a cell. Raises ValueError."""
    try:
        return float(cell)
    except ValueError:
        told = visible(show_value(cell.strip())) if cell.strip() else "nothing"
        raise ValueError(f"line {line}, column {column}: {told}; must be a finite number") from None


def checked_heights(heights: np.ndarray) -> np.ndarray:
    """The same, or ValueError: they are too few or too many, or some are missing."""
    if heights.ndim != 2 or min(heights.shape) < 2:
        shape = " x ".join(map(str, heights.shape))
        raise ValueError(f"holds {shape} heights; must be 2 x 2 or more")
    if heights.size > MOST_HEIGHTS:
        raise ValueError(f"holds {heights.size} heights; must be at most {MOST_HEIGHTS:.0e}")
    holes = np.argwhere(~np.isfinite(heights))
    if len(holes):
        i, j = holes[0]
        raise ValueError(f"line {i + 1}, column {j + 1}: {heights[i, j]}; must be a finite number")
    return np.ascontiguousarray(heights)
