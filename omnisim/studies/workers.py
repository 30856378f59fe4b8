"""Runs on all cores of this machine: processes that are handed batches of them.

A process that dies, killed for its memory say, takes its batch with it: the batch is halved and tried again, so that
the run that kills is found. It becomes a row with that status, all others finish.
"""

import gc
import multiprocessing
import os
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple, Protocol, TypeVar, cast

BATCH_SECONDS = 0.25  # of a batch, about: what a crash can lose
T_co = TypeVar("T_co", covariant=True)
MOST_BORN_DEAD = 20  # processes that end before they have done anything, one after the other
BORN_DEAD = "processes end as they begin: a script must call this below `if __name__ == '__main__':`"
LEAST = 0.04  # of such a batch: the smallest towards the end
MOST = 2000  # runs of a batch: what waits for a worker must fit into a pipe
SHARE = 2  # batches that each worker can still expect
GROWTH = 8  # of a batch by the next, at most: the first run of a process takes longer
AHEAD = 2  # batches of several runs that each worker has before it, so that it waits for nobody


class Task(Protocol[T_co]):
    """What is done with a few numbers, something for each, and what stands for one that has killed its process."""

    def __call__(self, runs: Sequence[int]) -> Sequence[T_co]: ...

    def lost(self, run: int, how: str) -> T_co: ...


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Batch(NamedTuple):
    """Runs that go to one worker; tried: how often that has ended with its death."""

    runs: tuple[int, ...]
    tried: int = 0


@dataclass
class Worker:
    """held: the batch under way, and what waits behind it; since: when the first of them began."""

    process: Any
    connection: Connection
    held: deque[Batch]
    since: float = 0.0


def serve(task: Task[Any], connection: Connection, inherited: list[Connection]) -> None:
    """What a worker does until nobody sends it anything any more."""
    for other in inherited:  # else nobody would see the end of the process that hands out the batches
        other.close()
    gc.freeze()  # a search for garbage in what a fork inherits would copy nearly all of it: 10,000 pages
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that hands out the batches
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    try:
        while runs := connection.recv():
            connection.send(made(task, runs))
    except (EOFError, OSError):
        pass


def made(task: Task[Any], runs: tuple[int, ...]) -> list[Any] | Exception:
    """What the task makes of these numbers, or what it raised."""
    try:
        return list(task(runs))
    except Exception as error:
        return error


class Batches:
    """Batches of runs, as large as about BATCH_SECONDS take, and smaller towards the end."""

    def __init__(self, runs: list[int], workers: int):
        self.left = deque(runs)
        self.again: deque[Batch] = deque()
        self.workers = workers
        self.size = 1

    @property
    def ahead(self) -> int:
        """How many of them a worker has before it: of single runs, which may take long, one."""
        return AHEAD if self.size > 1 else 1

    def next(self) -> Batch | None:
        if self.again:
            return self.again.popleft()
        least = max(1, int(LEAST * self.size))
        size = min(self.size, max(least, len(self.left) // (SHARE * self.workers)), len(self.left))
        return Batch(tuple(self.left.popleft() for _ in range(size))) if size else None

    def took(self, batch: Batch, seconds: float) -> None:
        """A batch has taken so long."""
        self.size = max(1, min(GROWTH * self.size, int(BATCH_SECONDS * len(batch.runs) / max(seconds, 1e-6)), MOST))

    def failed(self, batch: Batch) -> bool:
        """A worker died of a batch; whether it is worth another try."""
        half = (len(batch.runs) + 1) // 2
        if len(batch.runs) == 1 and batch.tried:
            return False
        parts = [batch.runs[:half], batch.runs[half:]]
        self.again.extend(Batch(part, batch.tried + 1) for part in parts if part)
        return True


def on_cores(task: Task[T_co], runs: list[int], workers: int, stop: Callable[[], bool]) -> Iterator[list[T_co]]:
    """What the task makes of these numbers, in batches, in the order in which they finish; once `stop`, asked ten times
    a second, says so, none is begun any more. If it raises, what is under way is given up."""
    batches = Batches(runs, workers)
    if workers == 1:
        yield from here(task, batches, stop)
        return
    alone = (
        sys.platform == "linux" and threading.active_count() == 1
    )  # a fork may inherit locks that other threads hold
    context = multiprocessing.get_context("fork" if alone else "spawn")
    hands: list[Worker] = []
    born_dead = 0

    def replaced(worker: Worker) -> None:
        hands.remove(worker)
        worker.process.join()
        worker.connection.close()
        hands.append(start(context, task, hands))

    def hand_out() -> None:
        nonlocal born_dead
        while True:
            worker = min(hands, key=lambda worker: len(worker.held))
            if len(worker.held) >= batches.ahead or not (batch := batches.next()):
                return
            try:
                worker.connection.send(batch.runs)
            except OSError:  # it was killed
                batches.again.appendleft(batch)
                if worker.held:  # found below
                    return
                replaced(worker)
                born_dead += 1
                if born_dead > MOST_BORN_DEAD:
                    raise RuntimeError(BORN_DEAD) from None
                continue
            worker.since = worker.since if worker.held else time.perf_counter()
            worker.held.append(batch)

    try:
        for _ in range(min(workers, len(runs))):
            hands.append(start(context, task, hands))
            if not stop():
                hand_out()  # to one while the next is made
        while True:
            stopping = stop()
            if not stopping:
                hand_out()
            busy = {worker.connection: worker for worker in hands if worker.held}
            if not busy:
                return
            for ready in wait(list(busy), timeout=0.1):
                worker = busy[cast(Connection, ready)]
                try:
                    rows = worker.connection.recv()
                except (EOFError, OSError):
                    suspect, *others = worker.held
                    batches.again.extendleft(others)
                    replaced(worker)
                    if not batches.failed(suspect):
                        yield [task.lost(suspect.runs[0], end_of(worker.process.exitcode))]
                    continue
                batch, begun = worker.held.popleft(), worker.since
                worker.since = time.perf_counter()
                if isinstance(rows, Exception):
                    raise rows
                born_dead = 0
                batches.took(batch, worker.since - begun)
                if not stopping:
                    hand_out()  # before anybody looks at the rows
                yield rows
    finally:
        for worker in hands:
            if worker.held:
                worker.process.kill()
                worker.process.join()
            else:  # it ends by itself, and that takes a while
                with suppress(OSError):
                    worker.connection.send(())
            worker.connection.close()


def here(task: Task[T_co], batches: Batches, stop: Callable[[], bool]) -> Iterator[list[T_co]]:
    """The same in this process."""
    while batch := batches.next():
        begun = time.perf_counter()
        rows = list(task(batch.runs))
        batches.took(batch, time.perf_counter() - begun)
        yield rows
        if stop():
            return


def start(context: Any, task: Task[Any], others: list[Worker]) -> Worker:
    """A worker more."""
    here, there = context.Pipe()
    forked = context.get_start_method() == "fork"
    inherited = [here, *(other.connection for other in others)] if forked else []
    process = context.Process(target=serve, args=(task, there, inherited), daemon=True)
    process.start()
    there.close()
    return Worker(process, here, deque())


def end_of(code: int | None) -> str:
    """How a process has ended, in words."""
    return f"killed by signal {-code}" if code is not None and code < 0 else f"ended with code {code}"
