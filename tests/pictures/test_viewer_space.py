"""The page of a machine free in space as a browser shows it."""

import numpy as np
import pytest
from helpers.charts import CURVES
from helpers.stages import either

from omnisim.pictures.viewer import kept_rows
from omnisim.pictures.viewer_space import shape_of_type, up
from omnisim.results.spatial import matrices
from omnisim.scene.scene import load

SCENES = ("cable_duct", "kiwi_ramp", "rocker")


@pytest.mark.parametrize("name", either(SCENES, ["kiwi_ramp"]))
def test_rollers_are_drawn_where_they_were_computed(runs, shown, name):
    """On springs, on a rocker and inclined: in rows that the page has; between them springs swing on their own."""
    trajectory, tab = runs[name], shown(name)
    ask = "([t, w, n]) => (omnisim.seek(t), [...Array(n).keys()].map(i => omnisim.rollerPosition(w, i)))"
    kept = kept_rows(trajectory.time)
    assert len(kept) < len(trajectory.time)
    for row in np.linspace(0, len(trajectory.time) - 1, 19).astype(int):
        for w, wheel in enumerate(trajectory.wheels):
            center = trajectory[f"wheels/{wheel}/rollers/center_position"][row]
            drawn = np.array(tab.evaluate(ask, [trajectory.time[row], w, len(center)]))
            assert np.abs(drawn - center).max() < (1e-6 if row in kept else 2e-3)  # 6e-8; 8e-4 where one meets the duct


@pytest.mark.parametrize("name", either(SCENES, ["rocker"]))
def test_contact_points_are_drawn_where_they_were_computed(runs, shown, name):
    trajectory, tab = runs[name], shown(name)
    for row in kept_rows(trajectory.time)[::9]:
        drawn = tab.evaluate("t => (omnisim.seek(t), omnisim.contactPoint(0))", trajectory.time[row])
        assert np.abs(drawn - trajectory[f"wheels/{trajectory.wheels[0]}/contact_point"][row]).max() < 1e-6  # float32


def test_a_wheel_in_the_air_looks_so(runs, shown):
    run, tab = runs["cable_duct"], shown("cable_duct")
    inside = kept_rows(run.time)
    flying = np.array([run[f"wheels/{wheel}/contact_roller"][inside] < 0 for wheel in run.wheels])
    ask = "([t, w]) => (omnisim.seek(t), omnisim.inTheAir(w))"
    rows = [*np.flatnonzero(flying.any(axis=0))[:3], np.argmin(flying.any(axis=0))]
    assert flying[:, rows[0]].any() and not flying[:, rows[-1]].any()
    for row in rows:
        told = [tab.evaluate(ask, [run.time[inside[row]], w]) for w in range(4)]
        assert told == flying[:, row].tolist()


def test_springs_are_as_short_as_their_wheels_have_come_up(runs, shown):
    run, tab = runs["cable_duct"], shown("cable_duct")
    free = 0.0475 * (0.9 - 0.12)  # from the axle to what holds the spring above
    for row in kept_rows(run.time)[::17]:
        lengths = tab.evaluate("t => (omnisim.seek(t), omnisim.springLengths())", run.time[row])
        travels = [run[f"wheels/{wheel}/suspension_travel"][row] for wheel in run.wheels]
        assert np.ptp(travels) < 0.02 and np.abs(np.add(lengths, travels) - free).max() < 1e-8  # float32


def test_the_bar_of_a_rocker_turns_with_it_about_its_pivot(runs, shown):
    run, tab = runs["rocker"], shown("rocker")
    for row in kept_rows(run.time)[::17]:
        ((wheel, place),) = tab.evaluate("t => (omnisim.seek(t), omnisim.carried())", run.time[row])
        assert wheel == "front_left"
        place = np.reshape(place, (4, 4)).T
        angle = run["wheels/front_right/rocker_angle"][row]
        assert place[1:3, 1] == pytest.approx([np.cos(angle), np.sin(angle)], abs=1e-7)
        pivot = np.array([0.235, 0.0, 0.0475, 1.0])
        assert np.abs(place @ pivot - pivot).max() < 1e-9


def test_the_chart_has_the_angle_of_a_rocker_once(runs, shown):
    (curve,) = shown("rocker").evaluate(CURVES)["angle of the rocker, rad"]
    run = runs["rocker"]
    recorded = run["wheels/front_right/rocker_angle"][kept_rows(run.time)]
    assert curve["label"] == "front" and np.array_equal(curve["values"], recorded.astype("float32"))


def test_a_rocker_turns_as_its_wheels_stand(runs):
    """The angle that is told is that of the mean of the rollers of either wheel about the line of the rocker, along x
    here, from where they stand in the plane."""
    run = runs["rocker"]
    config = load("rocker").config
    (axle,) = config.axles
    assert np.ptp(run[f"wheels/{axle.wheels[0]}/rocker_angle"]) > 0.01
    for wheel in config.wheels:
        if config.rocker_of(wheel) is None:
            assert f"wheels/{wheel.name}/rocker_angle" not in run
            continue
        middle = run[f"wheels/{wheel.name}/rollers/center_position"].mean(axis=1) - run["body/position"]
        _, y, z = np.einsum("tij,ti->jt", matrices(run["body/orientation"]), middle) - np.reshape(axle.point, (3, 1))
        angle = np.arctan2(z, y) - np.arctan2(config.type_of(wheel).radius - axle.point[2], wheel.position[1])
        wrapped = (run[f"wheels/{wheel.name}/rocker_angle"] - angle + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(wrapped).max() < 1e-12


def test_barrels_are_drawn_as_barrels_in_their_rows():
    kind = load("kiwi_ramp").config.wheel_types["omni"]
    drawn = shape_of_type(kind)
    u, r = np.transpose(drawn["profile"])
    shape = kind.profile
    assert u[-1] == -u[0] == shape.half_length and r.max() == shape.radius
    circle = (r - shape.radius + shape.curvature_radius) ** 2 + u**2
    assert np.abs(circle - shape.curvature_radius**2).max() < 1e-17
    assert drawn["rollers"] == 18 and drawn["rows"][1] == {"offset": 0.009, "phase": np.radians(20.0)}


def test_up_is_against_gravity():
    assert up(load("cable_duct").config) == [0.0, 0.0, 1.0]
    slope = np.radians(10.0)
    assert up(load("kiwi_ramp").config) == pytest.approx([np.sin(slope), 0.0, np.cos(slope)])


@pytest.mark.parametrize("name", either(SCENES, ["cable_duct"]))
def test_the_browser_has_nothing_to_complain_of(shown, name):
    tab = shown(name)
    choices = tab.locator("#quantity option").all_text_contents()
    assert {"height, m", "roll and pitch, rad"} <= set(choices)
    assert ("suspension travel, m" in choices) == (name == "cable_duct")
    for quantity in choices:
        tab.locator("#quantity").select_option(quantity)
    tab.emulate_media(color_scheme="dark")
    tab.wait_for_timeout(300)
    assert tab.complaints == []
