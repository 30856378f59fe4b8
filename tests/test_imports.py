"""Who may import whom: data flows one way."""

import ast
import subprocess
import sys
import tomllib
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import omnisim

pytestmark = pytest.mark.short
PACKAGE = Path(omnisim.__file__).parent
# A room imports from itself and from rooms above it in this list: data flows down, from the scene file to the pictures.
ROOMS = (
    "base", "scene", "contact", "dynamics", "march", "results", "run", "native", "studies", "gym", "fitting", "cad",
    "pictures", "exports",
)  # fmt: skip
ONLY = {
    "h5py": {"results.hdf5", "base.hdf5_reading", "base.trajectory_file", "studies.result"},
    "pydantic": {
        "scene.schema",
        "scene.ground_schema",
        "scene.wheel_schema",
        "scene.problems",
        "scene.validation",
        "scene.values",
        "studies.schema",
        "studies.factors",
        "studies.study",
        "gym.options",
        "fitting.schema",
        "fitting.fit_file",
    },
    "gymnasium": {"gym.follow", "gym.single"},
    "numba": {"base.kernel", "base.compiler", "base.calls", "base.machine_code", "native.object_code"},
    "tomlkit": {"scene.toml_text"},
    "pandas": {"results.trajectory", "results.tables"},
    "xarray": {"results.trajectory", "results.tables", "studies.result"},
    "pyarrow": {"results.tables"},
    "scipy": {"results.tables", "studies.study", "fitting.least_squares", "fitting.uncertainty"},
    "distributed": {"studies.cluster"},
    "mcap": {"exports.recording"},
    "rosbags": {"exports.messages"},
    "matplotlib": {"results.trajectory", "cad.drawing", "cad.portrait"}
    | {
        f"pictures.plots.{name}"
        for name in (
            "style",
            "outline",
            "panels",
            "drive",
            "floor",
            "motion",
            "bearing_loads",
            "roller_maps",
            "spectra",
            "wheels",
            "paper",
            "overview",
            "studies",
            "fits",
        )
    },
}


def modules():
    for path in PACKAGE.rglob("*.py"):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        if not name.endswith("__init__"):
            yield name, path


@cache
def imported(path):
    """Every module that a file imports, at the top or inside a function."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
    return found


MODULES = dict(modules())


def arrows(name):
    """The modules of the package that one imports."""
    return {target.removeprefix("omnisim.") for target in imported(MODULES[name])} & set(MODULES) - {name}


def room(name):
    return ROOMS.index(name.partition(".")[0])


def test_every_module_is_in_a_room_and_every_room_is_installed():
    assert {name.partition(".")[0] for name in MODULES} == set(ROOMS)
    packages = tomllib.loads((PACKAGE.parent / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    folders = {path.parent for path in MODULES.values()}
    assert {"omnisim." + ".".join(folder.relative_to(PACKAGE).parts) for folder in folders} <= set(packages)


@pytest.mark.parametrize("name", MODULES)
def test_a_module_imports_only_from_its_room_and_those_before(name):
    assert not [target for target in arrows(name) if room(target) > room(name)]


def test_no_modules_import_each_other_in_a_circle():
    TopologicalSorter({name: arrows(name) for name in MODULES}).prepare()  # CycleError names a circle


@pytest.mark.parametrize("package", ONLY)
def test_a_library_is_met_in_one_place(package):
    users = {name for name, path in modules() if any(target.split(".")[0] == package for target in imported(path))}
    assert users == ONLY[package]


def test_a_scene_is_read_without_waiting_for_the_compiler():
    program = "import sys, omnisim; omnisim.load('six_rollers'); print({'numba', 'h5py', 'tomlkit'} & set(sys.modules))"
    assert (
        subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.strip()
        == "set()"
    )


def test_nothing_in_the_project_reads_outside_it():
    root = PACKAGE.parent
    folders = [root / name for name in ("omnisim", "cli", "tests", "bench", "data")]
    texts = [
        path for folder in folders for path in folder.rglob("*") if path.suffix in {".py", ".toml", ".md", ".c", ".cc"}
    ]
    assert len(texts) > 40
    assert not [path for path in texts if "../" + "shared" in path.read_text()]
