"""Machines fitted to logs that are simulated: what made them comes back, within what the fit says of itself."""
# ruff: noqa: E501  (tables of texts)

import json

import numpy as np
import pytest
from logs import POSITION_NOISE, YAW_NOISE, write_log

import omnisim
from omnisim.fitting.fit_file import load_fit
from omnisim.fitting.simulation import SimulatedPaths, prepared

pytest.importorskip("scipy")
WHEELS = ("front_right", "front_left", "rear")
TRUE = {"wheel_types.a.radius": 1.04, "wheels.*.position": 0.95, "friction.coefficient": 0.1, "tracked.x": 0.03}
FIT = """
scene = "omni3"
[[logs]]
file = "first.csv"
[[logs]]
file = "second.csv"
[[logs]]
file = "third.csv"
use = "test"
[free]
"wheel_types.a.radius" = { scale = true, start = 1.0, from = 0.8, to = 1.2, also = ["wheel_types.a.roller_distance"] }
"wheels.*.position" = { scale = true, start = 1.0, from = 0.8, to = 1.2 }
"friction.coefficient" = { start = 0.3, from = 0.02, to = 0.8 }
"tracked.x" = { start = 0.0, from = -0.1, to = 0.1 }
[weights]
"body/position" = 0.002
"body/yaw" = 0.004
every = 0.05
"""
# Accelerations that let wheels slip, so that the logs tell friction
TWISTS = {
    "first": [[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.6, 0.0, 0.0], [-0.6, 0.3, 0.0], [-0.6, 0.3, 0.0], [0.0, 0.0, 2.0]],
    "second": [[0.0, 0.0, 0.0], [0.0, 0.6, 1.0], [0.0, 0.6, 1.0], [0.5, -0.5, -1.0], [0.5, -0.5, -1.0], [0.0, 0.0, 0.0]],
    "third": [[0.0, 0.0, 0.0], [0.4, 0.4, 0.0], [0.4, 0.4, 0.0], [0.4, -0.4, 1.0], [0.4, -0.4, 1.0], [0.0, 0.0, 0.0]],
}  # fmt: skip
TIMES = [0.0, 0.4, 1.5, 2.3, 3.0, 3.4]


@pytest.fixture(scope="module")
def runs():
    """What the machine that is looked for does: time, position, yaw and angles of each log."""
    base = omnisim.load("omni3").config
    radius = TRUE["wheel_types.a.radius"]
    truth = {
        "time.end": 4.0, "time.step": 0.01, "time.output_interval": 0.05, "friction.coefficient": TRUE["friction.coefficient"],
        "wheel_types.a.radius": radius * base.wheel_types["a"].radius,
        "wheel_types.a.roller_distance": radius * base.wheel_types["a"].roller_distance,
    } | {
        f"wheels.{wheel.name}.position": [TRUE["wheels.*.position"] * place for place in wheel.position]
        for wheel in base.wheels
    }  # fmt: skip
    found = {}
    for name, twist in TWISTS.items():
        run = omnisim.simulate(omnisim.load("omni3", truth | {"command": {"times": TIMES, "twist": twist}}))
        assert run.complete
        yaw = run["body/yaw"]
        point = TRUE["tracked.x"] * np.column_stack([np.cos(yaw), np.sin(yaw)])
        angles = np.column_stack([run[f"wheels/{wheel}/spin_angle"] for wheel in WHEELS])
        found[name] = run.time, run["body/position"][:, :2] + point, yaw, angles
    return found


def folder(tmp_path, runs, noise=0.0, seed=0, fit=FIT):
    """A folder with these runs as logs, with so many times the usual noise on every pose; its fit file."""
    random = np.random.default_rng(seed)
    for name, (time, position, yaw, angles) in runs.items():
        moved = position + noise * random.normal(0.0, POSITION_NOISE, position.shape)
        turned = yaw + noise * random.normal(0.0, YAW_NOISE, yaw.shape)
        write_log(tmp_path / f"{name}.csv", WHEELS, time, moved, turned, angles)
    (tmp_path / "fit.toml").write_text(fit)
    return tmp_path / "fit.toml"


@pytest.fixture(scope="module")
def found(tmp_path_factory, runs):
    """What a fit makes of them with noise."""
    return omnisim.fit(folder(tmp_path_factory.mktemp("noisy"), runs, noise=1.0), workers=2)


@pytest.mark.long
def test_logs_without_noise_give_back_the_machine_that_made_them(tmp_path, runs):
    """Up to what cubics through angles every 0.05 s make of the corners of its motion."""
    found = omnisim.fit(folder(tmp_path, runs), workers=1)
    assert found.status == "complete"
    for key, value in TRUE.items():
        assert found.estimates[key].value == pytest.approx(value, abs=0.01), key
    for entry in found.logs:
        assert entry.errors()["after"].rms_position < 0.1 * entry.errors()["ideal"].rms_position
        assert entry.errors()["after"].end_position < 0.005


@pytest.mark.long
def test_a_fit_of_noisy_logs_tells_the_truth_within_its_intervals(found):
    """With four estimates and one repeat: within three deviations. The test log, which has no part in it, gains too."""
    for key, value in TRUE.items():
        one = found.estimates[key]
        assert abs(one.value - value) < 3.0 * one.deviation, (key, one)
        assert one.low < one.value < one.high
    test = found.logs[2].errors()
    assert test["after"].end_position < 0.25 * test["before"].end_position
    assert test["after"].end_position < test["ideal"].end_position  # the wheels slip


@pytest.mark.long
def test_the_number_of_workers_changes_no_bit(tmp_path, runs):
    fit = folder(tmp_path, runs, noise=1.0)
    one, two = (omnisim.fit(fit, workers=workers) for workers in (1, 2))
    assert one.numbers() == two.numbers()


def test_a_run_starts_at_rest_in_the_first_pose_of_its_log_and_follows_its_angles(tmp_path, runs):
    fit = load_fit(folder(tmp_path, runs))
    prepared(fit)
    values = fit.start.copy()
    values[3] = 0.03
    log = fit.logs[1]
    path = SimulatedPaths(fit, 1)(values[None], [1])[0][0]
    np.testing.assert_allclose(path.position[0], log.position[0], atol=1e-15)
    assert path.yaw[0] == pytest.approx(log.yaw[0], abs=1e-15)


@pytest.mark.long
def test_a_search_that_is_stopped_keeps_the_best_so_far(tmp_path, runs):
    trials = []
    found = omnisim.fit(
        folder(tmp_path, runs), workers=1, progress=lambda trial: trials.append(trial) or len(trials) > 1
    )
    assert found.solution.interrupted and found.status == "interrupted; the best so far"
    assert len(trials) == 2 and found.solution.trials == 2
    json.dumps(found.numbers(), allow_nan=False)


@pytest.mark.long
def test_the_folder_holds_a_scene_that_runs_and_the_numbers(tmp_path, found):
    found.save(tmp_path / "out")
    scene = omnisim.load(tmp_path / "out/fitted.toml")
    value = found.estimates["wheels.*.position"].value
    assert scene.config.wheels[2].position[0] == pytest.approx(-0.195 * value, rel=1e-12)
    assert scene.config.friction.coefficient == found.estimates["friction.coefficient"].value
    numbers = json.loads((tmp_path / "out/fit.json").read_text())
    assert set(numbers["estimates"]["tracked.x"]) == {"value", "deviation", "low", "high"}
    assert np.array(numbers["correlation"]).shape == (4, 4)
    for entry, use in zip(numbers["logs"], ("fit", "fit", "test"), strict=True):
        assert entry["use"] == use
        assert all(
            set(entry[part]) == {"end_position", "end_yaw", "rms_position"} for part in ("before", "after", "ideal")
        )
    with pytest.raises(FileExistsError):
        found.save(tmp_path / "out")
