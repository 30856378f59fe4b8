"""A trajectory for other tools: CSV, Parquet and MATLAB files, and recordings of ROS 2."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from os import PathLike
from pathlib import Path

from omnisim.base.files import holds, write_whole
from omnisim.base.formatting import visible
from omnisim.results.layout import Recorded
from omnisim.results.tables import ExportError, csv_files, extra, mat_file, parquet_files

__all__ = ["FORMATS", "ExportError", "images", "outputs", "unwritten", "write"]


def write(trajectory: Recorded, path: str | PathLike[str], overwrite: bool = False) -> tuple[Path, ...]:
    """Write what the suffix of `path` says, whole or not at all; the paths written.

    Raises ExportError for another suffix, a library that is not installed, and what a format cannot hold; SceneError if
    a format needs the scene and it cannot be read; FileExistsError unless it may overwrite; ValueError for NaN or inf;
    OSError.
    """
    files = images(trajectory, path)
    write_whole(unwritten(files, path), overwrite)
    return tuple(files)


def images(trajectory: Recorded, path: str | PathLike[str]) -> dict[Path, bytes]:
    """What `write` writes. Raises ExportError, SceneError and ValueError as it does."""
    path = outputs(path)[0]
    trajectory.validate()
    return FORMATS[path.suffix.lower()](trajectory, path)


def outputs(path: str | PathLike[str]) -> tuple[Path, ...]:
    """The files that make up an export to `path`, as far as the path tells: the table by time has events beside it,
    run.csv run.events.csv; a recording the URDF of the machine, run.mcap run.urdf, and meshes of its rollers.

    Raises ExportError for another suffix, and for a library that is not installed.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        known = ", ".join(FORMATS)
        raise ExportError(f"{visible(str(path))}: unknown suffix {path.suffix!r}; it must be one of {known}")
    for library in LIBRARIES.get(suffix, ()):
        with extra(suffix[1:]):
            import_module(library)
    return path, *(path.with_suffix(beside.format(path.suffix)) for beside in BESIDE[suffix])


def unwritten(files: dict[Path, bytes], path: str | PathLike[str]) -> dict[Path, bytes]:
    """Those of an export to `path` that have to be written: a mesh stays that is there already, just as it would be."""
    known = outputs(path)
    return {file: image for file, image in files.items() if file in known or not holds(file, image)}


def tables(made: Callable[[Recorded], tuple[bytes, ...]]) -> Callable[[Recorded, Path], dict[Path, bytes]]:
    """A format whose files are known by the path."""
    return lambda trajectory, path: dict(zip(outputs(path), made(trajectory), strict=True))


def recording(trajectory: Recorded, path: Path) -> dict[Path, bytes]:
    from omnisim.exports.recording import files  # here: tables wait for no kernels

    return files(trajectory, path)


LIBRARIES = {".parquet": ("pyarrow",), ".mat": ("scipy.io",), ".mcap": ("mcap", "rosbags")}  # that a format needs
BESIDE = {".csv": (".events{}",), ".parquet": (".events{}",), ".mat": (), ".mcap": (".urdf",)}  # suffixes, {}: its own
FORMATS = {
    ".csv": tables(csv_files),
    ".parquet": tables(parquet_files),
    ".mat": tables(mat_file),
    ".mcap": recording,
}
