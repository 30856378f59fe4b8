"""Who may import whom: data flows one way."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import omnisim

pytestmark = pytest.mark.short
PACKAGE = Path(omnisim.__file__).parent
# from the scene file down to the trajectory: a module imports only from rows above its own, or from its own row
LAYERS = (
    ("kernel", "direct", "toml_text", "text", "records", "files", "arguments", "copying", "version"),
    ("angle", "vector", "state", "tableau", "status", "config"),
    ("roller", "contact.tracking", "problems", "trajectory", "ideal", "solids", "drives"),
    ("rules", "machine_rules", "estimates"),
    ("validation", "plausibility", "design", "first_scene", "storage"),
    ("scene",),
    ("contact.kinematics", "export", "report", "commanded"),
    ("contact.reaction", "contact.coulomb", "contact.contensou"),
    ("parameters",),
    ("packing", "constraints"),
    ("geometry",),
    ("mesh", "viewer"),
    ("wheel_drawing", "robot_description"),
    ("mjcf", "urdf"),
    ("robot_files",),
    ("wheel", "actuation"),
    ("rigid", "body"),
    ("articulated", "joints", "bearings"),
    ("loads", "impulse"),
    ("coupled", "wheel_dynamics"),
    ("chassis",),
    ("multibody",),
    ("dynamics",),
    ("runge_kutta", "checks", "tracking_alone"),
    ("implicit",),
    ("grip",),
    ("exchange",),
    ("events", "extremes"),
    ("onset",),
    ("stepper",),
    ("statics", "model"),
    ("slopes",),
    ("stiffness",),
    ("start",),
    ("observables",),
    ("collect",),
    ("inputs", "sensors"),
    ("loop", "analysis", "ripple"),
    ("plots.style", "plots.asked"),
    ("plots.marks", "plots.outline"),
    ("plots.panels",),
    ("plots.drive",),
    ("plots.floor", "plots.motion", "plots.bearing_loads", "plots.roller_maps", "plots.spectra", "plots.paper"),
    ("plots.overview",),
    ("target",),
    ("simulation",),
    ("timing",),
    ("precision",),
)
ONLY = {
    "h5py": {"storage"},
    "pydantic": {"config", "problems", "validation"},
    "numba": {"kernel", "direct"},
    "tomlkit": {"toml_text"},
    "pandas": {"trajectory", "export"},
    "xarray": {"trajectory", "export"},
    "pyarrow": {"export"},
    "scipy": {"export"},
    "matplotlib": {
        "trajectory",
        "wheel_drawing",
        "plots.style",
        "plots.outline",
        "plots.panels",
        "plots.drive",
        "plots.floor",
        "plots.motion",
        "plots.bearing_loads",
        "plots.roller_maps",
        "plots.spectra",
        "plots.paper",
        "plots.overview",
    },
}


def modules():
    for path in PACKAGE.rglob("*.py"):
        name = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        if not name.endswith("__init__"):
            yield name, path


def imported(path):
    """Every module that a file imports, at the top or inside a function."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def layer(name):
    return next(number for number, names in enumerate(LAYERS) if name in names)


def test_every_module_has_its_place():
    assert {name for name, _ in modules()} == {name for names in LAYERS for name in names}


@pytest.mark.parametrize("name", [name for name, _ in modules()])
def test_a_module_imports_nothing_from_further_down(name):
    path = PACKAGE / (name.replace(".", "/") + ".py")
    known = {known for names in LAYERS for known in names}
    for target in imported(path):
        target = target.removeprefix("omnisim.")
        if target in known and name != "trajectory":  # its methods lead to storage and export
            assert layer(target) <= layer(name), f"{name} imports {target}"


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
