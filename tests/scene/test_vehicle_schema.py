"""What the scene of a vehicle may say: one line for every defect of its chassis, its wheels and its command."""
# ruff: noqa: E501 (the table of defects reads best with one defect to a line)

import pytest
from scene_text import assert_one_line, message, replaced
from vehicles import FOLLOWING, VEHICLE

from omnisim.scene.scene import parse

pytestmark = pytest.mark.short

# Each defect as (old, new, line, key and value, what is allowed), of a vehicle and of one whose wheels follow a command.
FL, FR, RL, RR = VEHICLE.splitlines(keepends=True)[4:8]
UPRIGHT, CENTER, INERTIA = '[scene]\nupright = "contacts"\n', "[0.02, 0.0, 0.1]", "[0.1, 0.2, 0.25]"
VEHICLE_DEFECTS = {
    "two wheels on contacts": (RL + RR, "", 9, "scene.upright = 'contacts'", "needs three wheels or more: two contacts cannot"),
    "one wheel on contacts": (FR + RL + RR, "", 8, "scene.upright = 'contacts'", 'one contact cannot carry roll and pitch; use "servo"'),
    "two wheels by default": (RL + RR + "]\n" + UPRIGHT, "]\n", 15, "chassis = {", 'upright = "contacts", the default with a chassis, needs'),
    "wheels on one line": (FL + FR, FL.replace("[0.2, 0.1]", "[-0.2, 0]"), 10, "scene.upright = 'contacts'", "the wheel centres lie on one line"),
    "centre of mass ahead": (CENTER, "[0.4, 0, 0.1]", 21, "chassis.center_of_mass = [0.4, 0, 0.1]", "mass, at [0.24, 0], lies outside of the wheels: 0.04 m beyond the line from 'fr' to 'fl'; the machine would tip"),
    "centre of mass to the left": (CENTER, "[0, 0.2, 0.1]", 21, "chassis.center_of_mass = [0, 0.2, 0.1]", "0.02 m beyond the line from 'fl' to 'rl'"),
    "centre of mass under the floor": (CENTER, "[0, 0, -1]", 21, "chassis.center_of_mass[2] = -1", "three finite numbers [x, y, z], z >= 0"),
    "planar centre of mass": (CENTER, "[0, 0]", 21, "chassis.center_of_mass = [0, 0]", "three finite numbers [x, y, z]"),
    "missing chassis key": ("mass = 6.0\n", "", 19, "chassis.mass", "missing; must be a finite number > 0"),
    "misspelt chassis key": ("mass = 6.0", "mas = 6.0", 20, "chassis.mas = 6.0", "unknown key; did you mean 'mass'? Allowed: mass, center_of_mass"),
    "massless chassis": ("mass = 6.0", "mass = 0", 20, "chassis.mass = 0", "must be a finite number > 0"),
    "chassis as an array": ("[chassis]", "[[chassis]]", 19, "chassis = [", "must be a table with the keys mass, center_of_mass, inertia"),
    "impossible chassis": (INERTIA, "[0.1, 0.2, 0.31]", 22, "chassis.inertia[2] = 0.31", "must be at most the sum of the other two = 0.3: no body"),
    "chassis without an inertia": (INERTIA, "[0.1, 0.2, 0]", 22, "chassis.inertia[2] = 0", "three finite numbers > 0 [Ixx, Iyy, Izz]"),
    "wheel without a position": (", position = [0.2, 0.1]", "", 5, "wheels.fl.position", "missing; on a chassis it must be two finite numbers"),
    "unknown type of a wheel": ('"rl", type = "mecanum"', '"rl", type = "omni"', 7, "wheels.rl.type = 'omni'", "no such wheel type"),
    "duplicate name": ('"rl"', '"fl"', 7, "wheels.fl.name = 'fl'", "must be unique"),
    "wheels without a chassis": (VEHICLE[VEHICLE.index("[chassis]") :], "", 6, "wheels.fr = {", "several wheels need a [chassis]"),
    "misspelt chassis": ("[chassis]", "[chasis]", 19, "chasis = {", "did you mean 'chassis'?"),
}  # fmt: skip
COMMAND_DEFECTS = {
    "four parallel omni wheels": ("deg = 45.0", "deg = 0", 23, "command = {", "(fl, fr, rl, rr) do not determine vx, vy and yaw_rate; they leave open: sideways motion"),
    "missing command key": ("twist = [[0, 0, 0], [0.5, 0.2, -1]]\n", "", 23, "command.twist", "must be a list of one or more twists [vx, vy, yaw_rate]"),
    "misspelt command key": ("times", "time", 24, "command.time = [0, 1]", "did you mean 'times'?"),
    "short command": ("times = [0, 1]", "times = [0]", 25, "command.twist = [[0, 0, 0], [0.5, 0.2, -1]]", "as long as times (1), not 2"),
    "falling command times": ("times = [0, 1]", "times = [0, -1]", 24, "command.times[1] = -1", "times never decrease"),
    "planar twist": ("0.2, -1]]", "0.2]]", 25, "command.twist[1] = [0.5, 0.2]", "twists [vx, vy, yaw_rate] of finite numbers"),
}  # fmt: skip
EVERY_DEFECT = {name: (VEHICLE, *defect) for name, defect in VEHICLE_DEFECTS.items()}
EVERY_DEFECT |= {name: (FOLLOWING, *defect) for name, defect in COMMAND_DEFECTS.items()}


@pytest.mark.parametrize("defect", EVERY_DEFECT.values(), ids=EVERY_DEFECT.keys())
def test_one_defect_gives_one_line_with_file_line_key_value_and_what_is_allowed(defect):
    assert_one_line(*defect)


def test_a_vehicle_stands_on_its_contacts_unless_the_scene_says_servo():
    assert parse(VEHICLE).config.upright == "contacts"
    assert parse(replaced(VEHICLE, UPRIGHT, "")).config.upright == "contacts"
    assert parse(replaced(VEHICLE, '"contacts"', '"servo"')).config.upright == "servo"


@pytest.mark.parametrize("away", [RL + RR, FR + RL + RR, RL + FR])
def test_a_servo_needs_no_wheels_around_the_machine(away):
    text = VEHICLE
    for line in away.splitlines(keepends=True):
        text = text.replace(line, "")
    parse(text.replace('"contacts"', '"servo"'))


def test_the_common_centre_of_mass_may_lie_on_the_line_of_two_wheels():
    wheels = 4 * (0.4 + 6 * 0.1)  # kg: at the origin
    edge = 0.2 * (6.0 + wheels) / 6.0
    parse(replaced(VEHICLE, CENTER, f"[{edge!r}, 0, 1]"))
    assert "1e-06 m beyond" in message(replaced(VEHICLE, CENTER, f"[{edge + 1e-6 * 10 / 6!r}, 0, 1]"))


def test_a_flat_plate_is_a_chassis():
    parse(replaced(VEHICLE, INERTIA, "[0.1, 0.2, 0.3]"))


def test_every_wheel_without_a_target_is_named():
    text = message(FOLLOWING[: FOLLOWING.index("[command]")])
    keys = [line.split(": ")[1] for line in text.splitlines()]
    assert keys == [f"wheels.{name}.drive.rate" for name in ("fl", "fr", "rl", "rr")]


def test_a_command_needs_a_wheel_that_follows_it():
    text = message(FOLLOWING.replace("= 0.5 }", "= 0.5, rate = 1 }"))
    assert text.startswith("s.toml:23: command = {") and "no wheel follows it" in text


def test_the_wheels_that_follow_a_command_must_determine_the_motion_alone():
    text = FOLLOWING
    for name in (FL, FR):
        free = name.replace(" },", ', drive = { kind = "free" } },')
        text = text.replace(name.replace(" },", ', drive = { kind = "rate", proportional = 0.5 } },'), free)
    assert message(text).endswith(
        "(rl, rr) do not determine vx, vy and yaw_rate; they leave open: sideways motion, rotation"
    )
    three = replaced(FOLLOWING, '"rate", proportional = 0.5', '"free"')
    assert [wheel.drive.follows_command for wheel in parse(three).config.wheels] == [False, True, True, True]


def test_a_drive_that_follows_a_command_has_an_empty_table():
    assert parse(FOLLOWING).config.wheels[0].drive.table == ((0.0,), (0.0,))
