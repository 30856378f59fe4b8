"""Pictures of trajectories: every view of every kind of file, and what cannot be shown."""

import numpy as np
import pytest
from figures import every_axis_is_named, lines, machine, undriven
from helpers.stages import either
from synthetic import synthetic_attributes, synthetic_data, synthetic_trajectory

from omnisim.results.trajectory import Trajectory

matplotlib = pytest.importorskip("matplotlib", reason="needs matplotlib")
matplotlib.use("agg")

from matplotlib import pyplot  # noqa: E402

from omnisim.pictures import plots  # noqa: E402


@pytest.fixture(autouse=True)
def closed():
    """Figures do not pile up."""
    yield
    pyplot.close("all")


# --- every view of every kind of file -------------------------------------------------------------


@pytest.mark.parametrize(
    "name", either(sorted(set(plots.VIEWS) - {"trackings", "ride"}), ["story", "odometry", "slip"])
)
def test_every_view_of_a_machine_is_drawn(name, kiwi):
    for trajectories in (machine(), [machine(title="made up"), kiwi]):
        figure = plots.VIEWS[name](trajectories)
        figure.canvas.draw()
        every_axis_is_named(figure)


@pytest.mark.parametrize(
    "name", either(sorted(set(plots.VIEWS) - {"trackings", "odometry", "drives", "ride"}), ["story", "rollers"])
)
def test_every_view_of_a_wheel_is_drawn(name, wheel):
    plots.VIEWS[name](wheel).canvas.draw()


@pytest.mark.parametrize("name", either(sorted(set(plots.VIEWS) - {"trackings", "bearings"}), ["story", "ride"]))
def test_every_view_of_a_machine_free_in_space_is_drawn(name, runs):
    for scene in ("cable_duct", "kiwi_ramp")[: 1 if name == "ripple" else 2]:  # the second is too short for one
        figure = plots.VIEWS[name](runs[scene])
        figure.canvas.draw()
        every_axis_is_named(figure)


def test_a_ride_shows_height_roll_pitch_and_travel_as_recorded(runs):
    run = runs["cable_duct"]
    height, angles, travel, _, events = plots.ride(run).axes
    assert np.array_equal(height.lines[0].get_ydata(), 1e3 * run["body/position"][:, 2])
    roll, pitch = (np.radians(line.get_ydata()) for line in angles.lines)
    w, x, y, z = run["body/orientation"].T
    assert np.abs(np.sin(pitch) - 2.0 * (w * y - x * z)).max() < 1e-15
    assert np.abs(np.tan(roll) * (1.0 - 2.0 * (x * x + y * y)) - 2.0 * (w * x + y * z)).max() < 1e-15
    for line, wheel in zip(travel.lines, run.wheels, strict=True):
        assert np.array_equal(line.get_ydata(), 1e3 * run[f"wheels/{wheel}/suspension_travel"])
    assert [label.get_text() for label in events.get_yticklabels()][-2:] == ["contact begin", "contact end"]
    assert len(plots.ride(runs["kiwi_ramp"]).axes) == 4  # no springs


def test_a_wheel_looks_the_same_in_every_panel(runs):
    """Those that stand on springs alone, in the panel of their travel too."""
    run = runs["cable_duct"]
    data = {path: array for path, array in run.data.items() if "front_left/suspension" not in path}
    _, _, travel, force, _ = plots.ride(Trajectory(run.attributes, data)).axes
    of_travel, of_force, told = (
        [(line.get_label(), line.get_color(), line.get_linestyle()) for line in lines]
        for lines in (travel.lines, force.lines, travel.get_legend().get_lines())
    )
    assert [label for label, *_ in of_travel] == list(run.wheels[1:]) and set(of_travel) <= set(of_force)
    assert [look for _, *look in told] == [look for _, *look in of_travel]


def test_a_ride_shows_a_rocker_once_by_its_name(runs):
    run = runs["rocker"]
    angle = plots.ride(run).axes[2]
    (line,) = angle.lines
    assert (line.get_label(), angle.get_ylabel()) == ("front", "angle of rockers, deg")
    assert np.array_equal(line.get_ydata(), np.degrees(run["wheels/front_right/rocker_angle"]))


@pytest.mark.parametrize("name", either(["story", "path", "contact", "slip", "forces", "rollers", "energy"], ["story"]))
@pytest.mark.parametrize("size", [{"rows": 1, "events": 0}, {"rows": 2, "events": 1}, {"rows": 30, "rollers": 64}])
def test_small_and_large_files_are_drawn_without_a_warning(name, size, recwarn):
    plots.VIEWS[name](synthetic_trajectory(**size)).canvas.draw()
    assert [str(warning.message) for warning in recwarn] == []


def test_a_motion_without_any_value_above_zero_is_drawn(recwarn):
    data = {path: np.zeros_like(array) if array.dtype == float and path != "time" else array
            for path, array in synthetic_data().items()}  # fmt: skip
    still = Trajectory(synthetic_attributes(), data)
    for name in ("story", "rollers", "energy"):
        plots.VIEWS[name](still).canvas.draw()
    plots.trackings([still, still]).canvas.draw()
    assert [str(warning.message) for warning in recwarn] == []


# --- several runs, and what cannot be shown -------------------------------------------------------


def test_several_runs_have_a_colour_each_and_their_wheels_a_line(kiwi):
    figure = plots.story({"first": machine(), "second": kiwi})
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["first", "second"]
    (axes,) = [axes for axes in figure.axes if axes.get_ylabel() == "normal force, N"]
    looks = [(line.get_color(), line.get_linestyle()) for line in axes.get_lines()]
    assert len(set(looks)) == 6 and len({colour for colour, _ in looks}) == 2
    assert [looks[i][1] for i in range(3)] == [looks[i][1] for i in range(3, 6)]


def test_runs_of_one_title_are_numbered():
    (legend,) = plots.energy([machine(), machine()]).legends
    assert [text.get_text() for text in legend.get_texts()] == ["rollers µ (1)", "rollers µ (2)"]
    assert plots.energy(machine(title="a $ b $\\c")).get_suptitle() == "a $ b $\\c"


@pytest.mark.parametrize(
    ("name", "trajectories", "reason"),
    [
        ("odometry", [synthetic_trajectory()], "no odometry"),
        ("bearings", [synthetic_trajectory()], "output.bearing_loads = true"),
        ("ripple", [synthetic_trajectory()], "no ripple to show: wheel 'wheel' turns past fewer"),
        ("drives", [undriven()], "no drives to show"),
        ("story", [synthetic_trajectory(rows=0)], "no rows"),
        ("trackings", [synthetic_trajectory()], "two files"),
        (
            "trackings",
            [synthetic_trajectory(), synthetic_trajectory(title="another")],
            "title, wheels or output",
        ),
    ],
)
def test_what_cannot_be_shown_is_said_in_a_line(name, trajectories, reason):
    with pytest.raises(plots.PlotError, match=reason) as error:
        plots.VIEWS[name](trajectories)
    assert "\n" not in str(error.value)


def test_a_wheel_that_does_not_turn_is_left_out_of_the_ripple():
    run = machine()
    run.data["wheels/left/spin_angle"] = np.zeros(41)
    assert list(lines(plots.ripple(run), "normal force, N")) == ["back", "right"]
