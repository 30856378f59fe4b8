"""A scene that is stepped from outside: a controller sets the inputs of its drives between the steps.

    loop = omnisim.Loop(omnisim.load("youbot"))
    while loop.time < 2.0:
        loop.command(0.3, 0.0, 0.1 * (1.0 - loop.yaw))        a twist; or loop.drive("front_left", 0.2)
        loop.advance(0.01)
    loop.trajectory().save("controlled.h5")

Nothing is compiled again: inputs are the tables that the kernels read anyway. What a controller sets is one more piece
of them, held from then on, and the trajectory's scene has it as tables, so that loading it repeats the run.
"""

import math
import time
import tomllib
from dataclasses import replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from omnisim import status
from omnisim.collect import collect
from omnisim.direct import direct
from omnisim.events import EVENT
from omnisim.ideal import wheel_rows
from omnisim.packing import pack
from omnisim.parameters import DRIVE, Parameters
from omnisim.records import blank
from omnisim.scene import Scene, SceneError
from omnisim.start import begin, blank_rows
from omnisim.state import YAW, Places, X, Y, places_in
from omnisim.status import EVENTS_PER_STEP
from omnisim.stepper import march
from omnisim.tableau import METHODS
from omnisim.toml_text import MISSING, assign, rewrite
from omnisim.trajectory import Trajectory

ON_GRID = 1e-9  # relative, of times that must be multiples of the step
FOR_EVER = np.iinfo(np.int64).max


class Loop:
    """One run of a scene, as far as it has come, with the step that the scene gives: none is picked for `solver.error`.

    Raises SceneError if the scene gives no step, or if the rows of all of it do not fit into memory.
    """

    def __init__(self, scene: Scene):
        self.scene = scene = stepped(scene)
        self.stages = METHODS[scene.config.solver.method].stages
        self.parameters: Parameters = pack(scene.config)
        self.run = begin(scene.config, self.parameters)
        try:
            count, machine = scene.config.time.outputs + 1, self.parameters.machine
            self.rows = blank_rows(self.run, count, scene.config.bearing_loads, bool(machine.odometry))
        except MemoryError as error:
            raise SceneError(f"{scene.source}: time.output_interval: too many rows for the memory: {error}") from None
        self.log = blank(EVENT, 4 * EVENTS_PER_STEP)
        self.wall_time = 0.0
        self._at: Places = places_in(self.parameters)
        self._dt = float(self.run.clock.dt)
        self._driven: set[int] = set()
        self._pieces = len(self.parameters.starts)  # of the tables; there may be room for more
        self._followers = [w for w, wheel in enumerate(scene.config.wheels) if wheel.drive.controlled]
        self.names = MappingProxyType({wheel.name: w for w, wheel in enumerate(scene.config.wheels)})
        self.march(0)  # finds the rollers in contact; the first call loads or compiles the kernels
        self.wall_time = 0.0

    def march(self, work: int = FOR_EVER) -> int:
        """March up to the goal, or for about so many right-hand sides; the status."""
        clock = self.run.clock
        clock["pause"] = FOR_EVER if work == FOR_EVER else min(int(clock["rhs"]) + work, FOR_EVER)
        begun = time.perf_counter()
        result = direct(march, self.parameters, self.stages, self.run, self.rows, self.log)
        while result == status.LOG_FULL:
            self.log = np.concatenate([self.log, np.zeros_like(self.log)]).view(np.recarray)
            result = direct(march, self.parameters, self.stages, self.run, self.rows, self.log)
        self.wall_time += time.perf_counter() - begun
        return result

    def advance(self, seconds: float) -> bool:
        """March on by a multiple of the scene's step; whether the run goes on after that.

        False at the end of the scene, or where something stopped the run: `status` says what. Raises ValueError for a
        time that is no multiple of the step.
        """
        steps = round(seconds / self._dt) if math.isfinite(seconds) else 0
        if steps < 1 or abs(seconds - steps * self._dt) > ON_GRID * seconds:
            raise ValueError(f"{seconds!r} s is no multiple of the scene's step, {self._dt:g} s")
        clock = self.run.clock
        clock["goal"] = min(int(clock["step"]) + steps, self.scene.config.time.steps)
        return self.march() == status.RUNNING

    def drive(self, wheel: str, value: float) -> None:
        """Give a drive its input from now on: by its kind torque (N m), target rate (rad/s) or voltage (V).

        Raises KeyError for an unknown wheel, ValueError for a drive without input or a number that is not finite.
        """
        w = self.names[wheel]
        drive = self.scene.config.wheels[w].drive
        if drive.given is None:
            raise ValueError(f"wheel '{wheel}' has a drive of kind '{drive.kind}', which takes no input")
        self._set({w: value})

    def command(self, vx: float, vy: float, yaw_rate: float) -> None:
        """Give all drives that follow a rate those of this twist of the chassis from now on (m/s, rad/s, its axes).

        Raises ValueError if the machine has no such drive, or for a number that is not finite.
        """
        if not self._followers:
            raise ValueError("no wheel has a drive of kind 'rate' or a controlled motor, which could follow a command")
        rates = (self._rows @ (vx, vy, yaw_rate)).tolist()
        self._set({w: rates[w] for w in self._followers})

    @property
    def time(self) -> float:
        """s"""
        return int(self.run.clock["step"]) * self._dt

    @property
    def status(self) -> str:
        """ "running", or how the run ended, as the trajectory's status has it."""
        running = self.run.clock.status == status.RUNNING
        return "running" if running else self.trajectory().attributes["status"]

    @property
    def yaw(self) -> float:
        """rad"""
        return float(self.run.y[YAW])

    @property
    def yaw_rate(self) -> float:
        """rad/s"""
        return float(self.run.y[self._at.yaw_rate])

    @property
    def position(self) -> np.ndarray:
        """Of the chassis origin or the centre of a bare wheel: x, y, m."""
        return self.run.y[[X, Y]] - self._to_centre()

    @property
    def velocity(self) -> np.ndarray:
        """Of the same point: x, y, m/s, world axes."""
        x, y = self._to_centre()
        v = self._at.velocity
        return self.run.y[v : v + 2] + self.yaw_rate * np.array([y, -x])

    @property
    def spin_angles(self) -> np.ndarray:
        """Of all wheels in the order of the scene (W,), rad."""
        return self.run.y[self._at.spin_angle :][: len(self.names)].copy()

    @property
    def spin_rates(self) -> np.ndarray:
        """Of all wheels (W,), rad/s."""
        return self.run.y[self._at.spin_rate :][: len(self.names)].copy()

    @property
    def odometry(self) -> np.ndarray:
        """Pose that ideal wheels without slip would report: x, y, yaw (m, rad).

        Raises ValueError for a machine whose wheels tell no pose.
        """
        if not self.parameters.machine.odometry:
            raise ValueError("the spin rates of this machine's wheels tell no pose")
        yaw = self.parameters.machine.odometry_yaw + self.spin_angles @ self.parameters.wheels.odometry[:, 2]
        return np.append(self.run.y[self._at.odometry : self._at.odometry + 2], yaw)

    def trajectory(self) -> Trajectory:
        """The run so far, at the output times it has passed."""
        if self._driven:
            self.march(0)  # takes over what was set last
        return collect(self._scene(), self.parameters, self.run, self.rows, self.log, self.wall_time)

    def _to_centre(self) -> np.ndarray:
        """C from the chassis origin, world axes, m."""
        (x, y), yaw = self.parameters.machine.centre, self.run.y[YAW]
        return np.array([x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw)])

    @cached_property
    def _rows(self) -> np.ndarray:
        return wheel_rows(self.scene.config)

    def _set(self, values: dict[int, float]) -> None:
        """Hold these inputs of drives from now on: a piece of the tables begins here, later ones keep the rest."""
        if not all(map(math.isfinite, values.values())):
            raise ValueError(f"inputs of drives must be finite numbers: {values}")
        here, piece, pieces = self.time, int(self.run.clock["piece"]) + 1, self._pieces
        if piece == pieces or self.parameters.starts[piece] > here:  # none begins here yet
            if pieces == len(self.parameters.starts):
                self._make_room()
            starts, inputs = self.parameters.starts, self.parameters.inputs
            if piece < pieces:
                starts[piece + 1 : pieces + 1] = starts[piece:pieces].copy()
                inputs[piece + 1 : pieces + 1] = inputs[piece:pieces].copy()
            starts[piece], inputs[piece] = here, inputs[piece - 1]
            inputs[piece, :, 0] += inputs[piece, :, 1] * (here - starts[piece - 1])
            self._pieces += 1
        for w, value in values.items():
            self.parameters.inputs[piece : self._pieces, DRIVE + w] = value, 0.0
            self._driven.add(w)

    def _make_room(self) -> None:
        """Room for as many pieces again; those that are not there yet never begin."""
        starts, inputs = self.parameters.starts, self.parameters.inputs
        more = max(64, len(starts))
        starts = np.concatenate([starts, np.full(more, np.inf)])
        inputs = np.concatenate([inputs, np.zeros((more, *inputs.shape[1:]))])
        self.parameters = self.parameters._replace(starts=starts, inputs=inputs)

    def _scene(self) -> Scene:
        """The scene with all that was set as tables of the drives."""
        if not self._driven:
            return self.scene
        data, edits = tomllib.loads(self.scene.text), []
        for w in sorted(self._driven):
            times, values = self._table(DRIVE + w)
            given = self.scene.config.wheels[w].drive.given
            edits += [(("wheels", w, "drive", "times"), times), (("wheels", w, "drive", given), values)]
        for path, value in edits:
            assign(data, path, value)
        if all(w in self._driven for w, wheel in enumerate(self.scene.config.wheels) if wheel.drive.follows_command):
            data.pop("command", None)  # nobody follows it any more
        return replace(self.scene, text=rewrite(self.scene.text, edits, data))

    def _table(self, channel: int) -> tuple[list[float], list[float]]:
        """Times and values of an input, so far and as they would go on."""
        starts, inputs = self.parameters.starts, self.parameters.inputs[:, channel]
        times, values = [], []
        for piece in range(self._pieces):
            value = inputs[piece, 0]
            if piece:
                times.append(float(starts[piece]))
                values.append(float(inputs[piece - 1, 0] + inputs[piece - 1, 1] * (starts[piece] - starts[piece - 1])))
            times.append(float(starts[piece]))
            values.append(float(value))
        return times, values


def stepped(scene: Scene) -> Scene:
    """The scene without `solver.error`, so that loading what the loop has done repeats it."""
    config = scene.config
    if config.solver.error is None:
        return scene
    if config.time.step is None:
        raise SceneError(f"{scene.source}: time.step: missing; a Loop marches with it, and picks none for solver.error")
    data, error = tomllib.loads(scene.text), ("solver", "error")
    assign(data, error, MISSING)
    return replace(scene, config=config.at_step(config.time.step), text=rewrite(scene.text, [(error, MISSING)], data))
