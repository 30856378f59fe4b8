"""The page of a trajectory: what is in it, and the command that writes it."""

import base64
import json
from html.parser import HTMLParser

import numpy as np
import pytest
from click.testing import CliRunner
from synthetic import synthetic_data, synthetic_trajectory

import omnisim
from omnisim.contact.roller_profile import axial_coordinate, profile_radius
from omnisim.dynamics.packing import pack
from omnisim.pictures.viewer import (
    BODY,
    BODY_MORE,
    WHEEL,
    NothingToShow,
    kept_rows,
    machine,
    motion,
    page,
)
from omnisim.pictures.viewer_space import POINTS
from omnisim.results.trajectory import Trajectory
from omnisim.scene.scene import packaged_scenes
from omnisim_cli.main import cli

SCENES = ("coulomb_wheel", "kiwi", "mixed", "youbot")


class Elements(HTMLParser):
    """Every element with its attributes, those of the labels and the text around it, and the text inside."""

    def __init__(self, text):
        super().__init__()
        self.found, self.labels = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes) | {"in label": bool(self.labels)}, []))
        self.labels += ["label"] * (tag == "label")

    def handle_endtag(self, tag):
        self.labels = self.labels[:-1] if tag == "label" else self.labels

    def handle_data(self, data):
        if self.found:
            self.found[-1][2].append(data)


def embedded(text):
    """The data in a page."""
    return next(json.loads("".join(inside)) for _, given, inside in Elements(text).found if given.get("id") == "data")


def decoded(array):
    return np.frombuffer(base64.b64decode(array["base64"]), array["dtype"]).reshape(array["shape"])


# --- data -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SCENES)
def test_the_arrays_in_the_page_are_the_datasets_of_the_file(runs, name):
    trajectory = runs[name]
    rows, arrays = kept_rows(trajectory.time), embedded(page(trajectory))["motion"]
    for path, dtype in BODY.items():
        assert (decoded(arrays[path]) == trajectory[path][rows].astype(dtype)).all()
    for wheel in trajectory.wheels:
        for path, dtype in WHEEL.items():
            path = f"wheels/{wheel}/{path}"
            assert (decoded(arrays[path]) == trajectory[path][rows].astype(dtype)).all()
    for path in BODY_MORE:
        assert (path in arrays) == (path in trajectory)
        assert path not in arrays or (decoded(arrays[path]) == trajectory[path][rows].astype("float32")).all()


def test_the_page_has_the_targets_of_the_drives(runs):
    """Half a second to 0.5 m/s: wheels of 47.5 mm radius are to turn at 10.5 rad/s from then on."""
    trajectory, arrays = runs["youbot"], embedded(page(runs["youbot"]))["motion"]
    time = decoded(arrays["time"])
    for wheel in trajectory.wheels:
        target = decoded(arrays[f"wheels/{wheel}/target_rate"])
        assert np.abs(target - np.minimum(time, 0.5) / 0.0475).max() < 1e-6  # 4e-7, float32
    assert not [path for path in embedded(page(runs["coulomb_wheel"]))["motion"] if "target" in path]


def test_extremes_of_rows_that_are_left_out_count_for_the_next_one_kept():
    trajectory = synthetic_trajectory(rows=1001)
    trajectory.data["time"] = 1e-3 * np.arange(1001)
    path = "wheels/wheel/drive_torque"
    trajectory.data[f"interval_max/{path}"] = highest = trajectory[path] + 1.0
    trajectory.data[f"interval_min/{path}"] = trajectory[path] - 1.0
    rows, arrays = kept_rows(trajectory.time), motion(trajectory)
    assert len(rows) == 60
    for i in range(1, len(rows)):
        since = slice(rows[i - 1] + 1, rows[i] + 1)
        assert arrays[f"interval_max/{path}"][i] == np.float32(highest[since].max())
        assert arrays[f"interval_min/{path}"][i] == np.float32(trajectory[path][since].min() - 1.0)
    assert len(arrays[f"interval_max/{path}"]) == 60 and arrays[f"interval_max/{path}"][0] == np.float32(highest[0])


def test_the_events_in_the_page_are_those_of_the_file(runs):
    events = embedded(page(runs["mixed"]))["events"]
    assert events["time"] == runs["mixed"]["events/time"].tolist() and len(events["time"]) > 100
    assert [events["kinds"][kind] for kind in events["kind"]] == runs["mixed"]["events/kind"].tolist()
    assert events["wheel"] == runs["mixed"]["events/wheel"].tolist()


def test_rollers_that_turn_evenly_have_turned_by_rate_times_time():
    data = synthetic_data(rows=601) | {"time": 0.01 * np.arange(601)}
    rates = np.arange(6.0)
    data["wheels/wheel/rollers/joint_rate"] = np.tile(rates, (601, 1))
    arrays = motion(Trajectory(synthetic_trajectory().attributes, data))
    expected = np.outer(arrays["time"], rates)
    assert np.abs(arrays["wheels/wheel/rollers/joint_angle"] - expected).max() < 2e-6  # 9e-7, float32 at 30 rad


def is_exact(name):
    return all(kind.profile.kind == "exact" for kind in omnisim.load(name).config.wheel_types.values())


@pytest.mark.parametrize("name", [name for name in packaged_scenes() if is_exact(name)])
def test_the_profile_is_that_of_the_simulated_roller(name):
    config = omnisim.load(name).config
    types = machine(config)["types"]
    for wheel, record in zip(config.wheels, pack(config).wheels, strict=True):
        u, r = np.transpose(types[wheel.type]["profile"])
        for i, q in enumerate(np.linspace(-record.alpha, record.alpha, POINTS)):
            assert abs(u[i] - axial_coordinate(record, q)) < 1e-15  # 2e-17
            assert abs(r[i] - profile_radius(record, q)) < 1e-15


@pytest.mark.parametrize(
    ("rows", "interval", "kept"),
    [(1, 0.1, 1), (2, 0.1, 2), (101, 0.01, 51), (102, 0.01, 52), (1001, 1e-3, 60), (11, 1, 11), (10**6, 0.01, 20_001)],
)  # fmt: skip
def test_rows_are_thinned_to_sixty_a_second_and_the_last_stays(rows, interval, kept):
    found = kept_rows(interval * np.arange(rows))
    assert len(found) == kept and found[0] == 0 and found[-1] == rows - 1


# --- page -----------------------------------------------------------------------------------------


def test_ten_seconds_of_a_mecanum_machine_are_far_below_20_mb(runs, youbot):
    assert runs["youbot"].time[-1] == 10.0
    assert len(youbot.encode()) < 2e6  # 1.2e6, of them 0.9e6 for code


def test_the_page_fetches_nothing(youbot):
    elements = Elements(youbot).found
    assert not [given for _, given, _ in elements if {"src", "href"} & given.keys()]
    imports = next(json.loads("".join(inside)) for _, given, inside in elements if given.get("type") == "importmap")
    assert all(address.startswith("data:text/javascript;base64,") for address in imports["imports"].values())
    assert "url(" not in youbot.partition("</style>")[0] and "@import" not in youbot


def test_everything_that_is_operated_has_a_label(youbot):
    operated = [(tag, given) for tag, given, _ in Elements(youbot).found if tag in ("button", "input", "select")]
    assert len(operated) == 13
    assert not [given for _, given in operated if not (given.get("aria-label") or given["in label"])]


def test_a_title_is_text_whatever_it_says(runs):
    trajectory = runs["coulomb_wheel"]
    text = page(Trajectory(trajectory.attributes | {"title": "</script><b>$data"}, trajectory.data))
    assert embedded(text)["title"] == "</script><b>$data" and not [
        tag for tag, *_ in Elements(text).found if tag == "b"
    ]


def test_a_slope_is_told(runs, youbot):
    assert "the floor rises" not in youbot
    sloping = omnisim.simulate(omnisim.load("youbot", ["time.end=0.03", "floor.slope_deg=7.5", "floor.uphill_deg=30"]))
    assert "the floor rises by 7.5&deg; towards 30&deg; from its x axis" in page(sloping)


def test_without_rows_there_is_nothing_to_show():
    with pytest.raises(NothingToShow, match="no rows"):
        page(synthetic_trajectory(rows=0, events=0))


# --- command --------------------------------------------------------------------------------------


def view(*arguments):
    return CliRunner().invoke(cli, ["view", *map(str, arguments)], prog_name="omnisim")


def test_view_writes_stem_html_here_and_replaces_it_with_force_only(runs, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runs["coulomb_wheel"].save("wheel.h5")
    assert view("wheel.h5").stdout.startswith("wheel.html (0.9")
    assert (tmp_path / "wheel.html").read_text() == page(runs["coulomb_wheel"])
    again = view("wheel.h5")
    assert again.exit_code == 2 and "--force" in again.stderr
    assert view("wheel.h5", "--force").exit_code == 0
    onto_itself = view("wheel.h5", "-o", "wheel.h5", "--force")
    assert onto_itself.exit_code == 2 and omnisim.open_trajectory("wheel.h5").complete


def test_view_says_in_one_line_what_is_wrong_with_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "notes.h5").write_text("not HDF5")
    synthetic_trajectory(rows=0, events=0).save("empty.h5")
    synthetic_trajectory().save("strange.h5")
    for name, reason in (("none.h5", "No such file"), ("notes.h5", "not an HDF5 file"), ("empty.h5", "no rows")):
        result = view(name)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1) and f"{name}: " in result.stderr
        assert reason in result.stderr
    assert "strange.h5: scene of the file:1: " in view("strange.h5").stderr
