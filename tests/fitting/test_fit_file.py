"""A fit file and its logs: what they mean, and what is said of bad ones."""

import gzip

import numpy as np
import pytest

from omnisim.fitting.fit_file import load_fit
from omnisim.fitting.logs import FitError

pytestmark = pytest.mark.short
WHEELS = ("left", "back", "right")
ROWS = "0.0,1.0,2.0,3.1,0.5,0,0\n0.1,1.0,2.0,-3.1,0.1,0.2,0.3\n0.2,1.1,2.0,-3.1,0.1,0.2,0.3\n"
COLUMNS = '{ time = 0, "body/position.x" = 1, "body/position.y" = 2, "body/yaw" = 3, ' + ", ".join(
    f'"wheels.{name}.angle_increment" = {i}' for i, name in enumerate(WHEELS, 4)
)
LOG = f'[[logs]]\nfile = "run.csv"\ncolumns = {COLUMNS} }}\n'
FREE = '[free]\n"friction.coefficient" = { start = 0.5, from = 0.1, to = 1.2 }\n'


def load(tmp_path, text=LOG + FREE, rows=ROWS):
    (tmp_path / "run.csv").write_text(rows)
    path = tmp_path / "fit.toml"
    path.write_text(f'scene = "kiwi"\n{text}')
    return load_fit(path)


def test_increments_are_summed_from_the_first_row_on_and_yaw_has_no_jumps(tmp_path):
    log = load(tmp_path).logs[0]
    np.testing.assert_allclose(log.angles[:, 0], [0.0, 0.1, 0.2], atol=1e-15)
    np.testing.assert_allclose(log.yaw, [3.1, 2 * np.pi - 3.1, 2 * np.pi - 3.1])
    assert log.use == "fit" and log.position[2, 0] == 1.1


def test_angles_and_rates_turn_a_wheel_as_increments_do(tmp_path):
    rows = "".join(f"{t},0,0,0,{7 + t**2},{0.1 * (2 * t - 1)},{2 * t}\n" for t in range(5))
    text = LOG.replace("left.angle_increment", "left.angle").replace("right.angle_increment", "right.spin_rate")
    text += 'scale = { "wheels.*.angle_increment" = 10.0 }\n'
    angles = load(tmp_path, text + FREE, rows).logs[0].angles
    np.testing.assert_allclose(angles, np.arange(5)[:, None] ** 2 * np.ones(3), atol=1e-12)


def test_columns_go_by_name_and_other_ones_are_ignored(tmp_path):
    named = LOG
    for i, name in enumerate(("t", "x", "y", "yaw", "a", "b", "c")):
        named = named.replace(f"= {i}", f'= "{name}"')
    rows = "note,t,x,y,yaw,a,b,c\n" + "\n".join(f"good,{row}" for row in ROWS.splitlines())
    assert np.array_equal(load(tmp_path, named + FREE, rows).logs[0].angles, load(tmp_path).logs[0].angles)


def test_without_columns_the_header_has_the_keys(tmp_path):
    keys = ["time", "body/position.x", "body/position.y", "body/yaw", *(f"wheels.{n}.angle_increment" for n in WHEELS)]
    found = load(tmp_path, '[[logs]]\nfile = "run.csv"\n' + FREE, ",".join(keys) + "\n" + ROWS)
    assert np.array_equal(found.logs[0].angles, load(tmp_path).logs[0].angles)


def test_a_packed_log_is_the_same_log(tmp_path):
    (tmp_path / "run.csv.gz").write_bytes(gzip.compress(ROWS.encode()))
    found = load(tmp_path, LOG.replace("run.csv", "run.csv.gz") + FREE)
    assert np.array_equal(found.logs[0].position, load(tmp_path).logs[0].position)


def test_compared_rows_are_the_time_apart_with_both_ends(tmp_path):
    rows = "".join(f"{0.1 * i:.1f},0,0,0,0,0,0\n" for i in range(12))
    found = load(tmp_path, LOG + FREE + "[weights]\nevery = 0.3\n", rows)
    assert found.compared(found.logs[0]).tolist() == [0, 3, 6, 9, 11]


def test_a_factor_multiplies_what_the_scene_has_on_all_wheels_and_also(tmp_path):
    text = '[free]\n"wheels.*.position" = { scale = true, start = 1.0, from = 0.8, to = 1.2 }\n'
    text += '"wheel_types.omni.radius" = { scale = true, start = 1, from = 0.9, to = 1.1, also = ["wheel_types.omni.roller_distance"] }\n'  # noqa: E501
    found = load(tmp_path, LOG + text)
    settings = dict(found.settings([1.1, 0.9]))
    assert settings["wheels", 1, "position"] == pytest.approx((-0.1375, 0.0))
    assert settings["wheel_types", "omni", "radius"] == pytest.approx(0.045)
    assert settings["wheel_types", "omni", "roller_distance"] == pytest.approx(0.0378)


def test_the_tracked_point_is_free_too(tmp_path):
    text = '[tracked]\ny = 0.02\nyaw_deg = 90\n[free]\n"tracked.x" = { start = 0.0, from = -0.1, to = 0.1 }\n'
    assert load(tmp_path, LOG + text).point([0.03]) == pytest.approx((0.03, 0.02, np.pi / 2))


NAN = ROWS.replace("0.1,1.0", "0.1,nan")
BACK = ROWS.replace("0.2,1.1", "0.1,1.1")
BAD_TEXTS = [
    (("friction.coefficient", "friction.coeficient"), "did you mean 'coefficient'"),
    (("friction.coefficient", "wheels.front.spin_rate"), "no wheel is called 'front'"),
    (("friction.coefficient", "wheel_types.omnii.radius"), "no wheel type is called 'omnii'"),
    (("friction.coefficient", "tracked.z"), "unknown key"),
    (("to = 1.2", "to = 1.2, deviation = 0.1"), "deviation = 0.1: unknown key. Allowed: start, from, to, scale, also"),
    (("start = 0.5", "start = 1.5"), "start = 1.5: must be between from = 0.1 and to = 1.2"),
    (("from = 0.1", "from = -0.1"), "from = -0.1: no such scene: friction.coefficient = -0.1"),
    (("to = 1.2", "to = 0.1"), "the first below the second"),
    (("to = 1.2", 'to = 1.2, also = ["chassis.mas"]'), "did you mean 'mass'"),
    (("friction.coefficient", "wheels.*.position"), "which is no number; with scale = true"),
    (('"friction.coefficient" = { start', '"friction.patch_radius" = { scale = true, start'), "has nothing"),
    (("run.csv", "runn.csv"), "logs[0].file = 'runn.csv': cannot be read: No such file or directory"),
    (("time = 0", 'time = "t"'), "the log has no header"),
    (("time = 0", "time = 7"), "the log has 7 columns, counted from 0"),
    (("time = 0, ", ""), "no column for time"),
    ((', "wheels.right.angle_increment" = 6', ""), "no column for what wheel right turns; one of wheels.right.angle"),
    (("wheels.right.angle_increment", "wheels.rihgt.angle_increment"), "did you mean 'wheels.right.angle_increment'"),
    (("columns = ", 'use = "train"\ncolumns = '), 'must be "fit" or "test"'),
    (("columns = ", 'use = "test"\ncolumns = '), "no log to fit"),
    (("[free]", "[frei]"), "did you mean 'free'"),
]


@pytest.mark.parametrize(("change", "told"), BAD_TEXTS)
def test_a_bad_fit_is_told_in_one_line_with_its_place(tmp_path, change, told):
    assert change[0] in LOG + FREE
    with pytest.raises(FitError) as error:
        load(tmp_path, (LOG + FREE).replace(change[0], change[1], 1))
    assert told in str(error.value)
    assert str(error.value).startswith(f"{tmp_path / 'fit.toml'}:") and "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("rows", "told"),
    [
        (NAN, "run.csv:2: body/position.x = 'nan': must be a finite number"),
        (ROWS.replace("0.1,1.0", "0.1,one"), "run.csv:2: body/position.x = 'one': must be a finite number"),
        (ROWS.replace(",0.3\n0.2", "\n0.2"), "run.csv:2: wheels.right.angle_increment = nothing"),
        (BACK, "run.csv:3: time = 0.1: must be later than that of the row before, 0.1"),
        ("0,0,0,0,0,0,0\n", "1 rows; a log has 3 or more"),
        ("", "0 rows"),
    ],
)
def test_a_bad_log_is_told_with_its_line(tmp_path, rows, told):
    with pytest.raises(FitError) as error:
        load(tmp_path, rows=rows)
    assert told in str(error.value) and "\n" not in str(error.value)


def test_what_is_no_gzip_file_is_told(tmp_path):
    (tmp_path / "run.csv.gz").write_bytes(gzip.compress(ROWS.encode())[:-12])
    with pytest.raises(FitError, match="a damaged gzip file"):
        load(tmp_path, LOG.replace("run.csv", "run.csv.gz") + FREE)
