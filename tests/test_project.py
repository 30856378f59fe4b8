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


def test_what_contributing_names_is_there():
    told = text("CONTRIBUTING.md")
    links = [link for link in re.findall(r"\]\(([^)#]+)", told) if not link.startswith("http")]
    paths = re.findall(r"(?:omnisim|tests|docs|bench|cli|data)/[\w/]+\.\w+", told)
    assert len(paths) > 5 and [path for path in {*links, *paths} if not (ROOT / path).exists()] == []


def test_sections_that_contributing_leads_to_are_there():
    headings = re.findall(r"^## (.+)$", text("docs/pages/extend.md"), re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}
    asked = set(re.findall(r"extend\.md#([\w-]+)", text("CONTRIBUTING.md")))
    assert len(asked) == 6 and asked <= anchors


def test_modules_find_each_other_without_changes_of_the_search_path():
    folders = ("omnisim", "cli", "bench", "docs", "data", "tests")
    sources = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    assert len(sources) > 100
    assert [str(path) for path in sources if "sys." + "path" in path.read_text(encoding="utf-8")] == []
