"""What the house asks of every function in it."""

import ast
from pathlib import Path

import pytest

import omnisim

pytestmark = pytest.mark.short
ROOT = Path(omnisim.__file__).parents[1]
MOST_ARGUMENTS = 7
MORE = {
    "cli/bench.py: bench": "one for each option of the command line, as click hands them over",
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
