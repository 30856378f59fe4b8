"""One march of a scene, from its packed numbers to the rows that it records."""

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from omnisim.base import status
from omnisim.base.calls import at_once, direct
from omnisim.base.copying import Template
from omnisim.base.keeping import Ask, alone, kept
from omnisim.base.methods import METHODS
from omnisim.base.status import EVENTS_PER_STEP
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import Parameters
from omnisim.dynamics.state import Run
from omnisim.march.event_log import EVENT
from omnisim.march.initial_state import begin, blank_rows, unwritten
from omnisim.march.march import march
from omnisim.results.assembly import Ending, outcome, so_far
from omnisim.results.observables import Observables
from omnisim.scene.schema import Config

FOR_EVER = np.iinfo(np.int64).max


class Start(NamedTuple):
    """A scene as it begins."""

    parameters: Parameters
    run: Run


def packed(config: Config, ask: Ask[Config] = alone) -> Start:
    """The scene as it begins; ask: see `pack`."""
    parameters = pack(config, ask)
    return Start(parameters, begin(config, parameters, ask))


class Beginning:
    """A scene as it begins, for runs that may write into it: packed for the first, as many a scene runs but once, and
    copied for all others. Templates are two: a trajectory may hold the parameters for long."""

    def __init__(self, config: Config):
        self._config = config
        self._ran = False
        self._templates: tuple[Template[Parameters], Template[Run]] | None = None

    def start(self) -> Start:
        """For one more run."""
        if not self._ran:
            self._ran = True
            return packed(self._config)
        if self._templates is None:
            start = packed(self._config)
            self._templates = Template(start.parameters), Template(start.run)
        parameters, run = self._templates
        return Start(parameters.copy(), run.copy())


@kept
def beginning(config: Config) -> Beginning:
    return Beginning(config)


def packed_once(config: Config) -> Start:
    """The scene as it begins, for one run, which may write into it."""
    return beginning(config).start()


def blank_log() -> np.ndarray:
    """Space for events."""
    return unwritten(EVENT, 4 * EVENTS_PER_STEP)


class Marching:
    """A march as far as it has come: parameters, the run, its rows and events, and the wall time that it took, s.

    log: where its events go, by default one of its own; runs of which nobody reads them may have one in common. start:
    what the scene begins with, packed anew unless it is given. odometry: whether extremes of its error are followed, if
    the machine has any. Raises MemoryError if the rows do not fit into memory.
    """

    _known: Callable[..., int] | None = None  # see _kernel

    def __init__(
        self, config: Config, log: np.ndarray | None = None, start: Start | None = None, odometry: bool = True
    ):
        self.config = config
        self.stages = METHODS[config.solver.method].stages
        self.parameters, self.run = start or packed(config)
        followed = odometry and bool(self.parameters.machine["odometry"])
        self.rows = blank_rows(self.run, config.time.outputs + 1, config.bearing_loads, followed)
        self.log = blank_log() if log is None else log
        self.wall_time = 0.0

    def march(self, work: int = FOR_EVER) -> int:
        """March up to the goal, or for about so many right-hand sides; the status. The first call finds the rollers in
        contact, and loads or compiles the kernels."""
        clock = self.run.clock
        clock["pause"] = FOR_EVER if work == FOR_EVER else min(int(clock["rhs"]) + work, FOR_EVER)
        begun = time.perf_counter()
        result = self._march()
        while result == status.LOG_FULL:
            self.log = np.concatenate([self.log, np.zeros_like(self.log)])
            result = self._march()
        self.wall_time += time.perf_counter() - begun
        return result

    @property
    def loaded(self) -> bool:
        """Whether its kernels are."""
        return self._kernel is not None

    def _march(self) -> int:
        kernel = self._kernel
        return kernel(*self._arguments) if kernel else direct(march, *self._arguments)

    @property
    def _kernel(self) -> Callable[..., int] | None:
        """What `direct` calls at once, found only once."""
        self._known = self._known or at_once(march, self._arguments)
        return self._known

    @property
    def _arguments(self) -> tuple:
        return self.parameters, self.stages, self.run, self.rows, self.log

    def observables(self) -> Observables:
        """The datasets of the rows so far."""
        rows = so_far(self.rows, int(self.run.clock["row"]))
        return Observables(self.parameters, rows, self.config.time.output_interval, self.config)

    def ending(self) -> Ending:
        """How the march has ended, or would if it were left here."""
        return outcome(self.config, self.run, self.observables())
