"""What a project carries beside its code: the files at the top agree, and nothing bends the search path."""

import re
import tomllib
from pathlib import Path

import pytest

pytestmark = pytest.mark.short
ROOT = Path(__file__).parents[1]


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_version_to_cite_and_the_latest_in_the_changelog_are_that_of_the_package():
    version = tomllib.loads(text("pyproject.toml"))["project"]["version"]
    assert re.findall(r"^version: (.+)$", text("CITATION.cff"), re.MULTILINE) == [version]
    assert re.search(r"^## \[(.+?)\]", text("CHANGELOG.md"), re.MULTILINE)[1] == version


def test_modules_find_each_other_without_changes_of_the_search_path():
    folders = ("omnisim", "cli", "bench", "docs", "data", "tests")
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    assert len(sources) > 100
    assert [str(path) for path in sources if "sys." + "path" in path.read_text(encoding="utf-8")] == []
