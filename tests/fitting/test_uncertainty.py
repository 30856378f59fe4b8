"""What logs tell: intervals that cover, rows that follow each other, and what cannot be told."""

from dataclasses import replace

import numpy as np
import pytest
from logs import noisy, tour, write_log
from machines import machine, scene

from omnisim.fitting.fit_file import load_fit
from omnisim.fitting.fitting import what_is_known
from omnisim.fitting.ideal import IdealPaths
from omnisim.fitting.least_squares import Search
from omnisim.fitting.logs import Log
from omnisim.fitting.simulation import SimulatedPaths, prepared
from omnisim.fitting.uncertainty import correlation_time
from omnisim.scene.ideal_kinematics import wheel_rows

pytest.importorskip("scipy")
TRUE = np.array([1.05, 0.98, 1.01, 0.97, 1.08, 0.02, -0.03])  # radii, places, tracked point of omni4_squares
SIMULATED = np.array([1.03, 0.97, 24.0, 0.02])  # radii, places, viscosity, tracked point
REPEATS = 100
RING = [(0.2 * np.cos(a), 0.2 * np.sin(a)) for a in 2.0 * np.pi / 3.0 * np.arange(3)]
FIT = """
scene = "machine.toml"
[[logs]]
file = "one.csv"
[[logs]]
file = "other.csv"
[free."wheel_types.omni.radius"]
scale = true
start = 1
from = 0.8
to = 1.2
also = ["wheel_types.omni.roller_distance"]
[free]
"wheels.*.position" = { scale = true, start = 1, from = 0.8, to = 1.2 }
"friction.viscosity" = { start = 20, from = 4, to = 60 }
"tracked.x" = { start = 0, from = -0.1, to = 0.1 }
[weights]
"body/position" = 0.002
"body/yaw" = 0.004
"""


@pytest.fixture(scope="module")
def known():
    """The packaged fit with two logs of 40 s that ideal kinematics makes with TRUE values."""
    fit = load_fit("omni4_squares")
    time = np.arange(0.0, 40.01, 0.1)
    angles = tour(time, wheel_rows(fit.scene.config))
    weights = fit.config.weights.model_copy(update={"every": None})
    fit = replace(fit, config=fit.config.model_copy(update={"weights": weights}))
    logs = []
    for turned in (angles, angles[:, ::-1]):
        log = Log("made.csv", "fit", time, np.zeros((len(time), 2)), np.zeros(len(time)), turned)
        path = IdealPaths(replace(fit, logs=(log,))).path(TRUE, log)
        logs.append(replace(log, position=path.position, yaw=path.yaw))
    return replace(fit, logs=tuple(logs))


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Three omni wheels on a wet floor, and two logs of 6 s that they make with SIMULATED values."""
    folder = tmp_path_factory.mktemp("simulated")
    friction, time = {"law": "viscous", "viscosity": 20.0}, {"end": 1.0, "step": 5e-4, "output_interval": 0.05}
    data = machine("omni", RING, (90.0, 210.0, 330.0), [{"kind": "free"}] * 3, friction=friction, time=time)
    (folder / "machine.toml").write_text(scene(data).text)
    (folder / "fit.toml").write_text(FIT)
    time = np.arange(0.0, 6.01, 0.1)
    angles = 3.0 * tour(time, wheel_rows(scene(data).config))
    nowhere = np.zeros((len(time), 2)), np.zeros(len(time))
    for name, turned in (("one", angles), ("other", angles[:, ::-1])):
        write_log(folder / f"{name}.csv", ("w0", "w1", "w2"), time, *nowhere, turned)
    fit = load_fit(folder / "fit.toml")
    prepared(fit)
    paths = SimulatedPaths(fit, 1)(SIMULATED[None], [0, 1])[0]
    logs = (replace(log, position=path.position, yaw=path.yaw) for log, path in zip(fit.logs, paths, strict=True))
    return replace(fit, logs=tuple(logs))


def solved(fit, paths):
    search = Search(fit, paths, range(len(fit.parameters)), lambda trial: None)
    found = search.solve(fit.start)
    return found, what_is_known(fit, found, search.weights)


def covered(fit, paths, true):
    """In how many noisy repeats the interval of each parameter covers its true value; the first pose has noise too."""
    random = np.random.default_rng(5)
    found = np.zeros(len(true), int)
    for _ in range(REPEATS):
        repeat = replace(fit, logs=tuple(noisy(log, random) for log in fit.logs))
        _, told = solved(repeat, paths(repeat))
        found += (told.low <= true) & (told.high >= true)
    print(found)
    return found


def simulation(fit):
    return SimulatedPaths(fit, 1)


def test_logs_without_noise_give_back_what_made_them(known):
    found, _ = solved(known, IdealPaths(known))
    np.testing.assert_allclose(found.values, TRUE, atol=2e-8)  # 3e-10 measured


def test_simulated_logs_without_noise_give_back_the_machine_that_made_them(simulated):
    found, _ = solved(simulated, simulation(simulated))
    np.testing.assert_allclose(found.values, SIMULATED, rtol=2e-8)  # 1e-9 measured


def test_a_run_that_stops_early_is_told_with_its_log_and_how(simulated):
    paths = simulation(simulated)
    path, _ = paths(np.array([[1.0, 1.0, 60.0, 0.0]]), [0, 1])[0]  # too viscous for the step
    assert [told.split(":")[0] for told in paths.early] == ["one.csv", "other.csv"]
    assert "time.step = 0.0005 s" in paths.early[0]
    assert (path.position[-1] == path.position[-2]).all(), "it stays where it stopped"


@pytest.mark.long
def test_95_percent_intervals_cover_the_truth_in_90_to_99_percent_of_noisy_repeats(known):
    """Of 100, for each of seven parameters."""
    found = covered(known, IdealPaths, TRUE)
    assert (found >= 90).all() and (found <= 99).all()


@pytest.mark.long
def test_intervals_of_simulated_logs_cover_the_truth_in_90_to_99_percent_of_noisy_repeats(simulated):
    """Of 100, for each of four parameters, friction among them."""
    found = covered(simulated, simulation, SIMULATED)
    assert (found >= 90).all() and (found <= 99).all()


def test_white_noise_counts_every_row_and_a_running_mean_one_of_as_many():
    """Integrated autocorrelation time of a mean over k rows of white noise: k."""
    random = np.random.default_rng(0)
    noise = random.normal(size=(20000, 2))
    assert correlation_time([noise[:9000], noise[9000:]]) == pytest.approx(1.0, abs=0.1)  # 1.02 measured
    means = np.apply_along_axis(lambda column: np.convolve(column, np.ones(10) / 10, "valid"), 0, noise)
    assert correlation_time([means]) == pytest.approx(10.0, rel=0.15)


def test_what_no_log_depends_on_is_told_and_the_rest_is_as_it_was(known):
    """Friction does nothing to ideal kinematics."""
    fit = load_fit({
        **known.document.data,
        "free": {"friction.coefficient": {"start": 0.5, "from": 0.1, "to": 1.2}, **known.document.data["free"]},
        "logs": [{**entry, "file": str(load_fit_folder() / entry["file"])} for entry in known.document.data["logs"]],
    })  # fmt: skip
    repeat = replace(fit, logs=known.logs, config=known.config)
    found, told = solved(repeat, IdealPaths(repeat))
    assert "the logs cannot tell friction.coefficient: its interval is as wide as its range" in told.untold
    assert (told.low[0], told.high[0]) == (0.1, 1.2)
    np.testing.assert_allclose(found.values[1:], TRUE, atol=1e-6)
    assert np.isfinite(told.deviation).all() and (told.deviation[1:] < 1e-3).all()


def load_fit_folder():
    from omnisim.fitting.fit_file import packaged_fits

    return packaged_fits()["omni4_squares"].parent


def test_a_turn_by_itself_cannot_tell_radii_from_places(known):
    """Turning on the spot gives one number, the yaw, for a factor on all radii and one on all places: R / L."""
    free = {
        "wheel_types.a.radius": {
            "scale": True, "start": 1.0, "from": 0.8, "to": 1.25,
            "also": [f"wheel_types.{name}.{key}" for name in "abcd" for key in ("radius", "roller_distance")
                     if (name, key) != ("a", "radius")],
        },
        "wheels.*.position": {"scale": True, "start": 1.0, "from": 0.8, "to": 1.25},
    }  # fmt: skip
    fit = load_fit({
        **known.document.data, "free": free,
        "logs": [{**entry, "file": str(load_fit_folder() / entry["file"])} for entry in known.document.data["logs"]],
    })  # fmt: skip
    time = known.logs[0].time
    angles = -np.outer(3.0 * time, np.ones(4))
    log = replace(known.logs[0], position=np.zeros((len(time), 2)), angles=angles)
    fit = replace(fit, logs=(log,), config=known.config)
    log = replace(log, yaw=IdealPaths(fit).path(np.ones(2), log).yaw)
    repeat = replace(fit, logs=(noisy(log, np.random.default_rng(1)),))
    _, told = solved(repeat, IdealPaths(repeat))
    assert any("apart" in sentence or "hardly tell" in sentence for sentence in told.untold), told.untold
    assert abs(told.correlation[0, 1]) > 0.999
