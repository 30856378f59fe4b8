"""The state at t = 0, and the memory of a march."""

import math

import numpy as np

from omnisim.config import Config
from omnisim.contact.tracking import IMPLICIT
from omnisim.grip import alignment, fineness, stopping_alignment
from omnisim.parameters import Parameters
from omnisim.state import CLOCK, MODE, WATCH, YAW, Newton, Rows, Run, X, Y, places_in
from omnisim.stiffness import resolve
from omnisim.tableau import EXPLICIT, METHODS


def begin(config: Config, parameters: Parameters) -> Run:
    """A Run at t = 0; the march itself finds the rollers in contact."""
    y, rates = initial_state(config, parameters)
    count, clock = len(parameters.wheels), np.zeros(1, CLOCK).view(np.recarray)[0]
    clock.dt = config.time.output_interval / config.time.steps_per_output
    clock.steps, clock.steps_per_row = config.time.steps, config.time.steps_per_output
    clock.goal, clock.wheel, clock.reach = clock.steps, -1, clock.dt
    method = METHODS[config.solver.method]
    clock.choice, clock.stability_limit = resolve(config, parameters), method.tableau.stability_limit
    lightness = parameters.machine.mass * parameters.machine.slip_mobility
    clock.fineness, clock.aligned = fineness(clock.dt), alignment(clock.dt, clock.choice)
    clock.stopping = stopping_alignment(clock.dt, clock.choice, lightness)
    return Run(
        y=y,
        trial=np.empty_like(y),
        stage=np.empty_like(y),
        carry=np.zeros_like(y),
        increment=np.zeros_like(y),
        slopes=np.zeros((method.tableau.stages + 1, len(y))),
        rates=rates,
        mode=np.zeros(count, MODE).view(np.recarray),
        watch=np.zeros(count, WATCH).view(np.recarray),
        watch_end=np.zeros(count, WATCH).view(np.recarray),
        clock=clock,
        newton=newton_room(parameters, len(y) if clock.choice != EXPLICIT else 0),
    )


def newton_room(parameters: Parameters, states: int) -> Newton:
    """Room for implicit steps: forces depend on yaw, spin angles and all rates."""
    at = places_in(parameters)
    active = np.arange(YAW, at.friction_loss) if states else np.zeros(0, np.int64)
    count = len(active)
    return Newton(
        active=active,
        stages=np.zeros((7, states)),
        real=np.zeros((2 * count + 1, count)),
        complex=np.zeros((count + 1, count), complex),
        pivots=np.zeros((2, count), np.int64),
    )


def blank_rows(run: Run, count: int) -> Rows:
    """Room for `count` rows of a run."""
    wheels, rollers = run.rates.shape
    return Rows(
        y=np.empty((count, len(run.y))),
        rates=np.empty((count, wheels, rollers)),
        mode=np.empty((count, wheels), MODE).view(np.recarray),
        piece=np.empty(count, np.int64),
    )


def initial_state(config: Config, parameters: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """State y (n,) without the rates of the rollers in contact, and rates (W, N) of all rollers, rad/s."""
    wheels, rollers = parameters.sector.shape[:2]
    implicit = parameters.machine.tracking == IMPLICIT
    at = places_in(parameters)
    y = np.zeros(at.rho + 3 * wheels * rollers * implicit)
    rates = np.zeros((wheels, rollers))
    y[YAW], y[at.yaw_rate] = math.radians(config.initial.yaw_deg), config.initial.yaw_rate
    cos, sin, (x, y_centre) = math.cos(y[YAW]), math.sin(y[YAW]), parameters.machine.centre
    to_centre = np.array([x * cos - y_centre * sin, x * sin + y_centre * cos])  # C from the chassis origin, world axes
    y[[X, Y]] = config.initial.position + to_centre
    y[at.velocity : at.yaw_rate] = config.initial.velocity + y[at.yaw_rate] * np.array([-to_centre[1], to_centre[0]])
    if parameters.machine.odometry:
        y[[at.odometry, at.odometry + 1]] = config.initial.position
    for w, wheel in enumerate(config.wheels):
        record = parameters.wheels[w]
        y[at.spin_angle + w], y[at.spin_rate + w] = math.radians(wheel.spin_angle_deg), wheel.spin_rate
        q = roller_azimuths(record, y[at.spin_angle + w])
        axis_n = -record.cos_psi * np.sin(q)  # p = chi' + w . a
        rates[w, : record.rollers] = wheel.roller_rates + wheel.spin_rate * record.sin_psi + y[at.yaw_rate] * axis_n
        if implicit:
            rho = y[at.rho + 3 * rollers * w :][: 3 * record.rollers].reshape(-1, 3)
            rho[:] = -roller_directions(q, y[YAW] + math.radians(wheel.heading_deg))
    return y, rates


def roller_azimuths(record: np.record, spin_angle: np.ndarray | float) -> np.ndarray:
    """q of every roller of a wheel, up to whole turns, rad: (..., N_r) for spin angles (...)."""
    return record.phase + 2.0 * record.alpha * np.arange(record.rollers) - np.asarray(spin_angle)[..., None]


def roller_directions(q: np.ndarray, yaw: np.ndarray | float) -> np.ndarray:
    """d = -cos q n + sin q h of every roller, world axes: (..., N_r, 3) for q (..., N_r) and yaw (...)."""
    yaw = np.asarray(yaw)[..., None]
    return np.stack([np.sin(q) * np.cos(yaw), np.sin(q) * np.sin(yaw), -np.cos(q)], axis=-1)
