"""A trajectory as tables: CSV, Parquet and MATLAB files, pandas and xarray."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO, StringIO
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from omnisim.base.trajectory_file import CHECKSUM, SCENE_CHECKSUM, checksum
from omnisim.results.layout import EVENT_NUMBER, TIME, Quantity, Recorded

if TYPE_CHECKING:
    import pandas
    import xarray

MATLAB_NAME = 63  # characters
MATLAB_KEYWORDS = {
    "break", "case", "catch", "classdef", "continue", "else", "elseif", "end", "for", "function", "global", "if",
    "otherwise", "parfor", "persistent", "return", "spmd", "switch", "try", "while",
}  # fmt: skip


class ExportError(ValueError):
    """A file that cannot be made; the message is one line."""


class Column(NamedTuple):
    """One column of a flat table: `values` has a number or a name for each row."""

    name: str
    units: str
    description: str
    values: np.ndarray


def table(trajectory: Recorded, along: str = TIME) -> list[Column]:
    """Every dataset along `along`, time or events, as columns: one for each component.

    Components are named as their scales have them: body/position.x, wheels/NAME/rollers/center_velocity.3.x; events
    without their folder.
    """
    found = []
    for quantity in trajectory.quantities:
        if quantity.axes[0] == along:
            array = trajectory[quantity.path]
            labels = [trajectory[axis].tolist() for axis in quantity.axes[1:]]
            flat = array.reshape(len(array), math.prod(array.shape[1:]))
            for component, values in zip(product(*labels), flat.T, strict=True):
                name = ".".join([quantity.path.removeprefix("events/"), *map(str, component)])
                found.append(Column(name, quantity.units, quantity.description, values))
    return found


def csv_files(trajectory: Recorded) -> tuple[bytes, bytes]:
    """The tables by time and of events: names, then units as a comment, then rows; numbers to the last bit."""
    return _csv(table(trajectory)), _csv(table(trajectory, EVENT_NUMBER))


def _csv(columns: list[Column]) -> bytes:
    text = StringIO(newline="")
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(column.name for column in columns)
    lines.writerow(["# " + columns[0].units, *(column.units for column in columns[1:])])
    lines.writerows(zip(*(column.values.tolist() for column in columns), strict=True))
    return text.getvalue().encode()


def parquet_files(trajectory: Recorded) -> tuple[bytes, bytes]:
    """The tables by time and of events; attributes as metadata of the schema, units and descriptions of its fields."""
    texts = {name: value if isinstance(value, str) else json.dumps(value)
             for name, value in trajectory.attributes.items()}  # fmt: skip
    return _parquet(table(trajectory), texts), _parquet(table(trajectory, EVENT_NUMBER), texts)


def _parquet(columns: list[Column], attributes: dict[str, str]) -> bytes:
    with extra("parquet"):
        import pyarrow
        from pyarrow import parquet
    arrays = [pyarrow.array(column.values) for column in columns]
    fields = [
        pyarrow.field(column.name, array.type, metadata={"units": column.units, "description": column.description})
        for column, array in zip(columns, arrays, strict=True)
    ]
    image = BytesIO()
    parquet.write_table(pyarrow.table(arrays, pyarrow.schema(fields, attributes)), image)
    return image.getvalue()


def mat_file(trajectory: Recorded) -> tuple[bytes]:
    """Structs as the tree of the HDF5 file: datasets, and `attributes`, and `units` of all of them.

    Series of numbers are columns, names are cells. Wheels stand in the order of attributes.wheels; a name that MATLAB
    does not allow is changed (see `field_names`).
    """
    with extra("mat"):
        from scipy.io import savemat
        from scipy.io.matlab import MatWriteError
    rename = field_names(trajectory.wheels)
    contents: dict[str, Any] = {"attributes": {name: _cells(value) for name, value in trajectory.attributes.items()}}
    for quantity in trajectory.quantities:
        parts = quantity.path.split("/")
        if "wheels" in parts:
            name = parts.index("wheels") + 1
            parts[name] = rename[parts[name]]
        _put(contents, parts, _cells(trajectory[quantity.path]))
        _put(contents, ["units", *parts], quantity.units)
    image = BytesIO()
    try:
        savemat(image, contents, long_field_names=True, oned_as="column")
    except MatWriteError as error:
        raise ExportError(f"a .mat file cannot hold this trajectory: {error}") from None
    return (image.getvalue(),)


def field_names(wheels: tuple[str, ...]) -> dict[str, str]:
    """A legal and unique MATLAB name for each wheel: letters, digits and underscores, and no keyword."""
    found: dict[str, str] = {}
    for wheel in wheels:
        legal = re.sub(r"\W", "_", wheel)[:MATLAB_NAME]
        choices = (f"{legal[: MATLAB_NAME - 4]}_{number}" for number in range(2, 1000))
        while legal in MATLAB_KEYWORDS or legal in found.values():
            legal = next(choices)
        found[wheel] = legal
    return found


def _cells(value: Any) -> Any:
    """Names as objects, which become cells."""
    names = isinstance(value, tuple) or (isinstance(value, np.ndarray) and value.dtype.kind == "U")
    return np.array(value, dtype=object) if names else value


def _put(tree: dict[str, Any], parts: list[str], value: Any) -> None:
    for part in parts[:-1]:
        tree = tree.setdefault(part, {})
    tree[parts[-1]] = value


def data_frame(trajectory: Recorded) -> pandas.DataFrame:
    """The table by time, with time as its index; `attrs` has the attributes, and `units` by column."""
    with extra("pandas"):
        import pandas
    columns = table(trajectory)
    frame = pandas.DataFrame({column.name: column.values for column in columns}).set_index(TIME)
    frame.attrs = {**trajectory.attributes, "units": {column.name: column.units for column in columns}}
    return frame


def data_tree(trajectory: Recorded) -> xarray.DataTree:
    """The tree that xarray opens from the saved file: groups, dimensions, coordinates, attributes."""
    with extra("xarray"):
        import xarray
    variables: dict[str, dict[str, tuple]] = {"": {}}
    for quantity in trajectory.quantities:
        group, _, name = quantity.path.rpartition("/")
        variables.setdefault(group, {})[name] = _variable(quantity, trajectory[quantity.path])
    datasets = {group: xarray.Dataset(found) for group, found in variables.items()}
    datasets["events"] = datasets["events"].set_coords("time")  # as the file says
    wheels = trajectory.wheels
    datasets[""].attrs = trajectory.attributes | {
        "wheels": list(wheels) if len(wheels) > 1 else wheels[0],  # as netCDF
        SCENE_CHECKSUM: checksum(trajectory.attributes["scene"]),
    }
    return xarray.DataTree.from_dict({f"/{group}": dataset for group, dataset in datasets.items()})


def _variable(quantity: Quantity, array: np.ndarray) -> tuple:
    """Dimensions, values and attributes as xarray takes them."""
    dimensions = [axis.rpartition("/")[2] for axis in quantity.axes]
    sums = {CHECKSUM: checksum(*array.tolist())} if quantity.dtype == "str" else {}
    return dimensions, array, {"units": quantity.units, "description": quantity.description} | sums


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Imports in this block are those of the optional extra `name`; without them, ExportError says what to install."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise ExportError(f"{error.name} is not installed: pip install 'omnisim-engine[{name}]'") from None
