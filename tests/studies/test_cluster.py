"""Studies on a cluster of Dask: a real scheduler and real workers, on this machine."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip("distributed", reason="needs the extra cluster")
from omnisim.studies.cluster import ClusterError
from omnisim.studies.study import StudyError
from omnisim.studies.sweep import journal_of, sweep

STUDY = {
    "schema": 1,
    "scene": "kiwi",
    "set": {"time.end": 0.1, "time.output_interval": 0.01},
    "vary": {"friction.coefficient": {"uniform": [-0.05, 0.6]}},
    "design": {"kind": "latin", "count": 60, "seed": 3},
    "measure": {"far": {"dataset": "body/position", "at": "end", "component": "norm"}},
}


def same(one, other):
    for name in one:
        if name != "wall_time":
            np.testing.assert_array_equal(one[name], other[name], err_msg=name)


def start(folder, *words):
    return subprocess.Popen(
        [sys.executable, "-m", "distributed.cli." + words[0], *words[1:]],
        cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
    )  # fmt: skip


@pytest.fixture(params=["1"])
def cluster(tmp_path, request):
    """A scheduler with two workers of so many threads: its address and its processes."""
    file = tmp_path / "scheduler.json"
    processes = [start(tmp_path, "dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(file))]
    for _ in range(2):
        worker = (
            "dask_worker",
            "--scheduler-file",
            str(file),
            "--nthreads",
            request.param,
            "--no-dashboard",
            "--no-nanny",
        )
        processes.append(start(tmp_path, *worker))
    until = time.monotonic() + 60.0
    while not file.exists() and time.monotonic() < until:
        time.sleep(0.05)
    import json

    yield json.loads(file.read_text())["address"], processes
    for process in processes:
        process.kill()
        process.wait()


def test_a_cluster_finds_the_same_bits(cluster):
    address, _ = cluster
    same(sweep(STUDY, cluster=address), sweep(STUDY, workers=1))


@pytest.mark.long
@pytest.mark.parametrize("cluster", ["2"], indirect=True)
def test_threads_of_workers_find_the_same_bits(cluster):
    address, _ = cluster
    same(sweep(STUDY, cluster=address), sweep(STUDY, workers=1))


@pytest.mark.long
def test_a_worker_that_is_killed_loses_nothing(cluster, tmp_path):
    address, (_, worker, _) = cluster
    killed = []

    def watch(done):
        if done.ended > 5 and not killed:
            killed.append(done.ended)
            os.kill(worker.pid, signal.SIGKILL)

    found = sweep(STUDY, tmp_path / "study.h5", cluster=address, progress=watch)
    assert killed and found.complete
    same(found, sweep(STUDY, workers=1))


@pytest.mark.long
def test_a_scheduler_that_vanishes_leaves_what_has_finished(cluster, tmp_path):
    """And what is missing is done elsewhere, with the result of a study that nothing has disturbed."""
    address, (scheduler, *_) = cluster
    path = tmp_path / "study.h5"
    study = STUDY | {"design": STUDY["design"] | {"count": 4000}}

    def watch(done):
        if done.ended > 5:
            scheduler.kill()

    with pytest.raises(ClusterError, match=r"is gone.*--resume goes on"):
        sweep(study, path, cluster=address, progress=watch)
    assert journal_of(path).exists() and not path.exists()
    same(sweep(study, path, resume=True), sweep(study))


@pytest.mark.long
def test_a_cluster_that_is_started_here(tmp_path):
    same(sweep(STUDY, cluster="local", workers=2), sweep(STUDY, workers=1))


def test_an_address_where_nobody_is_is_told(monkeypatch):
    monkeypatch.setattr("omnisim.studies.cluster.PATIENCE", 0.5)
    with pytest.raises(StudyError, match="no scheduler of Dask answers there"):
        sweep(STUDY, cluster="tcp://127.0.0.1:9")
