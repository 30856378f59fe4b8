"""`omnisim fit` as people and scripts meet it: what it prints, what it refuses, what it leaves."""
# ruff: noqa: E501  (tables of texts)

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from commands import command, refused
from logs import tour, write_log

import omnisim
from omnisim.fitting.ideal import dead_reckoned
from omnisim.scene.ideal_kinematics import wheel_rows

pytest.importorskip("scipy")
WHEELS = ("left", "back", "right")
FIT = """
scene = "kiwi"
[[logs]]
file = "run.csv"
[free]
"wheel_types.omni.radius" = { scale = true, start = 1.0, from = 0.8, to = 1.2, also = ["wheel_types.omni.roller_distance"] }
"chassis.mass" = { start = 2.5, from = 1.0, to = 9.0 }
[weights]
every = 0.1
"""


@pytest.fixture
def fit(tmp_path):
    """A log of ideal wheels whose radius is 1.05 times that of the scene."""
    config = omnisim.load("kiwi").config
    time = np.arange(0.0, 2.01, 0.05)
    angles = tour(time, wheel_rows(config))
    position, yaw = dead_reckoned(config, 1.05 * angles)
    random = np.random.default_rng(0)
    write_log(tmp_path / "run.csv", WHEELS, time, position + random.normal(0, 1e-3, position.shape), yaw, angles)
    (tmp_path / "fit.toml").write_text(FIT)
    return tmp_path / "fit.toml"


def test_a_fit_prints_estimates_errors_and_what_logs_cannot_tell_and_fills_its_folder(fit, tmp_path):
    pytest.importorskip("matplotlib")
    result = command("fit", fit, "-o", tmp_path / "out", "--workers", 1)
    assert result.exit_code == 0, result.output
    assert "2 keys from 1 of 1 logs" in result.stdout and "complete" in result.stdout
    assert "the logs cannot tell chassis.mass" in " ".join(result.stdout.split())
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "fit.json", "fitted.toml", "paths.png", "residuals.png",
    ]  # fmt: skip
    numbers = json.loads((tmp_path / "out/fit.json").read_text())
    assert numbers["estimates"]["wheel_types.omni.radius"]["value"] == pytest.approx(1.05, abs=0.01)
    assert numbers["ideal_estimates"].keys() == {"wheel_types.omni.radius"}
    assert all((tmp_path / "out" / name).read_bytes().startswith(b"\x89PNG") for name in ("paths.png", "residuals.png"))
    again = command("fit", fit, "-o", tmp_path / "out")
    refused(again, "exists already; --force replaces it")
    assert command("fit", fit, "-o", tmp_path / "out", "--force", "--quiet", "--workers", 1).output == ""


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("chassis.mass", "chassis.maas"), "did you mean 'mass'"),
        (("run.csv", "nun.csv"), "No such file"),
        (('scene = "kiwi"', 'scene = "kiwy"'), "did you mean 'kiwi'"),
        (("every = 0.1", "every = -0.1"), "every = -0.1: must be a finite number > 0"),
        (("[free]", "[free"), "not valid TOML"),
    ],
)
def test_a_bad_fit_is_refused_and_nothing_is_written(fit, tmp_path, change, told):
    fit.write_text(FIT.replace(*change))
    refused(command("fit", fit, "-o", tmp_path / "out"), told)
    assert not (tmp_path / "out").exists()


def test_a_fit_that_is_not_there_is_told_with_those_that_are(tmp_path):
    refused(command("fit", "omni4_sqares"), "did you mean 'omni4_squares'")
    refused(command("fit", tmp_path), "Is a directory")


def test_a_folder_that_cannot_be_is_refused_before_anything_runs(fit, tmp_path):
    refused(command("fit", fit, "-o", tmp_path / "no/where"), "there is no folder")
    refused(command("fit", fit, "-o", fit), "not a folder")


@pytest.mark.skipif(os.name != "posix", reason="signals")
@pytest.mark.long
def test_an_interrupt_keeps_the_best_so_far_and_says_so(tmp_path):
    """Of a packaged fit that takes long; the estimates are written."""
    hearing = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"  # else not in the background
    program = f"{hearing}; from omnisim_cli.main import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", program, "fit", "omni3_squares", "-o", str(tmp_path / "out"), "--workers", "1"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for line in process.stderr:
        if line.startswith("search"):
            break
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    out, told = process.communicate(timeout=300)
    assert process.returncode == 1 and "Traceback" not in told
    assert "interrupted; the estimates are the best so far" in told, told
    assert json.loads((tmp_path / "out/fit.json").read_text())["status"] == "interrupted; the best so far"
    assert "interrupted" in out
