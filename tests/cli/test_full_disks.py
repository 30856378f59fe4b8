"""A disk that takes no more costs no file that was there, and no run."""

import errno
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from pathlib import Path

import pytest
from commands import command, contents, refused, settings

import omnisim
from omnisim.results.trajectory import open_trajectory as read

pytestmark = [pytest.mark.short, pytest.mark.skipif(os.name != "posix", reason="limits, pipes and mounts of POSIX")]
SHORT = settings("time.end=0.02", "time.output_interval=0.01", "time.step=0.001")
ENTRY = "from omnisim_cli.main import main; main()"


@contextmanager
def files_end_at(limit):
    """Files cannot grow beyond so many bytes, as on a disk that fills up."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def disk(tmp_path_factory):
    """A disk of 16 kB of its own."""
    place = tmp_path_factory.mktemp("disk")
    if (
        not shutil.which("mount")
        or subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=16k", "tmpfs", place], capture_output=True, check=False
        ).returncode
    ):
        pytest.skip("this user may mount nothing")
    yield place
    subprocess.run(["umount", "--lazy", place], check=True)


WRITERS = {
    "run": ("run", "scene.toml", "-o", "out.h5", "--quiet", *SHORT),
    "run to csv": ("run", "scene.toml", "-o", "out.csv", "--quiet", *SHORT),
    "export": ("export", "made.h5", "out.csv"),
    "wheel, mesh": ("wheel", "scene.toml", "-o", "out.stl"),
    "wheel, drawing": ("wheel", "scene.toml", "-o", "out.svg"),
    "plot": ("plot", "made.h5", "--view", "energy", "-o", "out.svg"),
    "wheel, model": ("wheel", "youbot", "-o", "out.urdf"),
}


def of(arguments):
    return next(name for name in arguments if name.startswith("out."))


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_what_was_there_and_names_the_path(name, here):
    output = of(WRITERS[name])
    (here / output).write_text("precious")
    before = contents(here)
    with files_end_at(1000):
        result = command(*WRITERS[name], "--force")
    line = refused(result, "out.", code=1)
    assert "File too large" in line and contents(here) == before


def test_a_full_disk_leaves_the_old_page(here):
    trajectory = omnisim.simulate(omnisim.load("scene.toml", SHORT[1::2]))
    trajectory.save("made.h5", overwrite=True)
    assert command("view", "made.h5").exit_code == 0
    before = contents(here)
    with files_end_at(1000):
        refused(command("view", "made.h5", "--force"), "made.html: cannot be written: File too large", code=1)
    assert contents(here) == before


def test_a_run_that_fits_nowhere_says_so(here):
    with files_end_at(1000):
        result = command(*WRITERS["run"])
    refused(result, "out.h5: cannot be written: File too large", "no other folder takes it: the run is lost", code=1)


def test_a_run_that_the_disk_does_not_take_is_kept_in_the_current_folder(here, disk):
    (disk / "out.h5").write_text("precious")
    result = command("run", "scene.toml", "-o", disk / "out.h5", "--force", *SHORT)
    place = here / "out.h5"
    assert result.exit_code == 1
    expected = f"Error: {disk}/out.h5: cannot be written: {os.strerror(errno.ENOSPC)}; the run is in {place}\n"
    assert result.stderr.endswith(expected) and str(place) in result.stdout
    assert read(place).complete and contents(disk) == {"out.h5": b"precious"}


def test_or_else_in_the_temporary_one(here, disk, tmp_path_factory, monkeypatch):
    refuge = tmp_path_factory.mktemp("refuge")
    monkeypatch.setattr(tempfile, "tempdir", str(refuge))
    scene = here / "scene.toml"
    monkeypatch.chdir(disk)
    (refuge / "out.h5").write_text("precious")
    result = command("run", scene, "-o", "out.h5", "--quiet", *SHORT)
    refused(result, f"out.h5: cannot be written: No space left on device; the run is in {refuge}/out_2.h5", code=1)
    assert read(refuge / "out_2.h5").complete and contents(disk) == {}


def test_a_folder_that_is_gone_at_the_end_loses_no_run(here, monkeypatch):
    (here / "results").mkdir()

    def simulate(scene, progress, original=omnisim.simulate):
        shutil.rmtree("results")
        return original(scene, progress)

    monkeypatch.setattr("omnisim.run.simulation.simulate", simulate)
    result = command("run", "scene.toml", "-o", "results/out.h5", "--quiet", *SHORT)
    refused(result, "results/out.h5: cannot be written: No such file", f"the run is in {here}/out.h5", code=1)


def test_a_file_that_came_meanwhile_is_not_replaced(here, monkeypatch):
    def simulate(scene, progress, original=omnisim.simulate):
        Path("out.h5").write_text("precious")
        return original(scene, progress)

    monkeypatch.setattr("omnisim.run.simulation.simulate", simulate)
    refused(command(*WRITERS["run"]), "another process has made it meanwhile", f"{here}/out_2.h5", code=1)
    assert Path("out.h5").read_text() == "precious" and read("out_2.h5").complete


def test_two_runs_into_one_file_the_second_says_so(here):
    holding = "from omnisim.base.files import reserved; from pathlib import Path; import sys\n"
    holding += "with reserved(Path('out.h5')): print(flush=True); sys.stdin.read()"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", holding], **pipes) as first:
        first.stdout.readline()
        for arguments in (WRITERS["run"], (*WRITERS["run"], "--force"), ("export", "made.h5", "out.h5.csv")):
            result = command(*arguments)
            if arguments[0] == "export":
                assert result.exit_code == 0  # of another file
            else:
                refused(result, f"out.h5: cannot write there: another omnisim (process {first.pid}) is about to write")
        first.stdin.close()
    assert command(*WRITERS["run"]).exit_code == 0
