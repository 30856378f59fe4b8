"""What the house asks of every function in it."""

import ast
import re
from pathlib import Path

import pytest

import omnisim

pytestmark = pytest.mark.short
UPRIGHT = {  # that a wheel's frame is a turn about the vertical: one file of kernels; the others count in arrays
    "contact/frame.py",
    "dynamics/multibody/residuals.py",
    "dynamics/wheel_values.py",
    "dynamics/parameters.py",
    "dynamics/slopes.py",
    "dynamics/static_loads.py",
    "run/timing.py",
}
ROOT = Path(omnisim.__file__).parents[1]
MOST_ARGUMENTS = 7
MORE = {
    "cli/bench.py: bench": "one for each option of the command line, as click hands them over",
    "cli/wheel.py: wheel": "the same",
}


def functions():
    """Every function of the package and of the command line by file and name, with its number of arguments."""
    for path in sorted([*ROOT.glob("omnisim/**/*.py"), *ROOT.glob("cli/**/*.py")]):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.FunctionDef):
                given = node.args
                names = [one.arg for one in (*given.posonlyargs, *given.args, given.vararg, *given.kwonlyargs) if one]
                count = len([name for name in names if name not in ("self", "cls")])
                yield f"{path.relative_to(ROOT).as_posix()}: {node.name}", count


def test_no_function_takes_more_than_seven_arguments_without_a_reason():
    found = dict(functions())
    assert len(found) > 500
    assert {name for name, count in found.items() if count > MOST_ARGUMENTS} == set(MORE)


def test_one_file_of_kernels_knows_that_frames_are_turned_about_the_vertical_alone():
    package = ROOT / "omnisim"
    knowing = [path for path in package.rglob("*.py") if "cos_heading" in path.read_text(encoding="utf-8")]
    assert {path.relative_to(package).as_posix() for path in knowing} == UPRIGHT
    parts = re.compile(r"\b(frame|carrier|heading|body)\.(cos|sin)\b")
    asking = [path for path in package.rglob("*.py") if parts.search(path.read_text(encoding="utf-8"))]
    assert [path.relative_to(package).as_posix() for path in asking] == ["contact/frame.py"]
