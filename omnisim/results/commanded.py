"""What a scene asks of its machine: the target rates of its drives, and the path of the motion that they ask for.

    yaw(t) = yaw_0 + int w dt                        v, w    commanded velocity (chassis axes, m/s) and yaw rate (rad/s)
    r(t)   = r_0 + int R(yaw) v dt                   R(yaw)  turns chassis axes to those of the world

Twists are linear between their knots, so yaw is exact; r is integrated by Gauss and Legendre, exact to rounding.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from omnisim.results.trajectory import Trajectory
from omnisim.scene.drive_schema import Drive
from omnisim.scene.ideal_kinematics import inverse, rms_distance, wheel_rows
from omnisim.scene.schema import Command, Config

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)  # error below 1e-18 of a piece that turns by less than a turn
AGREEING = 1e-9  # of the fastest wheel: target rates that ideal wheels have together, but for rounding


class Table(NamedTuple):
    """Knots: times (K,), s, and values (K, n) there; linear between, held outside, two equal times are a jump."""

    times: np.ndarray
    values: np.ndarray

    def before(self, times: np.ndarray) -> np.ndarray:
        """Values (T, n) just before times (T,)."""
        return _columns(-times, -self.times[::-1], self.values[::-1])

    def after(self, times: np.ndarray) -> np.ndarray:
        """Values (T, n) at times (T,), just after a jump."""
        return _columns(times, self.times, self.values)


def _columns(times: np.ndarray, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.column_stack([np.interp(times, knots, column) for column in values.T])


def target_rates(run: Trajectory, config: Config | None) -> dict[str, np.ndarray]:
    """Target spin rates (T,), rad/s, by wheel: recorded ones, else those that the scene of the run gives, if known."""
    found = {}
    tables = _rate_tables(config) if config else [None] * len(run.wheels)
    for wheel, table in zip(run.wheels, tables, strict=True):
        path = f"wheels/{wheel}/target_rate"
        if path in run:
            found[wheel] = run[path]
        elif table is not None:
            found[wheel] = table.after(run.time)[:, 0]
    return found


def path(config: Config, times: np.ndarray) -> np.ndarray | None:
    """Commanded position (m) and yaw (rad) of the chassis origin, (T, 3), at ascending times (T,), s.

    Those of [command], or else of target rates that all wheels have and that agree on a motion of ideal wheels. None
    where the scene asks for no motion.
    """
    twists = _twists(config)
    if twists is None:
        return None
    initial = config.initial
    return integral(twists, (*initial.position, np.radians(initial.yaw_deg)), times)


def integral(twists: Table, start: Sequence[float], times: np.ndarray) -> np.ndarray:
    """Poses x, y, yaw (T, 3) at ascending times >= 0 that twists vx, vy, yaw rate lead to from a start at t = 0."""
    edges = np.union1d(np.append(times, 0.0), twists.times[(twists.times > 0.0) & (twists.times < times[-1])])
    turned = np.diff(edges) * np.abs(twists.values[:, 2]).max()
    parts = max(1, int(np.ceil(turned.max(initial=0.0) / (2.0 * np.pi))))
    edges = np.interp(np.arange((len(edges) - 1) * parts + 1) / parts, np.arange(len(edges)), edges)
    first = twists.after(edges[:-1])
    rise = twists.before(edges[1:]) - twists.after(edges[:-1])
    length = np.diff(edges)[:, None]
    yaw = start[2] + _sums(length[:, 0] * (first + 0.5 * rise)[:, 2])
    s = 0.5 * (NODES + 1.0)  # within each piece, from 0 to 1
    vx, vy = (first[:, i, None] + rise[:, i, None] * s for i in (0, 1))
    angle = yaw[:-1, None] + length * (first[:, 2, None] * s + 0.5 * rise[:, 2, None] * s**2)
    cos, sin = np.cos(angle), np.sin(angle)
    way = [(length * rates) @ (0.5 * WEIGHTS) for rates in (cos * vx - sin * vy, sin * vx + cos * vy)]
    poses = np.column_stack([start[0] + _sums(way[0]), start[1] + _sums(way[1]), yaw])
    return poses[edges.searchsorted(times)]


def _sums(steps: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(steps)])


def _twists(config: Config) -> Table | None:
    """The commanded twist, None where there is none."""
    if config.command:
        return Table(np.array(config.command.times), np.array(config.command.twist))
    asked = _rate_tables(config)
    tables = [table for table in asked if table is not None]
    if config.chassis is None or len(tables) < len(asked):
        return None
    rows = wheel_rows(config)
    twist_of = inverse(rows, rms_distance(config))
    if twist_of is None:
        return None
    knots = np.unique(np.concatenate([table.times for table in tables]))
    sides = [np.hstack([side(table, knots) for table in tables]) for side in (Table.before, Table.after)]
    rates = np.stack(sides, axis=1).reshape(2 * len(knots), -1)
    twists = rates @ twist_of.T
    agree = np.abs(twists @ rows.T - rates).max() <= AGREEING * np.abs(rates).max()
    return Table(np.repeat(knots, 2), twists) if agree else None


def _rate_tables(config: Config) -> list[Table | None]:
    """The target rate of each wheel as the scene has it, None of a drive without one."""
    return [
        _rate_table(wheel.drive, config.command, row)
        for wheel, row in zip(config.wheels, wheel_rows(config), strict=True)
    ]


def _rate_table(drive: Drive, command: Command | None, row: np.ndarray) -> Table | None:
    if drive.follows_command and command:
        return Table(np.array(command.times), np.array(command.twist) @ row[:, None])
    if drive.rate is None:
        return None
    rates = np.atleast_1d(drive.rate)[:, None]
    return Table(np.array(drive.times or (0.0,)), rates)
