"""What tests of recordings share."""

from functools import cache

import pytest
from recorded_machines import MACHINES, run_of
from recordings import by_rosbags

from omnisim.exports.formats import write


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """Run, scene, file and messages of a machine, each made once."""

    @cache
    def found(name):
        run = run_of(name)
        path, *beside = write(run, tmp_path_factory.mktemp("a recording") / "of a run.mcap")
        assert [other.suffix for other in beside] == [".urdf"] + [".stl"] * (len(beside) - 1)
        return run, MACHINES[name]().config, path, by_rosbags(path, "ROS2_HUMBLE")

    return found
