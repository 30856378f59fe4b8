"""`omnisim new`: what it asks, what it writes, and that the machine drives its square."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from commands import command
from helpers.stages import either

import omnisim
from omnisim.scene.bought_wheel import bought_wheel
from omnisim.scene.design import KINDS, Controller, DesignError, Motor, Robot, part
from omnisim.scene.estimates import estimates
from omnisim.scene.first_scene import scene_text
from omnisim.scene.packaged import packaged_wheels
from omnisim.scene.scene import parse
from omnisim.scene.solids import gap, hub_radius
from omnisim.scene.toml_text import show_path
from omnisim_cli.main import cli
from omnisim_cli.new import MOTORS, PLACES, Quantity

ROBOTS = {
    "mecanum": Robot("mecanum", 0.076, 12.0, Controller(2.0), track=0.3, wheelbase=0.35),
    "kiwi": Robot("kiwi", 0.05, 3.0, Controller(1.0), distance=0.15),
    "mecanum on motors": Robot(
        "mecanum", 0.076, 12.0, Motor(0.35, 12.0, 785.4, 0.3, 24.0, gear_ratio=20.0), track=0.3, wheelbase=0.35
    ),
    "four-omni": Robot("four-omni", 0.03, 2.5, Controller(0.3), track=0.13, wheelbase=0.13),
}


STRENGTHS = ("torque", "stall_torque", "stall_current", "no_load_current")


def scaled(robot: Robot, scale: float, **others) -> Robot:
    """A machine of another size: lengths by scale, masses by its cube, torques by its fourth power."""
    lengths = {key: getattr(robot, key) * scale for key in ("wheel_radius", "track", "wheelbase", "distance")}
    strong = {key: getattr(robot.motor, key) * scale**4 for key in STRENGTHS if hasattr(robot.motor, key)}
    motor = robot.motor._replace(**strong)
    return robot._replace(**lengths, mass=robot.mass * scale**3, motor=motor, **others)


@pytest.mark.short
@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS.keys())
@pytest.mark.parametrize("scale", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("rollers", [None, 6, 12, 40])
def test_what_it_writes_loads_without_a_warning_at_any_size(robot, scale, rollers):
    scene = parse(scene_text(scaled(robot, scale, rollers=rollers)))
    assert scene.warnings == ()
    config = scene.config
    whole = config.chassis.mass + sum(
        kind.disk.mass + kind.roller_count * kind.roller.mass for kind in map(config.type_of, config.wheels)
    )
    assert whole == pytest.approx(robot.mass * scale**3, rel=1e-4)  # six digits; the mass is that of all together


@pytest.mark.short
@pytest.mark.parametrize("kind", KINDS)
def test_rollers_that_it_chooses_have_room_for_each_other_and_for_the_hub(kind):
    for rollers in (4, 6, 10, 20, 60):
        try:
            wheel = part(ROBOTS[kind]._replace(rollers=rollers))
        except DesignError as error:
            first, last = map(int, re.search(r"(\d+) to (\d+) do", str(error)).groups())
            assert not first <= rollers <= last
            part(ROBOTS[kind]._replace(rollers=first)), part(ROBOTS[kind]._replace(rollers=last))
            continue
        shape = wheel.shape
        assert gap(shape, KINDS[kind].rows) >= 0.0099 * shape.radius
        assert shape.roller_distance < shape.radius * math.cos(shape.alpha)
        assert wheel.hub < hub_radius(shape)


@pytest.mark.short
def test_numbers_that_are_given_are_in_the_scene_and_the_others_are_marked(folder):
    size = ("--size", "60cm", "0.4", "100mm")
    given = command("new", "m.toml", "--yes", "--rollers", 12, "--roller-diameter", "24mm", "--wheel-mass", "900 g",
                    "--friction", 0.8, *size)  # fmt: skip
    assert given.exit_code == 0, given.stderr
    text = (folder / "m.toml").read_text()
    data = tomllib.loads(text)
    kind = data["wheel_types"]["mecanum"]
    assert (kind["roller_count"], kind["roller_distance"]) == (12, pytest.approx(0.064))
    assert data["chassis"]["size"] == [0.6, 0.4, 0.1] and data["friction"]["coefficient"] == 0.8
    config = omnisim.load("m.toml").config.wheel_types["mecanum"]
    assert config.disk.mass + 12 * config.roller.mass == pytest.approx(0.9, rel=1e-5)
    marked = {line.split(" =")[0] for line in text.splitlines() if "ESTIMATED" in line and "=" in line}
    assert marked == {"disk", "roller"}
    command("new", "all.toml", "--yes")
    everything = (folder / "all.toml").read_text()
    marked = {line.split(" =")[0] for line in everything.splitlines() if "ESTIMATED" in line and "=" in line}
    assert marked == {"coefficient", "roller_distance", "roller_count", "disk", "roller", "size"}


@pytest.mark.short
def test_the_scene_says_how_to_write_it_again(folder):
    assert (
        command("new", "a.toml", "--yes", "--kind", "kiwi", "--mass", "2500 g", "--size", 0.3, 0.3, 0.1).exit_code == 0
    )
    text = (folder / "a.toml").read_text()
    again = re.search(r"^# Written by: omnisim new (.*)$", text, re.MULTILINE)[1].split()
    assert command("new", "b.toml", *again).exit_code == 0  # nothing is left to ask
    assert (folder / "b.toml").read_text() == text


@pytest.mark.short
def test_it_asks_for_what_is_not_given_until_the_answer_is_good(folder):
    answers = "kiwi\n\n0.2 parsec\n200 mm\n4kg\nrate\n15 kg cm\n"
    result = CliRunner().invoke(cli, ["new", "k.toml"], input=answers)
    assert result.exit_code == 0 and result.stdout == "k.toml\n"  # questions go to stderr
    assert "Radius of a wheel [50 mm]" in result.stderr and "'0.2 parsec': must be a number > 0" in result.stderr
    config = omnisim.load("k.toml").config
    assert math.hypot(*config.wheels[0].position) == pytest.approx(0.2, rel=1e-5)
    assert config.wheels[0].drive.torque_limit == pytest.approx(15 * 9.80665e-2, rel=1e-5)
    assert "Track" not in result.stderr
    fewer = CliRunner().invoke(cli, ["new", "f.toml", "--kind", "kiwi", "--torque", "1"], input="\n\n\n")
    assert fewer.exit_code == 0 and "Kind" not in fewer.stderr and "torque" not in fewer.stderr


@pytest.mark.short
@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [("0.076", "m", 0.076), ("76 mm", "m", 0.076), ("3in", "m", 0.0762), ("7500 rpm", "rad/s", 250 * math.pi),
     ("15 kg cm", "N m", 1.47099750), ("200 mN m", "N m", 0.2), ("100 oz.in", "N m", 0.70615518), ("500mA", "A", 0.5)],
)  # fmt: skip
def test_units_of_data_sheets_are_understood(text, unit, value):
    assert Quantity(unit).convert(text, None, None) == pytest.approx(value, rel=1e-8)


@pytest.mark.short
@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--wheel-radius", "76"], "a wheel of 76 m; a number without a unit is in metres: 76mm?"),
        (["--wheel-radius", "76 parsec"], "'76 parsec': must be a number > 0 with a unit or none: m, mm, cm, in"),
        (["--mass", "-3"], "'-3': must be a number > 0"),
        (["--kind", "kiwi", "--track", "0.3"], "--track: not of --kind kiwi, which has --distance"),
        (["--motor", "rate", "--gear", "20"], "--gear: not of --motor rate, which has --torque"),
        (["--roller-diameter", "60mm"], "10 rollers of 60 mm do not fit on this wheel; diameters from 10.5 to 28"),
        (["--wheel-mass", "0.1"], "a wheel of 0.1 kg is too light: 10 rollers alone weigh 0.352 kg"),
        (["--mass", "1"], "a machine of 1 kg is too light: its 4 wheels weigh 2.82 kg"),
        (["--torque", "2 mNm"], "the motors are too weak for this speed: it takes 228 s to reach 0.5 m/s"),
        (["--track", "30mm"], "these numbers make no machine; nothing was written\n       wheels.front_right.position"),
    ],
)  # fmt: skip
def test_numbers_that_make_no_machine_are_refused_in_a_sentence(folder, options, told):
    result = command("new", "q.toml", "--yes", *options)
    assert result.exit_code == 2 and told in result.stderr
    assert not list(folder.iterdir())


@pytest.mark.short
def test_nothing_is_overwritten_unless_forced_and_no_answer_writes_nothing(folder):
    (folder / "robot.toml").write_text("mine")
    refused = command("new", "--yes")
    assert refused.exit_code == 2 and "robot.toml: exists already; --force replaces it" in refused.stderr
    assert (folder / "robot.toml").read_text() == "mine"
    assert command("new", "--yes", "--force").exit_code == 0
    assert omnisim.load("robot.toml").warnings == ()
    silent = command("new", "other.toml")
    assert silent.exit_code == 2 and "--kind: no answer, and nothing was written; --yes takes" in silent.stderr
    assert command("new", "robot.csv", "--yes").stderr.startswith("Error: robot.csv: a scene is a TOML file")
    assert {path.name for path in folder.iterdir()} == {"robot.toml"}


@pytest.mark.parametrize("name", either(ROBOTS, ["kiwi", "mecanum on motors"]))
def test_the_machine_drives_its_square(name):
    """Sides of 1 m. Strafing mecanum wheels of ten rollers fall short by 1 - sin(alpha) / alpha, 1.6 per cent."""
    robot = ROBOTS[name]
    scene = parse(scene_text(robot))
    run = omnisim.simulate(scene)
    assert run.complete
    times, rows = scene.config.command.times, run.time
    corners = np.array(
        [run["body/position"][np.searchsorted(rows, times[3 * side] - 1e-9)][:2] for side in range(1, 5)]
    )
    short = 1.0 - math.sin(math.pi / 10) / (math.pi / 10) if robot.kind == "mecanum" else 0.0
    y = 1.0 - short
    end = run["body/position"][-1][:2]
    np.testing.assert_allclose(corners, [[1.0, 0.0], [1.0, y], [0.0, y], [0.0, 0.0]], atol=0.01)  # measured 6.1e-3
    np.testing.assert_allclose(end, [0.0, 0.0], atol=1e-3)  # measured 2e-4: it comes back as short as it went
    assert abs(run["body/yaw"][-1]) < 1e-3  # measured 6.2e-5


@pytest.mark.short
def test_the_page_shows_what_it_writes_and_what_is_estimated_and_doubted():
    page = (Path(__file__).parents[2] / "docs/pages/robot.md").read_text()
    text = scene_text(ROBOTS["mecanum"])
    (block,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert block in text
    found = list(estimates(parse(text).config))
    assert len(found) == 7 and all(show_path(one.path) in page and one.value in page for one in found)
    first, second = re.findall(r"Warning: platform.toml:\d+: (.*?)\n(?=Warning|```)", page, re.DOTALL)
    (large,) = parse(text.replace("radius = 0.076", "radius = 76")).warnings
    assert large.partition(": ")[2] == first
    hands = [f"wheels.{name}.mirrored=true" for name in ("front_left", "rear_right")]
    hands += [f"wheels.{name}.mirrored=false" for name in ("front_right", "rear_left")]
    (told,) = parse(text, overrides=hands).warnings
    assert told.endswith(" ".join(second.split()))


@pytest.mark.short
def test_every_option_and_kind_is_on_the_page():
    page = (Path(__file__).parents[2] / "docs/pages/robot.md").read_text()
    assert all(f"`{word}`" in page for word in (*PLACES, *MOTORS))
    assert all(f"--{name.replace('_', '-')}" in page for names in PLACES.values() for name in names)


@pytest.mark.short
def test_a_motor_is_taken_from_its_data_sheet_with_the_units_printed_there(folder):
    sheet = ("--voltage", 12, "--stall-torque", "6 kg cm", "--stall-current", "5.5", "--no-load-speed", "1000 rpm",
             "--no-load-current", "200mA", "--gear", 10)  # fmt: skip
    made = command("new", "m.toml", "--yes", *sheet)
    assert made.exit_code == 0, made.stderr
    drive = omnisim.load("m.toml").config.wheels[2].drive
    assert (drive.kind, drive.nominal_voltage, drive.stall_current, drive.no_load_current) == ("dc_motor", 12, 5.5, 0.2)
    assert drive.stall_torque == pytest.approx(0.588399, rel=1e-5) and drive.gear_ratio == 10
    assert drive.no_load_speed == pytest.approx(1000 * math.pi / 30, rel=1e-5)
    wrong = command("new", "w.toml", "--yes", *sheet, "--stall-torque", "60 kg cm")
    assert wrong.exit_code == 2 and "wheels.front_left.drive.stall_torque = 5.88399: contradicts" in wrong.stderr
    assert wrong.stderr.count("contradicts") == 1  # of four motors
    assert "--torque: not of --motor dc_motor" in command("new", "w.toml", "--motor", "dc_motor", "--torque", 1).stderr


@pytest.mark.short
@pytest.mark.parametrize("name", packaged_wheels())
def test_a_robot_on_a_packaged_wheel_loads_without_a_warning(name):
    """It has that wheel, and what the wheel's own scene needs: rubber, method, step."""
    wheel, own = bought_wheel(name), omnisim.load(name).config
    for kind in wheel.kinds:
        lengths = dict.fromkeys(("track", "wheelbase", "distance"), 6.0 * wheel.radius)
        robot = Robot(kind, wheel.radius, 4.0 * wheel.mass + 3.0, Controller(2.0), wheel=name, **lengths)
        scene = parse(scene_text(robot))
        assert scene.warnings == ()
        config = scene.config
        assert config.wheel_types[name] == own.wheel_types[name]
        assert config.upright == ("free" if own.upright == "free" else "contacts")
        assert (abs(own.wheel_types[name].roller_angle_deg) > 20.0) == (kind == "mecanum")


def test_a_wheel_that_is_sold_settles_what_it_has(folder):
    assert command("new", "desk.toml", "--yes", "--wheel", "xrp_omni_70", "--kind", "kiwi").exit_code == 0
    text = Path("desk.toml").read_text()
    assert tomllib.loads(text)["wheel_types"] == {"xrp_omni_70": {"from": "xrp_omni_70"}}
    again = re.search("Written by: omnisim (.*)", text)[1].split()
    assert command(*again, "again.toml").exit_code == 0 and Path("again.toml").read_text() == text
    for options, told in (
        (["xrp_omni_7"], "--wheel xrp_omni_7: no packaged wheel has this name; did you mean 'xrp_omni_70'?"),
        (
            ["xrp_omni_70", "--kind", "mecanum"],
            "--kind mecanum: not of --wheel xrp_omni_70, which is for kiwi, four-omni",
        ),
        (["xrp_omni_70", "--wheel-radius", "3cm"], "--wheel-radius: --wheel xrp_omni_70 has its own"),
        (["omni_125", "--mass", "1"], "a machine of 1 kg is too light: its 4 wheels weigh"),
    ):
        result = command("new", "other.toml", "--yes", "--wheel", *options)
        assert result.exit_code == 2 and told in result.stderr and not Path("other.toml").exists()
