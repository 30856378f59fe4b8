"""What a user of the command meets with a machine free in space."""

import csv
import math
import re
import tomllib

import pytest
from commands import command, refused, settings

import omnisim
from omnisim.results.trajectory import open_trajectory
from omnisim.scene.rollers import end_radius, half_length

pytestmark = pytest.mark.usefixtures("folder")

SHORT = settings("time.end=0.8")
LIMP = "wheels.front_left.suspension.stiffness=0.0"  # the others let the front down by more than its clearance
OFF = "chassis.center_of_mass=[0.6, 0.0, 0.0575]"  # beyond the front wheels


@pytest.fixture(scope="module")
def run_of(tmp_path_factory):
    """The file of a short run across the beginning of a ramp, and what was said."""
    path = tmp_path_factory.mktemp("free") / "ramp.h5"
    result = command("run", "kiwi_ramp", "-o", path, *SHORT)
    assert result.exit_code == 0, result.stderr
    return path, result.stdout


def loads_of(text):
    """Loads at standstill in `info`, N."""
    return [
        float(load) for load in re.findall(r"(\S+) N(?:  +\S+ mm)?$", text.partition("\nwheels\n")[2], re.MULTILINE)
    ]


def test_info_has_pose_loads_and_travel_at_rest():
    result = command("info", "cable_duct")
    assert result.exit_code == 0 and "Warning" not in result.stderr, result.stderr
    text = result.stdout
    assert "upright on the plane floor" not in text and "the run stops" in text and "not used by this scene" not in text
    weight = 24.0 * 9.81
    assert sum(loads_of(text)[:4]) == pytest.approx(weight, rel=1e-3)  # four digits
    travel = (weight / 4.0 - (0.3 + 0.7) * 9.81) / 6000.0  # what the hub and its wheel weigh, the spring does not feel
    told = re.findall(r"N +(\S+) mm$", text, re.MULTILINE)
    assert [float(value) for value in told] == pytest.approx([1e3 * travel] * 4, rel=2e-3)
    sag = travel + weight / 4.0 / 2e5
    assert float(re.search(r"chassis origin +(\S+) mm", text)[1]) == pytest.approx(-1e3 * sag, rel=2e-3)


def test_info_tells_on_which_slopes_it_tips_and_how_it_swings():
    text = command("info", "kiwi_ramp").stdout
    config = omnisim.load("kiwi_ramp").config
    total = math.fsum([2.5, *[0.18 + 18 * 0.0045] * 3])
    height = (2.5 * 0.1 + 3 * (0.18 + 18 * 0.0045) * 0.05) / total
    least = math.degrees(math.atan2(0.0625, height))  # each edge is 62.5 mm away
    assert re.search(rf"any way, the least .* {least:.3g}$", text, re.MULTILINE)
    heave = math.sqrt(3.0 * config.wheel_types["omni"].contact.stiffness / total) / (2.0 * math.pi)
    assert f"heave swings    {heave:.3g} Hz" in text
    kind = config.wheel_types["omni"]
    ripple = (kind.radius - kind.profile.curvature_radius) * (1.0 - math.cos(kind.covered))
    assert "18 in 2 rows" in text and f"goes up and down by {1e3 * ripple:.3g} mm" in text


def test_info_tells_how_far_wheels_heave_whose_rollers_are_cut_short_and_which_have_no_spring(folder):
    """Between two, 30 deg from both, the rim is R1 cos q + u c sin q + r sqrt(1 - c^2 sin^2 q) below the centre."""
    text = omnisim.load("cable_duct", ["wheel_types.mecanum.covered_deg=25.0"]).text
    spring = re.search(r"^suspension = .*\n", text, re.MULTILINE)[0]
    (folder / "short.toml").write_text(text.replace(spring, "", 3))
    kind = omnisim.load("short.toml").config.wheel_types["mecanum"]
    q, c = math.radians(30.0), math.cos(math.radians(45.0))
    rim = half_length(kind) * c * math.sin(q) + end_radius(kind) * math.sqrt(1.0 - (c * math.sin(q)) ** 2)
    ripple = kind.radius - kind.roller_distance * math.cos(q) - rim
    said = command("info", "short.toml").stdout
    assert f"every 60 deg; between two the wheel goes up and down by {1e3 * ripple:.3g} mm" in said
    assert len(re.findall(r"no spring$", said, re.MULTILINE)) == 3
    assert "every 60 deg; the wheel stays round" in command("info", "cable_duct").stdout


@pytest.mark.parametrize(("overrides", "parts"), [
    (["initial.height=-0.02"], ["initial.height = -0.02", "wheel 'front_left' begins below the ground",
                                "rollers in it add up to 0.0483 m, more than the radius of one, 0.0115 m; give a"]),
    ([OFF], ["initial.height", "missing", "no pose at rest", "give a height"]),
    ([LIMP], ["initial.height", "no pose at rest", "its chassis would be in the ground"]),
])  # fmt: skip
def test_what_cannot_begin_is_one_line(folder, overrides, parts):
    line = refused(command("run", "cable_duct", *SHORT, *settings(*overrides)), *parts)
    assert "bug" not in line and not list(folder.iterdir())
    with pytest.raises(omnisim.SceneError, match=re.escape(parts[0])):
        omnisim.simulate(omnisim.load("cable_duct", overrides))


@pytest.mark.parametrize(("before", "after", "line"), [
    ("", "", 9),  # where it is said that it is free
    ("", "\n[initial]\nyaw_deg = 10.0\n", 78),
    ("\ninitial.yaw_deg = 10.0\n", "", 2),
])  # fmt: skip
def test_a_pose_that_is_missing_is_missed_where_the_scene_tells_of_the_start(folder, before, after, line):
    text = omnisim.load("cable_duct", [OFF]).text
    (folder / "off.toml").write_text(before + text + after)
    refused(command("run", "off.toml"), f"off.toml:{line}: initial.height: missing")


@pytest.mark.parametrize(
    ("start", "told"),
    [
        ("initial.vertical_velocity=-1e4", "the chassis touches the ground at t = 2.15307"),  # of 1e-6 s
        ("initial.roll_rate=1e6", "the motion diverged at t = 5e-05 s: a state is no longer finite; try"),
    ],
)
def test_a_start_too_fast_for_its_step_is_told_as_such(start, told):
    """It would be half a metre below the ground after a step, or turn fifty times: no friction is to blame. From 4e4
    m/s on rounding decides, and so the processor, whether the state in the ground is still finite."""
    run = omnisim.simulate(omnisim.load("cable_duct", [start, "time.end=0.01"]))
    assert run.attributes["status"].startswith(told)


def test_a_wheel_that_is_driven_into_the_ground_is_not_said_to_lie_on_its_side_alone():
    """18 rollers fall 30 mm in 0.3 microseconds."""
    run = omnisim.simulate(omnisim.load("kiwi_ramp", ["initial.vertical_velocity=-1e5", "time.end=0.01"]))
    assert "at more places at once than are followed" in run.attributes["status"]
    assert "lies on its side or is driven deep into the ground" in run.attributes["status"]


def test_info_of_a_machine_that_cannot_begin_says_so_too(folder):
    scene = tomllib.loads(omnisim.load("cable_duct", [OFF]).text)
    assert scene["chassis"]["center_of_mass"][0] == 0.6
    (folder / "off.toml").write_text(omnisim.load("cable_duct", [OFF]).text)
    refused(command("info", "off.toml"), "off.toml:", "initial.height", "no pose at rest")
    (folder / "placed.toml").write_text(omnisim.load("cable_duct", [OFF, "initial.height=0.01"]).text)
    text = command("info", "placed.toml").stdout
    assert "it has no pose at rest" in text and "10 mm over the base plane" in text


def test_a_run_tells_its_contacts_and_no_exchanges(run_of):
    _, said = run_of
    assert re.search(r"events +\d+ contact_begins?, \d+ contact_ends?$", said, re.MULTILINE) and "exchange" not in said
    assert "rigid body 13" in said and "status    complete" in said


def test_info_of_its_file_has_the_datasets_of_space(run_of):
    text = command("info", run_of[0]).stdout
    for path in ("/body/orientation", "/body/angular_velocity", "/energy/elastic", "/energy/contact_loss"):
        assert path in text


def test_its_rows_are_in_the_tables(run_of, folder):
    assert command("export", run_of[0], "ramp.csv").exit_code == 0
    with open(folder / "ramp.csv", newline="") as file:
        _units, *rows = csv.DictReader(file)
    run = open_trajectory(run_of[0])
    assert len(rows) == len(run.time)
    names = [name for name in rows[0] if "orientation" in name]
    assert len(names) == 4 and [float(rows[-1][name]) for name in names] == run["body/orientation"][-1].tolist()


@pytest.mark.parametrize("view", ["story", "ride", "path", "energy"])
@pytest.mark.long
def test_its_pictures_are_drawn(run_of, folder, view):
    result = command("plot", run_of[0], "--view", view, "-o", "picture.png")
    assert result.exit_code == 0, result.stderr
    assert (folder / "picture.png").stat().st_size > 10_000


def test_a_ride_of_a_machine_that_is_held_upright_is_refused(folder):
    omnisim.simulate(omnisim.load("kiwi", ["time.end=0.01", "time.output_interval=0.005"])).save("kiwi.h5")
    refused(command("plot", "kiwi.h5", "--view", "ride", "-o", "picture.png"), "held upright", "free in space")


def test_wheels_of_another_shape_are_told_of_and_drawn_as_they_are(folder):
    """Barrels of curvature 48 mm in two rows of nine: (R - 48 mm) (1 - cos 10 deg) lower where one takes over."""
    said = command("wheel", "kiwi_ramp").stdout
    assert "49.9899 mm on average, for the controller; 49.9696 mm to 50.0000 mm" in said
    assert "the centre heaves by 0.0304 mm, 0.0608 % of the rolling radius" in said
    assert "closes the gaps where it gives in by 0.0608 mm at the highest place; under 10.7 N" in said
    for file in ("wheel.png", "wheel.stl", "wheel.xml", "wheel.urdf"):
        result = command("wheel", "kiwi_ramp", "-o", file)
        assert result.exit_code == 0 and (folder / file).is_file(), result.stderr


def test_trackings_and_formulations_are_not_compared():
    for choices in (("implicit", "explicit"), ("multibody", "reduced")):
        line = refused(command("compare", *choices, "kiwi_ramp"), "kiwi_ramp:9: scene.upright = 'free'", "held upright")
        assert f", {choices[1]}: there is nothing to compare" in line and "--set" not in line


STUDY = """
schema = 1
scene = "kiwi_ramp"
[set]
"time.end" = 0.05
"time.output_interval" = 0.01
[vary]
"chassis.center_of_mass" = [[0.0, 0.0, 0.1], [0.4, 0.0, 0.1]]
[measure]
roll = { dataset = "body/angular_velocity", reduce = "max", component = "norm" }
load = { dataset = "wheels/*/normal_force", reduce = "max" }
"""


def test_a_study_goes_on_where_a_machine_cannot_begin(folder):
    (folder / "study.toml").write_text(STUDY)
    result = command("sweep", "study.toml", "--workers", "1")
    assert result.exit_code == 0, result.stderr
    found = omnisim.open_study("study.h5")
    first, second = found["status"].tolist()
    assert first == "complete" and second.startswith("impossible: initial.height: missing")
    assert found["load"][0] > 10.0 and math.isnan(found["load"][1])
