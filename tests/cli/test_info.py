"""What a user of `omnisim info` meets: facts of scenes and of trajectories."""

import math
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
from commands import SCENE, command, settings
from helpers.stages import either
from machines import toml

import omnisim
from omnisim.base.formatting import WIDTH
from omnisim.scene.scene import packaged_scenes

pytestmark = pytest.mark.usefixtures("folder")


def test_info_of_a_scene_says_what_is_modelled_and_how_large_it_is():
    result = command("info", SCENE)
    assert result.exit_code == 0, result.stderr
    for fact in ("2000 steps", "41 rows", "modelled", "left out", "roller length  0.05 m", "0.01 m amid",
                 "0.00330127 m until the tips are points"):  # fmt: skip
        assert fact in result.stdout


def table(text, heading):
    """The rows below a heading of `info`, without their header: columns stand two blanks apart."""
    block = text.partition(f"\n{heading}")[2].partition("\n\n")[0].splitlines()[2:]
    return [re.split(" {2,}", line.strip()) for line in block]


def test_info_of_a_machine_has_its_whole_its_wheels_and_each_type_once():
    result = command("info", "youbot")
    assert result.exit_code == 0, result.stderr
    text = result.stdout
    wheels = table(text, "wheels")
    assert [row[0] for row in wheels] == ["front_left", "front_right", "rear_left", "rear_right"]
    assert wheels[1][1:-1] == ["mecanum", "[0.235, -0.15] m", "0 deg", "yes", "rate"]
    weight = float(re.search(r"weight (\S+) N", text)[1])
    assert weight == pytest.approx(22.8 * 9.81)
    assert sum(float(row[-1].split()[0]) for row in wheels) == pytest.approx(weight, rel=1e-3)  # four digits
    turn = (0.235 + 0.15) / 0.0475
    rates = {name: [float(rate) for rate in row] for name, *row in table(text, "spin rates of ideal wheels")}
    assert rates["front_left"] == pytest.approx([1 / 0.0475, -1 / 0.0475, -turn], rel=1e-3)
    assert text.count("roller length") == 1 and "wheel type 'mecanum'\n" in text
    assert "31 states" in text and "all wheels: rate of the command" in text


def test_info_says_on_which_slopes_a_machine_slides_drives_up_no_more_and_tips(folder):
    """Four mecanum wheels: mu / sqrt 2 along the axes, mu / 2 across; the steeper the weaker its drives."""
    scene = tomllib.loads(omnisim.load("youbot").text)
    scene["floor"] = {"slope_deg": 5.0, "uphill_deg": 45.0}
    for wheel in scene["wheels"]:
        wheel["drive"]["torque_limit"] = 0.5
    (folder / "sloping.toml").write_text("\n".join(f"{key} = {toml(value)}" for key, value in scene.items()))
    rows = {name: row for name, *row in table(command("info", "sloping.toml").stdout, "steepest slopes")}
    mu, weight = scene["friction"]["coefficient"], 22.8 * 9.81
    climbs = math.degrees(math.asin(4 * 0.5 / 0.0475 / weight))
    ahead, least = (math.degrees(math.atan(mu / by)) for by in (math.sqrt(2.0), 2.0))
    assert [float(slope) for slope in rows["ahead"][:3]] == pytest.approx([ahead, 0.0, climbs], rel=5e-3)
    assert float(rows["any way, the least"][0]) == pytest.approx(least, rel=5e-3)
    assert float(rows["on its 5 deg"][0]) == pytest.approx(least, rel=5e-3)
    assert "steepest slopes" not in command("info", SCENE).stdout  # a servo holds a bare wheel


@pytest.mark.parametrize("name", either(packaged_scenes(), ["six_rollers", "mixed", "kiwi_ramp"]))
def test_info_of_a_scene_fits_a_terminal_and_tells_its_types_once(name):
    result = command("info", name)
    assert result.exit_code == 0, result.stderr
    assert max(map(len, result.stdout.splitlines())) <= WIDTH
    config = omnisim.load(name).config
    assert result.stdout.count("roller length") == len(config.wheel_types)
    assert ("\nmachine\n" in result.stdout) == (config.chassis is not None)


def test_a_machine_says_how_far_its_odometry_is_off_and_what_it_holds(folder):
    result = command("run", "kiwi", *settings("time.end=0.6"))
    assert result.exit_code == 0, result.stderr
    off = (
        r"^odometry +off by (\S+) m and (\S+) rad at the end;\s+"
        r"by (\S+) m \((\S+)%\s+of\s+the\s+(\S+)\s+m\s+driven\)\s+and\s+(\S+)\s+rad\s+at\s+most$"
    )
    position, yaw, most, part, way, turned = map(float, re.search(off, result.stdout, re.MULTILINE).groups())
    run = omnisim.open_trajectory("kiwi.h5")
    assert position == pytest.approx(math.hypot(*run["odometry/position_error"][-1]), rel=1e-2)
    assert yaw == pytest.approx(abs(run["odometry/yaw_error"][-1]), rel=1e-2)
    assert most == pytest.approx(run["interval_max/odometry/position_error"].max(), rel=1e-2)
    assert turned == pytest.approx(
        np.abs(omnisim.open_trajectory("kiwi.h5")["interval_max/odometry/yaw_error"]).max(), rel=1e-2
    )
    assert part == pytest.approx(100.0 * most / way, abs=0.006)
    assert way == pytest.approx(np.hypot(*np.diff(run["body/position"][:, :2], axis=0).T).sum(), rel=1e-3)
    text = command("info", "kiwi.h5").stdout
    assert re.search(off, text, re.MULTILINE)
    assert "/odometry/yaw" in text and "servo_torque" not in text  # its contacts carry roll and pitch
    assert max(map(len, text.splitlines())) <= WIDTH
    assert "odometry" not in command("run", SCENE).stdout


def test_info_tells_scenes_from_trajectories_by_content(folder):
    assert command("run", SCENE, "-o", "run.h5", "--quiet").exit_code == 0
    (folder / "run.h5").rename(folder / "run.toml")
    (folder / "scene.h5").write_text(Path(SCENE).read_text())
    assert "15 exchange" in command("info", "run.toml").stdout
    assert "left out" in command("info", "scene.h5").stdout


def test_info_sums_up_what_bearings_carry(folder):
    overrides = settings("output.bearing_loads=true", "time.end=0.2")
    assert command("run", "youbot", "-o", "loads.h5", *overrides).exit_code == 0
    shown, run = command("info", "loads.h5").stdout, omnisim.open_trajectory("loads.h5")
    axle = re.search(r"^rear_left, axle +(\S+) \((\S+)\) +(\S+) ", shown, re.MULTILINE)
    force, path = run["wheels/rear_left/bearing_force"], "wheels/rear_left/bearing"
    radial = np.hypot(force[:, 0], force[:, 2])
    most, along = run[f"interval_max/{path}_radial_force"].max(), run[f"interval_min/{path}_axial_force"].min()
    expected = most, np.sqrt(np.mean(radial**2)), max(run[f"interval_max/{path}_axial_force"].max(), -along)
    np.testing.assert_allclose([float(number) for number in axle.groups()], expected, rtol=1e-3)
    assert "/wheels/NAME/rollers/bearing_moment" in shown and "constraints" not in shown


def test_info_and_the_summary_name_the_largest_of_the_march(folder):
    """Slip of a stopping wheel lasts a fraction of the time between two rows."""
    result = command("run", "kiwi", *settings("time.end=0.3", "time.output_interval=0.1"))
    run, text = omnisim.open_trajectory("kiwi.h5"), command("info", "kiwi.h5").stdout
    block = text.partition("\nextremes of the march")[2].partition("\n\n")[0].splitlines()[1:]
    rows = [re.split(" {2,}", line) for line in block]
    assert [row[0] for row in rows] == list(run.wheels)
    names = ("normal_force", "friction_force", "slip_velocity", "drive_torque", "drive_power")
    for wheel, *shown in rows:
        for name, value in zip(names, shown, strict=True):
            most = run[f"interval_max/wheels/{wheel}/{name}"].max()
            assert float(value.split()[-1]) == pytest.approx(most, rel=1e-3)
    load = max(run[f"interval_max/wheels/{wheel}/normal_force"].max() for wheel in run.wheels)
    assert re.search(rf"^peaks +load {load:.4g} N, friction ", result.stdout, re.MULTILINE)


def test_info_of_a_machine_on_motors_prints_what_their_data_sheet_makes_of_them():
    """U / I_s, U (1 - I_0 / I_s) / w_0; and the sheet's own speed and stall torque behind the gear."""
    result = command("info", "platform24v")
    assert result.exit_code == 0, result.stderr
    text = result.stdout.partition("motor of front_left, front_right, rear_left, rear_right, at the wheel\n")[2]
    constant = 24.0 * (1.0 - 0.164 / 39.3) / 922.6
    for fact in (f"{24.0 / 39.3:.6g} ohm", f"{constant:.6g} before its gear", f"{922.6 / 51:.4g} rad/s at 24 V",
                 f"{51 * 1.016:.4g} N m at 24 V", f"6 A: at most {51 * constant * 6.0:.4g} N m"):  # fmt: skip
        assert fact in text
