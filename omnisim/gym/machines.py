"""Machines of one kind side by side: their arrays stand along a first axis, and all cores march them at once.

Each machine is a run of its own. Which thread marches it, and with which others, changes no bit of it.
"""

import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from itertools import pairwise
from typing import Any

import numpy as np

from omnisim.base import status
from omnisim.base.calls import direct
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import DRIVE_INPUT, Parameters
from omnisim.dynamics.state import YAW, Run, places_in
from omnisim.march.initial_state import begin
from omnisim.march.many import march_each
from omnisim.run.marching import FOR_EVER, Marching
from omnisim.run.sensors import to_centre
from omnisim.scene.schema import Config

WORTH_SHARING = 5e-4  # s of marching: to wake a thread and to be woken takes about 1e-4 s


class OtherKind(ValueError):
    """A machine that cannot stand beside the others."""


class Machines:
    """So many machines, at first all of one scene, marched by so many threads where that is worth it.

    config: of a scene without rows between its start and its end, and without knots in its tables.
    """

    def __init__(self, config: Config, count: int, threads: int):
        shares = max(1, min(threads, count))
        self.scratch = [Marching(config) for _ in range(shares)]  # rows and log of each thread, and what is copied
        self.first = self.scratch[0]
        self.bounds = np.linspace(0, count, shares + 1).astype(int).tolist()
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
        place(self.parameters, with_piece(parameters), who)
        place(self.runs, run, who)
        self.clock["goal"][who], self.clock["pause"][who] = 0, FOR_EVER

    def drive(self, who: np.ndarray, wheels: np.ndarray, values: np.ndarray) -> None:
        """Give drives (D,) of the machines `who` (N,) their inputs (N, D) from now on, as a Loop does."""
        starts, inputs = self.parameters.starts, self.parameters.inputs
        self.clock["piece"][who] = 0
        starts[who, 1] = self.clock["step"][who] * self.clock["dt"][who]
        given = inputs[:, 1, :, 0]  # a view
        given[np.ix_(who, DRIVE_INPUT + wheels)] = values[who]

    def march(self, who: np.ndarray, steps: int) -> None:
        """March the machines `who` (N,) on by so many steps, or up to where something stops them."""
        self.clock["goal"][who] = np.minimum(self.clock["step"][who] + steps, self.clock["steps"][who])
        threads = len(self.scratch) if self.work > WORTH_SHARING else 1
        begun = time.perf_counter()
        if threads == 1:
            self._march(0, 0, self.bounds[-1])
        else:
            self._share()
        self.work = threads * (time.perf_counter() - begun)

    def _share(self) -> None:
        if not self.pool:
            self.pool = ThreadPoolExecutor(len(self.scratch) - 1, "omnisim")
        first, *others = [(share, *ends) for share, ends in enumerate(pairwise(self.bounds))]
        shares = [self.pool.submit(self._march, *other) for other in others]
        try:
            self._march(*first)  # by the thread that asks
            for share in shares:
                share.result()
        finally:
            wait(shares)  # after Ctrl-C too: nobody may touch a machine that marches

    def _march(self, share: int, first: int, last: int) -> None:
        own = self.scratch[share]
        direct(march_each, self.parameters, own.stages, self.runs, own.rows, own.log, first, last)

    def close(self) -> None:
        if self.pool:
            self.pool.shutdown()

    @property
    def pose(self) -> np.ndarray:
        """Of the chassis origins or wheel centres (N, 3): x, y, m, and yaw, rad."""
        pose = self.runs.y[:, : YAW + 1].copy()
        pose[:, :YAW] -= self._to_centre().T
        return pose

    @property
    def twist(self) -> np.ndarray:
        """Of the same points (N, 3), world axes: m/s, m/s, rad/s."""
        twist = self.runs.y[:, self.at.velocity : self.at.yaw_rate + 1].copy()
        x, y = self._to_centre()
        twist[:, 0] += twist[:, 2] * y
        twist[:, 1] -= twist[:, 2] * x
        return twist

    @property
    def spin_rates(self) -> np.ndarray:
        """(N, W), rad/s"""
        return self.runs.y[:, self.at.spin_rate :][:, : self.runs.rates.shape[1]]

    @property
    def normal_forces(self) -> np.ndarray:
        """Of the floor on the wheels (N, W), N; 0 of a wheel in the air."""
        loaded = np.asarray(self.runs.mode)["loaded"] > 0
        return np.where(loaded, np.maximum(np.asarray(self.runs.monitors)["normal_force"], 0.0), 0.0)

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

    def _to_centre(self) -> np.ndarray:
        return to_centre(np.asarray(self.parameters.machine)["centre"].T, self.runs.y[:, YAW])


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
    return found.view(np.recarray) if found.dtype.names else found


def place(whole: Any, part: Any, who: np.ndarray) -> None:
    """Put what was not stacked in these places. Raises OtherKind where it has another shape."""
    if isinstance(whole, tuple) and isinstance(part, tuple):
        for inner, own in zip(whole, part, strict=True):
            place(inner, own, who)
    elif (whole is None) != (part is None) or (part is not None and whole.shape[1:] != np.shape(part)):
        raise OtherKind("machines side by side have the same wheels, rollers, drives and methods")
    elif part is not None:
        whole[who] = part
