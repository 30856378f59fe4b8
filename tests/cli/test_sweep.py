"""`omnisim sweep` as people and scripts meet it: what it prints, what it refuses, what an interrupt leaves."""

import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest
from commands import command, contents, refused

from omnisim.studies.result import open_study
from omnisim.studies.sweep import journal_of

# a test that runs in the background may ignore Ctrl-C
HEARING = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from omnisim_cli.main import main; main()"
)
STUDY = """
schema = 1
scene = "kiwi"
set = { "time.end" = 0.05, "time.output_interval" = 0.01 }
[vary]
"friction.coefficient" = [-0.1, 0.2, 0.4]
[measure]
far = { dataset = "body/position", at = "end", component = "norm" }
"""
DRAWN = (
    STUDY.replace("[-0.1, 0.2, 0.4]", "{ mean = 0.3, deviation = 0.3 }")
    + '[design]\nkind = "random"\ncount = 30\nseed = 2\n'
)
LONG = (
    DRAWN.replace("0.05,", "20.0,").replace("count = 30", "count = 4000").replace("deviation = 0.3", "deviation = 0.01")
)


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(DRAWN)
    return path


def test_the_summary_tells_measures_failures_and_how_to_repeat_them(study, tmp_path):
    result = command("sweep", study, "-o", tmp_path / "found.h5", "--workers", 1)
    assert result.exit_code == 0, result.output
    found = open_study(tmp_path / "found.h5")
    failed = (found["status"] != "complete").sum()
    assert 0 < failed < 30
    assert f"{30 - failed} of 30 that have ended" in result.stdout
    most = np.nanargmax(found["far"])
    assert f"(run {most})" in result.stdout and "runs/s" in result.stdout
    repeated = f"--set friction.coefficient={found['friction.coefficient'][most].item()!r}"
    assert f"omnisim run kiwi --set time.end=0.05 --set time.output_interval=0.01 {repeated}" in result.stdout
    assert "impossible: friction.coefficient = -" in result.stdout
    assert not journal_of(tmp_path / "found.h5").exists()


def test_info_tells_of_a_file_what_the_summary_told(study, tmp_path):
    file = tmp_path / "found.h5"
    summary = command("sweep", study, "-o", file).output.splitlines()
    told = command("info", file).output.splitlines()
    assert told[:2] == [summary[0], "varied    friction.coefficient"]
    assert told[2:] == [line for line in summary[2:] if not line.startswith(("file ", "run "))]


def test_a_study_is_no_trajectory(study, tmp_path):
    command("sweep", study, "-o", tmp_path / "found.h5", "--workers", 1)
    for name in ("run", "view"):
        refused(command(name, tmp_path / "found.h5"), "a study, which is no trajectory; omnisim plot shows it")


def test_quiet_says_nothing(study, tmp_path):
    result = command("sweep", study, "-o", tmp_path / "found.h5", "--workers", 1, "--quiet")
    assert (result.exit_code, result.output) == (0, "")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("friction.coefficient", "friction.coeficient"), "did you mean 'coefficient'"),
        (("[-0.1, 0.2, 0.4]", "[]"), "must have one value or more"),
        (("body/position", "body/positon"), "near: body/position"),
        (('"end"', "0.033"), "a multiple of time.output_interval"),
        (("[-0.1, 0.2, 0.4]", "{ uniform = [0, 1] }"), "takes a design that draws"),
        (('scene = "kiwi"', 'scene = "kiwy"'), "did you mean 'kiwi'"),
    ],
)
def test_a_bad_study_is_refused_and_nothing_is_written(tmp_path, change, told):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("-0.1, ", "").replace(*(part.replace("-0.1, ", "") for part in change)))
    before = contents(tmp_path)
    refused(command("sweep", path, "-o", tmp_path / "found.h5"), told)
    assert contents(tmp_path) == before


def test_a_grid_too_large_for_the_disk_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("-0.1, ", ""))
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=100))
    refused(command("sweep", path, "-o", tmp_path / "found.h5"), "2 runs take about", "of room")
    assert not (tmp_path / "found.h5").exists() and not journal_of(tmp_path / "found.h5").exists()


def test_files_are_not_replaced_unasked(study, tmp_path):
    output = tmp_path / "found.h5"
    assert command("sweep", study, "-o", output, "--workers", 1).exit_code == 0
    refused(command("sweep", study, "-o", output), "exists already; --force replaces it")
    assert command("sweep", study, "-o", output, "--workers", 1, "--force").exit_code == 0
    refused(command("sweep", study, "-o", "/dev/full"), "not a regular file")
    refused(command("sweep", tmp_path / "none.toml"), "No such file")


def test_ctrl_c_writes_what_has_finished_and_resume_does_the_rest(tmp_path):
    path = tmp_path / "study.toml"
    path.write_text(LONG)
    output = tmp_path / "found.h5"
    program = [sys.executable, "-c", HEARING, "sweep", str(path), "-o", str(output)]
    process = subprocess.Popen(
        program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    until = time.monotonic() + 300.0
    while (
        not (journal_of(output).exists() and journal_of(output).read_bytes().count(b"\n") > 2)
        and time.monotonic() < until
    ):
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGINT)
    summary, told = process.communicate(timeout=60)
    assert told.count("stopping, and writing what has finished") == 1
    assert process.returncode == 1 and "--resume does what is missing" in told
    assert " not " not in summary  # what has not run has not failed
    found = open_study(output)
    assert 0 < found.attributes["finished"] < 4000
    done = found["status"] == "complete"
    assert np.isfinite(found["far"][done]).all() and (found["status"][~done] == "not run").all()
