"""Encoders of the measured mecanum robot, each message counted once, at the time that it took.

    python -m docs.mended_logs PUBLISHED.csv data/measured/omni4_squares_1.csv.gz      (one log after the other)

PUBLISHED.csv is a run of the OptiOdom data set with its rows every 0.01 s. The robot sends, every 40 ms, what each wheel
has turned since its last message, in 1/2880 of a turn. The log has a quarter of it in every row until the next message
comes: right, if there were four rows to a message. There are 3.6 on squares and 3.76 on circles, since writing a row took
longer than the 0.01 s that its time says, so that sums over rows leave out 10 % and 6 % of what the wheels turned. Poses
were spread evenly over the rows afterwards, from a clock of their own.

Here a message counts once, at 40 ms times its number, and poses are spread evenly over that time. The packaged log has both:
time_s and count_1 ... count_4 (turns, increments) as published, clock_s and turned_1 ... turned_4 (turns) mended, with
every fifth row.
"""

import gzip
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np

MESSAGE = 0.04  # s between messages
COUNTS = 2880  # of a turn
ROWS = 4  # to a message, by the log
TOGETHER = 2  # rows between changes of the four wheels by one message, at most
USUAL = 3.7  # rows to a message; where nothing changes for longer, there were several alike
KEPT = 5  # every so many rows
HEADER = "time_s,x_m,y_m,yaw_rad,count_1,count_2,count_3,count_4,clock_s,turned_1,turned_2,turned_3,turned_4"


class Messages(NamedTuple):
    """number (n,): how many messages there have been before each row, with parts of one; turned (n, W): turns of the
    wheels until each row; rows: to a message, the mean."""

    number: np.ndarray
    turned: np.ndarray
    rows: float


def messages(increments: np.ndarray) -> Messages:
    """What the increments (n, W) of a published log, in turns, tell of the messages."""
    counts = np.rint(increments * COUNTS * ROWS)
    first = first_rows(counts)
    parts = np.maximum(1, np.rint(np.diff(first) / USUAL))
    usual = float(np.diff(first).sum() / parts.sum())
    begin = np.concatenate([[0], first, [len(counts)]])
    size = np.concatenate([[first[0] / usual], parts, [(len(counts) - first[-1]) / usual]])
    number = np.interp(np.arange(len(counts) + 1), begin, np.concatenate([[0.0], np.cumsum(size)]))
    last = np.searchsorted(begin, np.arange(len(counts)), side="right")  # of the piece that a row is in: where it ends
    turned = np.cumsum(counts[begin[last] - 1] / COUNTS * np.diff(number)[:, None], axis=0)
    return Messages(number[:-1], turned - turned[0], usual)


def first_rows(counts: np.ndarray) -> np.ndarray:
    """Rows in which a message begins: where a count changes, of one wheel a row or two before that of another."""
    found: list[int] = []
    for row in np.flatnonzero(np.any(np.diff(counts, axis=0) != 0, axis=1)) + 1:
        if not found or row - found[-1] > TOGETHER:
            found.append(int(row))
    return np.array(found)


def mended(published: np.ndarray) -> np.ndarray:
    """(m, 13) rows of the packaged log from those (n, 8) that are published."""
    time, increments = published[:, 0] - published[0, 0], published[:, 4:]
    found = messages(increments)
    at = MESSAGE * found.number
    clock = time * at[-1] / time[-1]
    turned = np.column_stack([np.interp(clock, at, wheel) for wheel in found.turned.T])
    kept = np.unique([*range(0, len(time), KEPT), len(time) - 1])
    sums = np.cumsum(increments, axis=0)[kept]
    summed = np.concatenate([increments[:1], np.diff(sums, axis=0)])
    return np.column_stack([time[kept], published[kept, 1:4], summed, clock[kept], turned[kept]])


def read(path: Path) -> np.ndarray:
    """(n, 8): time, x, y, yaw and increments, with a header or without."""
    text = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
    lines = text.decode().splitlines()
    return np.loadtxt(lines[0 if lines[0][0].isdigit() else 1 :], delimiter=",")


def text(rows: np.ndarray) -> str:
    """What the packaged file holds."""
    form = ["%.4f", *["%.6f"] * 3, *["%.6g"] * 4, "%.4f", *["%.6f"] * 4]
    lines = [",".join(one % (cell + 0.0) for one, cell in zip(form, row, strict=True)) for row in rows]
    return "\n".join([HEADER, *lines, ""])


if __name__ == "__main__":
    source, target = map(Path, sys.argv[1:])
    target.write_bytes(gzip.compress(text(mended(read(source))).encode(), mtime=0))
