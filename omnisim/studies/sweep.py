"""All runs of a study: handed out, kept as they finish, gathered."""

import hashlib
import shlex
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from errno import EEXIST
from os import PathLike
from pathlib import Path
from threading import Event
from typing import Any, NamedTuple

from omnisim.base.arguments import callable_or_none
from omnisim.base.formatting import visible
from omnisim.base.version import VERSION
from omnisim.results.layout import COMPLETE
from omnisim.scene.document import by_name
from omnisim.scene.toml_text import show_path, show_value
from omnisim.studies import journal
from omnisim.studies.journal import Journal
from omnisim.studies.result import StudyResult, gathered, open_study, rows_of
from omnisim.studies.study import Study, StudyError, load_study
from omnisim.studies.task import Row, Task
from omnisim.studies.workers import cores, on_cores

OTHER = "of another study, another scene or another version of omnisim; --force begins anew"
ROW_BYTES, NUMBER_BYTES = 160, 40  # of a run in journal and file together, and of each of its numbers


class Done(NamedTuple):
    """How far a study has come: runs that have ended, those of them that are not complete, all runs."""

    ended: int
    failed: int
    runs: int


Progress = Callable[[Done], object]


def sweep(
    study: str | PathLike[str] | Mapping[str, Any] | Study,
    output: str | PathLike[str] | None = None,
    *,
    workers: int | None = None,
    cluster: str | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> StudyResult:
    """Run a study.

        found = omnisim.sweep("study.toml", "study.h5")
        found = omnisim.sweep({
            "schema": 1, "scene": "youbot", "vary": {"friction.coefficient": [0.3, 0.7]},
            "measure": {"far": {"dataset": "body/position", "at": "end", "component": "x"}},
        })

    study: a file, or what one says. output: the HDF5 file; while the study is under way, finished runs are safe in
    OUTPUT.journal beside it. workers: processes, by default one for each core. cluster: the address of a scheduler of
    Dask, or "local" to start one (extra `cluster`). resume: go on with the journal of this study. progress: called with
    a Done after each batch; if it returns something true, no more runs begin, and what has finished is gathered. The
    numbers are the same whatever runs them.

    Raises StudyError or SceneError for what is wrong with the study, FileExistsError unless it may overwrite, and
    OSError, as of a full disk: what has finished is in the journal then.
    """
    callable_or_none("sweep", "progress", progress, "a Done")
    made = study if isinstance(study, Study) else load_study(study)
    path = Path(output) if output is not None else None
    task = Task(made, kept_in(made, path))
    if path is None:
        return gathered(task, all_rows(task, [], handed_out(task, workers, cluster), progress))
    known = begun(task, path, resume, overwrite)
    check_room(task, path)
    if task.folder:
        task.folder.mkdir(exist_ok=True)
    with Journal(journal_of(path), fingerprint(made.document.text, made.scene.text)) as kept:
        rows = all_rows(task, known, handed_out(task, workers, cluster), progress, kept)
    found = gathered(task, rows)
    found.save(path, overwrite=overwrite or resume)
    if found.complete:
        journal_of(path).unlink()
    return found


HandOut = Callable[[list[int], Callable[[], bool]], Iterator[list[Row]]]


def handed_out(task: Task, workers: int | None, cluster: str | None) -> HandOut:
    """What takes numbers of runs, and whether to stop, and gives rows in batches."""
    if cluster is not None:
        from omnisim.studies.cluster import on_cluster  # here: it takes Dask

        return lambda runs, stop: on_cluster(task, runs, cluster, workers, stop)
    return lambda runs, stop: on_cores(task, runs, min(workers or cores(), max(len(runs), 1)), stop)


def all_rows(
    task: Task, known: list[Row], hand_out: HandOut, progress: Progress | None, kept: Journal | None = None
) -> list[Row]:
    """The rows that are known, and those of the other runs as they finish."""
    rows = {row.run: row for row in known}
    count = task.study.count
    failed = sum(row.status != COMPLETE for row in known)
    told = progress or (lambda done: False)
    stop = Event()
    if told(Done(len(rows), failed, count)):
        stop.set()
    for batch in hand_out([run for run in range(count) if run not in rows], stop.is_set):
        if kept:
            kept.write(batch)
        rows |= {row.run: row for row in batch}
        failed += sum(row.status != COMPLETE for row in batch)
        if told(Done(len(rows), failed, count)):
            stop.set()
    return list(rows.values())


def begun(task: Task, path: Path, resume: bool, overwrite: bool) -> list[Row]:
    """The rows to go on with. Raises StudyError, and FileExistsError for what may not be replaced."""
    beside = journal_of(path)
    if resume:
        known = {row.run: row for row in [*in_file(task, path), *in_journal(task, beside)]}
        return list(known.values())
    if overwrite:
        beside.unlink(missing_ok=True)
    elif beside.exists():
        raise FileExistsError(EEXIST, "runs of a study are in it; --resume goes on, --force begins anew", str(beside))
    elif path.exists():
        raise FileExistsError(EEXIST, "exists already; --force replaces it, --resume does what is missing", str(path))
    return []


def in_journal(task: Task, path: Path) -> list[Row]:
    """The rows in a journal, if it is there. Raises StudyError for that of another study."""
    rows = journal.read(path, fingerprint(task.study.document.text, task.study.scene.text)) if path.exists() else []
    if rows is None:
        raise StudyError(f"{visible(str(path))}: {OTHER}")
    return rows


def in_file(task: Task, path: Path) -> list[Row]:
    """The rows in the file of a study, if it is there. Raises StudyError for that of another study."""
    if not path.exists():
        return []
    found = open_study(path)
    a = found.attributes
    mine = fingerprint(task.study.document.text, task.study.scene.text)
    if fingerprint(a["study"], a["scene"], a["omnisim_version"]) != mine:
        raise StudyError(f"{visible(str(path))}: {OTHER}")
    return rows_of(task, found)


def journal_of(path: Path) -> Path:
    return path.with_name(f"{path.name}.journal")


def kept_in(study: Study, path: Path | None) -> Path | None:
    """The folder of trajectories, if they are all kept. Raises StudyError without an output to stand beside."""
    if study.config.keep.trajectories != "all":
        return None
    if path is None:
        raise StudyError('keep.trajectories = "all": takes an output file, beside which they stand')
    return path.with_name(f"{path.stem}_runs")


def fingerprint(study: str, scene: str, version: str = VERSION) -> str:
    """Tells one study from another: by its text, that of its scene, and who runs it."""
    return hashlib.sha256("\0".join((study, scene, version)).encode()).hexdigest()


def check_room(task: Task, path: Path) -> None:
    """Raises StudyError if the disk has no room for the results."""
    numbers = len(task.readings) + len(task.final) + len(task.study.factors)
    needed = task.study.count * (ROW_BYTES + NUMBER_BYTES * numbers)
    free = shutil.disk_usage(path.resolve().parent).free
    if needed > free:
        what = f"{task.study.count} runs take about {needed / 1e9:.3g} GB"
        raise StudyError(
            f"{task.study.document.source}: {what}, and {visible(str(path))} has {free / 1e9:.3g} GB of room"
        )


def repeat(task: Task, run: int) -> str:
    """The command that repeats a run."""
    study = task.study
    document = study.scene.document
    fixed = {show_path(by_name(one.path, document.data)): one.value for one in document.applied}
    own = fixed | task.overrides(run)
    words = [f"--set {shlex.quote(f'{key}={show_value(value, sys.maxsize)}')}" for key, value in own.items()]
    return " ".join(["omnisim run", shlex.quote(study.scene.source), *words])
