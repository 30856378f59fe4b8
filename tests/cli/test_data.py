"""`omnisim data`: the list, a file, a copy, pictures."""

import pytest
from commands import command

from omnisim.base.formatting import WIDTH
from omnisim.fitting.fit_file import packaged_fits
from omnisim.scene.packaged import packaged_scenes, packaged_text, packaged_wheels
from omnisim.scene.scene import load

pytestmark = pytest.mark.short


def test_the_list_names_every_scene_wheel_and_fit_with_what_it_is():
    result = command("data")
    assert result.exit_code == 0, result.stderr
    lines = result.stdout.splitlines()
    assert max(map(len, lines)) <= WIDTH
    names = [line.split()[0] for line in lines if line.startswith("  ") and not line.startswith("   ")]
    assert names == [*packaged_scenes(), *packaged_wheels(), *packaged_fits()]
    (row,) = (line for line in lines if "lekiwi_omni_102" in line)
    assert "101.6 mm" in row and "2 x 6" in row and "147 g" in row


def test_a_wheel_is_shown_with_its_sources_and_a_copy_is_a_scene_of_the_users_own(folder):
    assert command("data", "omni_58").stdout == packaged_text("omni_58") + "\n"
    result = command("data", "omni_58", "-o", "mine.toml")
    assert result.exit_code == 0 and result.stdout == "mine.toml\n"
    assert load("mine.toml").config == load("omni_58").config
    again = command("data", "omni_58", "-o", "mine.toml")
    assert again.exit_code == 2 and "--force replaces it" in again.stderr


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_pictures_are_drawn_of_any_scenes_wheels(folder, suffix):
    pytest.importorskip("matplotlib", reason="needs the extra plot")
    result = command("data", "mixed", "fm202", "-o", f"three.{suffix}")
    assert result.exit_code == 0, result.stderr
    image = (folder / f"three.{suffix}").read_bytes()
    assert image[:4] in (b"\x89PNG", b"<?xm", b"%PDF") and len(image) > 10_000


def test_a_picture_of_no_name_shows_every_packaged_wheel_and_those_of_packaged_machines(folder):
    pytest.importorskip("matplotlib", reason="needs the extra plot")
    assert command("data", "-o", "wheels.svg").exit_code == 0
    drawn = (folder / "wheels.svg").read_text(encoding="utf-8")
    assert all(
        f"<!-- {name} -->" in drawn for name in (*packaged_wheels(), "fm202", "soccer_kit", "soccer_robot", "youbot")
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["omni_5"], "omni_5: nothing of this name comes with the package; did you mean 'omni_5"),
        (["omni_58", "omni_48", "-o", "two.toml"], "two.toml: must be .png, .svg, .pdf or, of one NAME, .toml"),
        (["-o", "all.toml"], "all.toml: must be .png, .svg, .pdf or, of one NAME, .toml"),
        (["omni_58", "-o", "wheel.stl"], "wheel.stl: must be"),
        (["omni_58", "-o", "no/such.toml"], "no/such.toml: there is no folder"),
    ],
)
def test_what_cannot_be_is_one_line_and_nothing_is_written(folder, arguments, said):
    result = command("data", *arguments)
    assert result.exit_code == 2 and said in result.stderr and len(result.stderr.splitlines()) == 1
    assert not [path for path in folder.iterdir() if not path.name.startswith(".")]
