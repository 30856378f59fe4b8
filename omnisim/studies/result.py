"""What a study has found: named arrays along the varied keys or along `run`, in one HDF5 file that xarray opens.

Where a run has no number (it stopped early, was impossible, has not run yet) the file has the fill value of netCDF,
which readers take for missing, and the status says why.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from omnisim.base.files import write_whole
from omnisim.base.formatting import visible
from omnisim.base.hdf5_reading import open_to_read
from omnisim.base.trajectory_file import STUDY
from omnisim.base.version import VERSION
from omnisim.results.hdf5 import LIBRARY, TEXT, describe
from omnisim.scene.toml_text import show_value
from omnisim.studies.study import StudyError
from omnisim.studies.task import Row, Task

if TYPE_CHECKING:
    import xarray

FORMAT, FORMAT_VERSION = STUDY, 1
MISSING = 9.969209968386869e36  # netCDF's fill value of a double
NOT_RUN = "not run"
OF_KEYS = "values of this key of the scene, in the units of its file"
RUN = "run"
OF_RUNS = (
    ("stop_time", "s", "simulated time at which the run ended"),
    ("wall_time", "s", "time that its march took"),
)


@dataclass(frozen=True)
class Variable:
    """An array along the dimensions named, with its unit and what it is; NaN where a float is missing. scale: it is a
    dimension itself; coordinate: it tells where in the study a number stands."""

    dims: tuple[str, ...]
    values: np.ndarray
    units: str
    description: str
    coordinate: bool = False

    @property
    def attributes(self) -> dict[str, str]:
        """Of the dataset in the file."""
        return {name: text for name, text in (("units", self.units), ("description", self.description)) if text}

    def is_scale(self, name: str) -> bool:
        return self.dims == (name,)


class StudyResult(Mapping[str, np.ndarray]):
    """The arrays of a study by name.

        found = omnisim.sweep("study.toml")              or omnisim.open_study("study.h5")
        found["drift"]                      along the varied keys of a grid, else `run`; NaN: none
        found.to_xarray();  found.save("study.h5")

    attributes  format, format_version, omnisim_version, study and scene (texts), design, seed, runs, finished
    variables   Variable by name
    """

    def __init__(self, attributes: dict[str, Any], variables: dict[str, Variable]):
        self.attributes = attributes
        self.variables = variables

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self.variables:
            raise KeyError(f"no variable {name!r}; there are {', '.join(self.variables)}")
        return self.variables[name].values

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __len__(self) -> int:
        return len(self.variables)

    @property
    def complete(self) -> bool:
        """Whether all runs have run, however they ended."""
        return self.attributes["finished"] == self.attributes["runs"]

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the numbers that were asked for."""
        return tuple(str(name) for name in self.attributes["measures"])

    def to_xarray(self) -> xarray.Dataset:
        """The Dataset that xarray opens from the saved file (extra `xarray`)."""
        import xarray

        made = {
            name: xarray.Variable(
                one.dims, one.values, ({"units": one.units} if one.units else {}) | {"description": one.description}
            )
            for name, one in self.variables.items()
        }
        apart = {name for name, one in self.variables.items() if one.coordinate}
        data = {name: one for name, one in made.items() if name not in apart}
        return xarray.Dataset(data, {name: made[name] for name in apart}, self.attributes)

    def save(self, path: str | PathLike[str], overwrite: bool = False) -> None:
        """Write an HDF5 file, whole or not at all. Raises FileExistsError unless it may overwrite, and OSError."""
        write_whole({Path(path): self.image()}, overwrite)

    def image(self) -> memoryview:
        """The file as bytes."""
        buffer = BytesIO()
        with h5py.File(buffer, "w", track_order=True, libver=LIBRARY) as file:
            for name, value in self.attributes.items():
                file.attrs.create(name, value, dtype=TEXT if isinstance(value, str | tuple) else None)
            others = " ".join(name for name, one in self.variables.items() if one.coordinate and not one.is_scale(name))
            made = {name: _create(file, name, one, others) for name, one in self.variables.items()}
            for name, one in self.variables.items():
                if not one.is_scale(name):
                    for dimension, axis in zip(made[name].dims, one.dims, strict=True):
                        dimension.attach_scale(made[axis])
        return buffer.getbuffer()

    def __repr__(self) -> str:
        a = self.attributes
        sizes = {name: one.values.size for name, one in self.variables.items() if one.is_scale(name)}
        along = ", ".join(f"{name}: {size}" for name, size in sizes.items())
        return (
            f"<StudyResult of {a['finished']} runs of {a['runs']} ({a['design']}); {along}; {', '.join(self.measures)}>"
        )


def _create(file: h5py.File, name: str, one: Variable, coordinates: str) -> h5py.Dataset:
    values = one.values
    if values.dtype.kind in "UO":
        dataset = file.create_dataset(name, data=values.astype(object), dtype=TEXT)
    else:
        missing = values.dtype.kind == "f"
        stored = np.where(np.isnan(values), MISSING, values) if missing else values
        dataset = file.create_dataset(
            name, data=stored, chunks=stored.shape if stored.size else None, fletcher32=bool(stored.size)
        )
        if missing and not one.is_scale(name):
            dataset.attrs["_FillValue"] = MISSING
    describe(dataset, **one.attributes)
    if one.is_scale(name):
        dataset.make_scale(name)
    elif coordinates and not one.coordinate:
        describe(dataset, coordinates=coordinates)
    return dataset


def open_study(path: str | PathLike[str]) -> StudyResult:
    """Read the file of a study. Raises StudyError, one line, for what is none."""
    shown = visible(str(path))
    try:
        with open_to_read(path) as file:
            if file.attrs.get("format") != FORMAT:
                raise StudyError(f"{shown}: HDF5, but no study of omnisim (attribute format is not {FORMAT!r})")
            attributes = {name: _plain(value) for name, value in file.attrs.items() if not name.startswith("_")}
            return StudyResult(attributes, {name: _read(file, name) for name in file})
    except OSError as error:
        raise StudyError(f"{shown}: {error.strerror or 'not an HDF5 file, or damaged'}") from None


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return tuple(map(str, value.tolist()))
    return value.item() if isinstance(value, np.generic) else value


def _read(file: h5py.File, name: str) -> Variable:
    dataset = file[name]
    text = h5py.check_string_dtype(dataset.dtype) is not None
    values = dataset.asstr()[...].astype(str) if text else dataset[...]
    if "_FillValue" in dataset.attrs:
        values = np.where(values == MISSING, np.nan, values)
    dims = (name,) if dataset.is_scale else tuple(dimension[0].name.removeprefix("/") for dimension in dataset.dims)
    own = dataset.is_scale or name in str(file.attrs["coordinates"]).split()
    return Variable(dims, values, str(dataset.attrs.get("units", "")), str(dataset.attrs["description"]), own)


def gathered(task: Task, rows: Iterable[Row]) -> StudyResult:
    """The StudyResult of a study of which these rows are known."""
    study = task.study
    count = study.count
    known = list(rows)
    runs = [row.run for row in known]
    status = np.full(count, NOT_RUN, dtype=object)
    status[runs] = [row.status for row in known]
    times = np.full((len(OF_RUNS), count), np.nan)
    times[:, runs] = np.array([(row.stop_time, row.wall_time) for row in known]).reshape(len(known), len(OF_RUNS)).T
    asked = (*task.readings, *task.final)
    numbers = np.full((len(asked), count), np.nan)
    found = np.array([(*row.measures, *row.final) for row in known], dtype=float)  # None: NaN
    numbers[:, runs] = found.reshape(len(known), len(asked)).T
    variables = coordinates(task)
    dims = tuple(factor.key for factor in study.factors) if study.kind == "grid" else (RUN,)
    for reading, values in zip(asked, numbers, strict=True):
        variables[reading.name] = Variable(dims, values.reshape(study.shape), reading.units, reading.told)
    variables["status"] = Variable(dims, status.astype(str).reshape(study.shape), "1", "how the run ended")
    for (name, units, told), values in zip(OF_RUNS, times, strict=True):
        variables[name] = Variable(dims, values.reshape(study.shape), units, told)
    variables["seed"] = Variable(dims, study.seeds.astype(np.int64).reshape(study.shape), "1", "of what a run draws")
    attributes = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "omnisim_version": VERSION,
        "study": study.document.text,
        "scene": study.scene.text,
        "design": study.kind,
        "measures": tuple(reading.name for reading in task.readings),
        "coordinates": " ".join(name for name, one in variables.items() if one.coordinate),
        "runs": count,
        "finished": int(np.sum(status != NOT_RUN)),
    }
    return StudyResult(attributes, variables)


def rows_of(task: Task, found: StudyResult) -> list[Row]:
    """The rows of a StudyResult of this task's study: of the runs that have run."""
    names = [reading.name for reading in (*task.readings, *task.final)]
    table = np.array([found[name].ravel() for name in names]).reshape(len(names), task.study.count).T.tolist()
    columns = zip(*(found[name].ravel().tolist() for name in ("status", "stop_time", "wall_time")), table, strict=True)
    rows = []
    for run, (status, stop_time, wall_time, numbers) in enumerate(columns):
        values = tuple(None if math.isnan(value) else value for value in numbers)
        if status != NOT_RUN:
            split = len(task.readings)
            rows.append(Row(run, status, stop_time, wall_time, values[:split], values[split:]))
    return rows


def coordinates(task: Task) -> dict[str, Variable]:
    """The values of the varied keys."""
    study = task.study
    if study.kind == "grid":
        return {
            factor.key: Variable(
                (factor.key,),
                column(factor.listed),
                "",
                OF_KEYS,
                True,
            )
            for factor in study.factors
        }
    found = {RUN: Variable((RUN,), np.arange(study.count), "1", "runs, counted from 0", True)}
    for factor, values in zip(study.factors, study.columns, strict=True):
        dims: tuple[str, ...] = (RUN,)
        if factor.each:
            axis = factor.key.partition(".")[0]
            found[axis] = Variable((axis,), np.array(factor.names), "", "names", True)
            dims = (RUN, axis)
        shape = (study.count, factor.draws)[: len(dims)]
        found[factor.key] = Variable(dims, column(values).reshape(shape), "", OF_KEYS, True)
    return found


def column(values: Iterable[Any]) -> np.ndarray:
    """Values of a key as an array: numbers as they are, all else as the text of a scene file has it."""
    values = list(values)
    types = set(map(type, values))
    if bool not in types and all(issubclass(kind, int | float) for kind in types):
        return np.array(values, dtype=np.int64 if all(issubclass(kind, int) for kind in types) else np.float64)
    return np.array([value if isinstance(value, str) else show_value(value, sys.maxsize) for value in values])
