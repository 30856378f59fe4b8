"""Files are written whole or not at all, by one process at a time, and read only as far as they may be long."""

import os
import subprocess
import sys
import time

import pytest

from omnisim.base import files
from omnisim.base.files import read_small, reserved, write_whole

pytestmark = [pytest.mark.short, pytest.mark.skipif(os.name != "posix", reason="locks and pipes of POSIX")]
HOLDING = """
import sys
from pathlib import Path
from omnisim.base.files import reserved
with reserved(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def holder(path):
    """A process that has reserved a path."""
    child = subprocess.Popen([sys.executable, "-c", HOLDING, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    assert child.stdout.readline() == b"held\n"
    return child


def test_the_second_of_two_writers_is_told_who_the_first_is(tmp_path):
    first = holder(tmp_path / "run.h5")
    with pytest.raises(OSError, match=rf"another omnisim \(process {first.pid}\)"), reserved(tmp_path / "run.h5"):
        pass
    first.communicate(b"")
    with reserved(tmp_path / "run.h5"):
        assert len(os.listdir(tmp_path)) == 1
    assert os.listdir(tmp_path) == []


def test_what_a_killed_process_leaves_behind_is_in_nobodys_way(tmp_path):
    first = holder(tmp_path / "run.h5")
    first.kill()
    first.wait()
    assert len(os.listdir(tmp_path)) == 1
    with reserved(tmp_path / "run.h5"), reserved(tmp_path / "run.h5"), reserved(tmp_path / "other.h5"):
        pass
    assert os.listdir(tmp_path) == []


def test_a_link_and_its_file_are_one_reservation(tmp_path):
    (tmp_path / "link.h5").symlink_to(tmp_path / "run.h5")
    first = holder(tmp_path / "run.h5")
    with pytest.raises(OSError, match="another omnisim"), reserved(tmp_path / "link.h5"):
        pass
    first.communicate(b"")


def test_nothing_is_replaced_unless_told_even_if_made_in_the_last_moment(tmp_path, monkeypatch):
    old, new = tmp_path / "old", tmp_path / "new"
    old.write_bytes(b"precious")
    with pytest.raises(FileExistsError, match="exists already; overwrite=True replaces it"):
        write_whole({new: b"x", old: b"x"}, overwrite=False)
    assert os.listdir(tmp_path) == ["old"] and old.read_bytes() == b"precious"
    late = tmp_path / "late"
    monkeypatch.setattr(os, "fsync", lambda _: late.write_bytes(b"quicker"))
    with pytest.raises(FileExistsError):
        write_whole({new: b"x", late: b"x"}, overwrite=False)
    assert sorted(os.listdir(tmp_path)) == ["late", "old"] and late.read_bytes() == b"quicker"


def test_without_hard_links_a_file_gets_its_name_as_well(tmp_path, monkeypatch):
    def unsupported(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "link", unsupported)
    write_whole({tmp_path / "new": b"x"}, overwrite=False)
    assert os.listdir(tmp_path) == ["new"]


@pytest.mark.parametrize("device", ["/dev/zero", "/dev/full", "/dev/null"])
def test_a_device_is_not_read(device):
    with pytest.raises(OSError, match="not a regular file"):
        read_small(device, 1000)


def test_a_file_is_read_up_to_its_limit_and_a_huge_one_not_at_all(tmp_path):
    (tmp_path / "fits").write_bytes(b"x" * 1000)
    assert read_small(tmp_path / "fits", 1000) == b"x" * 1000
    with open(tmp_path / "huge", "wb") as file:
        file.truncate(10**12)
    with pytest.raises(OSError, match=r"more than 0\.0 MB"):
        read_small(tmp_path / "huge", 1000)


def test_a_pipe_is_read_to_its_end_and_one_without_a_writer_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "SILENCE", 0.2)
    os.mkfifo(tmp_path / "pipe")
    begun = time.monotonic()
    with pytest.raises(OSError, match="a pipe that nobody writes to"):
        read_small(tmp_path / "pipe", 1000)
    assert time.monotonic() - begun < 5.0
    slow = "import sys, time; f = open(sys.argv[1], 'w'); time.sleep(0.6); f.write('ab'); f.close()"
    writer = subprocess.Popen([sys.executable, "-c", slow, tmp_path / "pipe"])
    descriptor = os.open(tmp_path / "pipe", os.O_RDONLY)  # waits until the writer is there
    assert read_small(f"/dev/fd/{descriptor}", 1000) == b"ab"
    os.close(descriptor)
    writer.wait()
