"""omnisim: simulation of omni and mecanum wheels with real rollers, exact contact geometry and rigid contact.

    import omnisim

    run = omnisim.simulate("youbot")                      a packaged scene, or the path of a TOML file
    run["wheels/front_left/normal_force"]                 a dataset as an array
    run.plot()                                            a Figure of matplotlib; run.view() shows it moving in 3-D
    run.save("run.h5")                                    omnisim.open_trajectory("run.h5") reads it

    scene = omnisim.load("youbot", {"friction.coefficient": 0.3})          SceneError says what is wrong with a scene
    loop = omnisim.Loop(scene)                            the same step by step, with inputs set by a controller
    while loop.advance(0.01):
        loop.command(0.3, 0.0, 0.5 * (0.2 - loop.yaw))

    found = omnisim.sweep("study.toml", "study.h5")       many runs, keys of the scene varied, on all cores
    found = omnisim.fit("fit.toml")                       keys of a scene estimated from logs of a machine

`omnisim --help` and a mistyped scene wait for no compiler: names are found on first use. __init__.pyi has their types.
"""

from importlib import import_module

_MODULES = {
    "analysis": "results.comparison",
    "export": "exports.formats",
    "plots": "pictures.plots",
    "report": "results.report",
    "viewer": "pictures.viewer",
}
_HOMES = {
    "Loop": ("run.loop", "Loop"),
    "Scene": ("scene.scene", "Scene"),
    "SceneError": ("scene.scene", "SceneError"),
    "Trajectory": ("results.trajectory", "Trajectory"),
    "TrajectoryError": ("base.trajectory_file", "TrajectoryError"),
    "__version__": ("base.version", "VERSION"),
    "FitError": ("fitting.logs", "FitError"),
    "fit": ("fitting.fitting", "fit"),
    "load": ("scene.scene", "load"),
    "load_text": ("scene.scene", "load_text"),
    "open_trajectory": ("results.trajectory", "open_trajectory"),
    "open_study": ("studies.result", "open_study"),
    "simulate": ("run.simulation", "simulate"),
    "simulate_many": ("studies.many", "simulate_many"),
    "sweep": ("studies.sweep", "sweep"),
}
__all__ = sorted([*_MODULES, *_HOMES])


def __getattr__(name: str):
    if name in _MODULES:
        return import_module(f"omnisim.{_MODULES[name]}")
    if name not in _HOMES:
        raise AttributeError(f"module 'omnisim' has no attribute {name!r}")
    home, there = _HOMES[name]
    return getattr(import_module(f"omnisim.{home}"), there)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
