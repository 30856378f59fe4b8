"""What a user of `omnisim bench` meets: the table, the report, what stops it."""

import builtins
import json
import os
import re
import sys

import pytest
from commands import command, settings

from omnisim.base.formatting import WIDTH
from omnisim.base.methods import METHODS
from omnisim.scene.schema import FRICTION_KEYS
from omnisim_cli import bench
from omnisim_cli.bench_report import FILES

pytestmark = pytest.mark.usefixtures("folder")
TINY = ["six_rollers", "--set", "time.end=0.2", "--step", "1e-3", "--step", "5e-4", "--repeats", "1"]


def test_every_method_and_law_can_be_chosen():
    assert sorted(METHODS) == sorted(bench.METHODS)
    assert sorted(FRICTION_KEYS) == sorted(bench.LAWS)


def test_the_table_fits_a_terminal_and_ends_in_a_verdict(folder):
    result = command("bench", *TINY, "--method", "heun", "--method", "rk4")
    assert result.exit_code == 0, result.stderr
    assert max(map(len, result.stdout.splitlines())) <= WIDTH
    assert result.stdout.count("  heun  ") == 2 and result.stdout.count("  rk4 ") == 2
    assert re.search(r"^\*  rk4 +explicit +0.0005 +1.1e-08 ", result.stdout, re.MULTILINE)
    assert "confirmed by dopri5" in result.stdout
    assert "Fastest with errors below 1e-06: " in result.stdout and "below 1e-09: none" in result.stdout
    assert "pair of steps: heun 2." in result.stdout.replace("\n", " ")  # measured: 2.30
    assert os.listdir(folder) == []


def test_the_report_holds_what_the_screen_shows(folder):
    result = command(
        "bench", *TINY, "--method", "rk4", "--tracking", "explicit", "--tracking", "implicit", "-o", "report"
    )
    assert result.exit_code == 0, result.stderr
    data = json.loads((folder / "report/report.json").read_text())
    (scene,) = data["scenes"]
    assert [(row["tracking"], row["step_s"]) for row in scene["rows"]] == [
        (tracking, step) for tracking in ("explicit", "implicit") for step in (1e-3, 5e-4)
    ]
    assert scene["verdict"].split()[-1] in result.stdout
    page = (folder / "report/report.md").read_text()
    assert page.count("\n| ") == 6 and "## six_rollers, regularized" in page
    again = command("bench", *TINY, "-o", "report")
    assert again.exit_code == 2 and "report.json: exists already" in again.stderr


def test_the_plot_is_written_if_matplotlib_is_there(folder):
    pytest.importorskip("matplotlib")
    from omnisim_cli.bench_plot import COLOURS

    assert sorted(COLOURS) == sorted(METHODS)
    result = command("bench", *TINY, "--method", "rk4", "--law", "regularized", "--law", "coulomb", "-o", "report")
    assert result.exit_code == 0, result.stderr
    assert sorted(os.listdir(folder / "report")) == sorted(FILES)
    assert (folder / "report/work_precision.png").read_bytes().startswith(b"\x89PNG")


def test_without_matplotlib_the_rest_is_written(folder, monkeypatch):
    def absent(name, *rest, original=builtins.__import__):
        if name.startswith("matplotlib"):
            raise ModuleNotFoundError(f"No module named '{name}'", name=name)
        return original(name, *rest)

    monkeypatch.delitem(sys.modules, "omnisim_cli.bench_plot", raising=False)
    monkeypatch.setattr(builtins, "__import__", absent)
    result = command("bench", *TINY, "--method", "rk4", "-o", "report")
    assert result.exit_code == 0, result.stderr
    assert "pip install matplotlib" in result.stderr
    assert sorted(os.listdir(folder / "report")) == ["report.json", "report.md"]


def test_a_run_that_stops_is_a_row_that_says_why(folder):
    result = command(
        "bench", *TINY, "--method", "rk4", "--method", "radau5", "--set", "friction.slip_speed=1e-4", "-o", "report"
    )
    assert result.exit_code == 0, result.stderr
    assert "reference: radau5 at 5e-05 s, confirmed by radau5 at 0.0001 s" in result.stdout
    assert "stopped: rk4 at 0.001, 0.0005 s: " in result.stdout
    rows = json.loads((folder / "report/report.json").read_text())["scenes"][0]["rows"]
    assert [row["error"] is None for row in rows] == [True, True, False, False]
    assert rows[0]["status"] != "complete" and rows[0]["wall_s_per_simulated_s"] is None


def test_steps_are_those_of_the_bench_also_for_a_scene_that_picks_its_own(folder):
    result = command("bench", *TINY, "--method", "rk4", "--set", "solver.error=1e-4", "-o", "report")
    assert result.exit_code == 0, result.stderr
    rows = json.loads((folder / "report/report.json").read_text())["scenes"][0]["rows"]
    assert [row["steps"] for row in rows] == [200, 400]


def test_a_scene_without_a_reference_is_a_failure_of_its_own():
    lifted = ["wrench.times=[0, 0.2]", "wrench.force=[[0, 0, 0], [0, 0, 200]]"]
    result = command("bench", *TINY, *settings(*lifted))
    assert result.exit_code == 1
    assert "six_rollers: no reference to measure errors by: wheel 'wheel' leaves the floor" in result.stderr
