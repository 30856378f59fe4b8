"""The tables of a scene, its wrench, command and drives, as the pieces that kernels read."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from omnisim.base.keeping import kept
from omnisim.dynamics.parameters import DRIVE_INPUT, FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE
from omnisim.scene.cubic import cubic_curvature
from omnisim.scene.drive_schema import Drive
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.schema import Command, Config, Wheel, Wrench

SHORTEST = 1e-14  # relative: pieces of tables that are no longer than rounding are left out
WRENCH = [FORCE_X, FORCE_Y, FORCE_Z, YAW_TORQUE]

Table = tuple[tuple[float, ...], tuple[Any, ...]]  # times and values


def merge_tables(config: Config) -> tuple[np.ndarray, np.ndarray]:
    """All tables of a scene on the union of their knots: starts (S,) and inputs (S, channels, 2).

    Between two knots every input is linear, so one number, the current piece, tells all of them; a jump is two
    equal knots, between which no piece lies.
    """
    starts, inputs = merged(wheel_rows(config), config.wrench, config.command, *map(drive_table, config.wheels))
    return starts.copy(), inputs.copy()


def drive_table(wheel: Wheel) -> Table | None:
    """What the drive of a wheel is given, by time: of one that follows angles the accelerations that they ask for. None
    of one that follows the command."""
    drive = wheel.drive
    if drive.kind == "follow":
        return followed_table(drive, cubic_curvature(drive.times, drive.angle, wheel.spin_rate))
    return given_table(drive)


@kept
def given_table(drive: Drive) -> Table | None:
    return None if drive.follows_command else drive.table


@kept
def followed_table(drive: Drive, curvature: tuple[float, ...]) -> Table:
    return drive.times, curvature


@kept
def merged(
    rows: np.ndarray, wrench: Wrench, command: Command | None, *drives: Table | None
) -> tuple[np.ndarray, np.ndarray]:
    """The same of a wrench, a command and a table for each drive; rows: of the ideal machine."""
    found = list(tables(rows, wrench, command, drives))
    knots = sorted({time for _, times, _ in found for time in times if time > 0.0})
    edges = np.array([0.0, *knots, math.inf])
    lasting = edges[1:] - edges[:-1] > SHORTEST * (1.0 + edges[:-1])  # knots that rounding cannot part are a jump
    starts = edges[:-1][lasting]
    inputs = np.zeros((len(starts), DRIVE_INPUT + len(drives), 2))
    for channels, times, values in found:
        if len(times) == 1:
            inputs[:, channels, 0] = values
        else:
            inputs[:, channels, 0], inputs[:, channels, 1] = lines(np.array(times), np.array(values), starts)
    starts[0] = 0.0
    return starts, inputs


def tables(
    rows: np.ndarray, wrench: Wrench, command: Command | None, drives: tuple[Table | None, ...]
) -> Iterator[tuple[list[int], Sequence[float], Sequence[Sequence[float]]]]:
    """Channels, times and the values of these channels (K, C) of every table."""
    times, forces, yaw_torques = wrench.table
    yield WRENCH, times, tuple((*force, torque) for force, torque in zip(forces, yaw_torques, strict=True))
    followers = [w for w, table in enumerate(drives) if table is None]
    if followers and command:
        rates = [[rows[w] @ twist for w in followers] for twist in np.array(command.twist)]  # of an ideal machine
        yield [DRIVE_INPUT + w for w in followers], command.times, rates
    for w, table in enumerate(drives):
        if table is not None:
            yield [DRIVE_INPUT + w], table[0], [[value] for value in table[1]]


def lines(times: np.ndarray, values: np.ndarray, starts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values of a table (K, C) at each of `starts` and slopes from there to its next knot (S, C); held outside."""
    after = times.searchsorted(starts, side="right")  # first knot beyond each start
    last, first = np.maximum(after - 1, 0), np.minimum(after, len(times) - 1)
    rise = values[first] - values[last]
    length = (times[first] - times[last])[:, None]
    slopes = np.divide(rise, length, out=np.zeros(rise.shape), where=length > 0.0)
    return values[last] + slopes * (starts - times[last])[:, None], slopes
