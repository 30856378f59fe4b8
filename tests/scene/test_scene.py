"""From files, packaged names and --set to a Scene, or to a SceneError that says what to change."""

import dataclasses
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from vehicles import VEHICLE

from omnisim.base.formatting import visible
from omnisim.scene.scene import Scene, SceneError, load, packaged_scenes, parse

pytestmark = pytest.mark.short

FILE = Path(__file__).parents[1] / "reference" / "testbench_psi0.toml"
TEXT = FILE.read_text()
# The same scene in other legal layouts, to set keys in.
INLINE_WHEELS = 'wheels = [{ name = "wheel", type = "omni", drive = { kind = "free" } }]\n' + (
    TEXT[: TEXT.index("[[wheels]]")] + TEXT[TEXT.index("[initial]") :]
)
SUB_TABLE = TEXT.replace("[initial]", '[wheels.drive]  # a table\nkind = "free"\n[initial]')
DOTTED = "time.end = 2.0\ntime.step = 0.001\n" + TEXT.replace(
    "[time]\nend = 2.0\nstep = 0.001\noutput_interval = 0.05\n", ""
)


def message(source, *overrides: str) -> str:
    with pytest.raises(SceneError) as error:
        load(source, overrides)
    return str(error.value)


def set_message(*overrides: str) -> str:
    with pytest.raises(SceneError) as error:
        parse(TEXT, "s.toml", overrides)
    return str(error.value)


@pytest.mark.parametrize("source", [FILE, str(FILE)], ids=["Path", "str"])
def test_a_file_loads_with_its_text_stem_and_path(source):
    scene = load(source)
    assert (scene.text, scene.name, scene.source) == (TEXT, "testbench_psi0", str(FILE))
    assert scene.config.time.steps == 2000


def test_a_scene_is_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        load(FILE).text = ""


def test_every_packaged_scene_loads_by_name_and_keeps_its_name():
    for name in packaged_scenes():
        scene = load(name)
        assert (scene.name, scene.source) == (name, name)
        assert parse(scene.text).config == scene.config


def test_a_file_goes_before_a_packaged_scene_and_a_folder_does_not(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("omnisim.scene.scene.packaged_scenes", lambda: ["packed", "folder"])
    monkeypatch.setattr("omnisim.scene.scene._packaged", lambda name: FILE)
    Path("packed").write_text(TEXT.replace("Testbench", "Mine"))
    Path("folder").mkdir()
    assert load("packed").config.title.startswith("Mine")
    assert load("folder").config.title.startswith("Testbench")


def test_an_unknown_name_lists_the_packaged_scenes_and_the_nearest(monkeypatch):
    monkeypatch.setattr("omnisim.scene.scene.packaged_scenes", lambda: ["authors_testbench", "sliding_wheel"])
    assert message("slidingwheel").startswith("slidingwheel: no file and no packaged scene has this name;")
    assert "did you mean 'sliding_wheel'? Packaged scenes: authors_testbench, sliding" in message("slidingwheel")
    assert message("x") == (
        "x: no file and no packaged scene has this name. Packaged scenes: authors_testbench, sliding_wheel"
    )
    assert message("sliding_wheel.toml").endswith("no such file; did you mean the packaged scene 'sliding_wheel'?")


@pytest.mark.parametrize("source", ["missing.toml", os.path.join("some", "where"), "a\0b.toml"])
def test_a_missing_file_is_said_to_be_missing(source):
    assert message(source) == f"{visible(source)}: there is no such file"


def test_a_folder_is_no_scene(tmp_path):
    assert message(tmp_path) == f"{tmp_path}: cannot read this file: Is a directory"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads everything")
def test_an_unreadable_file_is_said_to_be_unreadable(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(TEXT)
    path.chmod(0)
    assert message(path) == f"{path}: cannot read this file: Permission denied"


def test_a_name_too_long_for_the_system_is_an_answer_and_no_traceback():
    assert "cannot read this file" in message("x" * 5000)


def test_text_that_is_not_utf8_names_the_line(tmp_path):
    path = tmp_path / "s.toml"
    path.write_bytes(b'schema = 1\ntitle = "\xfcber"\n')
    assert message(path).startswith(f"{path}:2: not a text in UTF-8")


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path):
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert load(path).config == load(FILE).config
    assert load(path, ["time.step=0.002"]).config.time.step == 0.002


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        (
            "step = 0.001",
            "step 0.001",
            10,
            "Expected '=' after a key in a key/value pair (line 10, column 6)",
        ),
        (
            "step = 0.001",
            "step = 0.001\nstep = 2",
            11,
            "Cannot overwrite a value (line 11, column 9): 'step = 2'",
        ),
        ("[solver]", "[time]", 13, "Cannot declare ('time',) twice (line 13"),
        ("step = 0.001", "step = .1", 10, "Invalid value (line 10, column 8): 'step = .1'"),
        ("yaw_rate = 1.2", 'x = """open', 41, "Unterminated string (line 41, end of the file)"),
    ],
)
def test_what_is_no_toml_names_line_column_and_text(old, new, line, said):
    with pytest.raises(SceneError) as error:
        parse(TEXT.replace(old, new).rstrip("\n"), "s.toml")
    assert str(error.value).startswith(f"s.toml:{line}: not valid TOML: {said}")


@pytest.mark.parametrize("value", ["[" * 5000 + "]" * 5000, "1" + "0" * 5000])
def test_monstrous_values_give_a_message(value):
    with pytest.raises(SceneError, match="not valid TOML"):
        parse(TEXT.replace("9.81", value))


# --- overrides ------------------------------------------------------------------------------------

OVERRIDES = [
    "title=Run #3: fast",
    "time.step=0.0005",
    "time.output_interval = 0.1",
    "solver.method=heun",
    'solver.tracking="implicit"',
    "scene.gravity=1",
    "friction={law = 'saturated', coefficient = 0.1}",
    "wheels.wheel.spin_rate=-3",
    "wheels.wheel.mirrored=true",
    "wheels.wheel.roller_rates=0.5",
    "wheels.wheel.drive={kind = 'torque', torque = 1}",
    "wheels.wheel.drive.times=[0, 1]",
    "wheels.wheel.drive.torque=[2, 3]",
    "wheel_types.omni.disk.mass=2",
    "wrench.times=[0.5]",
    "wrench.force=[[1, 2, 3]]",
    'initial."yaw_deg"=90',
]


@pytest.mark.parametrize("text", [TEXT, INLINE_WHEELS, SUB_TABLE, DOTTED], ids=["plain", "inline", "table", "dotted"])
def test_loading_the_text_of_a_scene_with_overrides_repeats_it(text):
    scene = parse(text, "s.toml", OVERRIDES)
    assert parse(scene.text).config == scene.config
    config = scene.config
    wheel = config.wheels[0]
    assert (config.title, config.time.step, config.time.output_interval) == ("Run #3: fast", 0.0005, 0.1)
    assert (config.solver.method, config.solver.tracking, config.world.gravity) == ("heun", "implicit", 1.0)
    assert (config.friction.law, config.friction.coefficient) == ("saturated", 0.1)
    assert (wheel.spin_rate, wheel.mirrored, wheel.roller_rates) == (-3.0, True, 0.5)
    assert wheel.drive.table == ((0.0, 1.0), (2.0, 3.0))
    assert config.wheel_types["omni"].disk.mass == 2.0
    assert config.wrench.table == ((0.5,), ((1.0, 2.0, 3.0),), (0.0,))
    assert config.initial.yaw_deg == 90.0


VEHICLE_OVERRIDES = [
    "wheels.rl.drive.torque=2",
    "wheels.rl.drive.kind=torque",
    "wheels.fr.drive={kind = 'dc_motor', voltage = 12, resistance = 2, torque_constant = 0.1}",
    "wheels.fl.drive={kind = 'rate', rate = 3, proportional = 1}",
    "wheels.fl.drive.torque_limit=0.5",
    "wheels.rr.position=[-0.3, -0.1]",
    "chassis.mass=7",
    "scene.upright=servo",
]


def test_overrides_find_each_of_several_wheels_by_its_name():
    scene = parse(VEHICLE, "s.toml", VEHICLE_OVERRIDES)
    assert parse(scene.text).config == scene.config
    fl, fr, rl, rr = scene.config.wheels
    assert (fl.drive.kind, fl.drive.table, fl.drive.torque_limit) == ("rate", ((0.0,), (3.0,)), 0.5)
    assert (fr.drive.kind, fr.drive.table) == ("dc_motor", ((0.0,), (12.0,)))
    assert (rl.drive.kind, rl.drive.table) == ("torque", ((0.0,), (2.0,)))
    assert (rr.drive.kind, rr.position, scene.config.chassis.mass) == ("free", (-0.3, -0.1), 7.0)
    assert scene.config.upright == "servo"


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("wheels.rl.drive.kind=rate", "wheels.rl.drive.proportional: missing; must be a finite number > 0"),
        ("wheels.rl.drive={kind='torque', torque=1, rate=1}", "wheels.rl.drive.rate = 1: not a key of a drive with"),
        ("chassis.center_of_mass=[1, 0, 0]", "chassis.center_of_mass = [1, 0, 0]: the common centre of mass"),
        ("chassis.inertia=[1, 1, 3]", "chassis.inertia[2] = 3: must be at most the sum of the other two = 2:"),
        (
            "scene.upright=srevo",
            'scene.upright = \'srevo\': must be "servo", "contacts" or "free"; did you mean \'servo\'?',
        ),
        ("wheels.rx.spin_rate=1", "no wheel is called 'rx'. Wheels: fl, fr, rl, rr"),
        ("command={times=[0], twist=[[1, 0, 0]]}", "command = {times = [0], twist = [[1, 0, 0]]}: no wheel follows it"),
    ],
)
def test_a_defect_of_a_vehicle_that_was_set_is_placed_at_its_set(override, said):
    with pytest.raises(SceneError) as error:
        parse(VEHICLE, "s.toml", [override])
    assert str(error.value).splitlines()[0].startswith(f"--set {override}: {said}")


def test_each_single_override_survives_in_the_text():
    for override in OVERRIDES[:11]:
        scene = parse(TEXT, "s.toml", [override])
        assert scene.config != parse(TEXT).config
        assert parse(scene.text).config == scene.config


def test_overrides_keep_comments_and_what_they_do_not_touch():
    text = TEXT.replace("step = 0.001", "step = 0.001  # s")
    changed = parse(text, "s.toml", ["time.step=0.002"]).text
    assert changed == text.replace("step = 0.001  # s", "step = 0.002  # s")


def test_without_overrides_the_text_is_the_file():
    assert parse(TEXT).text == TEXT


def test_a_renamed_wheel_answers_to_its_new_name():
    scene = parse(TEXT, "s", ["wheels.wheel.name=left", "wheels.left.spin_rate=1"])
    assert scene.config.wheels[0].spin_rate == 1.0


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("time.step", "must be KEY=VALUE with a dotted key, such as time.step=0.001"),
        ("=1", "must be KEY=VALUE"),
        ("time..step=1", "must be KEY=VALUE"),
        ("wheels.whel.spin_rate=1", "no wheel is called 'whel'; did you mean 'wheel'? Wheels: wheel"),
        ("wheels.x.spin_rate=1", "no wheel is called 'x'. Wheels: wheel"),
        ("wheels.wheel=1", "must set a key of the wheel, such as wheels.wheel.spin_rate=1.0"),
        ("time.step.x=1", "time.step = 0.001 is not a table and has no keys"),
        ("wheels.wheel.name.x=1", "wheels.wheel.name = 'wheel' is not a table and has no keys"),
        ("time.step=abc", "time.step = 'abc': must be a finite number > 0"),
        ("time.step=.5", "time.step = '.5': must be a finite number > 0; did you mean 0.5?"),
        ("time.step=", "time.step = '': must be a finite number > 0"),
        ("time.step=nan", "time.step = nan: must be a finite number > 0"),
        ("time.stepp=1", "time.stepp = 1: unknown key; did you mean 'step'?"),
        ("time=3", "time = 3: must be a table with the keys end, step, output_interval"),
        ("wheels=3", "wheels = 3: must be one or more tables [[wheels]]"),
        ("scene.upright=contacts", "scene.upright = 'contacts': must be \"servo\" without"),
        ("wrench.frame=body", "wrench.times: missing"),
        ("wheels.wheel.drive.torque=1", "wheels.wheel.drive.kind: missing"),
        ("time={step = 0, end = 1}", "time.step = 0: must be a finite number > 0"),
        ("wheels.wheel.type=onmi", "wheels.wheel.type = 'onmi': no such wheel type; did you mean 'omni'?"),
    ],
)
def test_a_defect_that_was_set_is_placed_at_its_set(override, said):
    assert set_message(override).startswith(f"--set {override}: {said}")
    assert "\n" not in set_message(override)


def test_a_set_that_upsets_a_key_of_the_file_is_placed_at_its_line_in_the_file():
    assert set_message("title=x", "time.step=0.0003").startswith("s.toml:11: time.output_interval = 0.05: ")


def test_set_defects_come_first_and_lines_are_those_of_the_original_file():
    text = TEXT.replace("radius = 0.05", "radius = -1")
    with pytest.raises(SceneError) as error:
        parse(text, "s.toml", ["wrench={times = [0, 1],\n force = 3}", "title=x", "time.step=0"])
    starts = [line.split(": ")[0] for line in str(error.value).splitlines() if line.startswith(("--", "s."))]
    assert starts[-1] == "s.toml:23"
    assert "--set time.step=0" in starts


def test_importing_the_scene_module_loads_no_heavy_library():
    code = "import omnisim.scene.scene, sys; print(*sys.modules)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numba", "h5py", "matplotlib", "scipy", "tomlkit"} & set(result.stdout.split())


def test_a_text_without_a_file_has_a_name_to_store_under():
    scene = parse(TEXT)
    assert isinstance(scene, Scene) and scene.name == "scene"
    assert tomllib.loads(scene.text)["schema"] == 1
