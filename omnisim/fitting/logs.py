"""Logs: what a robot measured, read from .csv and .csv.gz into one form."""

import csv
import gzip
import io
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from omnisim.base.files import read_small
from omnisim.base.formatting import visible
from omnisim.fitting.schema import MEASURED, POSE, TIME, LogEntry, known_columns
from omnisim.scene.document import InputError
from omnisim.scene.problems import Problem, did_you_mean
from omnisim.scene.toml_text import show_value

MOST_BYTES = 256 << 20  # of a log, and of what is packed in one
FEWEST = 3  # rows
GZIP = b"\x1f\x8b"


class FitError(InputError):
    """What is wrong with a fit or its logs, one line for each problem: file, line, key, value, what is allowed."""


@dataclass(frozen=True)
class Log:
    """A log of n rows and W wheels.

    file      as the fit file names it
    use       "fit" or "test"
    time      (n,) s, from 0 on
    position  (n, 2) m, of the tracked point
    yaw       (n,) rad, without jumps
    angles    (n, W) rad, turned since the first row, wheels in the order of the scene
    """

    file: str
    use: str
    time: np.ndarray
    position: np.ndarray
    yaw: np.ndarray
    angles: np.ndarray


@dataclass(frozen=True)
class Rows:
    """The text of a log: names of columns, empty without a header, and cells with the line of each row."""

    names: list[str]
    cells: list[list[str]]
    lines: list[int]


def log_problems(entry: LogEntry, i: int, wheels: tuple[str, ...]) -> Iterator[Problem]:
    """What is wrong with the i-th entry of [[logs]] whatever its file holds."""
    here = ("logs", i)
    known = known_columns(wheels)
    for key in entry.columns:
        if key not in known:
            yield Problem((*here, "columns", key), f"unknown column{did_you_mean(key, known) or '.'} {allowed(wheels)}")
    for key in entry.scale:
        if key not in known and key not in shared(known):
            yield Problem((*here, "scale", key), f"unknown column{did_you_mean(key, known) or '.'} {allowed(wheels)}")


def allowed(wheels: tuple[str, ...]) -> str:
    kinds = ", ".join(f"wheels.NAME.{kind}" for kind in MEASURED)
    return f"Allowed: {TIME}, {', '.join(POSE)}, {kinds}; wheels: {', '.join(wheels)}"


def shared(known: list[str]) -> set[str]:
    """Names of columns with a * for all wheels."""
    return {f"wheels.*.{key.rpartition('.')[2]}" for key in known if key.startswith("wheels.")}


def read_log(entry: LogEntry, i: int, folder: Path, wheels: tuple[str, ...]) -> "Log | list[Problem]":
    """The i-th log of a fit in this folder, or Problems of the entry. Raises FitError for what its file holds."""
    path = folder / entry.file
    try:
        rows = text_rows(path)
    except OSError as error:
        return [Problem(("logs", i, "file"), f"cannot be read: {error.strerror or error}")]
    shown = visible(str(path))
    if len(rows.cells) < FEWEST:
        raise FitError(f"{shown}: {len(rows.cells)} rows; a log has {FEWEST} or more")
    places = {}
    problems = []
    names = [*([] if entry.columns else rows.names)]
    columns = dict(entry.columns) or {key: key for key in known_columns(wheels) if key in names}
    for key, column in columns.items():
        try:
            places[key] = place(rows, column)
        except ValueError as error:
            problems.append(Problem(("logs", i, "columns", key), str(error)))
    for key in (TIME, *POSE):
        if key not in columns:
            problems.append(Problem(("logs", i, "columns"), f"no column for {key}"))
    for wheel in wheels:
        given = [kind for kind in MEASURED if f"wheels.{wheel}.{kind}" in columns]
        if len(given) != 1:
            what = f"{len(given)} columns" if given else "no column"
            choices = " or ".join(f"wheels.{wheel}.{kind}" for kind in MEASURED)
            problems.append(Problem(("logs", i, "columns"), f"{what} for what wheel {wheel} turns; one of {choices}"))
    if problems:
        return problems
    values = {key: numbers(rows, key, at, shown) * factor(entry, key) for key, at in places.items()}
    time = values[TIME]
    back = np.flatnonzero(np.diff(time) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        allowed_times = f"must be later than that of the row before, {time[row - 1]:g}"
        raise FitError(f"{shown}:{rows.lines[row]}: {TIME} = {time[row]:g}: {allowed_times}")
    return Log(
        file=entry.file, use=entry.use, time=time - time[0],
        position=np.column_stack([values[key] for key in POSE[:2]]), yaw=np.unwrap(values[POSE[2]]),
        angles=np.column_stack([turned(values, wheel, time) for wheel in wheels]),
    )  # fmt: skip


def turned(values: dict[str, np.ndarray], wheel: str, time: np.ndarray) -> np.ndarray:
    """(n,) rad that a wheel has turned since the first row: its angles; increments since the row before, summed; or
    rates, integrated by the trapezoidal rule."""
    angle, increment, rate = (values.get(f"wheels.{wheel}.{kind}") for kind in MEASURED)
    if angle is not None:
        return angle - angle[0]
    if increment is not None:
        return np.concatenate([[0.0], np.cumsum(increment[1:])])
    assert rate is not None  # as read_log has seen
    return np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time))])


def factor(entry: LogEntry, key: str) -> float:
    """The scale of a column: its own, else that of all wheels, else 1."""
    general = f"wheels.*.{key.rpartition('.')[2]}" if key.startswith("wheels.") else key
    return entry.scale.get(key, entry.scale.get(general, 1.0))


def text_rows(path: Path) -> Rows:
    """The cells of a .csv or .csv.gz; rows without any are left out. Raises OSError."""
    content = read_small(path, MOST_BYTES)
    if content.startswith(GZIP):
        try:
            content = gzip.GzipFile(fileobj=io.BytesIO(content)).read(MOST_BYTES + 1)
        except (EOFError, zlib.error, gzip.BadGzipFile) as error:
            raise OSError(f"a damaged gzip file: {error}") from None
        if len(content) > MOST_BYTES:
            raise OSError(f"it has more than {MOST_BYTES / 1e6:.0f} MB")
    reader = csv.reader(io.StringIO(content.decode("utf-8-sig", "replace")))
    try:
        found = [([cell.strip() for cell in cells], reader.line_num) for cells in reader if any(map(str.strip, cells))]
    except csv.Error as error:
        raise OSError(f"line {reader.line_num}: {error}") from None
    header = found[0][0] if found and not any(is_number(cell) for cell in found[0][0]) else []
    kept = found[1:] if header else found
    return Rows(header, [cells for cells, _ in kept], [line for _, line in kept])


def is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def place(rows: Rows, column: str | int) -> int:
    """The number of a column. Raises ValueError for one that is not there."""
    if isinstance(column, int):
        most = len(rows.names or (rows.cells[0] if rows.cells else ()))
        if column < most:
            return column
        raise ValueError(f"the log has {most} columns, counted from 0")
    if not rows.names:
        raise ValueError("the log has no header; must be the number of a column, from 0")
    if rows.names.count(column) != 1:
        many = "several columns" if column in rows.names else "no column"
        hint = did_you_mean(column, rows.names) or "."
        raise ValueError(f"the log has {many} of this name{hint} Columns: {', '.join(map(visible, rows.names))}")
    return rows.names.index(column)


def numbers(rows: Rows, key: str, at: int, shown: str) -> np.ndarray:
    """A column as finite numbers. Raises FitError for the first cell that is none."""
    try:
        found = np.array([float(cells[at]) for cells in rows.cells])
        if np.isfinite(found).all():
            return found
    except (ValueError, IndexError):
        pass
    for cells, line in zip(rows.cells, rows.lines, strict=True):
        cell = cells[at] if at < len(cells) else ""
        if not (is_number(cell) and np.isfinite(float(cell))):
            told = visible(show_value(cell)) if cell else "nothing"
            raise FitError(f"{shown}:{line}: {key} = {told}: must be a finite number")
    raise AssertionError("a column is numbers or it is not")
