"""Python as people use it: what the page of the interface names is there, has types, and shows itself."""

import html.parser
import importlib.metadata
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

import omnisim
from omnisim.results.layout import TABLE

ROOT = Path(__file__).parents[1]
API = ROOT / "docs" / "pages" / "api.md"
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
SHORT = {"time": {"end": 0.02, "output_interval": 0.01}}


@pytest.fixture(scope="module")
def run():
    return omnisim.simulate(omnisim.load("youbot", SHORT | {"title": "<b>&'title'"}))


@pytest.mark.short
def test_every_name_on_the_page_is_there_after_importing_omnisim_alone():
    named = sorted(set(re.findall(r"`omnisim\.([A-Za-z_.]+)", API.read_text(encoding="utf-8"))))
    assert {"plots.story", "viewer.page", "export.ExportError", "report.summary", "simulate"} <= set(named)
    program = f"import omnisim, operator\nfor name in {named!r}: operator.attrgetter(name)(omnisim)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.short
def test_no_public_name_is_hidden_by_a_module():
    """A room of the same name would take its place as soon as somebody imports it."""
    assert not {path.stem for path in (ROOT / "omnisim").iterdir()} & set(omnisim.__all__)
    assert set(omnisim.__all__) <= set(dir(omnisim))
    assert set(omnisim.plots.__all__) == {
        "VIEWS",
        "PlotError",
        "study",
        "fit_paths",
        "fit_residuals",
        *omnisim.plots.VIEWS,
    }


@pytest.mark.short
def test_the_package_tells_its_version_its_types_and_an_example():
    assert omnisim.__version__ == importlib.metadata.version("omnisim-engine")
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]["omnisim"]
    assert {"py.typed", "*.pyi"} <= set(data) and (ROOT / "omnisim" / "py.typed").exists()
    stub = (ROOT / "omnisim" / "__init__.pyi").read_text()
    assert set(re.findall(r'^    "(\w+)",$', stub, re.M)) == set(omnisim.__all__)
    title, _, example, *_ = omnisim.__doc__.splitlines()
    assert title.startswith("omnisim: ") and example == "    import omnisim"


USER = """
from pathlib import Path
from typing import assert_type

import numpy as np
from numpy.typing import NDArray

import omnisim

assert_type(omnisim.__version__, str)
scene = omnisim.load("youbot", {"friction.coefficient": 0.3, "time": {"end": 0.1}})
assert_type(scene.config.friction.coefficient, float)
run = omnisim.simulate(scene, progress=lambda done: done > 0.5)
assert_type(run, omnisim.Trajectory)
assert_type(run.view(show=False), Path)
run.plot("slip").savefig("slip.png")
omnisim.plots.story([run, run]).savefig("story.png")
assert_type(omnisim.report.summary(run), str)
assert_type(omnisim.viewer.page(run), str)
omnisim.export.write(run, "a.csv")
assert_type(omnisim.analysis.energy_error(run).absolute, float)
loop = omnisim.Loop("youbot")
assert_type(loop.advance(0.01), bool)
assert_type(loop.normal_forces, NDArray[np.float64])
assert_type(loop.copy(), omnisim.Loop)
loop.reset({"initial.yaw_deg": 3.0})
assert_type(omnisim.open_trajectory(Path("a.h5")).time, NDArray[np.float64])
omnisim.load_text("schema = 1", ["time.end=1"])
"""
WRONG = "omnisim.simulate(42)\nomnisim.nonsense\nomnisim.Loop('youbot').normal_force\n"


@pytest.mark.long
@pytest.mark.parametrize("tool", ["mypy", "pyright"])
def test_tools_that_check_types_know_the_public_names(tool, tmp_path):
    """mypy comes with the extra `test`; pyright wants node beside it, and would load one from the network."""
    file = tmp_path / "user.py"
    file.write_text(USER + WRONG)
    if tool == "mypy":
        command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "--cache-dir", tmp_path, file]
    elif importlib.util.find_spec("pyright") and shutil.which("node"):
        command = [sys.executable, "-m", "pyright", file]
    else:
        pytest.skip("no pyright with a node of its own")
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    found = {int(line) for line in re.findall(r"user\.py:(\d+):.*error", done.stdout)}
    first = USER.count("\n") + 1
    assert found == {first, first + 1, first + 2}, done.stdout


def test_a_notebook_completes_the_names_of_datasets(run):
    assert run._ipython_key_completions_() == list(run)
    assert all(run[path] is not None for path in run._ipython_key_completions_())


class Tags(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.tags, self.text, self.attributes = [], "", set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attributes}

    def handle_data(self, data):
        self.text += f"{data}\n"


def test_a_notebook_shows_a_run_with_its_datasets_and_nothing_from_elsewhere(run):
    shown = Tags(run._repr_html_())
    assert {"<b>&'title'", "complete", "wheels/NAME/normal_force"} <= set(shown.text.splitlines())
    assert set(shown.tags) == {"div", "table", "tr", "th", "td", "details", "summary"}
    assert shown.attributes == {"style"}
    there = [row for row in TABLE if row.path.format(wheel=run.wheels[0]) in run]
    assert f"{len(there)} datasets" in shown.text


def test_a_run_draws_itself_and_shows_itself(run, tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert run.plot("slip").axes
    with pytest.raises(ValueError, match="no view is called 'splip'; views: story"):
        run.plot("splip")
    path = run.view(tmp_path / "a.html")
    assert path.read_text(encoding="utf-8") == omnisim.viewer.page(run)
    assert opened == [path.resolve().as_uri()] and run.view(show=False).suffix == ".html"
    with pytest.raises(FileExistsError):
        run.view(path)
    assert run.view(path, overwrite=True) == path and len(opened) == 2


def test_a_scene_is_taken_by_name_by_path_and_as_it_is(run, tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(omnisim.load("six_rollers", SHORT).text)
    for source in (file, str(file), omnisim.load(file)):
        again = omnisim.simulate(source)
        assert again.complete and len(again.time) == 3
        assert omnisim.Loop(source).scene.config == omnisim.load(file).config
    assert omnisim.Loop("six_rollers").scene.name == "six_rollers"


@pytest.mark.short
def test_a_scene_tells_itself_in_a_few_lines():
    lines = repr(omnisim.load("youbot")).splitlines()
    assert len(lines) == 5 and max(map(len, lines)) < 140
    words = ("KUKA youBot", "front_left", "mecanum", "4 rate", "coulomb, coefficient 0.6", "3 s", "20 kg")
    assert all(word in " ".join(lines) for word in words)
    viscous = {"friction.law": "viscous", "friction.viscosity": 2.5}
    assert "  friction  viscous, viscosity 2.5\n" in repr(omnisim.load("youbot", viscous))


@pytest.mark.short
def test_overrides_are_a_dict_of_keys_or_of_tables_or_texts_as_the_command_takes_them():
    written = omnisim.load("youbot", ["friction.coefficient=0.3", "wheels.front_left.drive.rate=2.5", "time.end=1.5"])
    for overrides in (
        {"friction.coefficient": 0.3, "wheels.front_left.drive.rate": np.float64(2.5), "time.end": 1.5},
        {"friction": {"coefficient": 0.3}, "wheels": {"front_left": {"drive": {"rate": 2.5}}}, "time": {"end": 1.5}},
    ):
        scene = omnisim.load("youbot", overrides)
        assert scene.config == written.config and omnisim.load_text(scene.text).config == written.config
        assert "# KUKA youBot" in scene.text
    moved = omnisim.load("youbot", {"command": {"times": np.array([0.0, 1.0]), "twist": np.eye(3)[:2]}})
    assert moved.config.command.twist == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@pytest.mark.short
def test_a_text_is_a_scene_and_its_errors_name_lines():
    text = omnisim.load("six_rollers").text
    scene = omnisim.load_text(text, {"time.end": 1.0})
    assert scene.config.time.end == 1.0 and scene.source == "<text>"
    line = text[: text.index("end = ")].count("\n") + 1
    with pytest.raises(omnisim.SceneError, match=rf"^<text>:{line}: time.end = -1.0: must be a finite number > 0$"):
        omnisim.load_text(re.sub("^end = .*$", "end = -1.0", text, count=1, flags=re.M))
    with pytest.raises(omnisim.SceneError, match=r"^<text>:2: not valid TOML"):
        omnisim.load_text("schema = 1\n[time\n")


@pytest.mark.short
@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: omnisim.simulate(42), "simulate takes a Scene, a path or the name of a packaged scene, not 42 (int)"),
        (lambda: omnisim.Loop(None), "Loop takes a Scene, a path or the name of a packaged scene, not None (NoneType)"),
        (lambda: omnisim.Loop("x"), "x: no file and no packaged scene has this name"),
        (lambda: omnisim.load(3.5), "load takes a path or the name of a packaged scene, not 3.5 (float)"),
        (lambda: omnisim.load_text(b"a"), "load_text takes the text of a scene, not b'a' (bytes)"),
        (lambda: omnisim.open_trajectory(None), "open_trajectory takes a path, not None (NoneType)"),
        (lambda: omnisim.open_trajectory(0), "open_trajectory takes a path, not 0 (int)"),
        (lambda: omnisim.simulate("youbot", {"time.end": 1}),
         "simulate: progress must be a function of the fraction done, not {'time.end': 1} (dict)"),
        (lambda: omnisim.load("youbot", "time.end=1"),
         "overrides must be a dict or a list of texts 'KEY=VALUE', not 'time.end=1' (str)"),
        (lambda: omnisim.load("youbot", 7), "overrides must be a dict or a list of texts 'KEY=VALUE', not 7 (int)"),
        (lambda: omnisim.load("youbot", [7]), "an override must be a text 'KEY=VALUE', not 7 (int)"),
        (lambda: omnisim.load("youbot", {3: 7}), "overrides: 3 (int) is no key; must be dotted, such as 'time.step'"),
        (lambda: omnisim.load("youbot", {"title": None}),
         "overrides: title = None (NoneType) is nothing that a scene can hold"),
        (lambda: omnisim.load("youbot", {"friction": {"coefficient": -1}}),
         "overrides: friction.coefficient = -1: must be a finite number >= 0"),
    ],
)  # fmt: skip
def test_wrong_arguments_get_one_sentence(call, sentence):
    with pytest.raises((TypeError, ValueError)) as caught:
        call()
    assert str(caught.value).startswith(sentence) and "\n" not in str(caught.value)


@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_top_to_bottom(path, tmp_path):
    """Executed as a reader would; what is committed has no outputs."""
    import nbclient
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs for cell in code) and path.stat().st_size < 20_000
    nbclient.NotebookClient(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    kinds = {kind for cell in code for output in cell.outputs for kind in output.get("data", {})}
    assert {"text/html", "image/png", "text/plain"} <= kinds
    assert not [output for cell in code for output in cell.outputs if output.output_type == "error"]


@pytest.mark.short
def test_there_is_a_notebook():
    assert "first_machine" in [path.stem for path in NOTEBOOKS]
    assert json.loads(NOTEBOOKS[0].read_text(encoding="utf-8"))["nbformat"] == 4
