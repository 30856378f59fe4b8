"""Views over time: contact, slip, forces, odometry, energy."""

import numpy as np
from matplotlib.figure import Figure

from omnisim.pictures.plots.asked import config_of
from omnisim.pictures.plots.drive import TORQUE
from omnisim.pictures.plots.panels import Bands, Curves, Panel, bands_of_wheels, extremes, of_wheels, over_time, size
from omnisim.pictures.plots.style import PlotError, Runs, view
from omnisim.results.spatial import attitude
from omnisim.results.trajectory import Trajectory


def along(axis: int):
    """One component (T) of vectors (T, n)."""
    return lambda vectors: vectors[:, axis]


def of_body(path: str, value=np.asarray):
    """The curve of a dataset without wheels."""
    return lambda run: {"": value(run[path])}


def works(run: Trajectory) -> dict[str, np.ndarray]:
    """Energies (J) by name, that in gravity from its start on, losses of rubber and dampers together; losses and works
    that there are none of are left out."""
    found = {"kinetic energy": run["energy/kinetic"]}
    if "energy/gravity" in run:
        gravity = run["energy/gravity"]
        found["energy in gravity"] = gravity - gravity[:1]
    for name in ("friction_loss", "bearing_loss", "rolling_loss", "drive_work", "wrench_work", "electrical", "heat"):
        path = f"energy/{name}"
        if path in run and run[path].any():
            found[name.replace("_", " ")] = run[path]
    if is_free(run):
        found["elastic energy"] = run["energy/elastic"]
        found["damping loss"] = run["energy/contact_loss"] + run["energy/damper_loss"]
    return found


def position_errors(run: Trajectory) -> dict[str, np.ndarray]:
    """How far the reported position is off (m), and along which axis."""
    error = run["odometry/position_error"]
    return {"distance": size(error), "along x": error[:, 0], "along y": error[:, 1]}


def position_reach(run: Trajectory) -> Bands:
    """How far the distance reaches between rows."""
    path = "odometry/position_error"
    return {"distance": extremes(run, path)} if f"interval_max/{path}" in run else {}


def yaw_reach(run: Trajectory) -> Bands:
    path = "odometry/yaw_error"
    return {"": extremes(run, path)} if f"interval_max/{path}" in run else {}


def above_ground(run: Trajectory) -> dict[str, np.ndarray]:
    """How high the chassis origin is over its place on level ground, mm."""
    return {"": 1e3 * run["body/position"][:, 2]}


def inclination(run: Trajectory) -> dict[str, np.ndarray]:
    """Roll and pitch, deg."""
    return dict(zip(("roll", "pitch"), np.degrees(attitude(run["body/orientation"])), strict=True))


def rocker_angles(run: Trajectory) -> Curves:
    """By which each rocker is turned, deg, once for both of its wheels; by wheel where the scene cannot be read."""
    config = config_of(run)
    if config is None:
        return of_wheels("rocker_angle", np.degrees)(run)
    return {rocker.name: np.degrees(run[f"wheels/{rocker.wheels[0]}/rocker_angle"]) for rocker in config.axles}


HEIGHT = Panel("height, mm", above_ground)
INCLINATION = Panel("roll, pitch, deg", inclination)
TRAVEL = Panel("travel of springs, mm", of_wheels("suspension_travel", lambda travel: 1e3 * travel))
ROCKER = Panel("angle of rockers, deg", rocker_angles)
SPEED = Panel("speed, m/s", of_body("body/velocity", lambda velocity: size(velocity[:, :2])))
YAW_RATE = Panel("yaw rate, rad/s", of_body("body/yaw_rate"))
NORMAL_FORCE = Panel("normal force, N", of_wheels("normal_force"), bands_of_wheels("normal_force"))
SLIP_SPEED = Panel("slip speed, m/s", of_wheels("slip_velocity", size), bands_of_wheels("slip_velocity"))
FRICTION = Panel("friction, N", of_wheels("friction_force", size), bands_of_wheels("friction_force"))
WORKS = Panel("energy, J", works)
BALANCE = Panel("|balance|, J", of_body("energy/balance", np.abs), log=True)


@view
def contact(runs: Runs) -> Figure:
    """Which roller touches the floor, how far from straight down it stands, what share of the load it has."""
    return over_time(runs, [
        Panel("roller in contact", of_wheels("contact_roller"), steps=True),
        Panel("contact angle, rad", of_wheels("contact_angle")),
        Panel("share of the load", of_wheels("contact_share")),
    ])  # fmt: skip


@view
def ride(runs: Runs) -> Figure:
    """Height, roll and pitch of machines free in space, travel of springs, angles of rockers, normal forces. Raises
    PlotError for a machine that is held upright."""
    for name, run in runs.items():
        if not is_free(run):
            raise PlotError(f"{name}: it is held upright; only machines free in space have a ride")
    carried = [panel for panel in (TRAVEL, ROCKER) if any(panel.curves(run) for run in runs.values())]
    return over_time(runs, [HEIGHT, INCLINATION, *carried, NORMAL_FORCE])


def is_free(run: Trajectory) -> bool:
    """Whether the machine is free in space."""
    return "energy/elastic" in run


@view
def slip(runs: Runs) -> Figure:
    """The velocity of each wheel's roller at its contact point: size, along the heading, along the axle."""
    return over_time(runs, [
        SLIP_SPEED,
        Panel("along heading, m/s", of_wheels("slip_velocity", along(0))),
        Panel("along axle, m/s", of_wheels("slip_velocity", along(1))),
    ])  # fmt: skip


@view
def forces(runs: Runs) -> Figure:
    """What the floor does to each wheel: normal force, friction and its components; the torque of its drive."""
    return over_time(runs, [
        NORMAL_FORCE,
        FRICTION,
        Panel("friction along\nheading, N", of_wheels("friction_force", along(0))),
        Panel("friction along\naxle, N", of_wheels("friction_force", along(1))),
        TORQUE,
    ])  # fmt: skip


@view
def odometry(runs: Runs) -> Figure:
    """How far the pose that ideal wheels would report is off. Raises PlotError for a run without odometry."""
    for name, run in runs.items():
        if "odometry/yaw_error" not in run:
            raise PlotError(f"{name}: no odometry; only machines have it whose spin rates tell their motion")
    return over_time(runs, [
        Panel("error of position, m", position_errors, position_reach),
        Panel("error of yaw, rad", of_body("odometry/yaw_error"), yaw_reach),
    ])  # fmt: skip


@view
def energy(runs: Runs) -> Figure:
    """Kinetic energy, losses and works, and what is unaccounted for."""
    return over_time(runs, [WORKS, BALANCE])
