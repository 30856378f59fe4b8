"""A scene that is stepped from outside: a controller sets the inputs of its drives between the steps.

    loop = omnisim.Loop("youbot")
    while loop.time < 2.0:
        loop.command(0.3, 0.0, 0.1 * (1.0 - loop.yaw))        a twist; or loop.drive("front_left", 0.2)
        loop.advance(0.01)
    loop.trajectory().save("controlled.h5")

Nothing is compiled again: inputs are the tables that the kernels read anyway. What a controller sets is one more piece
of them, held from then on, and the trajectory's scene has it as tables, so that loading it repeats the run.
"""

import math
import tomllib
from collections.abc import Sequence
from copy import copy
from dataclasses import replace
from functools import cached_property
from os import PathLike
from types import MappingProxyType
from weakref import ref

import numpy as np

from omnisim.base import status
from omnisim.base.arguments import finite, number, shown
from omnisim.base.copying import copied
from omnisim.dynamics.input_tables import WRENCH
from omnisim.dynamics.parameters import DRIVE_INPUT
from omnisim.results.assembly import collect
from omnisim.results.trajectory import Trajectory
from omnisim.run.inputs import Held, hold_inputs, with_tables
from omnisim.run.marching import FOR_EVER
from omnisim.run.scene_march import SceneMarch
from omnisim.run.sensors import Sensors
from omnisim.scene.ideal_kinematics import wheel_rows
from omnisim.scene.scene import Overrides, Scene, SceneError, as_scene, changed
from omnisim.scene.toml_text import MISSING, assign, rewrite

ON_GRID = 1e-9  # relative, of times that must be multiples of the step


class Loop(SceneMarch, Sensors):
    """One run of a scene, as far as it has come, with the step that the scene gives: none is picked for `solver.error`.

    scene: a Scene, or what `load` takes. Raises SceneError if the scene gives no step, if a machine free in space
    cannot begin where it is put, or if the rows of all of it do not fit into memory, and as `load` does.
    """

    _told: "ref[Trajectory] | None" = (
        None  # the trajectory that was told last, whose datasets nobody may have asked for
    )

    def __init__(self, scene: Scene | str | PathLike[str]):
        super().__init__(stepped(as_scene("Loop", scene)))
        self.names = MappingProxyType({wheel.name: w for w, wheel in enumerate(self.config.wheels)})
        self._dt = float(self.run.clock["dt"])
        self._held = Held(len(self.parameters.starts))
        self.begin()

    def march(self, work: int = FOR_EVER) -> int:
        """March up to the goal, or for about so many right-hand sides; the status."""
        self._settle()
        self._seen = None
        return super().march(work)

    def advance(self, seconds: float) -> bool:
        """March on by a multiple of the scene's step; whether the run goes on after that.

        False at the end of the scene, or where something stopped the run: `status` says what. Raises ValueError for a
        time that is no multiple of the step.
        """
        number("seconds", seconds)
        steps = round(seconds / self._dt) if math.isfinite(seconds) else 0
        if steps < 1 or abs(seconds - steps * self._dt) > ON_GRID * seconds:
            raise ValueError(f"{seconds!r} s is no multiple of the scene's step, {self._dt:g} s")
        clock = self.run.clock
        clock["goal"] = min(int(clock["step"]) + steps, int(clock["steps"]))
        return self.march() == status.RUNNING

    def drive(self, wheel: str, value: float) -> None:
        """Give a drive its input from now on: by its kind torque (N m), target rate (rad/s) or voltage (V).

        Raises KeyError for an unknown wheel, ValueError for a drive without input or a number that is not finite.
        """
        if wheel not in self.names:
            raise KeyError(f"no wheel is called {wheel!r}; wheels: {', '.join(self.names)}")
        w = self.names[wheel]
        drive = self.scene.config.wheels[w].drive
        if drive.given is None or drive.kind == "follow":
            raise ValueError(f"wheel '{wheel}' has a drive of kind '{drive.kind}', which takes no input")
        self._hold({DRIVE_INPUT + w: finite(f"the input of wheel '{wheel}'", value)})

    def command(self, vx: float, vy: float, yaw_rate: float) -> None:
        """Give all drives that follow a rate those of this twist of the chassis from now on (m/s, rad/s, its axes).

        Raises ValueError if the machine has no such drive, or for a number that is not finite.
        """
        if not self._followers:
            raise ValueError("no wheel has a drive of kind 'rate' or a controlled motor, which could follow a command")
        twist = [finite(name, value) for name, value in (("vx", vx), ("vy", vy), ("yaw_rate", yaw_rate))]
        rates = (self._rows @ twist).tolist()
        self._hold({DRIVE_INPUT + w: rates[w] for w in self._followers})

    def wrench(self, force: Sequence[float] = (0.0, 0.0, 0.0), yaw_torque: float = 0.0) -> None:
        """Push with this force (x, y, z; N) and torque about the vertical (N m) from now on, in place of the scene's.

        It acts at the chassis' centre of mass or the centre of a bare wheel, along the axes that the scene names in
        `wrench.frame`: the world's unless it says "body". Raises ValueError for numbers that are not finite.
        """
        if not isinstance(force, Sequence | np.ndarray) or isinstance(force, str) or len(force) != 3:
            raise TypeError(f"force must be three numbers (x, y, z), N, not {shown(force)}")
        values = [finite(f"force {axis}", value) for axis, value in zip("xyz", force, strict=True)]
        self._hold(dict(zip(WRENCH, [*values, finite("yaw_torque", yaw_torque)], strict=True)))

    def copy(self) -> "Loop":
        """Another Loop in the same state, to the last bit; what either does from now on, the other does not see."""
        twin = copy(self)
        clock = self.run.clock
        twin.parameters, twin.run = copied(self.parameters), copied(self.run)
        twin.rows = copied(self.rows, int(clock["row"]) + 1)  # the one under way too
        twin.log = copied(self.log, int(clock["events"]))
        return twin

    def restore(self, state: "Loop") -> None:
        """Take over the whole state of another Loop, a `copy` made before: time, motion, inputs, rows and events.

        What follows is bit for bit what followed there. `state` stays as it is, and can be restored again.
        """
        if not isinstance(state, Loop):
            raise TypeError(f"restore takes a Loop, as copy() returns it, not {shown(state)}")
        self.__dict__ = state.copy().__dict__

    def reset(self, overrides: Overrides = ()) -> None:
        """Back to the start of the scene, nothing set; with overrides, as `load` takes them, to a start of their own.

        Raises SceneError, and stays where it is, if they make no scene.
        """
        self.__dict__ = Loop(changed(self.scene, overrides)).__dict__

    @property
    def status(self) -> str:
        """ "running", or how the run ended, as the trajectory's status has it."""
        if self.run.clock.status == status.RUNNING:
            return "running"
        return self.ending().sentence

    def trajectory(self) -> Trajectory:
        """The run so far, at the output times it has passed; the Loop may go on."""
        self._settle()
        here = self
        piece = int(self.run.clock["piece"]) + 1
        if piece < self._held.pieces and self.parameters.starts[piece] <= self.time:
            here = self.copy()
            here.march(0)  # the row of this instant is renewed by what was set last
        scene = with_tables(self.scene, here.parameters, self._held)
        found = collect(scene, here.parameters, here.run, here.rows, here.log, self.wall_time)
        self._told = ref(found)
        return found

    def __repr__(self) -> str:
        end = self.scene.config.time.end
        return f"<Loop {self.scene.config.title!r}: at {self.time:g} of {end:g} s, {self.status}>"

    @cached_property
    def _rows(self) -> np.ndarray:
        return wheel_rows(self.scene.config)

    @cached_property
    def _followers(self) -> list[int]:
        return [w for w, wheel in enumerate(self.scene.config.wheels) if wheel.drive.controlled]

    def _settle(self) -> None:
        """Let the trajectory that was told last have its datasets while all that they follow from stands still."""
        told = self._told and self._told()
        if told:
            _ = told.data
        self._told = None

    def _hold(self, values: dict[int, float]) -> None:
        """Hold these values of channels from now on."""
        self._settle()
        piece = int(self.run.clock["piece"]) + 1
        self.parameters, self._held = hold_inputs(self.parameters, self._held, piece, self.time, values)


def stepped(scene: Scene) -> Scene:
    """The scene without `solver.error`, so that loading what the loop has done repeats it."""
    config = scene.config
    if config.solver.error is None:
        return scene
    if config.time.step is None:
        raise SceneError(f"{scene.source}: time.step: missing; a Loop marches with it, and picks none for solver.error")
    data = tomllib.loads(scene.text)
    error = ("solver", "error")
    assign(data, error, MISSING)
    return replace(scene, config=config.at_step(config.time.step), text=rewrite(scene.text, [(error, MISSING)], data))
