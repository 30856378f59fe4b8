"""The state at t = 0, and the memory of a march."""

import math
from typing import NamedTuple

import numpy as np

from omnisim.base.blocks import cleared
from omnisim.base.keeping import Ask, alone, kept
from omnisim.base.methods import EXPLICIT, METHODS, Method
from omnisim.base.records import Record, recorded, records, single
from omnisim.dynamics.packing import machine_kind, shared_of, types_of
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.records import SPATIAL_MODE, SPATIAL_MONITORS
from omnisim.dynamics.spatial.swings import fastest_swing
from omnisim.dynamics.state import CLOCK, EXTREME, MODE, MONITORS, YAW, Newton, Recording, Run, places_in
from omnisim.march.slip_bounds import alignment, ending, stopping_alignment
from omnisim.march.spatial_start import pose_at_start, state_in_space
from omnisim.march.stiffness import resolve
from omnisim.march.substeps import fineness
from omnisim.scene.schema import Config, Time

COARSE_STEP = 1e-2  # s: of an upright machine, and of methods that are there for their accuracy


def begin(config: Config, parameters: Parameters, ask: Ask[Config] = alone) -> Run:
    """A Run at t = 0; the march itself finds the rollers in contact. ask: who tells what follows from the scene."""
    choice = resolve(config, parameters)
    if parameters.space is not None:
        y, rates = state_in_space(config, parameters, pose_at_start(config, parameters))
    else:
        y, rates = initial_state(config, parameters, ask)
    count = len(parameters.wheels)
    own, seen = (MODE, MONITORS) if parameters.space is None else (SPATIAL_MODE, SPATIAL_MONITORS)
    mode, monitors, monitors_end = cleared((own, (count,)), (seen, (count,)), (seen, (count,)))
    method = METHODS[config.solver.method]
    return Run(
        y=y,
        trial=np.empty_like(y),
        carry=np.zeros_like(y),
        increment=np.zeros_like(y),
        slopes=np.zeros((method.tableau.stages + 1, len(y))),
        rates=rates,
        mode=mode,
        monitors=monitors,
        monitors_end=monitors_end,
        clock=clock_at_start(config.time, method, choice, parameters),
        newton=newton_workspace(parameters, len(y)) if choice != EXPLICIT else None,
    )


def clock_at_start(time: Time, method: Method, choice: int, parameters: Parameters) -> Record:
    """The record CLOCK at t = 0."""
    clock = single(CLOCK, bytearray(clock_of(time, method, choice)))
    part = min(1.0, float(clock["dt"]) / coarse_step(parameters, choice))
    smooth, layered = parameters.workspace.resting is None, parameters.machine.slip_layer > 0.0
    clock["fineness"] = fineness(part, choice, method.tableau, smooth, layered)
    clock["aligned"] = alignment(part, choice, method.tableau.order)
    clock["ended"] = ending(part, method.tableau)
    clock["stopping"] = stopping_alignment(part, choice, method.tableau.order)
    return clock


@kept
def clock_of(time: Time, method: Method, choice: int) -> bytes:
    """The same without what depends on the machine."""
    steps_per_row = time.steps_per_output
    steps, dt = time.outputs * steps_per_row, time.output_interval / steps_per_row
    begun = {
        "steps": steps,
        "steps_per_row": steps_per_row,
        "goal": steps,
        "wheel": -1,
        "choice": choice,
        "dt": dt,
        "reach": dt,
        "stability_limit": method.tableau.stability_limit,
    }
    return records(CLOCK, [dict.fromkeys(CLOCK.names or (), 0) | begun]).tobytes()


def coarse_step(parameters: Parameters, choice: int) -> float:
    """A grid step from which on sub-steps of slip are as coarse as is safe, s: of explicit ones in space one in which
    the machine swings by 1 rad on its rubber, as they err by powers of that."""
    if parameters.space is None or choice != EXPLICIT:
        return COARSE_STEP
    return min(COARSE_STEP, 1.0 / fastest_swing(parameters))


def newton_workspace(parameters: Parameters, states: int) -> Newton:
    """Workspace for implicit steps: forces depend on yaw, spin angles and all rates; of a machine free in space on all
    of its positions but x and y, and on uneven ground on these."""
    at = places_in(parameters)
    active = np.arange(0 if parameters.space is not None and parameters.space.body.uneven else YAW, at.friction_loss)
    count = len(active)
    return Newton(
        active=active,
        busy=np.zeros_like(active),
        stages=np.zeros((9, states)),
        real=np.zeros((2 * count + 1, count)),
        complex=np.zeros((count + 1, count), complex),
        pivots=np.zeros((2, count), np.int64),
        sought=np.zeros(len(parameters.wheels), np.bool_),
    )


def blank_rows(run: Run, count: int, bearing_loads: bool = False, odometry: bool = False) -> Recording:
    """Space for `count` rows of a run; of bearing loads and of the odometry's error if asked for."""
    wheels, rollers = run.rates.shape
    return Recording(
        y=np.empty((count, len(run.y))),
        rates=np.empty((count, wheels, rollers)),
        mode=unwritten(run.mode.dtype, count, wheels),
        piece=np.empty(count, np.uint32),
        extremes=unwritten(EXTREME, count, wheels),
        bearing_extremes=np.empty((count * bearing_loads, wheels, 4, rollers + 1)),
        odometry_extremes=np.empty((count * odometry, 3)),
    )


def unwritten(dtype: np.dtype, *shape: int) -> np.ndarray:
    """Space for records: to clear it takes long. Each is an np.record; nobody reads a field of all of them by its name,
    so that they need be no recarray."""
    return np.empty(shape, recorded(dtype))


def initial_state(config: Config, parameters: Parameters, ask: Ask[Config] = alone) -> tuple[np.ndarray, np.ndarray]:
    """State y (n,) without the rates of the rollers in contact, and rates (W, N) of all rollers, rad/s."""
    machine = parameters.machine
    wheels = np.asarray(parameters.wheels)
    at = ask(machine_kind, config)["places"]
    count, _, rollers = parameters.sector.shape
    states = at.drift + 2 if parameters.workspace.articulated is not None else at.bodies
    y = np.zeros(states)
    yaw = math.radians(config.initial.yaw_deg)
    yaw_rate = config.initial.yaw_rate
    velocity, position = config.initial.velocity, config.initial.position
    cos = math.cos(yaw)
    sin = math.sin(yaw)
    x, y_centre = machine["centre"].tolist()
    to_centre = (x * cos - y_centre * sin, x * sin + y_centre * cos)  # C from the chassis origin, world axes
    y[: YAW + 1] = position[0] + to_centre[0], position[1] + to_centre[1], yaw
    y[at.velocity : at.yaw_rate] = velocity[0] - yaw_rate * to_centre[1], velocity[1] + yaw_rate * to_centre[0]
    y[at.yaw_rate] = yaw_rate
    if machine["odometry"]:
        y[at.odometry : at.odometry + 2] = position
    turning = ask(turning_wheels, config)
    y[at.spin_angle : at.spin_angle + count] = spin_angles = turning.spin_angles
    y[at.spin_rate : at.spin_rate + count] = turning.spin_rates
    rates = turning.rates
    if yaw_rate:
        rates = rates - yaw_rate * (wheels["cos_psi"][:, None] * np.sin(roller_azimuths(wheels, spin_angles)))
    rates = np.where(turning.there, rates, 0.0)
    if machine["implicit_tracking"]:
        q = roller_azimuths(wheels, spin_angles)
        headings = yaw + np.radians([wheel.heading_deg for wheel in config.wheels])
        directions = roller_directions(q, headings)[turning.there]
        y[at.rho : at.bodies].reshape(count, rollers, 3)[turning.there] = -directions
    return y, rates


class Turning(NamedTuple):
    """How wheels (W,) begin to turn: spin angles, rad, and rates, rad/s; axial rates of rollers (W, N) on a chassis
    that does not turn, rad/s; which of these there are."""

    spin_angles: np.ndarray
    spin_rates: np.ndarray
    rates: np.ndarray
    there: np.ndarray


def turning_wheels(config: Config) -> Turning:
    spin_angles, spin_rates = np.array([(wheel.spin_angle, wheel.spin_rate) for wheel in config.wheels]).T
    counts = np.array([kind.rollers for kind in types_of(config)])
    sin_psi = np.array([values["sin_psi"] for values in shared_of(config)])
    rates = (spin_rates * sin_psi)[:, None] + rates_given(config, counts.max())  # p = chi' + w . a
    return Turning(spin_angles, spin_rates, rates, np.arange(counts.max()) < counts[:, None])


def rates_given(config: Config, rollers: int) -> np.ndarray:
    """Axial rates of the rollers about their wheels, as the scene has them: (W, N), or (W, 1) where each has one."""
    given = [wheel.roller_rates for wheel in config.wheels]
    if not any(isinstance(own, tuple) for own in given):
        return np.array(given)[:, None]
    rates = np.zeros((len(given), rollers))
    for row, own, wheel in zip(rates, given, config.wheels, strict=True):
        row[: config.type_of(wheel).rollers] = own
    return rates


def roller_azimuths(wheels: np.ndarray | np.record, spin_angles: np.ndarray | float) -> np.ndarray:
    """q of every roller of records WHEEL up to whole turns, rad: (..., N) for spin angles (...)."""
    turned = np.multiply.outer(2.0 * wheels["alpha"], np.arange(np.max(wheels["rollers"])))
    return np.asarray(wheels["phase"])[..., None] + turned - np.asarray(spin_angles)[..., None]


def roller_directions(q: np.ndarray, yaw: np.ndarray | float) -> np.ndarray:
    """d = -cos q n + sin q h of every roller, world axes: (..., N_r, 3) for q (..., N_r) and yaw (...)."""
    yaw = np.asarray(yaw)[..., None]
    return np.stack([np.sin(q) * np.cos(yaw), np.sin(q) * np.sin(yaw), -np.cos(q)], axis=-1)
