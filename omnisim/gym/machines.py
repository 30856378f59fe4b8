"""Machines of one kind side by side: their arrays stand along a first axis, and all cores march them at once.

Each machine is a run of its own. Which thread marches it, and with which others, changes no bit of it.
"""

import math
import time
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any

import numpy as np

from omnisim.base import status
from omnisim.base.calls import direct
from omnisim.base.records import LeanRecords, lean, recorded
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import MACHINE, Parameters
from omnisim.dynamics.state import Run, places_in
from omnisim.gym.instants import drive_each, observe_each
from omnisim.gym.paths import Path
from omnisim.march.initial_state import begin
from omnisim.march.many import march_each
from omnisim.run.marching import FOR_EVER, Marching
from omnisim.scene.schema import Config

WORTH_SHARING = 5e-4  # s of marching: to wake a thread and to be woken takes about 1e-4 s
PIECE = 2e-4  # s of marching, that a thread takes upon itself at least: to hand it over takes about 2e-5 s


class OtherKind(ValueError):
    """A machine that cannot stand beside the others."""


class Machines:
    """So many machines, at first all of one scene, marched by so many threads where that is worth it.

    config: of a scene without rows between its start and its end, and without knots in its tables.
    """

    def __init__(self, config: Config, count: int, threads: int):
        threads = max(1, min(threads, count))
        self.scratch = [Marching(config) for _ in range(threads)]  # rows and log of each thread, and what is copied
        self.first = self.scratch[0]
        self.parameters: Parameters = stacked([with_piece(self.first.parameters)] * count)
        self.runs: Run = stacked([self.first.run] * count)
        self.clock = np.asarray(self.runs.clock)
        self.clock["goal"], self.clock["pause"] = 0, FOR_EVER
        self.at = places_in(self.first.parameters)
        self.pool: ThreadPoolExecutor | None = None
        self.work = 0.0  # s, that the last march took one thread, about
        self._march(0, 0, count)  # compiles, before several threads need it

    def put(self, who: np.ndarray, config: Config) -> None:
        """The machines `who`, by number, at the start of this scene. Raises OtherKind if it has other parts than the
        first."""
        parameters, run = self.first.parameters, self.first.run  # which never march
        if config is not self.first.config:
            parameters = pack(config)
            run = begin(config, parameters)
        if lean(self.parameters.machine.dtype) and not lean(parameters.machine.dtype):
            self._widen()
        place(self.parameters, with_piece(parameters), who)
        place(self.runs, run, who)
        self.clock["goal"][who], self.clock["pause"][who] = 0, FOR_EVER

    def _widen(self) -> None:
        """Let machines have what few have: from now on they are marched by kernels that know all of it."""
        machines: Any = np.array(self.parameters.machine, recorded(MACHINE)).view(np.recarray)
        self.parameters = self.parameters._replace(machine=machines)
        self._march(0, 0, 0)  # compiles, before several threads need it

    def drive(self, who: np.ndarray, wheels: np.ndarray, values: np.ndarray) -> None:
        """Give the drives of these wheels (D,) inputs (N, D) from now on, as a Loop does; of machines `who` (N,)."""
        tables = self.parameters.starts, self.parameters.inputs
        values = np.ascontiguousarray(values)  # which `direct` cannot tell from others
        direct(drive_each, who, wheels, values, self.runs.clock, *tables)

    def march(self, who: np.ndarray, steps: int) -> None:
        """March the machines `who` (N,) on by so many steps, or up to where something stops them."""
        self.clock["goal"][who] = np.minimum(self.clock["step"][who] + steps, self.clock["steps"][who])
        threads = len(self.scratch) if self.work > WORTH_SHARING else 1
        begun = time.perf_counter()
        if threads == 1:
            self._march(0, 0, len(self.clock))
        else:
            self._share()
        if steps:
            self.work = threads * (time.perf_counter() - begun)

    def _share(self) -> None:
        if not self.pool:
            self.pool = ThreadPoolExecutor(len(self.scratch) - 1, "omnisim")
        count, threads = len(self.clock), len(self.scratch)
        left = deque(pieces(count, threads, math.ceil(count * PIECE / max(self.work, PIECE))))
        others: list[Future[None]] = []
        try:
            others.extend(self.pool.submit(self._march_some, i, left) for i in range(1, threads))
            self._march_some(0, left)  # by the thread that asks
            for other in others:
                other.result()
        finally:
            wait(others)  # after Ctrl-C too: nobody may touch a machine that marches

    def _march_some(self, thread: int, left: deque[tuple[int, int]]) -> None:
        """March one piece of the machines after the other until none is left: a thread that others slow down takes
        fewer."""
        while True:
            try:
                piece = left.popleft()
            except IndexError:
                return
            self._march(thread, *piece)

    def _march(self, thread: int, first: int, last: int) -> None:
        own = self.scratch[thread]
        direct(march_each, self.parameters, own.stages, self.runs, own.rows, own.log, first, last)

    def close(self) -> None:
        if self.pool:
            self.pool.shutdown()

    def observe(self, path: Path, steps: np.ndarray, loads: bool, observed: np.ndarray) -> None:
        """Observations (N, O) of all machines, each after so many steps (N,) of the path."""
        runs, at = self.runs, self.at
        places = at.velocity, at.yaw_rate, at.spin_rate
        records = self.parameters.machine, runs.mode, runs.monitors
        direct(observe_each, runs.y, places, records, path, steps, loads, observed)

    @property
    def failed(self) -> np.ndarray:
        """Which (N,) have been stopped before their end."""
        found = self.clock["status"]
        return (found != status.RUNNING) & (found != status.COMPLETE)

    def sentence(self, i: int) -> str:
        """How the run of machine i has ended."""
        clock, config = self.runs.clock[i], self.first.config
        wheel = config.wheels[int(clock.wheel)].name
        elapsed = int(clock.step) * float(clock.dt) + float(clock.elapsed)
        return status.sentence(clock, elapsed, wheel, config.solver.method)


def pieces(count: int, threads: int, least: int) -> Iterator[tuple[int, int]]:
    """So many machines in pieces, first and last: each half of a fair share of what is left, and no shorter than the
    least but for the last."""
    first = 0
    while first < count:
        last = min(first + max((count - first) // (2 * threads), least), count)
        yield first, last
        first = last


def with_piece(parameters: Parameters) -> Parameters:
    """Parameters whose tables have one more piece, which an input from outside begins."""
    inputs = np.concatenate([parameters.inputs, parameters.inputs])
    return parameters._replace(starts=np.array([0.0, np.inf]), inputs=inputs)


def stacked(parts: Sequence[Any]) -> Any:
    """Arrays, records, and NamedTuples of such along a first axis. What is None stays None."""
    first = parts[0]
    if first is None:
        return None
    if isinstance(first, tuple):
        return type(first)(*map(stacked, zip(*parts, strict=True)))
    found = np.stack(parts)
    if not found.dtype.names:
        return found
    return found.view(LeanRecords if lean(found.dtype) else np.recarray)


def place(whole: Any, part: Any, who: np.ndarray) -> None:
    """Put what was not stacked in these places. Raises OtherKind where it has another shape."""
    if isinstance(whole, tuple) and isinstance(part, tuple):
        for inner, own in zip(whole, part, strict=True):
            place(inner, own, who)
    elif (whole is None) != (part is None) or (part is not None and whole.shape[1:] != np.shape(part)):
        raise OtherKind("machines side by side have the same wheels, rollers, drives and methods")
    elif part is not None:
        whole[who] = part
