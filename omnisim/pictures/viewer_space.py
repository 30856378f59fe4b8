"""What the page of a trajectory shows of a machine free in space beside the rest: its pose, springs, and the ground."""

import math
from typing import Any

import numpy as np

from omnisim.dynamics.ground import floor_of_scene
from omnisim.pictures import ground as uneven
from omnisim.results.spatial import attitude
from omnisim.results.trajectory import Trajectory
from omnisim.scene.rollers import drawn
from omnisim.scene.schema import Config
from omnisim.scene.wheel_schema import WheelType

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0)}
POINTS = 17  # of a profile: the page leaves out every other one, or three of four, where nobody sees it
ABOVE = 2e-3  # m, of the path over the ground
BODY = {"body/orientation": "float64", "body/angular_velocity": "float32"}
WHEEL = dict.fromkeys(
    ("suspension_travel", "suspension_rate", "rocker_angle", "rocker_rate", "contact_point"), "float32"
)


def shape_of_type(kind: WheelType) -> dict[str, Any]:
    """A type of wheels, its rows and the profile of its rollers as they are."""
    u, r = drawn(kind, POINTS)
    return {
        "radius": kind.radius,
        "rollerDistance": kind.roller_distance,
        "rollers": kind.rollers,
        "rows": [{"offset": row.offset, "phase": math.radians(row.phase_deg)} for row in kind.rings],
        "profile": np.column_stack([u, r]).tolist(),
    }


def motion_in_space(trajectory: Trajectory, config: Config, rows: np.ndarray) -> dict[str, np.ndarray]:
    """Datasets of BODY and WHEEL in these rows; roll and pitch, rad; the height of the path, m; normals of uneven
    ground at the contact points."""
    arrays = {path: trajectory[path][rows].astype(dtype) for path, dtype in BODY.items()}
    for wheel in trajectory.wheels:
        paths = {f"wheels/{wheel}/{name}": dtype for name, dtype in WHEEL.items()}
        arrays |= {path: trajectory[path][rows].astype(kind) for path, kind in paths.items() if path in trajectory}
    angles = attitude(trajectory["body/orientation"][rows])
    arrays |= {f"body/{name}": angle.astype(np.float32) for name, angle in zip(("roll", "pitch"), angles, strict=True)}
    floor = floor_of_scene(config)
    if floor is not None:
        x, y, _ = trajectory["body/position"][rows].T
        arrays["trace_height"] = (uneven.heights(floor, x, y) + ABOVE).astype(np.float32)
        for wheel in trajectory.wheels:
            x, y, _ = trajectory[f"wheels/{wheel}/contact_point"][rows].T
            arrays[f"wheels/{wheel}/contact_normal"] = uneven.normals(floor, x, y).astype(np.float32)
    return arrays


def up(config: Config) -> list[float]:
    """Against gravity, in the floor's axes."""
    slope, uphill = math.radians(config.floor.slope_deg), math.radians(config.floor.uphill_deg)
    return [math.sin(slope) * math.cos(uphill), math.sin(slope) * math.sin(uphill), math.cos(slope)]


def ground(trajectory: Trajectory, config: Config) -> np.ndarray | None:
    """Points (A, B, 3) on uneven ground, m; None of a plane."""
    size = max(math.hypot(*wheel.position) + 2.0 * config.type_of(wheel).radius for wheel in config.wheels)
    return uneven.mesh(config, trajectory["body/position"][:, :2], size)
