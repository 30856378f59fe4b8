"""What the scene of a run says beside its datasets: targets of the drives, the commanded path."""

from functools import lru_cache

import numpy as np

from omnisim.results import commanded
from omnisim.results.trajectory import Trajectory
from omnisim.scene.scene import SceneError, parse
from omnisim.scene.schema import Config


@lru_cache(maxsize=8)
def scene_of(text: str) -> Config | None:
    """None for a scene that this version does not read: then only what is recorded is shown."""
    try:
        return parse(text).config
    except SceneError:
        return None


def config_of(run: Trajectory) -> Config | None:
    return scene_of(run.attributes["scene"])


def rows_of(run: Trajectory, wheel: str) -> int:
    """How many rows of rollers a wheel has."""
    config = config_of(run)
    return next((len(config.type_of(one).rows) for one in config.wheels if one.name == wheel), 1) if config else 1


def target_rates(run: Trajectory) -> dict[str, np.ndarray]:
    """Target spin rates (T), rad/s, of the wheels that have one."""
    return commanded.target_rates(run, config_of(run))


def commanded_path(run: Trajectory) -> np.ndarray | None:
    """Poses x, y, yaw (T, 3) of the commanded motion, None where the scene asks for none."""
    config = config_of(run)
    return None if config is None else commanded.path(config, run.time)
