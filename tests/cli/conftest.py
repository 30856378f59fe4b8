"""A folder with a scene and a trajectory in it."""

from pathlib import Path

import pytest
from commands import SCENE
from synthetic import synthetic_trajectory


@pytest.fixture
def here(folder):
    """The folder of the test, with a scene and a trajectory in it."""
    (folder / "scene.toml").write_text(Path(SCENE).read_text())
    synthetic_trajectory().save("made.h5")
    return folder
