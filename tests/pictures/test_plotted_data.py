"""What stands in a figure is what stands in the datasets."""

import numpy as np
import pytest
from figures import MACHINE, axes_of, has_panel, lines, machine, motors
from synthetic import synthetic_trajectory

import omnisim
from omnisim.base.status import EVENT_KINDS
from omnisim.pictures.plots.floor import UNMARKED
from omnisim.results import commanded as commands_of

matplotlib = pytest.importorskip("matplotlib", reason="needs matplotlib")
matplotlib.use("agg")

from matplotlib import pyplot  # noqa: E402

from omnisim.pictures import plots  # noqa: E402
from omnisim.pictures.plots.marks import ordinal  # noqa: E402


@pytest.fixture(autouse=True)
def closed():
    """Figures do not pile up."""
    yield
    pyplot.close("all")


def test_the_story_shows_the_datasets():
    run = machine()
    figure = plots.story(run)
    found = lines(figure, "y, m")["rollers µ"]
    np.testing.assert_array_equal(found, run["body/position"][:, :2].T)
    time, yaw_rate = lines(figure, "yaw rate, rad/s")["rollers µ"]
    np.testing.assert_array_equal(time, run.time)
    np.testing.assert_array_equal(yaw_rate, run["body/yaw_rate"])
    speed = np.hypot(*run["body/velocity"][:, :2].T)
    np.testing.assert_allclose(lines(figure, "speed, m/s")["rollers µ"][1], speed, rtol=1e-15)
    for wheel in MACHINE:
        force = lines(figure, "normal force, N")[wheel][1]
        np.testing.assert_array_equal(force, run[f"wheels/{wheel}/normal_force"])
        slip = np.hypot(*run[f"wheels/{wheel}/slip_velocity"].T)
        np.testing.assert_allclose(lines(figure, "slip speed, m/s")[wheel][1], slip, rtol=1e-15)
    energies = lines(figure, "energy, J")
    assert list(energies) == ["kinetic energy", "friction loss", "bearing loss", "drive work", "wrench work"]
    np.testing.assert_array_equal(energies["drive work"][1], run["energy/drive_work"])
    np.testing.assert_array_equal(lines(figure, "|balance|, J")["rollers µ"][1], np.abs(run["energy/balance"]))


def test_all_events_stand_below_the_panels_and_on_the_path():
    run = machine()
    strip = plots.slip(run).axes[-1]
    assert [text.get_text() for text in strip.get_yticklabels()] == [kind.replace("_", " ") for kind in EVENT_KINDS]
    path = plots.path(run).axes[0]
    for kind in EVENT_KINDS:
        times = run["events/time"][run["events/kind"] == kind]
        shown = [line.get_xdata() for line in strip.get_lines() if line.get_label() == kind]
        np.testing.assert_array_equal(np.sort(np.concatenate(shown)), times)
        marks = [line for line in path.get_lines() if line.get_label() == kind]
        if kind in UNMARKED:
            assert not marks
            continue
        (marks,) = marks
        np.testing.assert_array_equal(marks.get_xdata(), np.interp(times, run.time, run["body/position"][:, 0]))


def test_arrows_point_along_the_heading(wheel):
    (arrows,) = [child for child in plots.path(wheel).axes[0].get_children() if hasattr(child, "U")]
    rows = np.isin(wheel["body/position"][:, 0], arrows.X)
    np.testing.assert_allclose(np.arctan2(arrows.V, arrows.U), wheel["body/yaw"][rows], atol=1e-15)
    np.testing.assert_array_equal(arrows.angles, np.degrees(wheel["body/yaw"][rows]))


def test_single_views_show_the_datasets(kiwi):
    forces, contact, slip, odometry = (draw(kiwi) for draw in (plots.forces, plots.contact, plots.slip, plots.odometry))
    for wheel in kiwi.wheels:
        of = f"wheels/{wheel}"
        for figure, label, values in (
            (forces, "friction along heading, N", kiwi[f"{of}/friction_force"][:, 0]),
            (forces, "friction along axle, N", kiwi[f"{of}/friction_force"][:, 1]),
            (forces, "drive torque, N m", kiwi[f"{of}/drive_torque"]),
            (contact, "roller in contact", kiwi[f"{of}/contact_roller"]),
            (contact, "contact angle, rad", kiwi[f"{of}/contact_angle"]),
            (contact, "share of the load", kiwi[f"{of}/contact_share"]),
            (slip, "along heading, m/s", kiwi[f"{of}/slip_velocity"][:, 0]),
            (slip, "along axle, m/s", kiwi[f"{of}/slip_velocity"][:, 1]),
        ):
            np.testing.assert_array_equal(lines(figure, label)[wheel][1], values)
    position, error = lines(odometry, "error of position, m"), kiwi["odometry/position_error"]
    np.testing.assert_array_equal(position["along y"][1], error[:, 1])
    np.testing.assert_allclose(position["distance"][1], np.hypot(*error.T), rtol=1e-15)
    (yaw,) = lines(odometry, "error of yaw, rad").values()
    np.testing.assert_array_equal(yaw[1], kiwi["odometry/yaw_error"])


def test_the_drives_view_shows_rates_beside_their_targets_torque_and_power(kiwi):
    figure = plots.drives(kiwi)
    rates, deviations = lines(figure, "spin rate, rad/s"), lines(figure, "spin rate less target, rad/s")
    twists = np.column_stack([np.interp(kiwi.time, [0, 0.1, 0.2], column) for column in np.array(
        [[0, 0, 0], [0.5, 0, 0], [0.5, 0, 0.5]]).T])  # fmt: skip
    power = 0.0
    for wheel, heading, (x, y) in zip(kiwi.wheels, (150, 270, 30), [(0.0625, 0.1083), (-0.125, 0), (0.0625, -0.1083)],
                                      strict=True):  # fmt: skip
        cos, sin = np.cos(np.radians(heading)), np.sin(np.radians(heading))
        target = (twists[:, 0] * cos + twists[:, 1] * sin + twists[:, 2] * (x * sin - y * cos)) / 0.05
        rate = kiwi[f"wheels/{wheel}/spin_rate"]
        np.testing.assert_allclose(rates[f"target of {wheel}"][1], target, atol=1e-3)  # places have four digits
        np.testing.assert_array_equal(rates[wheel][1], rate)
        np.testing.assert_array_equal(deviations[wheel][1], rate - rates[f"target of {wheel}"][1])
        for label, path in (("drive torque, N m", "drive_torque"), ("mechanical power, W", "drive_power")):
            np.testing.assert_array_equal(lines(figure, label)[wheel][1], kiwi[f"wheels/{wheel}/{path}"])
        power += kiwi[f"wheels/{wheel}/drive_power"]
    np.testing.assert_allclose(lines(figure, "power of all drives, W")["at the wheels"][1], power, atol=1e-15)
    assert not has_panel(figure, "voltage, V")


def test_the_drives_view_of_motors_shows_what_the_file_has_of_them():
    run = motors()
    figure = plots.drives(run)
    for label, path in (("voltage, V", "voltage"), ("current, A", "current"),
                        ("electrical power, W", "electrical_power")):  # fmt: skip
        for wheel in MACHINE:
            np.testing.assert_array_equal(lines(figure, label)[wheel][1], run[f"wheels/{wheel}/{path}"])
    target = lines(figure, "spin rate, rad/s")["target of back"][1]
    np.testing.assert_array_equal(target, run["wheels/back/target_rate"])
    supply = sum(run[f"wheels/{wheel}/electrical_power"] for wheel in MACHINE)
    np.testing.assert_allclose(lines(figure, "power of all drives, W")["from the supply"][1], supply, atol=1e-15)
    plots.drives([run, machine(title="another")]).canvas.draw()


@pytest.mark.parametrize(
    ("name", "label", "path"),
    [
        ("forces", "normal force, N", "normal_force"),
        ("forces", "friction, N", "friction_force"),
        ("slip", "slip speed, m/s", "slip_velocity"),
        ("drives", "drive torque, N m", "drive_torque"),
        ("drives", "mechanical power, W", "drive_power"),
    ],
)
def test_a_band_reaches_as_far_as_the_extremes_between_rows(name, label, path):
    """Over the interval before each row; where only the largest is known, up from the smaller of its two rows."""
    run = motors()
    axes = axes_of(plots.VIEWS[name](run), label)
    for wheel in MACHINE:
        (band,) = [band for band in axes.collections if band.get_label() == f"band of {wheel}"]
        found = {tuple(vertex) for vertex in band.get_paths()[0].vertices}
        high = run[f"interval_max/wheels/{wheel}/{path}"]
        values = run[f"wheels/{wheel}/{path}"]
        values = values if values.ndim == 1 else np.linalg.norm(values, axis=1)
        low = run.data.get(f"interval_min/wheels/{wheel}/{path}", np.minimum(values, [values[0], *values[:-1]]))
        for i in range(1, 41):
            for edge in (low, high):
                assert {(run.time[i - 1], edge[i]), (run.time[i], edge[i])} <= found
    assert not axes_of(plots.VIEWS[name](machine()), label).collections


def test_extremes_of_bearing_loads_and_of_odometry_are_bands(kiwi):
    """As high as `info` has the peak, whichever its sign, and higher than any row."""

    def top(figure, label, part):
        (band,) = [one for one in axes_of(figure, label).collections if one.get_label() == f"band of {part}"]
        return band.get_paths()[0].vertices[:, 1].max()

    bearings, of = plots.bearings(kiwi), "wheels/left"
    for label, path in (("axle, axial, N", f"{of}/bearing_axial_force"),
                        ("roller, axial, N", f"{of}/rollers/bearing_axial_force")):  # fmt: skip
        peak = max(np.abs(kiwi[f"{group}/{path}"]).max() for group in ("interval_max", "interval_min"))
        assert top(bearings, label, "left") == peak > lines(bearings, label)["left"][1].max()
    for label, path in (("axle, radial, N", f"{of}/bearing_radial_force"),
                        ("roller, radial, N", f"{of}/rollers/bearing_radial_force"),
                        ("roller, tilting moment, N m", f"{of}/rollers/bearing_tilting_moment")):  # fmt: skip
        assert top(bearings, label, "left") == kiwi[f"interval_max/{path}"].max()
    error = kiwi["interval_max/odometry/position_error"].max()
    assert top(plots.odometry(kiwi), "error of position, m", "distance") == error
    assert top(plots.path(kiwi), "distance, m", "odometry from machine") == error


def test_beside_the_path_stand_the_commanded_one_and_that_of_the_odometry(kiwi):
    figure = plots.path(kiwi)
    found = lines(figure, "y, m")
    commanded = commands_of.path(omnisim.load_text(kiwi.attributes["scene"]).config, kiwi.time)
    np.testing.assert_array_equal(found["commanded"], commanded[:, :2].T)
    np.testing.assert_array_equal(found["odometry"], kiwi["odometry/position"].T)
    distances = lines(figure, "distance, m")
    position = kiwi["body/position"][:, :2]
    np.testing.assert_allclose(distances["machine from command"][1], np.hypot(*(position - commanded[:, :2]).T))
    np.testing.assert_allclose(distances["odometry from machine"][1], np.hypot(*kiwi["odometry/position_error"].T))
    legend = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
    assert legend[:4] == ["begin", "path", "commanded", "odometry"]


def test_the_outline_stands_where_the_wheels_are(kiwi):
    """The corners of its frame are the wheel centres: omni wheels touch the floor right below them."""
    outlines = plots.path(kiwi).axes[0].collections[0]
    for row, frame in ((0, 0), (-1, -4)):  # a frame and three wheels each, the last row's at the end
        corners = outlines.get_paths()[frame].vertices[:3]
        contacts = np.array([kiwi[f"wheels/{wheel}/contact_point"][row, :2] for wheel in kiwi.wheels])
        distances = np.hypot(*(corners[:, None] - contacts).transpose(2, 0, 1))
        assert distances.min(axis=1).max() < 1e-12  # 4e-16


def test_a_legend_says_how_far_contours_of_the_ground_are_apart():
    """Of a bump of 7 mm on level ground, the darkest above."""
    scene = omnisim.load("cable_duct", ["floor.steps=[]", "floor.bumps=[[0.0, 0.0, 0.007, 0.5]]"]).text
    axes = plots.path(synthetic_trajectory(scene=scene)).axes[0]
    (said,) = [text.get_text() for text in axes.get_legend().get_texts() if "ground" in text.get_text()]
    assert said == "ground: 1 mm apart, dark is high"
    (contours,) = [part for part in axes.collections if hasattr(part, "levels")]
    np.testing.assert_allclose(np.diff(contours.levels), 1.0, rtol=5e-3)
    assert contours.cmap(0.0)[:3] > contours.cmap(1.0)[:3]


def test_the_story_shows_drives_where_there_are_any(kiwi, wheel):
    for run, driven in ((kiwi, True), (wheel, False), ([wheel, kiwi], True)):
        figure = plots.story(run)
        assert has_panel(figure, "drive torque, N m") == has_panel(figure, "spin rate, rad/s") == driven


@pytest.mark.parametrize(("count", "drawn", "said"), [(30, 30, "slip"), (608, 30, "slip, every 21st of 608"),
                                                      (31, 16, "slip, every 2nd of 31")])  # fmt: skip
def test_of_many_events_every_so_many_is_marked_and_the_legend_says_so(count, drawn, said):
    run = synthetic_trajectory(events=count)
    run.data["events/kind"] = np.array(["slip"] * count)
    run.data["events/time"] = np.linspace(0.05, 0.95, count)
    axes = plots.path(run).axes[0]
    (marks,) = [line for line in axes.get_lines() if line.get_label() == "slip"]
    assert len(marks.get_xdata()) == drawn
    ends = np.interp([0.05, 0.95], run.time, run["body/position"][:, 0])
    np.testing.assert_array_equal(marks.get_xdata()[[0, -1]], ends)
    assert axes.get_legend().get_texts()[-1].get_text() == said


def test_ticks_of_thousands_of_events_are_thinned_too():
    run = synthetic_trajectory(events=6001)
    run.data["events/kind"] = np.array(["slip"] * 6001)
    run.data["events/wheel"] = np.array(["wheel"] * 6001)
    run.data["events/time"] = np.linspace(0.0, 1.0, 6001)
    strip = plots.slip(run).axes[-1]
    assert [text.get_text() for text in strip.get_yticklabels()] == ["slip\nevery 13th of 6001"]
    (ticks,) = strip.get_lines()
    assert 450 < len(ticks.get_xdata()) <= 501 and set(ticks.get_xdata()[[0, -1]]) == {0.0, 1.0}


def test_ordinals():
    numbers = [1, 2, 3, 4, 11, 12, 13, 21, 102, 111, 113, 1003]
    shown = ["1st", "2nd", "3rd", "4th", "11th", "12th", "13th", "21st", "102nd", "111th", "113th", "1003rd"]
    assert [ordinal(number) for number in numbers] == shown


def test_the_map_of_rollers_has_their_joint_rates_and_follows_the_contact(kiwi):
    for axes, wheel in zip(plots.rollers(kiwi).axes, kiwi.wheels, strict=False):
        (image,), (contact,) = axes.get_images(), axes.get_lines()
        np.testing.assert_array_equal(image.get_array(), kiwi[f"wheels/{wheel}/rollers/joint_rate"].T)
        np.testing.assert_array_equal(contact.get_ydata(), kiwi[f"wheels/{wheel}/contact_roller"])


def test_bearings_show_what_info_sums_up(kiwi):
    figure = plots.bearings(kiwi)
    force, moment = (kiwi[f"wheels/left/bearing_{name}"] for name in ("force", "moment"))
    np.testing.assert_allclose(lines(figure, "axle, radial, N")["left"][1], np.hypot(force[:, 0], force[:, 2]))
    np.testing.assert_array_equal(lines(figure, "axle, axial, N")["left"][1], np.abs(force[:, 1]))
    tilting = np.hypot(moment[:, 0], moment[:, 2])
    np.testing.assert_allclose(lines(figure, "axle, tilting moment, N m")["left"][1], tilting)
    axial = np.abs(kiwi["wheels/left/rollers/bearing_force"][:, :, 2]).max(axis=1)
    np.testing.assert_array_equal(lines(figure, "roller, axial, N")["left"][1], axial)


def test_ripple_shows_the_spectrum(wheel):
    from omnisim.results.ripple import of_wheel

    (shown,) = lines(plots.ripple(wheel), "forward speed, m/s").values()
    velocity, yaw = wheel["body/velocity"], wheel["body/yaw"]
    forward = np.cos(yaw) * velocity[:, 0] + np.sin(yaw) * velocity[:, 1]
    np.testing.assert_array_equal(shown, of_wheel(wheel, "wheel", forward))
    orders, amplitudes = shown
    near = np.abs(orders - 1.0) < 0.5
    assert abs(orders[near][np.argmax(amplitudes[near])] - 1.0) < 0.05  # 0.0


def test_trackings_show_the_differences_and_the_bounds_of_the_paper():
    pair = [omnisim.simulate(omnisim.load("six_rollers", [f"solver.tracking={name}"]))
            for name in ("implicit", "explicit")]  # fmt: skip
    figure = plots.trackings(pair)
    for axes, (name, bound) in zip(
        figure.axes, {"acceleration": 1e-8, "velocity": 1e-7, "position": 1e-6}.items(), strict=True
    ):
        difference, paper = axes.get_lines()
        heights = [run[f"wheels/wheel/rollers/center_{name}"][:, 0, 2] for run in pair]
        np.testing.assert_array_equal(difference.get_ydata(), np.abs(heights[0] - heights[1]))
        assert difference.get_ydata().max() < bound  # 9e-11, 5e-12, 4e-13
        assert axes.get_yscale() == "log" and set(paper.get_ydata()) == {bound}


def test_rows_between_the_exchanges_of_two_trackings_are_left_out():
    a, b = synthetic_trajectory(), synthetic_trajectory()
    b.data["wheels/wheel/contact_roller"] = b["wheels/wheel/contact_roller"].copy()
    b.data["wheels/wheel/contact_roller"][4] += 1
    difference = plots.trackings([a, b]).axes[0].get_lines()[0]
    np.testing.assert_array_equal(difference.get_xdata(), np.delete(a.time, 4))
