"""Logs of machines that are known: files that hold them, fits of them."""

from dataclasses import replace

import numpy as np

from omnisim.fitting.logs import Log

POSITION_NOISE, YAW_NOISE = 0.002, 0.004  # m, rad: as motion capture has


def write_log(path, wheels, time, position, yaw, angles):
    """A file with a header of the keys."""
    names = ["time", "body/position.x", "body/position.y", "body/yaw", *(f"wheels.{name}.angle" for name in wheels)]
    np.savetxt(path, np.column_stack([time, position, yaw, angles]), delimiter=",", header=",".join(names), comments="")


def noisy(log: Log, random: np.random.Generator) -> Log:
    """The same log with white noise on every pose, the first included."""
    return replace(
        log,
        position=log.position + random.normal(0.0, POSITION_NOISE, log.position.shape),
        yaw=log.yaw + random.normal(0.0, YAW_NOISE, log.yaw.shape),
    )


def tour(time: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(n, W) angles of ideal wheels, phi' = rows @ twist, on a tour from rest with motion in every direction."""
    share = np.clip(time / 0.5, 0.0, 1.0)
    twist = np.column_stack([0.2 * np.cos(0.9 * time), 0.2 * np.sin(0.7 * time), 0.6 * np.cos(0.4 * time)])
    rates = (share**2 * (3.0 - 2.0 * share))[:, None] * twist @ rows.T
    return np.concatenate(
        [np.zeros((1, len(rows))), np.cumsum(0.5 * (rates[1:] + rates[:-1]), axis=0) * (time[1] - time[0])]
    )
