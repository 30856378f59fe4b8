"""Runs on a cluster, by Dask distributed: the same tasks, the same rows."""

import errno
import logging
import pickle
import time
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any

from omnisim.base.formatting import visible
from omnisim.studies.study import StudyError
from omnisim.studies.task import Row, Task
from omnisim.studies.workers import AHEAD, Batch, Batches, cores

PATIENCE = 10.0  # s, in which a scheduler answers
LOCAL = "local"
LOG = logging.getLogger(__name__)


class ClusterError(OSError):
    """The scheduler cannot be reached, or is gone; the message says what to do."""


def on_cluster(
    task: Task, runs: list[int], address: str, workers: int | None, stop: Callable[[], bool]
) -> Iterator[list[Row]]:
    """As `on_cores`, by the workers of a scheduler at this address, "local" for one that is started here. Where
    its dashboard is goes to the log.

    Raises StudyError if nobody answers, ClusterError if the scheduler vanishes.
    """
    try:
        from distributed import Client, LocalCluster, as_completed
        from distributed.client import FutureCancelledError
        from distributed.scheduler import KilledWorker
    except ModuleNotFoundError:
        raise StudyError("a cluster needs Dask: pip install 'omnisim-engine[cluster]'") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # it would show tracebacks of what is told here
    started: Any = None
    shown = visible(address)
    try:
        if address == LOCAL:
            started = LocalCluster(n_workers=workers or cores(), threads_per_worker=1)
        client = Client(started or address, timeout=PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(f"--cluster {shown}: no scheduler of Dask answers there: {visible(str(error))}") from None
    LOG.info("dashboard of the cluster: %s", client.dashboard_link)
    batches = Batches(runs, max(1, sum(client.nthreads().values())))
    packed = pickle.dumps(task)
    waiting: dict[Any, Batch] = {}
    queue = as_completed()

    def refill() -> None:
        while len(waiting) < AHEAD * batches.workers and not stop() and (batch := batches.next()):
            future = client.submit(run_batch, packed, batch.runs, pure=False)
            waiting[future] = batch
            queue.add(future)

    try:
        refill()
        while waiting:
            future = next(queue)
            batch = waiting.pop(future)
            try:
                rows, seconds = future.result()
                batches.took(batch, seconds)
                yield rows
            except KilledWorker:  # it has died of the batch several times
                if not batches.failed(batch):
                    yield [task.lost(batch.runs[0], "killed on the cluster")]
            refill()
    except (OSError, TimeoutError, FutureCancelledError) as error:
        raise ClusterError(
            errno.EIO, f"the scheduler at {shown} is gone; --resume goes on ({visible(str(error))})"
        ) from None
    finally:
        client.close(timeout=2)
        if started:
            started.close()


def run_batch(packed: bytes, runs: tuple[int, ...]) -> tuple[list[Row], float]:
    """Rows of these runs, and the time that they took, s; on a worker."""
    task = unpacked(packed)
    begun = time.perf_counter()
    return task(runs), time.perf_counter() - begun


@lru_cache(maxsize=2)
def unpacked(packed: bytes) -> Task:
    """The task of a study, made once on a worker."""
    return pickle.loads(packed)
