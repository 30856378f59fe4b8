"""Writing that goes wrong leaves what was there, and nothing else."""

import os
import subprocess
import sys
import textwrap

import numpy as np
import pytest
import synthetic
from synthetic import synthetic_trajectory

from omnisim.results.trajectory import open_trajectory


def untouched(folder, before):
    return {path.name: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
@pytest.mark.parametrize("place", ["h5py.Dataset.make_scale", "os.fsync", "os.replace"])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(saved, monkeypatch, place, error):
    before = {saved.name: saved.read_bytes()}

    def interrupted(*arguments):
        raise error

    monkeypatch.setattr(place, interrupted)
    with pytest.raises(error):
        synthetic_trajectory(rows=5).save(saved, overwrite=True)
    assert untouched(saved.parent, before)


def test_a_file_that_is_not_yet_whole_does_not_bear_the_name(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr("os.fsync", lambda number: seen.extend(path.name for path in tmp_path.iterdir()))
    synthetic_trajectory().save(tmp_path / "run.h5")
    assert len(seen) == 1 and seen[0].endswith(".tmp")
    assert [path.name for path in tmp_path.iterdir()] == ["run.h5"]


@pytest.mark.skipif(os.name != "posix", reason="file size limits are POSIX")
@pytest.mark.parametrize("limit", [100, 3000, 100_000], ids="limit={}".format)
def test_a_full_disk_is_one_clear_error_and_leaves_the_old_file(saved, limit):
    before = {saved.name: saved.read_bytes()}
    code = """
        import resource, sys
        from synthetic import synthetic_trajectory
        trajectory = synthetic_trajectory(rows=1001)
        resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
        try:
            trajectory.save(sys.argv[1], overwrite=True)
        except OSError as error:
            print(error.errno, error)
    """
    command = [sys.executable, "-c", textwrap.dedent(code), str(saved), str(limit)]
    environment = os.environ | {"PYTHONPATH": os.path.dirname(synthetic.__file__)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout == f"27 [Errno 27] File too large: '{saved}'\n"
    assert untouched(saved.parent, before)


def test_nan_that_came_in_after_construction_does_not_reach_a_file(saved):
    before = {saved.name: saved.read_bytes()}
    trajectory = synthetic_trajectory()
    trajectory["body/yaw"][3] = np.nan
    with pytest.raises(ValueError, match=r"dataset body/yaw is nan at index \(3,\)"):
        trajectory.save(saved, overwrite=True)
    assert untouched(saved.parent, before)


def test_a_second_write_replaces_the_first_only_if_told(saved):
    before = {saved.name: saved.read_bytes()}
    with pytest.raises(FileExistsError, match=r"exists already; overwrite=True replaces it: '.*run\.h5'$"):
        synthetic_trajectory(rows=5).save(saved)
    assert untouched(saved.parent, before)
    synthetic_trajectory(rows=5).save(saved, overwrite=True)
    assert len(open_trajectory(saved).time) == 5
    assert [path.name for path in saved.parent.iterdir()] == [saved.name]


def test_writing_to_a_link_replaces_the_file_behind_it(saved, tmp_path):
    link = tmp_path / "latest.h5"
    link.symlink_to(saved)
    synthetic_trajectory(rows=5).save(link, overwrite=True)
    assert link.is_symlink()
    assert len(open_trajectory(saved).time) == 5


@pytest.mark.parametrize(("name", "reason"), [("missing/run.h5", "No such file"), (".", "not a regular file")])
def test_a_place_that_cannot_be_written_is_one_line_with_its_path(tmp_path, name, reason):
    with pytest.raises(OSError, match=reason) as caught:
        synthetic_trajectory().save(tmp_path / name)
    assert str(tmp_path) in str(caught.value) and "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not os.path.exists("/dev/null"), reason="no /dev/null here")
def test_a_device_is_not_replaced_by_a_file():
    with pytest.raises(OSError, match="not a regular file: '/dev/null'"):
        synthetic_trajectory().save("/dev/null")


def test_a_read_only_folder_is_one_line_with_the_path(tmp_path):
    tmp_path.chmod(0o500)
    if os.access(tmp_path, os.W_OK):
        pytest.skip("this user (root) may write everywhere")
    with pytest.raises(PermissionError, match=r"Permission denied: '.*run\.h5'$"):
        synthetic_trajectory().save(tmp_path / "run.h5")
    assert list(tmp_path.iterdir()) == []
