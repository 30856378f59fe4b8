"""`omnisim sweep`: many runs of a scene, its keys varied."""

from __future__ import annotations

import logging
import signal
import sys
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from omnisim.base.formatting import aligned, visible

from .compiling import compilation_noted
from .screen import BAD_INPUT, ENDING, Failure, leave_at_once, note

if TYPE_CHECKING:
    from omnisim.studies.result import StudyResult
    from omnisim.studies.sweep import Done
    from omnisim.studies.task import Task

KINDS_OF_FAILURE = 5  # that the summary tells
WIDTH = 24  # of the bar
EVERY = 0.1  # s between two looks of it


@click.command()
@click.argument("study", metavar="STUDY.toml")
@click.option("-o", "output", metavar="FILE", help="Output file; else STEM.h5 here.")
@click.option("--workers", type=click.IntRange(1), metavar="N", help="Processes; else one for each core.")
@click.option("--cluster", metavar="ADDRESS", help='Scheduler of Dask, tcp://HOST:PORT, or "local" to start one.')
@click.option("--resume", is_flag=True, help="Go on where the study was interrupted.")
@click.option("--force", is_flag=True, help="Replace an output file that exists, and begin anew.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def sweep(
    study: str, output: str | None, workers: int | None, cluster: str | None, resume: bool, force: bool, quiet: bool
) -> None:
    """Run the scene of STUDY.toml many times, its keys varied, and write what each run measures to an HDF5 file.

    While the study is under way, finished runs are safe in FILE.journal: after Ctrl-C, a crash or a full disk --resume
    does what is missing.

    \b
    omnisim sweep study.toml                                writes study.h5
    omnisim sweep study.toml --resume
    omnisim sweep study.toml --cluster tcp://10.0.0.1:8786
    omnisim plot study.h5
    """
    from omnisim.studies import sweep as runs
    from omnisim.studies.study import load_study
    from omnisim.studies.task import Task

    from .output import output_path

    made = load_study(study)
    path = output_path(output or f"{made.name}.h5", study, force or resume)
    with compilation_noted([made.scene], quiet):
        task = Task(made)
    begun = time.perf_counter()
    if not quiet:
        log = logging.getLogger("omnisim.studies")
        log.setLevel(logging.INFO)
        log.addHandler(Notes())
    try:
        with Follower(quiet) as follower:
            found = runs.sweep(
                made, path, workers=workers, cluster=cluster, resume=resume, overwrite=force, progress=follower
            )
    except FileExistsError as error:
        raise Failure(f"{visible(str(error.filename))}: {error.strerror}", BAD_INPUT) from None
    except OSError as error:
        journal = runs.journal_of(path)
        kept = f"; finished runs are in {visible(str(journal))}: --resume goes on" if journal.exists() else ""
        raise Failure(f"{visible(str(error.filename or path))}: {error.strerror}{kept}") from None
    if not quiet:
        click.echo(summary(task, found, path, follower.ran, time.perf_counter() - begun))
    if not found.complete:
        done = f"{found.attributes['finished']} of {found.attributes['runs']} runs"
        raise Failure(f"interrupted after {done}; {visible(str(path))} has them, and --resume does what is missing")


class Notes(logging.Handler):
    """What studies have to say goes where notes go."""

    def emit(self, record: logging.LogRecord) -> None:
        note(record.getMessage())


class Follower:
    """Follows a study: a line with a bar if stderr is a terminal, and Ctrl-C or SIGTERM as a wish to stop."""

    def __init__(self, quiet: bool):
        self.drawing = not quiet and bool(sys.stderr) and sys.stderr.isatty()
        self.quiet = quiet
        self.stop = False
        self.begun = self.drawn = time.perf_counter()
        self.before: int | None = None  # runs that were known at the start
        self.ran = 0
        self.handlers: dict[int, Any] = {}

    def __enter__(self) -> Follower:
        for number in ENDING:
            if signal.getsignal(number) != signal.SIG_IGN:
                self.handlers[number] = signal.signal(number, self.on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self.handlers.items():
            signal.signal(number, handler)
        if self.drawing:
            self.write("\r\x1b[K")

    def __call__(self, done: Done) -> bool:
        now = time.perf_counter()
        if self.before is None:
            self.before = done.ended
            self.begun = now
        self.ran = done.ended - self.before
        if self.drawing and (now > self.drawn + EVERY or done.ended == done.runs):
            self.drawn = now
            self.write(f"\r{line(done, self.ran, now - self.begun)}\x1b[K")
        return self.stop

    def write(self, text: str) -> None:
        with suppress(OSError):  # the terminal is closed
            stream = getattr(sys.stderr, "stream", sys.stderr)
            stream.write(text)
            stream.flush()

    def on_signal(self, *_: object) -> None:
        if self.stop:
            leave_at_once()
        self.stop = True
        if not self.quiet:
            note("\nstopping, and writing what has finished; another Ctrl-C gives up" if self.drawing else "stopping")


def line(done: Done, ran: int, seconds: float) -> str:
    """What is seen of a study that is under way."""
    filled = WIDTH * done.ended // max(done.runs, 1)
    rate = ran / seconds if seconds > 0.0 else 0.0
    left = f", {duration((done.runs - done.ended) / rate)} left" if rate else ""
    failed = f", {done.failed} not complete" if done.failed else ""
    return f"[{'#' * filled}{'-' * (WIDTH - filled)}] {done.ended} of {done.runs} runs{failed}, {rate:.3g} runs/s{left}"


def duration(seconds: float) -> str:
    if seconds < 10.0:
        return f"{seconds:.2g} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def summary(task: Task, found: StudyResult, path: Path, ran: int, seconds: float) -> str:
    """What a study has found, for people: the range of every measure, with the runs that have it, and failures."""
    import numpy as np

    from omnisim.results.layout import COMPLETE
    from omnisim.studies.sweep import repeat

    a = found.attributes
    status = found["status"].ravel()
    scene = task.study.scene
    named: list[int] = []
    told = {
        "study": f"{a['runs']} runs of {visible(scene.config.title or scene.name)} ({a['design']})",
        "speed": f"{ran / max(seconds, 1e-9):.3g} runs/s: {ran} in {duration(seconds)}" if ran else "",
        "complete": f"{np.sum(status == COMPLETE)} of {a['finished']} that have ended",
    }
    for name in found.measures:
        values = found[name].ravel()
        if np.isfinite(values).any():
            least, most = int(np.nanargmin(values)), int(np.nanargmax(values))
            units = found.variables[name].units
            told[name] = f"{values[least]:.6g} (run {least}) to {values[most]:.6g} {units} (run {most})"
            named.append(most)
    for reason, count in Counter(_reason(text) for text in status if text != COMPLETE).most_common(KINDS_OF_FAILURE):
        run = next(i for i, text in enumerate(status) if _reason(text) == reason)
        told[f"{count} not"] = f"{status[run]} (run {run})"
        named.append(run)
    told["file"] = f"{visible(str(path))} ({path.stat().st_size / 1e6:.2g} MB)"
    again = [f"run {run}: {repeat(task, run)}" for run in dict.fromkeys(named)]  # on one line each, to be copied
    return "\n".join([aligned({key: value for key, value in told.items() if value}), *again])


def _reason(status: str) -> str:
    return status.partition(":")[0].partition(" at t")[0]
