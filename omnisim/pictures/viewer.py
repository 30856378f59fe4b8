"""A trajectory as one HTML page that needs nothing else: the machine in 3-D, its motion, the code that shows both.

    scene -> machine (constants) \\
                                  > page.html with style, modules and data inside
    datasets -> motion (arrays)  /

The modules of viewer_page/ stand in an import map of data URLs, so they import each other by name, from a file too.
"""

import base64
import html
import json
import math
import tempfile
import webbrowser
from errno import EEXIST
from importlib.resources import files
from os import PathLike
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from omnisim.base.arguments import path_text
from omnisim.base.files import write_whole
from omnisim.base.status import EVENT_KINDS
from omnisim.pictures.viewer_space import AXES, ground, motion_in_space, shape_of_type, up
from omnisim.results.commanded import target_rates
from omnisim.results.rollers import joint_angles
from omnisim.results.trajectory import Trajectory
from omnisim.scene.ground_schema import Rocker
from omnisim.scene.scene import parse
from omnisim.scene.schema import Config, Wheel

ROWS_PER_SECOND = 60.0  # more than a screen shows; the page interpolates with the rates
MOST_ROWS = 20_000  # of long runs: about 10 MB on four wheels of eighteen rollers
ROUNDING = 1e-9  # of a row
MODULES = (
    "motion", "wheels", "carriers", "chassis", "machine", "arrows", "shadow", "ground", "quality", "stage",
    "quantities", "timebar", "chart", "main",
)  # fmt: skip

# What the page gets, by path in the file. Positions and angles grow with the run, so they keep all their digits.
BODY = {"time": "float64", "body/position": "float64", "body/yaw": "float64", "body/velocity": "float32",
        "body/yaw_rate": "float32", "energy/balance": "float32"}  # fmt: skip
WHEEL = {"spin_angle": "float64", "spin_rate": "float32", "normal_force": "float32", "slip_velocity": "float32",
         "friction_force": "float32", "drive_torque": "float32", "drive_power": "float32",
         "contact_roller": "int32"}  # fmt: skip
# Those that not every file has, all float32; and of which it has the extremes between rows.
BODY_MORE = ("odometry/position_error", "odometry/yaw_error")
WHEEL_MORE = ("voltage", "current", "electrical_power")
WHEEL_EXTREMES = ("normal_force", "friction_force", "slip_velocity", "drive_torque", "drive_power")


class NothingToShow(ValueError):
    """A trajectory without rows."""


def show_page(trajectory: Trajectory, path: str | PathLike[str] | None, overwrite: bool, show: bool) -> Path:
    """Write the page, without a path to a new file among the temporary ones, and show it if wanted; its path."""
    text = page(trajectory)
    if path is None:
        path = Path(tempfile.mkdtemp(prefix="omnisim-")) / "view.html"
        overwrite = True
    path = Path(path_text("view", path))
    if path.exists() and not overwrite:
        raise FileExistsError(EEXIST, "exists already; overwrite=True replaces it", str(path))
    write_whole({path: text.encode()}, overwrite)
    if show:
        webbrowser.open(path.resolve().as_uri())
    return path


def page(trajectory: Trajectory) -> str:
    """The page, a whole HTML document. Raises NothingToShow, and SceneError if the scene in it cannot be read."""
    if not len(trajectory.time):
        raise NothingToShow("no rows: there is nothing to show")
    config = parse(trajectory.attributes["scene"], "scene of the file").config
    moved = motion(trajectory) | targets(trajectory, config)
    data = {
        "title": trajectory.attributes["title"],
        "status": trajectory.attributes["status"],
        "machine": machine(config),
        "events": events(trajectory),
    }
    if config.upright == "free":
        moved |= motion_in_space(trajectory, config, kept_rows(trajectory.time))
        found = ground(trajectory, config)
        data |= {"up": up(config)} | ({} if found is None else {"ground": encoded(found.astype(np.float32))})
    data["motion"] = {path: encoded(array) for path, array in moved.items()}
    imports = {"vendor": _module("vendor/vendor.min")} | {f"omnisim/{name}": _module(name) for name in MODULES}
    return Template(_text("page.html")).substitute(
        title=html.escape(trajectory.attributes["title"] or "omnisim"),
        floor=_floor(config),
        style=_text("vendor/uPlot.min.css") + _text("style.css"),
        imports=_json({"imports": imports}),
        data=_json(data),
        licenses=_text("vendor/LICENSES.txt").replace("--", "=="),  # "--" ends a comment
    )


def machine(config: Config) -> dict[str, Any]:
    """Types of wheels and the wheels, in SI units and radians; whether there is a chassis, and whether it is free in
    space."""
    return {
        "types": {name: shape_of_type(kind) for name, kind in config.wheel_types.items()},
        "wheels": [_wheel(config, wheel) for wheel in config.wheels],
        "chassis": config.chassis is not None,
        "free": config.upright == "free",
    }


def _wheel(config: Config, wheel: Wheel) -> dict[str, Any]:
    psi = math.radians(config.type_of(wheel).roller_angle_deg)
    rocker = config.rocker_of(wheel)
    return {
        **({} if rocker is None else {"rocker": _rocker(rocker)}),
        "name": wheel.name,
        "type": wheel.type,
        "position": wheel.position,
        "heading": math.radians(wheel.heading_deg),
        "psi": -psi if wheel.mirrored else psi,
        "phase": math.radians(wheel.phase_deg),
    }


def _rocker(rocker: Rocker) -> dict[str, Any]:
    return {"name": rocker.name, "axis": AXES[rocker.about], "point": rocker.point}


def _floor(config: Config) -> str:
    """A line on the floor where it slopes: the page shows it level, as its axes are, but for machines free in space."""
    floor = config.floor
    if not floor.slope_deg:
        return ""
    return f"\n  <p>the floor rises by {floor.slope_deg:g}&deg; towards {floor.uphill_deg:g}&deg; from its x axis</p>"


def motion(trajectory: Trajectory) -> dict[str, np.ndarray]:
    """The datasets of BODY and WHEEL and those that there are of the others, thinned; extremes; and the angle of each
    roller relative to its wheel (K, N_r), rad."""
    rows = kept_rows(trajectory.time)
    arrays = {path: trajectory[path][rows].astype(dtype) for path, dtype in BODY.items()} | extremes(trajectory, rows)
    more = [*BODY_MORE, *(f"wheels/{wheel}/{name}" for wheel in trajectory.wheels for name in WHEEL_MORE)]
    arrays |= {path: trajectory[path][rows].astype(np.float32) for path in more if path in trajectory}
    for wheel in trajectory.wheels:
        path = f"wheels/{wheel}"
        arrays |= {f"{path}/{name}": trajectory[f"{path}/{name}"][rows].astype(kind) for name, kind in WHEEL.items()}
        arrays[f"{path}/rollers/joint_angle"] = joint_angles(trajectory, wheel)[rows].astype(np.float32)
    return arrays


def extremes(trajectory: Trajectory, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Largest and least values (K,) since the row before of those that are kept, where the file has them."""
    paths = [*BODY_MORE, *(f"wheels/{wheel}/{name}" for wheel in trajectory.wheels for name in WHEEL_EXTREMES)]
    starts = np.append(0, rows[:-1] + 1)  # of the rows up to each one kept
    found = {}
    for group, extreme in (("interval_max", np.maximum), ("interval_min", np.minimum)):
        for path in (f"{group}/{path}" for path in paths):
            if path in trajectory:
                found[path] = extreme.reduceat(trajectory[path], starts).astype(np.float32)
    return found


def targets(trajectory: Trajectory, config: Config) -> dict[str, np.ndarray]:
    """Target spin rates (K,), rad/s, of the wheels that have one."""
    rows = kept_rows(trajectory.time)
    found = target_rates(trajectory, config)
    return {f"wheels/{wheel}/target_rate": rate[rows].astype(np.float32) for wheel, rate in found.items()}


def kept_rows(time: np.ndarray) -> np.ndarray:
    """Indices (K) of every n-th row and of the last: at most about ROWS_PER_SECOND, and MOST_ROWS."""
    duration = float(time[-1] - time[0])
    wanted = min(ROWS_PER_SECOND * duration, MOST_ROWS)
    stride = max(1, math.ceil((len(time) - 1) / wanted - ROUNDING)) if wanted > 0.0 else 1
    return np.unique(np.append(np.arange(0, len(time), stride), len(time) - 1))


def events(trajectory: Trajectory) -> dict[str, list]:
    """Columns of equal length; a kind is its place in `kinds`."""
    columns = {name: trajectory[f"events/{name}"].tolist() for name in ("time", "wheel", "roller_from", "roller_to")}
    kinds = [EVENT_KINDS.index(kind) for kind in trajectory["events/kind"].tolist()]
    return {"kinds": list(EVENT_KINDS), "kind": kinds, **columns}


def encoded(array: np.ndarray) -> dict[str, Any]:
    """An array as little-endian bytes in base64, with its type and its shape."""
    little = np.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    return {"dtype": array.dtype.name, "shape": array.shape, "base64": base64.b64encode(little.tobytes()).decode()}


def _text(name: str) -> str:
    return files("omnisim.pictures").joinpath("viewer_page", name).read_text(encoding="utf-8")


def _module(name: str) -> str:
    return "data:text/javascript;base64," + base64.b64encode(_text(f"{name}.js").encode()).decode()


def _json(value: Any) -> str:
    """JSON that no text in it can end the script element of."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
