"""The memory of a machine: every array that its kernels know in one block of bytes, each at a place that never changes.

Whoever has the block can march: a copy of it is a saved state, and a new machine begins as a copy of the packed start.
"""

from typing import Any, NamedTuple

import numpy as np

from omnisim.base.copying import copied
from omnisim.base.records import blank
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.spatial.records import SPATIAL_MONITORS
from omnisim.dynamics.state import MONITORS, Recording
from omnisim.march.initial_state import blank_rows
from omnisim.march.observation import OBSERVED_WHEEL, Observed
from omnisim.run.marching import FOR_EVER, Start, blank_log, packed
from omnisim.scene.schema import Config

ALIGNMENT = 64  # bytes


class Machine(NamedTuple):
    """A scene at its start, as kernels are called: the arguments of `march` and of `observe`, which has a row and
    workspace of its own."""

    marched: tuple[Any, ...]
    observed: tuple[Any, ...]

    @property
    def parameters(self) -> Parameters:
        return self.marched[0]


def machine_of(config: Config, stages: Any) -> Machine:
    """The machine of a scene before it stands on the floor, which the first march sees to. stages: of its method.

    Each march ends with an output row, the second of two, and no march is the last. Nothing but the log is left as
    memory happens to be: what is made of a scene is the same every time. Raises ConfigError if a machine free in space
    cannot begin where it is put.
    """
    parameters, run = with_piece(packed(config))
    clock = run.clock
    clock["steps"] = clock["steps_per_row"] = clock["pause"] = FOR_EVER
    clock["goal"] = 0
    run = run._replace(trial=np.zeros_like(run.y))
    row, rows = cleared(blank_rows(run, 1)), cleared(blank_rows(run, 2))
    own = parameters._replace(workspace=copied(parameters.workspace))
    wheels, rollers = run.rates.shape
    monitors = blank(MONITORS if parameters.space is None else SPATIAL_MONITORS, wheels)
    observed = Observed(
        slopes=np.zeros_like(row.y),
        servo=np.zeros((1, 2)),
        wheels=blank(OBSERVED_WHEEL, 1, wheels),
        joint_rate=np.zeros((0, wheels, rollers)),
        motion=np.zeros((3, 0, wheels, rollers, 3)),
        bearing_loads=np.zeros((0, wheels, 2, 3, rollers + 1)),
        energies=np.zeros((0 if parameters.space is None else 1, 3)),
    )
    marched = parameters, stages, run, rows, blank_log()
    return Machine(marched, (own, row, np.zeros(1), monitors, observed))


def cleared(rows: Recording) -> Recording:
    """Rows of zeros in the place of these."""
    zeros: list[Any] = [np.zeros_like(part) for part in rows]
    return Recording(*zeros)


def with_piece(start: Start) -> Start:
    """The start with room for one more piece, which an input from outside begins; those that are past make room."""
    parameters, run = start
    starts = np.append(parameters.starts, np.inf)
    inputs = np.concatenate([parameters.inputs, np.zeros((1, *parameters.inputs.shape[1:]))])
    return Start(parameters._replace(starts=starts, inputs=inputs), run)


class Memory:
    """Where each array of a machine stands in the block, the log of events last, and what the block holds at first.

    size: of the block, bytes; kept: of its part before the log, which is all that a state needs.
    """

    def __init__(self, machine: Machine):
        log = machine.marched[-1]
        self.arrays: dict[int, tuple[int, Any]] = {}  # place and array, by identity
        self.kept = self.size = 0
        self._add(machine.marched[:-1])
        self._add(machine.observed)
        self.kept = self.size
        self._add(log)

    def __getitem__(self, array: Any) -> int:
        """Where an array begins, bytes."""
        return self.arrays[id(array)][0]

    def field(self, array: Any, name: str, *index: int) -> int:
        """Where a field of a record begins, or of one of an array of records."""
        offset = array.dtype.fields[name][1]
        return self.element(array, *index) + offset if index else self[array] + offset

    def element(self, array: np.ndarray, *index: int) -> int:
        """Where an element of an array begins."""
        return self[array] + sum(i * stride for i, stride in zip(index, array.strides, strict=True))

    @property
    def start(self) -> bytes:
        """The part before the log, as a machine begins."""
        content = bytearray(self.kept)
        for place, array in self.arrays.values():
            if place < self.kept:
                content[place : place + array.nbytes] = array.tobytes()
        return bytes(content)

    def _add(self, value: Any) -> None:
        if isinstance(value, tuple):
            for part in value:
                self._add(part)
        elif isinstance(value, np.ndarray | np.void) and id(value) not in self.arrays:
            self.arrays[id(value)] = self.size, value
            self.size += -(-max(value.nbytes, 1) // ALIGNMENT) * ALIGNMENT
