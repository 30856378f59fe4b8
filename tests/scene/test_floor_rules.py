"""Ground in a scene: one line for every defect of it, heights from files, and what a scene keeps of them."""
# ruff: noqa: E501 (the table of defects reads best with one defect to a line)

from pathlib import Path

import numpy as np
import pytest
from commands import command, refused, settings
from grounds import GROUND, HILLS
from scene_text import assert_one_line, message, replaced

import omnisim
from omnisim.dynamics.ground import floor_of_scene
from omnisim.scene.heights import heights_of, read_heights
from omnisim.scene.scene import SceneError, changed, parse

pytestmark = pytest.mark.short

BUMP, SPACING, HEIGHT = "[0.3, 0.0, 0.012, 0.06]", "spacing = [0.5, 0.4]", "height = 0.005"
# Each defect as (old, new, line, key and value, what is allowed).
DEFECTS = {
    "bump without a radius": (BUMP, "[0.3, 0.0, 0.012]", 13, "floor.bumps[0] = [0.3, 0.0, 0.012]", "a list of bumps [x, y, height, radius]"),
    "a bump alone": (f"[{BUMP}, [1.0, 0.2, -0.01, 0.2]]", BUMP, 13, "floor.bumps[0] = 0.3", "a list of bumps [x, y, height, radius]"),
    "bump of no width": ("0.012, 0.06", "0.012, 0", 13, "floor.bumps[0][3] = 0", "radius > 0"),
    "bump that is no number": ("0.012, 0.06", "nan, 0.06", 13, "floor.bumps[0][2] = nan", "finite numbers"),
    "bump without an end": ("0.012, 0.06", "0.012, inf", 13, "floor.bumps[0][3] = inf", "finite numbers"),
    "bump narrower than a roller": ("0.012, 0.06", "0.012, 0.009", 13, "floor.bumps[0][3] = 0.009", "radius of a bump; must be at least 0.01, that of a roller, which touches a narrower bump in several places"),
    "pit narrower than a roller": ("-0.01, 0.2", "-0.01, 0.009", 13, "floor.bumps[1][3] = 0.009", "radius of a pit; must be at least 0.01"),
    "misspelt bumps": ("bumps", "bump", 13, "floor.bump = [", "did you mean 'bumps'? Allowed: slope_deg, uphill_deg, bumps, grid, steps"),
    "grid without spacing": (f", {SPACING}", "", 14, "floor.grid.spacing", "missing; must be two finite numbers > 0 [dx, dy]"),
    "spacing of 0": (SPACING, "spacing = [0.5, 0]", 14, "floor.grid.spacing[1] = 0", "must be two finite numbers > 0"),
    "negative spacing": (SPACING, "spacing = [-0.5, 1]", 14, "floor.grid.spacing[0] = -0.5", "must be two finite numbers > 0"),
    "origin that is no number": ("[-1.0, -1.0]", "[-1.0, nan]", 14, "floor.grid.origin[1] = nan", "two finite numbers [x, y]"),
    "grid without a file": ('file = "hills.csv", ', "", 14, "floor.grid.file", "missing; must be the name of a file of heights, CSV or .npy"),
    "missing file": ("hills.csv", "hill.csv", 14, "floor.grid.file = 'hill.csv'", "cannot be read: No such file or directory"),
    "a folder for a file": ("hills.csv", ".", 14, "floor.grid.file = '.'", "cannot be read: Is a directory"),
    "damaged heights": ("hills.csv", "data:application/gzip;base64,H4sI", 14, "floor.grid.file = 'data:application", "its heights are damaged"),
    "step without a point": ("point = [2.0, 0.0]\n", "", 15, "floor.steps[0].point", "missing; must be two finite numbers [x, y]"),
    "step that is no number": (HEIGHT, "height = nan", 18, "floor.steps[0].height = nan", "a finite number"),
    "sharp edge": ("edge_radius = 0.002", "edge_radius = 0", 19, "floor.steps[0].edge_radius = 0", "must be a finite number > 0"),
    "misspelt edge": ("edge_radius", "edge_radus", 19, "floor.steps[0].edge_radus = 0.002", "did you mean 'edge_radius'?"),
}  # fmt: skip
HEIGHTS = {
    "a word": ("0, 1\n2, high\n", "line 2, column 2: 'high'; must be a finite number"),
    "a hole": ("0, 1, 2\n2,, 1\n", "line 2, column 2: nothing; must be a finite number"),
    "no number": ("0, nan\n2, 1\n", "line 1, column 2: nan; must be a finite number"),
    "no end": ("0, 1\n-inf, 1\n", "line 2, column 1: -inf; must be a finite number"),
    "a row": ("0, 1, 2\n", "holds 1 x 3 heights; must be 2 x 2 or more"),
    "a column": ("0\n1\n2\n", "holds 3 x 1 heights; must be 2 x 2 or more"),
    "nothing": ("", "must be 2 x 2 or more"),
    "ragged rows": ("0, 1, 2\n2, 1\n", "line 2 has 2 heights, and line 1 has 3; must be as many in all"),
}


@pytest.fixture
def beside(folder):
    """A folder with the scene and its heights."""
    Path("s.toml").write_text(GROUND)
    Path("hills.csv").write_text(HILLS)
    return folder


@pytest.mark.parametrize("defect", DEFECTS.values(), ids=DEFECTS.keys())
def test_one_defect_gives_one_line_with_file_line_key_value_and_what_is_allowed(defect, beside):
    assert_one_line(GROUND, *defect)


@pytest.mark.parametrize(("content", "allowed"), HEIGHTS.values(), ids=HEIGHTS.keys())
def test_a_file_of_heights_with_a_defect_is_one_line_that_says_where(content, allowed, beside):
    Path("hills.csv").write_text(content)
    refused(command("run", "s.toml"), "s.toml:14: floor.grid.file = 'hills.csv': ", allowed)
    assert not Path("s.h5").exists()


def test_an_npy_file_of_what_are_no_heights_is_told(beside):
    for found, said in (
        (np.array([["a", "b"]] * 2), "must hold numbers"),
        (np.zeros((2, 2, 2)), "holds 2 x 2 x 2 heights"),
        (np.array([[0.0, 1.0], [np.nan, 1.0]]), "line 2, column 1: nan"),
        (np.zeros((1001, 1001)), "holds 1002001 heights; must be at most 1e+06"),
    ):
        np.save("h.npy", found)
        assert said in message(GROUND.replace("hills.csv", "h.npy"))
    Path("h.npy").write_bytes(b"\x93NUMPY and no more")
    assert "no readable .npy file of numbers" in message(GROUND.replace("hills.csv", "h.npy"))


def test_only_machines_free_in_space_stand_on_uneven_ground(beside):
    told = message(replaced(GROUND, '"free"', '"servo"')).splitlines()
    assert [line.split(":")[1] for line in told] == ["13", "14", "15", "22"]
    assert all('it needs upright = "free" in [scene]' in line for line in told)


def test_the_name_of_a_file_of_heights_is_relative_to_the_scene(beside, monkeypatch):
    scene = omnisim.load("s.toml")
    Path("elsewhere").mkdir()
    monkeypatch.chdir("elsewhere")
    assert omnisim.load(beside / "s.toml").config == scene.config
    with pytest.raises(SceneError, match="No such file"):
        omnisim.load_text(GROUND)


def test_a_scene_keeps_its_heights_to_the_last_bit_and_needs_no_file_any_more(beside):
    heights = np.random.default_rng(1).normal(size=(5, 7))
    np.save("h.npy", heights)
    scene = omnisim.load("s.toml", {"floor.grid.file": "h.npy"})
    Path("h.npy").unlink()
    Path("hills.csv").unlink()
    for again in (omnisim.load_text(scene.text), changed(scene, {"time.end": 2.0}), parse(scene.text, "else/where")):
        assert np.array_equal(heights_of(again.config.floor.grid.file), heights)
    assert again.config == scene.config and again.text == scene.text
    assert "bumps = [[0.3, 0.0, 0.012, 0.06]" in scene.text


def test_csv_and_npy_files_hold_the_same_heights(beside):
    found = read_heights(Path("hills.csv"))
    assert found.tolist() == [[0, 0.01, 0.02, 0], [0, -0.005, 0.03, 0], [0.01, 0.02, 0.01, 0]]
    np.save("h.npy", found.astype(">f8"))
    assert np.array_equal(read_heights(Path("h.npy")), found)


def test_kernels_know_the_ground_that_the_scene_says(beside):
    floor = floor_of_scene(omnisim.load("s.toml", {"floor.steps": [
        {"point": [2, 0], "direction_deg": 90, "height": -0.005, "edge_radius": 0.002}]}).config)  # fmt: skip
    assert floor.bumps.tolist() == [[0.3, 0.0, 0.012, 0.06], [1.0, 0.2, -0.01, 0.2]]
    assert floor.steps.tolist() == [[2.0, 0.0, 0.0, -1.0, 0.005, 0.002, 0.002]] and floor.level == -0.005
    assert floor.nodes.shape == (3, 4, 4) and floor.origin.tolist() == [-1, -1] and floor.spacing.tolist() == [0.5, 0.4]
    assert floor_of_scene(omnisim.load("kiwi").config) is None


def test_bad_ground_is_refused_by_the_command_line(beside):
    line = refused(command("run", "s.toml", *settings("floor.bumps=[[0, 0, 0.01, -1]]")), "radius > 0")
    assert line.startswith("Error: --set floor.bumps=[[0, 0, 0.01, -1]]: floor.bumps[0][3] = -1: must be")
