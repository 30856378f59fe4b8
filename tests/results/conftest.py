"""A trajectory file."""

import pytest
from synthetic import synthetic_trajectory


@pytest.fixture
def saved(tmp_path):
    trajectory = synthetic_trajectory()
    trajectory.save(tmp_path / "run.h5")
    return tmp_path / "run.h5"
