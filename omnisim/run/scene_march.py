"""The march of a scene from its beginning, and the trajectory of it."""

from omnisim.results.assembly import collect
from omnisim.results.trajectory import Trajectory
from omnisim.run.marching import Marching, packed_once
from omnisim.scene.problems import ConfigError
from omnisim.scene.scene import Scene, SceneError


class SceneMarch(Marching):
    """A march of a scene that gives its step. Raises SceneError if a machine free in space cannot begin where it is
    put, or if the rows do not fit into memory."""

    def __init__(self, scene: Scene):
        self.scene = scene
        try:
            super().__init__(scene.config, start=packed_once(scene.config))
        except ConfigError as error:
            raise SceneError(scene.document.told(error.problems)) from None
        except MemoryError as error:
            raise SceneError(f"{scene.source}: time.output_interval: too many rows for the memory: {error}") from None

    def begin(self) -> None:
        """Find the rollers in contact; the first call loads or compiles the kernels, which is no part of the march."""
        self.march(0)
        self.wall_time = 0.0

    def trajectory(self) -> Trajectory:
        """The run so far; it may not go on before somebody has asked for one of its datasets."""
        return collect(self.scene, self.parameters, self.run, self.rows, self.log, self.wall_time)
