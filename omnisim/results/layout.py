"""Every dataset and attribute that a trajectory may hold, in one table: paths, axes, units, meaning."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from omnisim.base.status import EVENT_KINDS

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


TIME, AXIS, PLANE, TANGENT, HUB, MOUNT, PART = "time", "axis", "plane", "tangent", "hub", "mount", "quaternion"
ROLLER, EVENT_NUMBER = "wheels/{wheel}/rollers/roller", "events/event"
LABELS = {
    AXIS: ("x", "y", "z"),
    PLANE: ("x", "y"),
    TANGENT: ("h", "k"),
    HUB: ("h", "k", "n"),
    MOUNT: ("radial", "lateral", "axial"),
    PART: ("w", "x", "y", "z"),
}  # the other two, ROLLER and EVENT_NUMBER, count from 0

BODY = "wheel centre (bare wheel) or chassis origin (vehicle; on the floor while it is kept upright)"
WHEELS, ROLLERS = "wheels/{wheel}", "wheels/{wheel}/rollers"
T, E = (TIME,), (EVENT_NUMBER,)

# Of which quantities a run tells the extremes of each interval between two rows: of the march, not of the rows.
# Those with a sign have a least value, too.
EXTREMES = (
    ("odometry/position_error", "m", "error of the reported position", False),
    ("odometry/yaw_error", "rad", "error of the reported yaw angle", True),
    (f"{WHEELS}/normal_force", "N", "normal force of the floor on the wheel", True),
    (f"{WHEELS}/friction_force", "N", "friction force of the floor on a roller, its length", False),
    (f"{WHEELS}/slip_velocity", "m/s", "slip velocity, its length", False),
    (f"{WHEELS}/drive_torque", "N m", "drive torque on the disk about k", True),
    (f"{WHEELS}/drive_power", "W", "power of the drive torque", True),
    (f"{WHEELS}/voltage", "V", "voltage at the motor", True),
    (f"{WHEELS}/current", "A", "current of the motor", True),
    (f"{WHEELS}/electrical_power", "W", "power that the motor takes from its supply", True),
    (f"{WHEELS}/bearing_radial_force", "N", "force of the axle on the wheel across it, its length", False),
    (f"{WHEELS}/bearing_axial_force", "N", "force of the axle on the wheel along it", True),
    (f"{WHEELS}/bearing_tilting_moment", "N m", "moment of the axle on the wheel across it, its length", False),
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
    Quantity(PART, (PART,), "1", "parts of a quaternion", "str", optional=True),
    Quantity("body/position", (TIME, AXIS), "m", f"position of the {BODY}"),
    Quantity("body/velocity", (TIME, AXIS), "m/s", f"velocity of the {BODY}"),
    Quantity("body/acceleration", (TIME, AXIS), "m/s^2", f"acceleration of the {BODY}"),
    Quantity("body/yaw", T, "rad", "yaw angle, counterclockwise from above, never wrapped"),
    Quantity("body/yaw_rate", T, "rad/s", "yaw rate"),
    Quantity("body/yaw_acceleration", T, "rad/s^2", "yaw acceleration"),
    Quantity("body/orientation", (TIME, PART), "1", "unit quaternion from chassis axes to world axes", optional=True),
    Quantity("body/angular_velocity", (TIME, AXIS), "rad/s", "angular velocity of the chassis", optional=True),
    Quantity("body/servo_torque", (TIME, PLANE), "N m", "torque about chassis x and y that keeps a machine upright",
             optional=True),
    Quantity("odometry/position", (TIME, PLANE), "m", "chassis origin as ideal wheels without slip would report it",
             optional=True),
    Quantity("odometry/yaw", T, "rad", "yaw angle as ideal wheels without slip would report it", optional=True),
    Quantity("odometry/position_error", (TIME, PLANE), "m", "reported less true position, world axes", optional=True),
    Quantity("odometry/yaw_error", T, "rad", "reported less true yaw angle", optional=True),
    Quantity(f"{WHEELS}/spin_angle", T, "rad", "spin angle about k, never wrapped; positive rolls forward"),
    Quantity(f"{WHEELS}/spin_rate", T, "rad/s", "spin rate about k"),
    Quantity(f"{WHEELS}/spin_acceleration", T, "rad/s^2", "spin acceleration about k"),
    Quantity(f"{WHEELS}/drive_torque", T, "N m", "drive torque on the disk about k"),
    Quantity(f"{WHEELS}/drive_power", T, "W", "power of the drive torque"),
    Quantity(f"{WHEELS}/target_rate", T, "rad/s", "spin rate that the drive follows", optional=True),
    Quantity(f"{WHEELS}/voltage", T, "V", "voltage of the motor", optional=True),
    Quantity(f"{WHEELS}/current", T, "A", "current of the motor", optional=True),
    Quantity(f"{WHEELS}/electrical_power", T, "W", "power that the motor takes from its supply; below 0 it gives some",
             optional=True),
    Quantity(f"{WHEELS}/heat", T, "W", "power turned into heat in the windings of the motor", optional=True),
    Quantity(f"{WHEELS}/normal_force", T, "N", "normal force of the floor on the wheel"),
    Quantity(f"{WHEELS}/contact_angle", T, "rad", "azimuth of contact_roller from straight down towards h"),
    Quantity(f"{WHEELS}/contact_roller", T, "1",
             "roller in contact with the floor; of several the one that carries most, -1 in the air", "int64"),
    Quantity(f"{WHEELS}/contact_point", (TIME, AXIS), "m", "where contact_roller touches the floor"),
    Quantity(f"{WHEELS}/slip_velocity", (TIME, TANGENT), "m/s", "velocity of contact_roller at its contact point"),
    Quantity(f"{WHEELS}/friction_force", (TIME, TANGENT), "N", "friction force of the floor on contact_roller"),
    Quantity(f"{WHEELS}/contact_share", T, "1",
             "1, or the share of contact_roller (the one at q = +alpha) while two rollers carry the load"),
    Quantity(f"{WHEELS}/contact_torque", T, "N m", "torque of the floor on contact_roller about the normal"),
    Quantity(f"{WHEELS}/suspension_travel", T, "m", "travel of the hub along chassis z, up", optional=True),
    Quantity(f"{WHEELS}/suspension_rate", T, "m/s", "its rate", optional=True),
    Quantity(f"{WHEELS}/rocker_angle", T, "rad", "by which its rocker is turned about the axis of the chassis",
             optional=True),
    Quantity(f"{WHEELS}/rocker_rate", T, "rad/s", "its rate", optional=True),
    Quantity(f"{WHEELS}/servo_torque", T, "N m", "torque about h that keeps a bare wheel upright", optional=True),
    Quantity(f"{WHEELS}/bearing_force", (TIME, HUB), "N", "force of the axle on the wheel", optional=True),
    Quantity(f"{WHEELS}/bearing_moment", (TIME, HUB), "N m",
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
    Quantity("energy/gravity", T, "J", "energy of all bodies in gravity, if it changes: 0 at the world's origin",
             optional=True),
    Quantity("energy/elastic", T, "J", "energy stored in rubber and springs", optional=True),
    Quantity("energy/contact_loss", T, "J", "energy lost in the damping of rubber since t = 0", optional=True),
    Quantity("energy/damper_loss", T, "J", "energy lost in the dampers of suspensions since t = 0", optional=True),
    Quantity("energy/friction_loss", T, "J", "energy lost to friction since t = 0"),
    Quantity("energy/bearing_loss", T, "J", "energy lost in the rollers' bearings since t = 0"),
    Quantity("energy/rolling_loss", T, "J", "energy lost to rolling resistance since t = 0, if there is some",
             optional=True),
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
    Quantity(EVENT_NUMBER, E, "1", "events in order of time, counted from 0", "int64"),
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


class Recorded(Protocol):
    """What files, tables and reports need of a trajectory: attributes and datasets as the table has them."""

    attributes: dict[str, Any]

    @property
    def data(self) -> dict[str, np.ndarray]: ...

    @property
    def quantities(self) -> tuple[Quantity, ...]: ...

    @property
    def time(self) -> NDArray[np.float64]: ...

    @property
    def wheels(self) -> tuple[str, ...]: ...

    @property
    def complete(self) -> bool: ...

    def validate(self) -> None: ...

    def __getitem__(self, path: str) -> np.ndarray: ...

    def __contains__(self, path: str) -> bool: ...
