"""The page of a trajectory as a browser shows it."""

import numpy as np
import pytest
from helpers.charts import CURVES
from helpers.stages import either

from omnisim.pictures.viewer import (
    kept_rows,
)

SCENES = ("coulomb_wheel", "kiwi", "mixed", "youbot", "kiwi on rows")


@pytest.mark.parametrize("name", either(SCENES, ["kiwi on rows"]))
def test_rollers_are_drawn_where_they_were_computed(runs, shown, name):
    """In rows that the page has, and in rows that were left out, which it interpolates."""
    trajectory, tab = runs[name], shown(name)
    rows = np.linspace(0, len(trajectory.time) - 1, 23).astype(int)
    of_wheel = "(count, w) => [...Array(count).keys()].map(i => omnisim.rollerPosition(w, i))"
    ask = f"([t, counts]) => (omnisim.seek(t), counts.map({of_wheel}))"
    centers = [trajectory[f"wheels/{wheel}/rollers/center_position"] for wheel in trajectory.wheels]
    left_out = set(rows) - set(kept_rows(trajectory.time))
    assert left_out
    for row in rows:
        drawn = tab.evaluate(ask, [trajectory.time[row], [center.shape[1] for center in centers]])
        for wheel, center in zip(drawn, centers, strict=True):
            assert np.abs(np.array(wheel) - center[row]).max() < 1e-4  # 2e-5, in rows of the page 3e-7


@pytest.mark.parametrize("name", either(SCENES, ["kiwi on rows"]))
def test_contact_points_are_drawn_where_they_were_computed(runs, shown, name):
    trajectory, tab = runs[name], shown(name)
    for row in kept_rows(trajectory.time)[::7]:
        drawn = tab.evaluate("t => (omnisim.seek(t), omnisim.contactPoint(0))", trajectory.time[row])
        assert np.abs(drawn - trajectory[f"wheels/{trajectory.wheels[0]}/contact_point"][row]).max() < 1e-12  # 7e-16


@pytest.mark.long
def test_it_draws_with_webgl_and_the_machine_is_in_the_picture(shown):
    tab = shown("youbot")
    assert tab.evaluate("!!document.querySelector('#stage canvas').getContext('webgl2')")
    with_chassis = tab.screenshot()
    tab.get_by_label("chassis").uncheck()
    tab.wait_for_timeout(500)
    assert tab.screenshot() != with_chassis
    tab.get_by_label("chassis").check()


@pytest.mark.long
def test_time_advances_while_it_plays_and_stands_while_it_does_not(shown):
    tab = shown("kiwi")
    tab.evaluate("omnisim.seek(0)")
    tab.get_by_role("button", name="Play").click()
    tab.wait_for_function("omnisim.time > 0.2")
    tab.get_by_role("button", name="Pause").click()
    stopped = tab.evaluate("omnisim.time")
    tab.wait_for_timeout(300)
    assert tab.evaluate("omnisim.time") == stopped and not tab.evaluate("omnisim.playing")


def test_the_slider_sets_the_time_and_keys_step_by_rows(runs, shown):
    tab, times = shown("kiwi"), runs["kiwi"].time[kept_rows(runs["kiwi"].time)]
    tab.get_by_role("slider").fill("1.5")
    assert tab.evaluate("omnisim.time") == 1.5
    for key, expected in (("Home", 0.0), ("ArrowRight", times[1]), ("ArrowRight", times[2]), ("ArrowLeft", times[1]),
                          ("End", times[-1]), ("ArrowRight", times[-1])):  # fmt: skip
        tab.keyboard.press(key)
        assert tab.evaluate("omnisim.time") == expected


LANE = 12  # px


@pytest.mark.parametrize("kind", either(["exchange", "stick", "slip"], []))
def test_an_event_is_told_where_the_mouse_is_in_the_lane_of_its_kind_and_a_click_goes_there(runs, shown, kind):
    tab, run = shown("kiwi"), runs["kiwi"]
    times = run["events/time"][run["events/kind"] == kind]
    lane = [name for name in ("exchange", "stick", "slip") if name in run["events/kind"]].index(kind)
    assert f"{len(times)} {kind}" == tab.locator("#lanes span").nth(lane).text_content()
    bar = tab.locator("#marks").bounding_box()
    there = {"x": 8 + (bar["width"] - 16) * times[0] / run.time[-1], "y": LANE * (lane + 0.4)}
    tab.locator("#marks").hover(position=there)
    assert f"{times[0]:.4f} s: {kind}" in tab.locator("#tooltip").text_content()
    tab.locator("#marks").click(position=there)
    reached = tab.evaluate("omnisim.time")  # of one of the events within a pixel
    assert reached in times and abs(reached - times[0]) < 1e-4


# Red, green, blue and opacity in lanes of the marks at times in s.
COLOURS = """([times, lanes]) => {
  const canvas = document.getElementById("marks");
  const pen = canvas.getContext("2d");
  const width = canvas.clientWidth - 16;
  return times.map((t) => lanes.map((lane) => {
    const x = Math.round((8 + (width * t) / omnisim.duration) * devicePixelRatio - 0.5);
    return [...pen.getImageData(x, (12 * lane + 5) * devicePixelRatio, 1, 1).data];
  }));
}"""


@pytest.mark.long
def test_no_slip_is_hidden_behind_a_stick(runs, shown):
    """Each has its mark in the lane of slips, in its own colour; so have those at whose time a wheel sticks."""
    tab, run = shown("mixed"), runs["mixed"]
    times = {kind: run["events/time"][run["events/kind"] == kind] for kind in ("stick", "slip")}
    sticks, slips = np.array(tab.evaluate(COLOURS, [times["slip"].tolist(), [1, 2]])).transpose(1, 0, 2)
    beside = np.abs(times["slip"][:, None] - times["stick"]).min(axis=1) < 1e-3  # s: less than a pixel
    assert len(slips) > 30 and beside.any()  # one lane for both would hide these
    for found, colour in ((slips, (229, 165, 10)), (sticks[beside], (46, 158, 68))):
        assert np.abs(found[:, :3] - colour).max() <= 5 and found[:, 3].min() > 90  # 2 of 255, 191: smooth edges


@pytest.mark.parametrize("name", either(SCENES, ["youbot"]))
def test_a_time_axis_stands_below_the_slider(runs, shown, name):
    tab, end = shown(name), runs[name].time[-1]
    slider = tab.get_by_role("slider").bounding_box()
    labels = tab.locator("#axis span").all()
    times = [float(label.text_content()) for label in labels]
    assert times[0] == 0.0 and 4 < len(times) < 20 and end - times[-1] < times[1]
    assert np.diff(times) == pytest.approx(times[1])
    for label, time in zip(labels, times, strict=True):
        box = label.bounding_box()
        middle = box["x"] + box["width"] / 2
        assert abs(middle - (slider["x"] + 8 + (slider["width"] - 16) * time / end)) < 0.1  # px; where the thumb is
        assert box["y"] >= slider["y"] + slider["height"] - 1


@pytest.mark.long
def test_ticks_are_round_whatever_the_duration(shown):
    ask = "async ([d, p]) => (await import('omnisim/timebar')).ticks(d, p)"
    for duration, pixels, expected in (
        (10.0, 1000, range(11)), (10.0, 200, (0, 5, 10)), (0.3, 500, (0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3)),
        (0.0, 500, [0]), (1000.0, 900, range(0, 1001, 100)), (2.5e-3, 400, (0, 5e-4, 1e-3, 1.5e-3, 2e-3, 2.5e-3)),
        (10.0, 0, [0]),
    ):  # fmt: skip
        assert shown("kiwi").evaluate(ask, [duration, pixels]) == list(expected)


@pytest.mark.long
def test_the_chart_has_curves_of_spin_rate_torque_power_and_odometry_error(runs, shown):
    tab, run = shown("youbot"), runs["youbot"]
    curves, rows = tab.evaluate(CURVES), kept_rows(run.time)
    assert tab.locator("#quantity option").all_text_contents() == list(curves)
    for title, name in (("spin rate, rad/s", "spin_rate"), ("drive torque, N m", "drive_torque"),
                        ("drive power, W", "drive_power")):  # fmt: skip
        assert [curve["label"] for curve in curves[title]] == list(run.wheels)
        for curve in curves[title]:
            expected = run[f"wheels/{curve['label']}/{name}"][rows].astype("float32")
            assert np.array_equal(curve["values"], expected)
    (position,), (yaw,) = curves["odometry error, m"], curves["odometry error, rad"]
    error = np.hypot(*run["odometry/position_error"][rows].astype("float32").astype(float).T)
    assert np.allclose(position["values"], error, rtol=1e-12, atol=0.0)
    assert np.array_equal(yaw["values"], run["odometry/yaw_error"][rows].astype("float32"))
    assert "voltage, V" not in curves and "odometry error, m" not in shown("coulomb_wheel").evaluate(CURVES)


@pytest.mark.long
def test_a_curve_tells_its_target_beside_its_value(shown):
    tab = shown("youbot")
    tab.locator("#quantity").select_option("spin rate, rad/s")
    tab.evaluate("omnisim.seek(5)")
    legend = tab.locator("#chart .u-legend")
    assert legend.inner_text().count("(target 10.53)") == 4
    assert len([row for row in legend.locator(".u-series").all() if row.is_visible()]) == 5  # time and four wheels


# Feeds the module that picks how finely to draw: [frames, ms each] in turn; the level after each, 0 the finest.
JUDGE = """async (turns) => {
  const { Quality } = await import("omnisim/quality");
  const quality = new Quality();
  return turns.map(([frames, ms]) => {
    for (let i = 0; i < frames; i++) quality.passed(ms / 1000);
    return quality.at;
  });
}"""


@pytest.mark.parametrize(
    ("turns", "levels"),
    [
        pytest.param([(600, 1000 / 60)], [0], id="a fast screen keeps the finest"),
        pytest.param([(600, 1000 / 30)], [0], id="a screen of 30 frames per second too"),
        pytest.param([(29, 17), (1, 900), (300, 17)], [0, 0, 0], id="a hiccup changes nothing"),
        pytest.param([(9, 45), (300, 25)], [1, 1], id="a bit too slow: one level, which stays where it is smooth"),
        pytest.param([(5, 250)], [3], id="much too slow: several at once"),
        pytest.param([(5, 250), (5, 250), (230, 17), (720, 17)], [3, 3, 3, 0], id="finer again after a while"),
        pytest.param([(9, 45), (312, 17), (9, 45), (312, 17), (312, 17)], [1, 0, 1, 1, 0], id="later each time"),
    ],
)
@pytest.mark.long
def test_how_finely_it_draws_follows_the_frame_times(shown, turns, levels):
    assert shown("kiwi").evaluate(JUDGE, turns) == levels


# Frames come when the test says so, with the time it says; pictures are counted.
BY_HAND = """
  window.asked = [];
  window.requestAnimationFrame = (frame) => asked.push(frame);
  window.turn = (ms) => asked.splice(0).forEach((frame) => frame((turn.time = (turn.time ?? 0) + ms)));
  window.pictures = 0;
  for (const kind of [WebGLRenderingContext, WebGL2RenderingContext]) {
    const clear = kind.prototype.clear;
    kind.prototype.clear = function (...given) { pictures++; return clear.apply(this, given); };
  }
"""
PIXELS = "document.querySelector('#stage canvas').width / document.querySelector('#stage').clientWidth"


@pytest.fixture
def by_hand(youbot, browser, tmp_path):
    (tmp_path / "page.html").write_text(youbot, encoding="utf-8")
    tab = browser.new_page()
    tab.add_init_script(BY_HAND)
    tab.goto((tmp_path / "page.html").as_uri())
    tab.wait_for_function("window.omnisim", polling=50)
    tab.evaluate("while (asked.length) turn(16)")
    yield tab
    tab.close()


@pytest.mark.parametrize("ms", either([8, 16, 40, 250], [16]))
def test_the_run_keeps_pace_with_the_clock_whatever_the_frame_rate(by_hand, ms):
    by_hand.evaluate("ms => { omnisim.play(); turn(ms); for (let i = 0; i < 20; i++) turn(ms); }", ms)
    assert by_hand.evaluate("omnisim.time") == pytest.approx(20e-3 * ms, abs=1e-12)


@pytest.mark.long
def test_it_plays_coarsely_where_frames_are_slow_and_is_sharp_at_rest(by_hand):
    assert by_hand.evaluate(PIXELS) == 1.0
    by_hand.evaluate("omnisim.play(); for (let i = 0; i < 20; i++) turn(250);")
    assert by_hand.evaluate(PIXELS) == 0.5
    by_hand.evaluate("omnisim.pause(); turn(250);")
    by_hand.wait_for_function(f"{PIXELS} === 1", polling=50)  # not by frames, which do not come


@pytest.mark.long
def test_nothing_is_drawn_while_nothing_moves(by_hand):
    by_hand.wait_for_timeout(300)
    before = by_hand.evaluate("pictures")
    by_hand.wait_for_timeout(500)
    assert by_hand.evaluate("[pictures, asked.length]") == [before, 0] and before > 0
    by_hand.evaluate("omnisim.seek(1); while (asked.length) turn(16);")
    assert by_hand.evaluate("pictures") > before


@pytest.mark.parametrize("name", either(SCENES, ["youbot"]))
def test_the_browser_has_nothing_to_complain_of(shown, name):
    tab = shown(name)
    for quantity in tab.locator("#quantity option").all_text_contents():
        tab.locator("#quantity").select_option(quantity)
    tab.evaluate("omnisim.seek(omnisim.duration / 2)")
    tab.emulate_media(color_scheme="dark")
    tab.wait_for_timeout(300)
    assert tab.complaints == []
