"""Who does the runs of a study: the same numbers by one process and by several, and by those that replace dead ones."""

import gc
import multiprocessing
import os
import signal
import time

import numpy as np
import pytest
from deadly import Deadly
from studied import DRAWN, SCENE, same

import omnisim
from omnisim.studies.study import load_study
from omnisim.studies.sweep import sweep
from omnisim.studies.task import Task
from omnisim.studies.workers import Batches, on_cores


def test_the_same_bits_by_one_process_and_by_two():
    same(sweep(DRAWN, workers=1), sweep(DRAWN, workers=2))


@pytest.mark.long
def test_a_killed_worker_costs_the_run_that_killed_it():
    study = load_study(DRAWN)
    rows = {row.run: row for rows in on_cores(Deadly(study), list(range(40)), 2, lambda: False) for row in rows}
    assert sorted(rows) == list(range(40))
    assert rows.pop(11).status == "lost: its process was killed by signal 9"
    expected = sweep(DRAWN, workers=1)
    for run, row in rows.items():
        assert row.status == expected["status"][run]
        assert row.measures[0] == (None if np.isnan(expected["far"][run]) else expected["far"][run])


@pytest.mark.long
def test_a_worker_that_is_killed_while_it_waits_is_replaced():
    study = load_study(DRAWN)
    task = Task(study)
    rows = []
    for batch in on_cores(task, list(range(40)), 2, lambda: False):
        if not rows:
            for child in multiprocessing.active_children():
                os.kill(child.pid, signal.SIGKILL)
                child.join()
        rows += batch
    assert sorted(row.run for row in rows) == list(range(40))
    assert not [row for row in rows if row.status.startswith("lost")]


class Moments:
    """When each of these numbers was begun, of batches that take a millisecond for each."""

    def __call__(self, runs):
        begun = time.monotonic()
        time.sleep(1e-3 * len(runs))
        return [begun] * len(runs)

    def lost(self, run, how):
        raise AssertionError(how)


def test_workers_go_on_while_nobody_looks_at_their_rows():
    """As while a journal waits for the disk: not only what was under way, the next batch of each of two is begun."""
    found = on_cores(Moments(), list(range(300)), 2, lambda: False)
    seen = [next(found) for _ in range(4)]
    time.sleep(0.5)
    looked = time.monotonic()
    later = list(found)
    assert sum(map(len, [*seen, *later])) == 300
    assert sum(moments[0] < looked for moments in later) >= 3  # 4


class Searched:
    """How many objects a search for garbage goes through, for each of these numbers; it has many of its own."""

    def __init__(self):
        self.inherited = [[] for _ in range(100_000)]

    def __call__(self, runs):
        return [len(gc.get_objects())] * len(runs)

    def lost(self, run, how):
        raise AssertionError(how)


def test_a_search_for_garbage_in_a_worker_leaves_alone_what_it_has_inherited():
    """To search it is to write on nearly every page of it, which a fork then copies."""
    searched = [count for rows in on_cores(Searched(), list(range(20)), 2, lambda: False) for count in rows]
    assert len(searched) == 20 and max(searched) < 1000  # 3


def test_batches_are_of_a_quarter_of_a_second_and_hand_out_every_run_once():
    batches, sizes, runs = Batches(list(range(3000)), 2), [], []
    while batch := batches.next():
        assert batches.ahead == (2 if batches.size > 1 else 1)  # single runs may be long: none waits behind another
        batches.took(batch, 1e-3 * len(batch.runs))
        sizes.append(len(batch.runs))
        runs += batch.runs
    assert runs == list(range(3000)) and sizes[:4] == [1, 8, 64, 250] and max(sizes) == 250
    assert min(sizes[4:-1]) == 10  # 4 % of the largest


@pytest.mark.long
def test_several_scenes_at_once_come_back_in_their_order():
    scenes = [omnisim.load("kiwi", {**SCENE["set"], "chassis.mass": mass}) for mass in (3.0, 6.0, 4.0)]
    runs = omnisim.simulate_many(scenes, workers=2)
    for run, scene in zip(runs, scenes, strict=True):
        alone = omnisim.simulate(scene)
        assert all(np.array_equal(run[path], alone[path]) for path in alone)
    with pytest.raises(omnisim.SceneError, match="no file and no packaged scene"):
        omnisim.simulate_many(["kiwi", "kiwy"])
