"""`omnisim sweep`: many runs of a scene, its keys varied."""

from __future__ import annotations

import logging
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from omnisim.base.formatting import aligned, visible

from .compiling import compilation_noted
from .screen import BAD_INPUT, Failure, StopWish, is_watched, note

if TYPE_CHECKING:
    from omnisim.studies.result import StudyResult
    from omnisim.studies.sweep import Done
    from omnisim.studies.task import Task


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
    except (OSError, KeyboardInterrupt) as error:
        journal = runs.journal_of(path)
        kept = f"; finished runs are in {visible(str(journal))}: --resume goes on" if journal.exists() else ""
        what = (
            f"{visible(str(error.filename or path))}: {error.strerror}" if isinstance(error, OSError) else "interrupted"
        )
        raise Failure(f"{what}{kept}") from None
    if not quiet:
        click.echo(summary(task, found, path, follower.ran, time.perf_counter() - begun))
    if not found.complete:
        done = f"{found.attributes['finished']} of {found.attributes['runs']} runs"
        raise Failure(f"interrupted after {done}; {visible(str(path))} has them, and --resume does what is missing")


class Notes(logging.Handler):
    """What studies have to say goes where notes go."""

    def emit(self, record: logging.LogRecord) -> None:
        note(record.getMessage())


class Follower(StopWish):
    """Follows a study: a bar if stderr is a terminal, and Ctrl-C or SIGTERM as a wish to stop."""

    def __init__(self, quiet: bool):
        super().__init__()
        self.quiet = quiet
        self.bar: Any = None  # of click
        self.begun = 0.0
        self.before = self.ran = 0  # runs that were known at the start, and those that have ended since

    def __exit__(self, exception: type[BaseException] | None, *rest: object) -> None:
        super().__exit__(exception, *rest)
        if self.bar:
            with suppress(OSError):  # the terminal is closed
                self.bar.render_finish()

    def __call__(self, done: Done) -> bool:
        """Whether to stop."""
        if not self.begun:
            self.listen()
            self.begun = time.perf_counter()
            self.before = done.ended
            if is_watched(self.quiet):
                self.bar = click.progressbar(
                    length=done.runs, show_pos=True, show_eta=True, item_show_func=self.rate,
                    file=getattr(sys.stderr, "stream", sys.stderr),
                )  # fmt: skip
        self.ran = done.ended - self.before
        if self.bar:
            with suppress(OSError):
                self.bar.update(done.ended - self.bar.pos, done)
        return self.stop

    def _on_signal(self, *_: object) -> None:
        super()._on_signal()
        if not self.quiet:
            note("stopping, and writing what has finished; another Ctrl-C gives up")

    def rate(self, done: Done | None) -> str:
        """What stands beside the bar."""
        rate = f"{self.ran / max(time.perf_counter() - self.begun, 1e-9):.3g} runs/s"
        return f"{rate}, {done.failed} not complete" if done and done.failed else rate


def summary(task: Task, found: StudyResult, path: Path, ran: int, seconds: float) -> str:
    """What a study has found, with the commands that repeat the runs that it names."""
    from omnisim.studies.report import findings, title
    from omnisim.studies.sweep import repeat

    from .output import megabytes

    lines, named = findings(found)
    told = {
        "study": title(found),
        "speed": f"{ran / max(seconds, 1e-9):.3g} runs/s: {ran} in {seconds:.3g} s" if ran else "",
        **lines,
        "file": f"{visible(str(path))} ({megabytes(path)})",
    }
    again = [f"run {run}: {repeat(task, run)}" for run in named]  # on one line each, to be copied
    return "\n".join([aligned({key: value for key, value in told.items() if value}), *again])
