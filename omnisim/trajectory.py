"""What a run returns: attributes and datasets, checked against one table of all that a trajectory holds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from omnisim.status import EVENT_KINDS

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

FORMAT = "omnisim-trajectory"
FORMAT_VERSION = 1
COMPLETE = "complete"

# Root attributes and their types; Trajectory itself fills the first two. Optional are those of runs whose step was
# picked for an error, and the formulation, which older files do not name.
ATTRIBUTES = {
    "format": str, "format_version": int, "omnisim_version": str, "title": str, "scene": str, "wheels": tuple,
    "model": str, "tracking": str, "method": str, "step": float, "steps": int, "rhs_evaluations": int,
    "wall_time": float, "status": str, "stop_time": float, "stop_wheel": str,
    "error_target": float, "error_estimate": float, "formulation": str,
}  # fmt: skip
OPTIONAL_ATTRIBUTES = frozenset(("error_target", "error_estimate", "formulation"))


@dataclass(frozen=True)
class Quantity:
    """One dataset. `axes` are the paths of its dimension scales; a scale has itself as its only axis."""

    path: str
    axes: tuple[str, ...]
    units: str
    description: str
    dtype: str = "float64"  # or int64, str
    optional: bool = False  # only of scenes that have it

    @cached_property
    def is_scale(self) -> bool:
        return self.axes == (self.path,)

    def of_wheel(self, wheel: str) -> Quantity:
        """This row with {wheel} filled in, in its path and its axes."""
        axes = tuple(axis.format(wheel=wheel) for axis in self.axes)
        return replace(self, path=self.path.format(wheel=wheel), axes=axes)


TIME, AXIS, PLANE, TANGENT, HUB, MOUNT = "time", "axis", "plane", "tangent", "hub", "mount"
ROLLER, EVENT = "wheels/{wheel}/rollers/roller", "events/event"
LABELS = {
    AXIS: ("x", "y", "z"),
    PLANE: ("x", "y"),
    TANGENT: ("h", "k"),
    HUB: ("h", "k", "n"),
    MOUNT: ("radial", "lateral", "axial"),
}  # the other two, ROLLER and EVENT, count from 0

BODY = "wheel centre (bare wheel) or chassis origin on the floor (vehicle)"
WHEEL, ROLLERS = "wheels/{wheel}", "wheels/{wheel}/rollers"
T, E = (TIME,), (EVENT,)

# Of which quantities a run tells the extremes of each interval between two rows: of the march, not of the rows.
# Those with a sign have a least value, too.
EXTREMES = (
    ("odometry/position_error", "m", "error of the reported position", False),
    ("odometry/yaw_error", "rad", "error of the reported yaw angle", True),
    (f"{WHEEL}/normal_force", "N", "normal force of the floor on the wheel", True),
    (f"{WHEEL}/friction_force", "N", "friction force of the floor on a roller, its length", False),
    (f"{WHEEL}/slip_velocity", "m/s", "slip velocity, its length", False),
    (f"{WHEEL}/drive_torque", "N m", "drive torque on the disk about k", True),
    (f"{WHEEL}/drive_power", "W", "power of the drive torque", True),
    (f"{WHEEL}/voltage", "V", "voltage at the motor", True),
    (f"{WHEEL}/current", "A", "current of the motor", True),
    (f"{WHEEL}/electrical_power", "W", "power that the motor takes from its supply", True),
    (f"{WHEEL}/bearing_radial_force", "N", "force of the axle on the wheel across it, its length", False),
    (f"{WHEEL}/bearing_axial_force", "N", "force of the axle on the wheel along it", True),
    (f"{WHEEL}/bearing_tilting_moment", "N m", "moment of the axle on the wheel across it, its length", False),
    (f"{ROLLERS}/bearing_radial_force", "N", "force of its axle on the roller across it, its length", False),
    (f"{ROLLERS}/bearing_axial_force", "N", "force of its axle on the roller along it", True),
    (f"{ROLLERS}/bearing_tilting_moment", "N m", "moment of its axle on the roller across it, its length", False),
)


def _extremes() -> Iterator[Quantity]:
    """The rows of the table that EXTREMES makes: interval_max/PATH, and interval_min/PATH of those with a sign."""
    since = "since the row before"
    for group, word in (("interval_max", "largest"), ("interval_min", "least")):
        scale = f"{group}/{ROLLER}"
        yield Quantity(scale, (scale,), "1", "rollers of this wheel, counted from 0", "int64", optional=True)
        for path, units, description, signed in EXTREMES:
            if signed or group == "interval_max":
                axes = (TIME, scale) if path.startswith(ROLLERS) else T
                yield Quantity(f"{group}/{path}", axes, units, f"{word} {description}, {since}", optional=True)


# Every dataset, in the order of the file. A scale comes before the datasets that use it.
TABLE = (
    Quantity(TIME, T, "s", "output times: row i is i * output_interval"),
    Quantity(AXIS, (AXIS,), "1", "world axes: x and y on the floor, z normal to it, up", "str"),
    Quantity(PLANE, (PLANE,), "1", "directions in the plane of the floor", "str", optional=True),
    Quantity(TANGENT, (TANGENT,), "1", "directions along the floor: h heading, k axle (left)", "str"),
    Quantity(HUB, (HUB,), "1", "directions at a wheel's axle: h heading, k left, n up", "str", optional=True),
    Quantity(MOUNT, (MOUNT,), "1", "directions of a roller's axle: radial from the wheel centre, axial along it", "str",
             optional=True),
    Quantity("body/position", (TIME, AXIS), "m", f"position of the {BODY}"),
    Quantity("body/velocity", (TIME, AXIS), "m/s", f"velocity of the {BODY}"),
    Quantity("body/acceleration", (TIME, AXIS), "m/s^2", f"acceleration of the {BODY}"),
    Quantity("body/yaw", T, "rad", "yaw angle, counterclockwise from above, never wrapped"),
    Quantity("body/yaw_rate", T, "rad/s", "yaw rate"),
    Quantity("body/yaw_acceleration", T, "rad/s^2", "yaw acceleration"),
    Quantity("body/servo_torque", (TIME, PLANE), "N m", "torque about chassis x and y that keeps a machine upright",
             optional=True),
    Quantity("odometry/position", (TIME, PLANE), "m", "chassis origin as ideal wheels without slip would report it",
             optional=True),
    Quantity("odometry/yaw", T, "rad", "yaw angle as ideal wheels without slip would report it", optional=True),
    Quantity("odometry/position_error", (TIME, PLANE), "m", "reported less true position, world axes", optional=True),
    Quantity("odometry/yaw_error", T, "rad", "reported less true yaw angle", optional=True),
    Quantity(f"{WHEEL}/spin_angle", T, "rad", "spin angle about k, never wrapped; positive rolls forward"),
    Quantity(f"{WHEEL}/spin_rate", T, "rad/s", "spin rate about k"),
    Quantity(f"{WHEEL}/spin_acceleration", T, "rad/s^2", "spin acceleration about k"),
    Quantity(f"{WHEEL}/drive_torque", T, "N m", "drive torque on the disk about k"),
    Quantity(f"{WHEEL}/drive_power", T, "W", "power of the drive torque"),
    Quantity(f"{WHEEL}/target_rate", T, "rad/s", "spin rate that the drive follows", optional=True),
    Quantity(f"{WHEEL}/voltage", T, "V", "voltage of the motor", optional=True),
    Quantity(f"{WHEEL}/current", T, "A", "current of the motor", optional=True),
    Quantity(f"{WHEEL}/electrical_power", T, "W", "power that the motor takes from its supply; below 0 it gives some",
             optional=True),
    Quantity(f"{WHEEL}/heat", T, "W", "power turned into heat in the windings of the motor", optional=True),
    Quantity(f"{WHEEL}/normal_force", T, "N", "normal force of the floor on the wheel"),
    Quantity(f"{WHEEL}/contact_angle", T, "rad", "azimuth of contact_roller from straight down towards h"),
    Quantity(f"{WHEEL}/contact_roller", T, "1", "roller in contact with the floor", "int64"),
    Quantity(f"{WHEEL}/contact_point", (TIME, AXIS), "m", "where contact_roller touches the floor"),
    Quantity(f"{WHEEL}/slip_velocity", (TIME, TANGENT), "m/s", "velocity of contact_roller at its contact point"),
    Quantity(f"{WHEEL}/friction_force", (TIME, TANGENT), "N", "friction force of the floor on contact_roller"),
    Quantity(f"{WHEEL}/contact_share", T, "1",
             "1, or the share of contact_roller (the one at q = +alpha) while two rollers carry the load"),
    Quantity(f"{WHEEL}/contact_torque", T, "N m", "torque of the floor on contact_roller about the normal"),
    Quantity(f"{WHEEL}/servo_torque", T, "N m", "torque about h that keeps a bare wheel upright", optional=True),
    Quantity(f"{WHEEL}/bearing_force", (TIME, HUB), "N", "force of the axle on the wheel", optional=True),
    Quantity(f"{WHEEL}/bearing_moment", (TIME, HUB), "N m",
             "moment of the axle on the wheel about its centre; along k that of drive and rotor", optional=True),
    Quantity(ROLLER, (ROLLER,), "1", "rollers of this wheel, counted from 0", "int64"),
    Quantity(f"{ROLLERS}/axial_rate", (TIME, ROLLER), "rad/s", "absolute angular velocity about the axis"),
    Quantity(f"{ROLLERS}/joint_rate", (TIME, ROLLER), "rad/s", "angular velocity relative to the wheel"),
    Quantity(f"{ROLLERS}/center_position", (TIME, ROLLER, AXIS), "m", "position of the centre"),
    Quantity(f"{ROLLERS}/center_velocity", (TIME, ROLLER, AXIS), "m/s", "velocity of the centre"),
    Quantity(f"{ROLLERS}/center_acceleration", (TIME, ROLLER, AXIS), "m/s^2", "acceleration of the centre"),
    Quantity(f"{ROLLERS}/bearing_force", (TIME, ROLLER, MOUNT), "N", "force of its axle on the roller", optional=True),
    Quantity(f"{ROLLERS}/bearing_moment", (TIME, ROLLER, MOUNT), "N m",
             "moment of its axle on the roller about its centre", optional=True),
    Quantity("constraints/position", T, "1", "largest residual of a joint or of the floor, m or rad", optional=True),
    Quantity("constraints/velocity", T, "1", "largest rate of such a residual, m/s or rad/s", optional=True),
    Quantity("constraints/position_drift", T, "1",
             "largest distance by which any step so far took a body from its joints, before it was put back, m or rad",
             optional=True),
    Quantity("constraints/velocity_drift", T, "1", "the same of velocities, m/s or rad/s", optional=True),
    *_extremes(),
    Quantity("energy/kinetic", T, "J", "kinetic energy of all bodies"),
    Quantity("energy/gravity", T, "J", "energy of all bodies in gravity, on an inclined floor: 0 at the world's origin",
             optional=True),
    Quantity("energy/friction_loss", T, "J", "energy lost to friction since t = 0"),
    Quantity("energy/bearing_loss", T, "J", "energy lost in the rollers' bearings since t = 0"),
    Quantity("energy/drive_work", T, "J", "work of the drives since t = 0"),
    Quantity("energy/wrench_work", T, "J", "work of the external wrench since t = 0"),
    Quantity("energy/electrical", T, "J", "energy that motors have taken from their supply since t = 0", optional=True),
    Quantity("energy/heat", T, "J", "of it, heat in their windings", optional=True),
    Quantity("energy/motor_loss", T, "J", "of it, lost to the friction of the motors", optional=True),
    Quantity("energy/motor_work", T, "J", "of it, work at the wheels: the part of drive_work that motors do",
             optional=True),
    Quantity("energy/magnetic", T, "J", "of it, stored in the inductance of the motors", optional=True),
    Quantity("energy/balance", T, "J",
             "kinetic + gravity - initial + losses - works, the numerical error; with motors that of theirs too, "
             "heat + motor_loss + motor_work + magnetic - electrical"),
    Quantity(EVENT, E, "1", "events in order of time, counted from 0", "int64"),
    Quantity("events/time", E, "s", "time of the event"),
    Quantity("events/kind", E, "1", ", ".join(EVENT_KINDS), "str"),
    Quantity("events/wheel", E, "1", "name of the wheel, empty where not meant", "str"),
    Quantity("events/roller_from", E, "1", "roller that had the contact, -1 where not meant", "int64"),
    Quantity("events/roller_to", E, "1", "roller that takes the contact, -1 where not meant", "int64"),
)  # fmt: skip


@lru_cache(maxsize=8)
def layout(wheels: tuple[str, ...]) -> Mapping[str, Quantity]:
    """Every dataset that a machine with these wheels may have, by path, in the order of the file."""
    rows = (row.of_wheel(wheel) for row in TABLE for wheel in wheels)
    return MappingProxyType({row.path: row for row in rows})


class Trajectory:
    """The motion of one run: T rows at equal intervals, N_r rollers per wheel, E events.

        run = omnisim.simulate("youbot")                 or omnisim.open_trajectory("run.h5")
        run["body/position"]                             (T, 3), m; `for path in run` tells what there is
        run.plot("slip");  run.save("run.h5")

    attributes  root attributes of the file by name (ATTRIBUTES has the types); `format` and `format_version`
                are filled in
    data        arrays by path in the file, no leading slash (TABLE has axes, units and meaning); the scales
                axis, tangent, rollers/roller and events/event follow from the rest and may be left out

    Raises ValueError, naming the attribute or dataset, when one is unknown, missing, of the wrong type or
    shape, or not finite.
    """

    def __init__(self, attributes: Mapping[str, Any], data: Mapping[str, np.ndarray]):
        given = {**attributes, "format": FORMAT, "format_version": FORMAT_VERSION}
        _same_names("attribute", given, ATTRIBUTES, OPTIONAL_ATTRIBUTES)
        self.attributes: dict[str, Any] = {name: _attribute(name, given[name]) for name in ATTRIBUTES if name in given}
        if not self.wheels:
            raise ValueError("attribute wheels: a trajectory has at least one wheel")
        table = layout(self.wheels)
        completed = _scales(self.wheels, data) | dict(data)
        _same_names("dataset", completed, table, {path for path, row in table.items() if row.optional})
        self.data: dict[str, np.ndarray] = {path: completed[path] for path in table if path in completed}
        self.validate()

    def validate(self) -> None:
        """Raise ValueError unless every dataset is as TABLE says, and every number finite."""
        for name, kind in ATTRIBUTES.items():
            if kind is float and not math.isfinite(self.attributes.get(name, 0.0)):
                raise ValueError(f"attribute {name} is {self.attributes[name]}: it must be finite")
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
        from omnisim import storage

        storage.write(self, path, overwrite)

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
        from omnisim import export

        return export.data_frame(self)

    def to_xarray(self) -> xarray.DataTree:
        """The tree that xarray opens from the saved file."""
        from omnisim import export

        return export.data_tree(self)

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
        from omnisim import report

        return report.as_html(self)

    def __repr__(self) -> str:
        a, rows, events = self.attributes, len(self.time), len(self["events/time"])
        until = f" to {self.time[-1]:g} s" if rows else ""
        return (f"<Trajectory {a['title']!r}: {rows} rows{until}, wheels {', '.join(self.wheels)}, "
                f"{events} events, {a['status']}>")  # fmt: skip


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
