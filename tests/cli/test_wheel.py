"""What a user of `omnisim wheel` meets: dimensions, files, messages."""

import builtins
import os
from xml.etree import ElementTree

import pytest
from commands import command

import omnisim
from omnisim.scene.scene import packaged_scenes
from omnisim.studies import wheel_cycle
from omnisim_cli.wheel_cycle import table

pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize("scene", [name for name in packaged_scenes() if name not in ("kiwi_ramp", "wheel_bench")])
def test_every_packaged_wheel_has_its_dimensions_told(scene):
    result = command("wheel", scene)
    assert result.exit_code == 0, result.stderr
    for heading in ("rolling radius", "roller length", "u, mm", "neighbours", "3 spheres"):
        assert heading in result.stdout


def test_youbots_wheel_is_told_as_its_scene_has_it():
    said = command("wheel", "youbot").stdout
    for fact in ("47.5000 mm", "0.0475 m at every angle", "6, axes at 36.0000 mm", "gap of 6.0090 mm"):
        assert fact in said
    profile = [line.split() for line in said.splitlines() if line.endswith("11.0955")]
    assert profile == [["-31.4907", "5.5477", "11.0955"], ["31.4907", "5.5477", "11.0955"]]


def test_straight_rollers_that_overlap_are_warned_of():
    assert "they overlap: in one row the exact rollers do not fit" in command("wheel", "kiwi").stdout
    assert "Warning: the rollers of this wheel overlap" in command("wheel", "kiwi", "-o", "kiwi.stl").stderr


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_a_drawing_is_written(folder, suffix):
    pytest.importorskip("matplotlib")
    assert command("wheel", "mixed", "--type", "omni", "-o", f"omni{suffix}").exit_code == 0
    assert os.listdir(folder) == [f"omni{suffix}"]


def test_without_matplotlib_a_drawing_says_what_to_install(folder, monkeypatch):
    original = builtins.__import__

    def absent(name, *arguments, **options):
        if name.startswith(("matplotlib", "omnisim.cad.drawing")):
            raise ImportError(name)
        return original(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", absent)
    result = command("wheel", "youbot", "-o", "wheel.png")
    assert (result.exit_code, os.listdir(folder)) == (2, [])
    assert result.stderr == "Error: a drawing needs matplotlib: pip install 'omnisim-engine[plot]'\n"


@pytest.mark.parametrize("arguments", [("-o", "wheel.stl"), ("--part", "roller", "-o", "roller.obj")])
def test_a_mesh_is_written_with_the_rolling_radius_in_its_head(folder, arguments):
    assert command("wheel", "youbot", *arguments).exit_code == 0
    assert b"rolling radius for the controller 0.0475 m" in (folder / arguments[-1]).read_bytes()[:82]


@pytest.mark.parametrize("suffix", [".xml", ".urdf"])
def test_a_model_is_written_with_the_rollers_of_all_types_beside_it(folder, suffix):
    result = command("wheel", "mixed", "-o", f"machine{suffix}")
    assert result.exit_code == 0, result.stderr
    parts = ("roller",) if suffix == ".urdf" else ("contact", "roller")
    files = [f"machine{suffix}", *(f"machine_{kind}_{part}.stl" for kind in ("mecanum", "omni") for part in parts)]
    assert sorted(os.listdir(folder)) == files
    assert sorted(result.stdout.split()) == files
    named = {mesh.get("file") or mesh.get("filename") for mesh in ElementTree.parse(files[0]).iter("mesh")} - {None}
    assert named == set(files[1:])


def test_a_file_that_exists_is_kept_unless_forced(folder):
    (folder / "machine_mecanum_roller.stl").write_text("precious")
    for output in ("machine.xml", "machine_mecanum_roller.stl"):
        result = command("wheel", "youbot", "-o", output)
        assert result.exit_code == 2 and "exists already; --force replaces it" in result.stderr
    assert (folder / "machine_mecanum_roller.stl").read_text() == "precious"
    assert os.listdir(folder) == ["machine_mecanum_roller.stl"]
    assert command("wheel", "youbot", "-o", "machine.xml", "--force").exit_code == 0


def test_models_in_both_formats_stand_side_by_side_with_the_same_mesh(folder):
    for suffix in (".urdf", ".xml"):
        assert command("wheel", "kiwi", "-o", f"machine{suffix}").exit_code == 0
    assert sorted(os.listdir(folder)) == [
        "machine.urdf", "machine.xml", "machine_omni_contact.stl", "machine_omni_roller.stl"
    ]  # fmt: skip
    named = [{mesh.get("file") or mesh.get("filename") for mesh in ElementTree.parse(f"machine{suffix}").iter("mesh")}
             for suffix in (".urdf", ".xml")]  # fmt: skip
    assert named[0] == {"machine_omni_roller.stl"} and named[0] < named[1]
    assert command("wheel", "kiwi", "-o", "machine.urdf").exit_code == 2  # the description itself is not replaced


PACKAGE_XML = '<package format="3"><name>my_robot</name></package>'


@pytest.mark.parametrize(("place", "content", "prefix"), [
    ("my_robot/urdf", None, "package://my_robot/urdf/"),
    ("checkout/robots/a", PACKAGE_XML, "package://my_robot/robots/a/"),
    ("my_robot", PACKAGE_XML.replace("my_robot", "other"), "package://my_robot/"),
    ("elsewhere", None, "package://my_robot/"),
])  # fmt: skip
def test_a_package_name_leads_from_its_folder_to_the_meshes(folder, place, content, prefix):
    """By the name of a folder or of its package.xml; else as if the model's folder were the package, with a warning."""
    (folder / place).mkdir(parents=True)
    if content:
        (folder / place.split("/")[0] / "package.xml").write_text(content)
    result = command("wheel", "kiwi", "-o", f"{place}/machine.urdf", "--package", "my_robot")
    assert result.exit_code == 0, result.stderr
    assert ("is the package 'my_robot'" in result.stderr) == (prefix == "package://my_robot/")
    named = {mesh.get("filename") for mesh in ElementTree.parse(f"{place}/machine.urdf").iter("mesh")}
    assert named == {f"{prefix}machine_omni_roller.stl"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("youbot", "-o", "no/such/folder/y.urdf"), "there is no folder"),
        (("youbot", "-o", "y.xml", "--package", "my_robot"), "--package is for .urdf"),
        (("youbot", "--package", "my_robot"), "--package is for .urdf"),
        (("youbot", "-o", "y.urdf", "--package", "package://a"), "must be the name of a ROS package"),
        (("youbot", "-o", "y.urdf", "--package", ""), "must be the name of a ROS package"),
        (
            ("mixed", "--type", "omnj"),
            "--type omnj: no such wheel type; did you mean 'omni'? The scene has: mecanum, omni",
        ),
        (("mixed", "--type", "x"), "--type x: no such wheel type. The scene has: mecanum, omni"),
        (("youbot", "-o", "wheel.step"), "one of .png, .svg, .pdf, .stl, .obj, .xml, .urdf"),
        (("youbot", "-o", "wheel"), "the suffix says what to write"),
        (("youbot", "--part", "roller", "-o", "wheel.png"), "--part is for meshes: .stl, .obj"),
        (("mixed", "--type", "omni", "-o", "wheel.xml"), "a .xml has all wheels of the scene"),
        (("no_such_scene",), "no packaged scene has this name"),
    ],
)
def test_a_wrong_argument_is_told_and_nothing_is_written(folder, arguments, message):
    result = command("wheel", *arguments)
    assert (result.exit_code, os.listdir(folder)) == (2, [])
    assert message in result.stderr.replace("\n       ", " ")


# --- several wheels -------------------------------------------------------------------------------


def test_several_wheels_are_told_side_by_side_and_drawn(folder):
    pytest.importorskip("matplotlib")
    result = command("wheel", "youbot", "kiwi", "--mass", "15", "-o", "both.png")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.startswith("four wheels each under a platform of 15 kg, their centres at 0.5 m/s\n")
    lines = result.stdout.splitlines()
    assert [line for line in lines if line in ("forward", "sideways", "diagonal", "turning")] == [
        "forward", "sideways", "diagonal", "turning",
    ]  # fmt: skip
    youbot = [line.split() for line in lines if line.startswith("  youbot")]
    assert float(youbot[0][1]) == 0.0 and float(youbot[1][1]) == pytest.approx(-4.51, abs=0.05)  # sin alpha / alpha
    assert lines[-1] == "both.png" and (folder / "both.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_a_wheel_whose_run_stops_says_why_below_its_line(monkeypatch):
    """Where no other method carries it to its end either."""
    monkeypatch.setattr(wheel_cycle, "CURES", ())
    result = command("wheel", "kiwi", "kiwi_ramp", "--mass", "200")
    assert result.exit_code == 0
    assert "  kiwi_ramp: unstable at t = " in result.stdout
    assert any(line.split() == ["kiwi_ramp", *"------"] for line in result.stdout.splitlines())


def test_a_wheel_that_took_another_method_says_so_below_its_line():
    wheels = wheel_cycle.candidates([omnisim.load("youbot")])
    found = wheel_cycle.Found(0.0, 0.0, None, 0.0, 0.0, 1.0, ("radau5", 1e-3))
    told = table("forward", wheels, [{"forward": found}]).splitlines()
    assert told[-1] == "  youbot: by radau5 with time.step = 0.001 s, since its own stops early"
    assert len(table("forward", wheels, [{"forward": found._replace(cure=None)}]).splitlines()) == len(told) - 1


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("youbot", "--mass", "15"), "--mass and --speed are for several scenes, whose wheels carry a platform"),
        (("youbot", "kiwi", "--type", "omni"), "--type is for the wheels of one scene"),
        (("youbot", "kiwi", "-o", "both.stl"), "both.stl: a picture of several wheels is one of .png, .svg, .pdf"),
        (("youbot", "kiwi", "--mass", "1"), "four wheels of youbot weigh more than the platform of 1 kg; see --mass"),
        (("youbot", "kiwy"), "kiwy: no file and no packaged scene has this name; did you mean 'kiwi'?"),
    ],
)
def test_what_several_wheels_cannot_be_asked_is_told_in_one_line(folder, arguments, told):
    result = command("wheel", *arguments)
    assert (result.exit_code, result.stdout, os.listdir(folder)) == (2, "", [])
    assert result.stderr.startswith(f"Error: {told}") and result.stderr.count("\n") == 1
