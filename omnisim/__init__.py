"""omnisim: simulation of omni and mecanum wheels with real rollers, exact contact geometry and rigid contact.

scene = omnisim.load("scene.toml")             a Scene; SceneError says what is wrong with the file
trajectory = omnisim.simulate(scene)           a Trajectory; its status says whether it reached the end
omnisim.Loop(scene)                            the same step by step, with inputs set by a controller
trajectory.save("run.h5");  omnisim.open_trajectory("run.h5")
"""

from importlib import import_module

_HOMES = {
    "Scene": "scene",
    "SceneError": "scene",
    "Loop": "loop",
    "load": "scene",
    "Trajectory": "trajectory",
    "simulate": "simulation",
    "open_trajectory": "storage",
    "TrajectoryError": "storage",
}
__all__ = sorted(_HOMES)


def __getattr__(name: str):
    """Import on first use: `omnisim --help` and a mistyped scene answer without waiting for the compiler."""
    if name not in _HOMES:
        raise AttributeError(f"module 'omnisim' has no attribute {name!r}")
    return getattr(import_module(f"omnisim.{_HOMES[name]}"), "read" if name == "open_trajectory" else name)


def __dir__() -> list[str]:
    return __all__
