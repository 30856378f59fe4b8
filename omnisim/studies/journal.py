"""The journal of a study that is under way: what has finished is on the disk, whatever happens to the process.

A text: the first line says which study it is, each further one what a batch of runs has found, with the CRC-32 of the
rest of the line before it. From a line on that a crash has cut off all is taken away.
"""

import json
import os
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from zlib import crc32

from omnisim.studies.task import Row

FORMAT = "omnisim-study-journal 1"


class Journal:
    """An open journal: rows are on the disk when `write` returns. Raises OSError, as of a full disk."""

    def __init__(self, path: Path, fingerprint: str):
        self.path = path
        new = not path.exists()
        if not new:
            os.truncate(path, _whole(path)[1])
        self.file = open(path, "ab", buffering=0)  # noqa: SIM115  (closed by __exit__)
        if new:
            self._line(json.dumps([FORMAT, fingerprint]))

    def write(self, rows: Iterable[Row]) -> None:
        self._line(json.dumps(list(rows), allow_nan=False))

    def _line(self, text: str) -> None:
        line = text.encode()
        image = b"%08x %b\n" % (crc32(line), line)
        if self.file.write(image) != len(image):  # a disk that is full takes a part of it
            raise OSError(28, os.strerror(28), str(self.path))
        os.fsync(self.file.fileno())

    def __enter__(self) -> "Journal":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.file.close()


def read(path: Path, fingerprint: str) -> list[Row] | None:
    """The rows in a journal; None if it is not one of this study."""
    lines, _ = _whole(path)
    if not lines or lines[0] != [FORMAT, fingerprint]:
        return None
    return [
        Row(run, status, stop, wall, tuple(measures), tuple(final))
        for rows in lines[1:]
        for run, status, stop, wall, measures, final in rows
    ]


def _whole(path: Path) -> tuple[list[list], int]:
    """What the lines say up to the first that is damaged, and how many bytes they are."""
    found: list[list] = []
    length = 0
    with open(path, "rb") as file:
        for line in file:
            check, _, text = line.rstrip(b"\n").partition(b" ")
            if not line.endswith(b"\n") or check != b"%08x" % crc32(text):
                break
            found.append(json.loads(text))
            length += len(line)
    return found, length
