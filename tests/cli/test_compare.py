"""What a user of `omnisim compare` meets: differences of two runs, and their times."""

import re
from pathlib import Path

import numpy as np
import pytest
from commands import SCENE, TIPS, command

pytestmark = pytest.mark.usefixtures("folder")


def test_compare_shows_both_trackings_beside_the_paper(folder):
    (folder / "fine.toml").write_text(Path(SCENE).read_text().replace("step = 0.001", "step = 0.0001"))
    result = command("compare", "implicit", "explicit", "fine.toml")
    assert result.exit_code == 0, result.stderr
    for name, paper in (("acceleration", "1e-08"), ("velocity", "1e-07"), ("position", "1e-06")):
        measured = float(re.search(rf"^  {name} +(\S+) +m\S* +{paper}$", result.stdout, re.MULTILINE)[1])
        assert measured < 1e-8, name  # 1.7e-10 m/s^2, 4.5e-12 m/s, 9.8e-13 m
    whole, tracking = (float(re.search(rf"{row} +(\d\S+)", result.stdout)[1]) for row in ("whole run", "alone"))
    assert 0.5 < whole < 10.0 and 1.0 < tracking < 50.0  # 1.9 and 8
    yaw = float(re.search(r"^body/yaw +rad +\S+ +(\S+)$", result.stdout, re.MULTILINE)[1])
    assert 0.0 < yaw < 1e-9
    assert "equal to the last bit:" in result.stdout and "  events/kind" in result.stdout
    assert "in turn" in result.stderr


def test_compare_shows_both_formulations_over_time(folder):
    result = command("compare", "reduced", "multibody", SCENE)
    assert result.exit_code == 0, result.stderr
    assert "reduced against multibody: rk4, step 0.001 s" in result.stdout
    slower = float(re.search(r"time, multibody / reduced: (\S+) \(", result.stdout)[1])
    assert slower > 1.0  # 9
    rows = re.findall(r"^  (\S+) s +(\S+) m +(\S+) rad +(\S+) m/s +(\S+) N$", result.stdout, re.MULTILINE)
    until, position, *_ = np.array(rows, float).T
    assert until[-1] == 2.0 and len(until) == 5
    assert (np.diff(position) >= 0.0).all() and 0.0 < position[-1] < 1e-6  # 1e-7 m
    assert "the paper" not in result.stdout


def test_compare_of_unlike_things_names_what_goes_together():
    result = command("compare", "reduced", "explicit", SCENE)
    assert result.exit_code == 2
    assert "compare implicit and explicit, or reduced and multibody" in result.stderr


def test_a_tracking_does_not_differ_from_itself():
    result = command("compare", "explicit", "explicit", SCENE)
    assert result.exit_code == 0 and "largest difference" not in result.stdout


def test_compare_of_a_scene_that_stops_early_says_so():
    scene = Path("stiff.toml")
    scene.write_text(Path(SCENE).read_text().replace("slip_speed = 0.05", "slip_speed = 1e-9"))
    result = command("compare", "implicit", "explicit", scene)
    assert result.exit_code == 1
    assert "stiff.toml, implicit: unstable" in result.stderr and "stiff.toml, explicit: unstable" in result.stderr
    assert "height of the centre" in result.stdout


def test_compare_and_info_know_scenes_without_a_step(folder):
    text = Path(SCENE).read_text().replace("step = 0.001", "").replace("[solver]", "[solver]\nerror = 1e-6")
    (folder / "stepless.toml").write_text(text)
    result = command("compare", "implicit", "explicit", "stepless.toml")
    assert result.exit_code == 0, result.stderr
    assert re.search(r"implicit against explicit: rk4, step \S+ s, \d+ steps, 41 rows", result.stdout)
    assert "2 s in steps that are picked for errors below 1e-06" in command("info", "stepless.toml").stdout


@pytest.mark.parametrize("pair", [("implicit", "explicit"), ("reduced", "multibody")])
def test_runs_without_rows_are_compared_up_to_there(here, pair):
    (here / "tips.toml").write_text(TIPS)
    result = command("compare", *pair, "tips.toml")
    assert result.exit_code == 1, result.output
    assert "the machine tips at t = 0 s: wheel 'back' leaves the floor" in result.stderr.splitlines()[-1]
