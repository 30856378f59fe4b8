"""The pages: those on files are what the schema and the table say; what others name is there."""

import re

import pytest

import omnisim
from docs import file_reference, scene_reference, sketches
from omnisim.scene.schema import Config

pytestmark = pytest.mark.short


@pytest.mark.parametrize("script", [scene_reference, file_reference])
def test_the_committed_page_is_what_the_script_makes(script):
    assert script.PAGE.read_text(encoding="utf-8") == script.page()


def keys(model):
    for name, field in model.model_fields.items():
        yield field.alias or name
        if table := scene_reference.table_of(field):
            yield from keys(table)


def test_every_key_of_a_scene_is_on_the_page():
    page = scene_reference.page()
    assert len(list(keys(Config))) > 50
    assert all(re.search(rf"[`\[ ]{key}[`.\]]", page) for key in keys(Config))


def test_every_default_that_is_told_belongs_to_a_key():
    """No note outlives its key."""
    page = scene_reference.page()
    assert all(note in page for note in scene_reference.DERIVED.values())


def test_every_public_name_is_on_the_page_of_the_interface():
    page = (scene_reference.PAGE.parent / "api.md").read_text(encoding="utf-8")
    assert all(f"`{name}" in page or f"omnisim.{name}" in page for name in omnisim.__all__)


def test_every_test_and_module_that_a_page_names_is_there():
    root, named = scene_reference.PAGE.parents[2], []
    for page in scene_reference.PAGE.parent.glob("*.md"):
        names = re.findall(r"`((?:\w+/)*\w+\.py)`", page.read_text(encoding="utf-8"))
        named += names if page.stem in ("theory", "validation") else [name for name in names if "/" in name]
    assert len(named) > 80
    for name in named:
        homes = (root, root / "omnisim", root / "tests")
        assert any((home / name).exists() for home in homes), name


def test_the_committed_sketches_are_what_the_script_draws_and_stand_on_a_page():
    pages = "".join(path.read_text(encoding="utf-8") for path in scene_reference.PAGE.parent.glob("*.md"))
    for name, sketch in sketches.SKETCHES.items():
        assert (sketches.FOLDER / f"{name}.svg").read_text(encoding="utf-8") == sketch().svg(), name
        assert f"(pictures/{name}.svg" in pages, name


def test_every_link_of_the_readme_leads_somewhere():
    root = scene_reference.PAGE.parents[2]
    links = re.findall(r"\]\(([^)#]+)(#[^)]*)?\)", (root / "README.md").read_text(encoding="utf-8"))
    assert len(links) > 15
    for path, anchor in links:
        text = (root / path).read_bytes()
        titles = re.findall(r"^#+ (.*)", text.decode(), re.M) if anchor else []
        assert not anchor or anchor[1:] in {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}
