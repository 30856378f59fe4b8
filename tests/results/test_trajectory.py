"""A trajectory is complete, finite and of the right shape, or it does not come into being."""

import re
import subprocess
import sys

import numpy as np
import pytest
from synthetic import synthetic_attributes, synthetic_data, synthetic_trajectory

from omnisim.results.layout import layout
from omnisim.results.report import summary
from omnisim.results.trajectory import Trajectory

pytestmark = pytest.mark.short


def changed(path, array):
    return Trajectory(synthetic_attributes(), synthetic_data() | {path: array})


def test_datasets_are_found_by_their_path_in_the_file():
    trajectory = synthetic_trajectory(rows=11, rollers=6)
    assert trajectory["wheels/wheel/rollers/center_position"].shape == (11, 6, 3)
    assert trajectory["/body/position"] is trajectory["body/position"]
    assert trajectory.time is trajectory["time"]
    assert "energy/balance" in trajectory and "energy/heat" not in trajectory
    assert list(trajectory) == list(trajectory.data) == [row.path for row in trajectory.quantities]


def test_scales_follow_from_the_sizes():
    trajectory = synthetic_trajectory(rollers=(6, 8), wheels=("left", "right"), events=4)
    assert trajectory["axis"].tolist() == ["x", "y", "z"]
    assert trajectory["tangent"].tolist() == ["h", "k"]
    assert trajectory["wheels/left/rollers/roller"].tolist() == [0, 1, 2, 3, 4, 5]
    assert trajectory["wheels/right/rollers/roller"].shape == (8,)
    assert trajectory["events/event"].tolist() == [0, 1, 2, 3]
    assert trajectory["events/event"].dtype == np.int64


@pytest.mark.parametrize(
    ("wrong", "near"),
    [
        ("body/postion", "body/position"),
        ("spin_rate", "wheels/wheel/spin_rate"),
        ("wheels/wheel/axial_rate", "wheels/wheel/rollers/axial_rate"),
    ],
)
def test_a_misspelt_name_is_answered_with_near_ones(wrong, near):
    with pytest.raises(KeyError) as caught:
        synthetic_trajectory()[wrong]
    assert wrong in str(caught.value) and near in str(caught.value)


def test_complete_is_what_status_says():
    assert synthetic_trajectory().complete
    stopped = synthetic_trajectory(status="wheel tips over", stop_time=0.25, stop_wheel="wheel")
    assert not stopped.complete
    assert "wheel tips over" in repr(stopped)


def test_repr_tells_rows_wheels_events_and_how_to_reach_datasets():
    trajectory = synthetic_trajectory(rows=11, events=3)
    lines = repr(trajectory).splitlines()
    assert lines[0] == "<Trajectory 'rollers µ': complete"
    assert lines[1].startswith("  duration  1 s, 11 rows, one every 0.1 s")
    assert lines[2].startswith("  wheels    wheel (")
    assert sum(map(int, re.findall(r"\d+", lines[3]))) == 3
    (path,) = re.findall(r"run\['(.*)'\]", lines[-1])
    assert path in trajectory and f" {len(list(trajectory))}," in lines[-1] and len(lines) == 6


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("path", [path for path, array in synthetic_data().items() if array.dtype == float])
def test_no_dataset_takes_a_number_that_is_not_finite(path, value):
    array = synthetic_data()[path]
    array.flat[-1] = value
    with pytest.raises(ValueError, match=f"dataset {path} is {value} at index .*finite"):
        changed(path, array)


@pytest.mark.parametrize(
    ("path", "array"),
    [
        ("time", np.array(0.0)),
        ("time", np.zeros((11, 1))),
        ("body/position", np.zeros((11, 2))),
        ("body/position", np.zeros((10, 3))),
        ("body/yaw", np.zeros((11, 1))),
        ("wheels/wheel/slip_velocity", np.zeros((11, 3))),
        ("wheels/wheel/rollers/joint_rate", np.zeros((11, 5))),
        ("wheels/wheel/rollers/center_velocity", np.zeros((11, 3, 6))),
        ("events/roller_to", np.zeros(4, dtype=np.int64)),
        ("axis", np.array(["x", "y"])),
    ],
)
def test_every_shape_is_checked_against_the_axes(path, array):
    with pytest.raises(ValueError, match=r"has shape .*: it must be"):
        changed(path, array)


@pytest.mark.parametrize(
    ("path", "array"),
    [
        ("body/yaw", np.zeros(11, dtype=np.float32)),
        ("body/yaw", np.zeros(11, dtype=np.int64)),
        ("body/yaw", [0.0] * 11),
        ("wheels/wheel/contact_roller", np.zeros(11)),
        ("events/roller_from", np.zeros(3, dtype=np.int32)),
        ("events/kind", np.zeros(3)),
        ("events/kind", np.array(["stop"] * 3, dtype=object)),
    ],
)
def test_every_type_is_checked_without_casting(path, array):
    with pytest.raises(ValueError, match=f"dataset {path} .*: it must be"):
        changed(path, array)


@pytest.mark.parametrize("path", [path for path in synthetic_data() if not layout(("wheel",))[path].optional])
def test_no_dataset_may_be_missing(path):
    data = synthetic_data()
    del data[path]
    with pytest.raises(ValueError, match=f"dataset {path} is missing"):
        Trajectory(synthetic_attributes(), data)


def test_unknown_datasets_and_attributes_are_refused():
    with pytest.raises(ValueError, match=r"unknown dataset body/yawrate; near: .*body/yaw_rate"):
        changed("body/yawrate", np.zeros(11))
    with pytest.raises(ValueError, match="unknown attribute colour"):
        synthetic_trajectory(colour="red")


@pytest.mark.parametrize("name", synthetic_attributes())
def test_no_attribute_may_be_missing(name):
    attributes = synthetic_attributes()
    del attributes[name]
    with pytest.raises(ValueError, match=f"attribute {name} is missing"):
        Trajectory(attributes, synthetic_data())


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("title", 3),
        ("wheels", "wheel"),
        ("wheels", ()),
        ("steps", None),
        ("step", "1"),
        ("stop_time", np.nan),
        ("error_estimate", np.inf),
    ],
)
def test_attributes_are_checked(name, value):
    with pytest.raises(ValueError, match=f"attribute {name}"):
        Trajectory(synthetic_attributes() | {name: value}, synthetic_data())


def test_attributes_from_numpy_become_plain_python():
    attributes = synthetic_trajectory(steps=np.int64(7), step=np.float64(0.5)).attributes
    assert type(attributes["steps"]) is int and type(attributes["step"]) is float
    assert attributes["format"] == "omnisim-trajectory" and attributes["format_version"] == 1


def test_summary_tells_what_a_run_did():
    text = summary(synthetic_trajectory(rows=11, events=3, method="dopri5"))
    facts = ("rollers µ", "dopri5, step 0.001 s, explicit", "10 steps", "11 rows", "complete", "6 rollers",
             "1 exchange, 1 stick, 1 slip", "kinetic", "/wheels/wheel/spin_rate")  # fmt: skip
    for fact in facts:
        assert fact in text
    assert "11 x 6 x 3  m " in text


def test_summary_puts_wheels_together_and_shows_where_they_differ():
    text = summary(synthetic_trajectory(wheels=("left", "right"), rollers=(6, 8)))
    assert "11 x 6|8 x 3" in text
    assert text.count("axial_rate") == 1


def test_summary_of_a_stopped_run_gives_its_status():
    text = summary(synthetic_trajectory(status="tipping at t = 0.25 s", stop_time=0.25, stop_wheel="wheel"))
    assert "status    tipping at t = 0.25 s\n" in text


@pytest.mark.parametrize(("rows", "events"), [(0, 0), (1, 0), (1, 1)])
def test_a_run_that_stops_at_once_is_a_trajectory_too(rows, events):
    trajectory = synthetic_trajectory(rows=rows, events=events)
    assert f"{rows} rows" in repr(trajectory)
    assert f"{rows} rows" in summary(trajectory)


def test_importing_trajectory_brings_neither_h5py_nor_numba():
    code = "import sys, omnisim.results.trajectory; sys.exit('h5py' in sys.modules or 'numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
