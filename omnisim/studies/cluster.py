"""Runs on a cluster, by Dask distributed: the same tasks, the same rows."""

import time
from collections.abc import Callable, Iterator
from typing import Any

from omnisim.base.formatting import visible
from omnisim.studies.study import StudyError
from omnisim.studies.task import Row, Task
from omnisim.studies.workers import Batch, Batches, cores

AHEAD = 2  # batches that each core of the cluster has before it
LOCAL = "local"


class ClusterError(OSError):
    """The scheduler cannot be reached, or is gone; the message says what to do."""


def on_cluster(
    task: Task, runs: list[int], address: str, workers: int | None, stop: Callable[[], bool]
) -> Iterator[list[Row]]:
    """As `on_cores`, by the workers of a scheduler at this address, "local" for one that is started here.

    Raises ClusterError.
    """
    try:
        from distributed import Client, LocalCluster, as_completed
        from distributed.scheduler import KilledWorker
    except ModuleNotFoundError:
        raise ImportError("a cluster needs Dask: pip install 'omnisim-engine[cluster]'") from None
    started: Any = None
    shown = visible(address)
    try:
        if address == LOCAL:
            started = LocalCluster(n_workers=workers or cores(), threads_per_worker=1)
        client = Client(started or address, timeout="10s")
    except (OSError, ValueError, TimeoutError) as error:
        raise StudyError(f"--cluster {shown}: no scheduler of Dask answers there: {visible(str(error))}") from None
    try:
        hands = max(1, sum(client.nthreads().values()))
        batches = Batches(runs, hands)
        everywhere = client.scatter(task, broadcast=True)
        waiting: dict[Any, Batch] = {}
        queue = as_completed()

        def refill() -> None:
            while len(waiting) < AHEAD * hands and not stop() and (batch := batches.next()):
                future = client.submit(run_batch, everywhere, batch.runs, pure=False)
                waiting[future] = batch
                queue.add(future)

        refill()
        while waiting:
            future = next(queue)
            batch = waiting.pop(future)
            try:
                rows, seconds = future.result()
            except KilledWorker:
                if not batches.failed(batch):
                    yield [task.lost(batch.runs[0], "killed on the cluster")]
                refill()
                continue
            batches.took(batch, seconds)
            yield rows
            refill()
    except (OSError, TimeoutError) as error:
        raise ClusterError(5, f"the scheduler at {shown} is gone ({visible(str(error))}); --resume goes on") from None
    finally:
        client.close(timeout=2)
        if started:
            started.close()


def run_batch(task: Task, runs: tuple[int, ...]) -> tuple[list[Row], float]:
    """Rows of these runs, and the time that they took, s; on a worker."""
    begun = time.perf_counter()
    return [task(run) for run in runs], time.perf_counter() - begun
