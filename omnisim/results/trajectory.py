"""What a run returns: attributes and datasets, checked against the table of layout.py."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Set
from difflib import get_close_matches
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnisim.base.arguments import path_text
from omnisim.base.trajectory_file import FORMAT, FORMAT_VERSION
from omnisim.results.layout import ATTRIBUTES, COMPLETE, LABELS, OPTIONAL_ATTRIBUTES, TIME, Quantity, layout

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

Data = Mapping[str, np.ndarray]


class Trajectory:
    """The motion of one run: T rows at equal intervals, N_r rollers per wheel, E events.

        run = omnisim.simulate("youbot")                 or omnisim.open_trajectory("run.h5")
        run["body/position"]                             (T, 3), m; `for path in run` tells what there is
        run.plot("slip");  run.save("run.h5")

    attributes  root attributes of the file by name (ATTRIBUTES has the types); `format` and `format_version`
                are filled in
    data        arrays by path in the file, no leading slash (TABLE has axes, units and meaning); the scales
                axis, tangent, rollers/roller and events/event follow from the rest and may be left out. Or what
                makes them, which is called when somebody asks for the first of them

    Raises ValueError, naming the attribute or dataset, when one is unknown, missing, of the wrong type or
    shape, or not finite.
    """

    def __init__(self, attributes: Mapping[str, Any], data: Data | Callable[[], Data]):
        given = {**attributes, "format": FORMAT, "format_version": FORMAT_VERSION}
        _same_names("attribute", given, ATTRIBUTES, OPTIONAL_ATTRIBUTES)
        self.attributes: dict[str, Any] = {name: _attribute(name, given[name]) for name in ATTRIBUTES if name in given}
        if not self.wheels:
            raise ValueError("attribute wheels: a trajectory has at least one wheel")
        self._finite_attributes()
        self._given: Data | Callable[[], Data] = data
        if not callable(data):
            _ = self.data

    @cached_property
    def data(self) -> dict[str, np.ndarray]:
        """All datasets, in the order of the file."""
        given = self._given() if callable(self._given) else self._given
        self._given = {}
        table = layout(self.wheels)
        completed = _scales(self.wheels, given) | dict(given)
        _same_names("dataset", completed, table, {path for path, row in table.items() if row.optional})
        self.data = {path: completed[path] for path in table if path in completed}
        self.validate()
        return self.data

    def __getstate__(self) -> dict[str, Any]:
        return {"attributes": self.attributes, "data": self.data}

    def _finite_attributes(self) -> None:
        for name, kind in ATTRIBUTES.items():
            if kind is float and not math.isfinite(self.attributes.get(name, 0.0)):
                raise ValueError(f"attribute {name} is {self.attributes[name]}: it must be finite")

    def validate(self) -> None:
        """Raise ValueError unless every dataset is as TABLE says, and every number finite."""
        self._finite_attributes()
        sizes: dict[str, int] = {}
        for quantity in self.quantities:
            array = self.data[quantity.path]
            if quantity.is_scale:
                sizes[quantity.path] = np.size(array)
            _check(quantity, array, tuple(map(sizes.__getitem__, quantity.axes)))

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What the datasets are, in the order of the file."""
        return tuple([row for path, row in layout(self.wheels).items() if path in self.data])

    @property
    def time(self) -> NDArray[np.float64]:
        """Output times (T), s."""
        return self.data[TIME]

    @property
    def wheels(self) -> tuple[str, ...]:
        """Names of the wheels, in the order of the scene."""
        return self.attributes["wheels"]

    @property
    def complete(self) -> bool:
        """False when the run stopped before its end: attributes status, stop_time and stop_wheel say why."""
        return self.attributes["status"] == COMPLETE

    def save(self, path: str | PathLike[str], overwrite: bool = False) -> None:
        """Write an HDF5 file, whole or not at all.

        Raises FileExistsError unless it may overwrite, OSError, and ValueError for NaN or inf.
        """
        from omnisim.results import hdf5

        hdf5.write(self, path, overwrite)

    def plot(self, view: str = "story") -> Figure:
        """A picture of `omnisim plot`, by the name of its view: a Figure of matplotlib (extra `plot`).

        Raises ValueError for a view that there is not, and where there is nothing that it could show.
        """
        try:
            from omnisim import plots
        except ModuleNotFoundError as error:
            if str(error.name).partition(".")[0] != "matplotlib":
                raise
            raise ImportError("plots need matplotlib: pip install 'omnisim-engine[plot]'") from None
        if view not in plots.VIEWS:
            raise ValueError(f"no view is called {view!r}; views: {', '.join(plots.VIEWS)}")
        return plots.VIEWS[view](self)

    def view(self, path: str | PathLike[str] | None = None, *, overwrite: bool = False, show: bool = True) -> Path:
        """Write the page of `omnisim view`, the machine moving in 3-D, and show it in the browser; its path.

        path: without one it is a new file in the folder of temporary files. Raises OSError, FileExistsError if it
        exists and may not be overwritten, and ValueError if there are no rows to show.
        """
        from omnisim import viewer

        return viewer.show_page(self, path, overwrite, show)

    def to_pandas(self) -> pandas.DataFrame:
        """A DataFrame by time, a column for each component of each dataset; `attrs` has attributes and units."""
        from omnisim.results import tables

        return tables.data_frame(self)

    def to_xarray(self) -> xarray.DataTree:
        """The tree that xarray opens from the saved file."""
        from omnisim.results import tables

        return tables.data_tree(self)

    def __getitem__(self, path: str) -> np.ndarray:
        name = path.strip("/")
        if name not in self.data:
            raise KeyError(f"no dataset {name!r}{_near(name, self.data)}")
        return self.data[name]

    def __contains__(self, path: str) -> bool:
        return path.strip("/") in self.data

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def _ipython_key_completions_(self) -> list[str]:
        """What a notebook offers after `run["`."""
        return list(self.data)

    def _repr_html_(self) -> str:
        """What a notebook shows."""
        from omnisim.results import report

        return report.as_html(self)

    def __repr__(self) -> str:
        from omnisim.results import report

        return f"<Trajectory {report.in_short(self)}>"


def open_trajectory(path: str | PathLike[str]) -> Trajectory:
    """Read a trajectory file; datasets and attributes this version does not know are left alone.

    Raises TrajectoryError, one line, when the file is missing, a folder, no HDF5 file, no trajectory, of a
    newer format, truncated, damaged or incomplete, and TypeError for what is no path.
    """
    from omnisim.results import hdf5

    return hdf5.read(path_text("open_trajectory", path), Trajectory)


@lru_cache(maxsize=8)
def _users(wheels: tuple[str, ...]) -> tuple[tuple[Quantity, tuple[tuple[str, int], ...]], ...]:
    """The scales but time, each with the datasets along it: path, and which of the axes it is there."""
    table = layout(wheels).values()
    return tuple(
        (scale, tuple((row.path, row.axes.index(scale.path)) for row in table if scale.path in row.axes))
        for scale in table
        if scale.is_scale and scale.path != TIME
    )


def _scales(wheels: tuple[str, ...], data: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The scales that follow from the rest: names of directions, or 0 .. n - 1 with n from the first user."""
    found = {}
    for scale, users in _users(wheels):
        sizes = (np.shape(data[path])[axis] for path, axis in users if path in data and np.ndim(data[path]) > axis)
        size = next(sizes, None if scale.optional else 0)
        if size is not None:
            labels = LABELS.get(scale.path)
            found[scale.path] = np.array(labels) if labels else np.arange(size, dtype=np.int64)
    return found


def _attribute(name: str, value: Any) -> Any:
    kind = ATTRIBUTES[name]
    if type(value) is kind:
        return value
    if isinstance(value, str) != (kind is str):
        raise ValueError(f"attribute {name} is {value!r}: it must be a {kind.__name__}")
    try:
        return kind(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f"attribute {name} is {value!r}: it must be a {kind.__name__}") from error


def _check(quantity: Quantity, array: np.ndarray, shape: tuple[int, ...]) -> None:
    path, dtype = quantity.path, quantity.dtype
    if not isinstance(array, np.ndarray):
        raise ValueError(f"dataset {path} is a {type(array).__name__}: it must be a NumPy array")
    if array.dtype.kind != "U" if dtype == "str" else array.dtype != dtype:
        raise ValueError(f"dataset {path} has type {array.dtype}: it must be {dtype}")
    if array.shape != shape:
        raise ValueError(f"dataset {path} has shape {array.shape}: it must be {shape}, along {quantity.axes}")
    if dtype == "float64" and not math.isfinite(np.vdot(array, array)) and not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"dataset {path} is {array[where]} at index {where}: it must be finite")


def _same_names(
    what: str, given: Mapping[str, Any], known: Mapping[str, Any], optional: Set[str] = frozenset()
) -> None:
    for name in given:
        if name not in known:
            raise ValueError(f"unknown {what} {name}{_near(name, known)}")
    for name in known:
        if name not in given and name not in optional:
            raise ValueError(f"{what} {name} is missing")


def _near(name: str, known: Mapping[str, Any]) -> str:
    """Names that look alike or end in the same word, as the end of a message."""
    ends = [path for path in known if path.endswith("/" + name)]
    near = dict.fromkeys(ends + get_close_matches(name, known, n=5))
    return f"; near: {', '.join(near)}" if near else ""
