"""The page on architecture tells where things are, and they are there."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from docs import rooms

pytestmark = pytest.mark.short
ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/pages/architecture.md").read_text(encoding="utf-8")
PLACE = re.compile(r"`([\w/]+\.py)`(?:: (`\w+`(?:, `\w+`)*))?")
PLACES = sorted({(file, names) for file, names in PLACE.findall(PAGE)})
FORMULAS = 23  # of the paper


@pytest.mark.parametrize(("file", "names"), PLACES)
def test_what_the_page_names_is_there(file, names):
    module = import_module("omnisim." + file.removesuffix(".py").replace("/", "."))
    assert [name for name in re.findall(r"\w+", names) if not hasattr(module, name)] == []


def test_every_formula_of_the_paper_has_a_place():
    rows = re.findall(r"^\| (\d+) \| .+ \| (.+) \|$", PAGE, re.MULTILINE)
    assert [int(number) for number, _ in rows] == list(range(1, FORMULAS + 1))
    assert all(PLACE.search(where) for _, where in rows)


def test_every_section_of_the_paper_is_there():
    assert re.findall(r"^\| \*\*(\d)\*\* \|", PAGE, re.MULTILINE) == list("123456")


def test_every_room_is_told_and_drawn():
    found = {path.parent.relative_to(rooms.PACKAGE).as_posix() for path in rooms.PACKAGE.rglob("__init__.py")} - {"."}
    assert set(re.findall(r"^\| `([\w/]+)/` \|", PAGE, re.MULTILINE)) == found - {"pictures/plots"}
    assert rooms.PICTURE.read_text(encoding="utf-8") == rooms.picture(), "python -m docs.rooms draws it anew"
