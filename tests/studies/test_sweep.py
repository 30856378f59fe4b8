"""Many runs: the same numbers whatever runs them, nothing finished is lost, and files that other readers open."""

import json
import os
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest
from studied import DRAWN, GRID, MEASURE, SCENE, same

import omnisim
from omnisim.studies import journal
from omnisim.studies.measures import Reading
from omnisim.studies.result import MISSING, open_study
from omnisim.studies.study import StudyError, load_study
from omnisim.studies.sweep import fingerprint, journal_of, repeat, sweep
from omnisim.studies.task import Task


def mark_of(source):
    study = load_study(source)
    return fingerprint(study.document.text, study.scene.text)


@pytest.fixture(scope="module")
def grid():
    return sweep(GRID, workers=1)


def test_measures_are_those_of_the_runs_themselves(grid):
    """Of each run of the grid, against its whole trajectory: equal to the last bit or two."""
    for i, friction in enumerate(GRID["vary"]["friction.coefficient"]):
        for j, mass in enumerate(GRID["vary"]["chassis.mass"]):
            run = omnisim.simulate(
                omnisim.load("kiwi", {**SCENE["set"], "friction.coefficient": friction, "chassis.mass": mass})
            )
            wheels = run.wheels
            time = run.time
            expected = {
                "far": np.linalg.norm(run["body/position"][-1]),
                "slip": max(run[f"interval_max/wheels/{w}/slip_velocity"].max() for w in wheels),
                "least_load": min(run[f"interval_min/wheels/{w}/normal_force"].min() for w in wheels),
                "load": np.sqrt(trapezoid(run["wheels/left/normal_force"] ** 2, time) / time[-1]),
                "work": run["energy/drive_work"][5],
                "drift": np.linalg.norm(run["odometry/position_error"][-1]),
                "impulse": sum(trapezoid(run[f"wheels/{w}/drive_torque"], time) for w in wheels),
                "swing": np.ptp(run["body/yaw_rate"]),
            }
            for name, value in expected.items():
                assert grid[name][i, j] == pytest.approx(value, rel=1e-14), name
            assert grid["status"][i, j] == "complete"
    assert np.ptp(grid["slip"]) > 0.0


def trapezoid(values, time):
    return np.sum(0.5 * (values[1:] + values[:-1]) * np.diff(time))


def test_impossible_runs_are_rows_with_their_reason():
    found = sweep(DRAWN, workers=1)
    below = found["friction.coefficient"] < 0.0
    assert 0 < below.sum() < 10
    assert all(status.startswith("impossible: friction.coefficient = -") for status in found["status"][below])
    assert np.isnan(found["far"][below]).all() and np.isfinite(found["far"][~below]).all()
    assert (found["status"][~below] == "complete").all()


def test_a_run_that_stops_early_is_a_row_without_numbers():
    """A law that is too stiff for the step; whole tables of the scene vary."""
    laws = [{"law": "coulomb", "coefficient": 0.5}, {"law": "regularized", "coefficient": 0.5, "slip_speed": 1e-5}]
    found = sweep(SCENE | {"vary": {"friction": laws}, "measure": {"far": MEASURE["far"]}}, workers=1)
    assert found["status"][0] == "complete"
    assert found["status"][1].startswith("unstable at t = 0."), found["status"][1]
    assert np.isnan(found["far"]).tolist() == [False, True]
    assert found["stop_time"][0] == 0.1 > found["stop_time"][1] > 0.0
    assert "law = 'regularized'" in found["friction"][1]


def test_two_strict_readers_open_the_file(tmp_path, grid):
    """xarray by both of its engines: dimensions, coordinates, masked numbers, units."""
    xarray = pytest.importorskip("xarray")
    sweep(DRAWN, tmp_path / "drawn.h5", workers=1)
    grid.save(tmp_path / "grid.h5")
    for engine in ("h5netcdf", "netcdf4"):
        pytest.importorskip(engine.replace("netcdf4", "netCDF4"))
        with xarray.open_dataset(tmp_path / "grid.h5", engine=engine) as data:
            assert dict(data.sizes) == {"friction.coefficient": 3, "chassis.mass": 2}
            np.testing.assert_array_equal(
                data["far"].sel({"friction.coefficient": 0.3, "chassis.mass": 5.0}), grid["far"][1, 1]
            )
            assert data["slip"].attrs["units"] == "m/s" and str(data["status"].values[0, 0]) == "complete"
        with xarray.open_dataset(tmp_path / "drawn.h5", engine=engine) as data:
            assert dict(data.sizes) == {"run": 40, "wheels": 3}
            assert {"friction.coefficient", "wheels.*.phase_deg"} <= set(data.coords)
            assert data["far"].isnull().sum() == (data["status"] != "complete").sum() > 0
    with h5py.File(tmp_path / "drawn.h5") as file:
        assert not any(np.isnan(file[name]).any() for name in file if file[name].dtype.kind == "f")
        assert (file["far"][...] == MISSING).any()
    same(open_study(tmp_path / "grid.h5"), grid)
    assert open_study(tmp_path / "grid.h5").to_xarray().equals(grid.to_xarray())


def test_a_stopped_study_goes_on_to_the_same_file(tmp_path):
    path = tmp_path / "study.h5"
    stopped = sweep(DRAWN, path, workers=1, progress=lambda done: done.ended >= 7)
    assert 7 <= stopped.attributes["finished"] < 40 and not stopped.complete
    assert (stopped["status"] == "not run").sum() == 40 - stopped.attributes["finished"]
    with pytest.raises(FileExistsError):
        sweep(DRAWN, path, workers=1)
    with pytest.raises(StudyError, match=r"study\.h5: of another study"):
        sweep(GRID, path, workers=1, resume=True)
    seen = []
    whole = sweep(DRAWN, path, workers=1, resume=True, progress=seen.append)
    assert seen[0].ended == stopped.attributes["finished"] and whole.complete
    assert not journal_of(path).exists()
    same(whole, sweep(DRAWN, workers=1))
    same(open_study(path), whole)


def test_resume_leaves_a_finished_study_alone_and_refuses_other_files(tmp_path):
    path = tmp_path / "study.h5"
    whole = sweep(DRAWN, path, workers=1)
    seen = []
    same(sweep(DRAWN, path, workers=1, resume=True, progress=seen.append), whole)
    assert [done.ended for done in seen] == [40]
    before = path.read_bytes()
    with pytest.raises(StudyError, match="of another study"):
        sweep(GRID, path, resume=True)
    omnisim.simulate(omnisim.load("kiwi", SCENE["set"])).save(tmp_path / "run.h5")
    with pytest.raises(StudyError, match="no study of omnisim"):
        sweep(GRID, tmp_path / "run.h5", resume=True)
    assert path.read_bytes() == before


def test_the_file_of_a_stopped_study_is_enough_to_go_on(tmp_path):
    path = tmp_path / "study.h5"
    stopped = sweep(DRAWN, path, workers=1, progress=lambda done: done.ended >= 7)
    journal_of(path).unlink()
    seen = []
    same(sweep(DRAWN, path, workers=1, resume=True, progress=seen.append), sweep(DRAWN, workers=1))
    assert seen[0].ended == stopped.attributes["finished"]


def test_a_journal_that_is_damaged_in_the_middle_goes_on_from_there(tmp_path):
    path = tmp_path / "study.h5"
    sweep(DRAWN, path, workers=1, progress=lambda done: done.ended >= 20)
    path.unlink()
    kept = journal_of(path)
    lines = kept.read_bytes().splitlines(keepends=True)
    assert len(lines) > 3  # of which study, and three batches or more
    kept.write_bytes(b"".join([*lines[:2], lines[2].replace(b"complete", b"xomplete"), *lines[3:]]))
    same(sweep(DRAWN, path, workers=1, resume=True), sweep(DRAWN, workers=1))


def test_a_line_that_a_crash_has_cut_is_done_again(tmp_path):
    path = tmp_path / "study.h5"
    sweep(DRAWN, path, workers=1, progress=lambda done: done.ended >= 7)
    kept = journal_of(path)
    text = kept.read_bytes()
    known = len(journal.read(kept, mark_of(DRAWN)))
    kept.write_bytes(text[:-20])
    left = len(journal.read(kept, mark_of(DRAWN)))
    assert left < known
    same(sweep(DRAWN, path, workers=1, resume=True), sweep(DRAWN, workers=1))


def test_a_disk_that_is_full_of_trajectories_stops_the_study(tmp_path, monkeypatch):
    study = GRID | {"keep": {"trajectories": "all"}}

    def full(*_, **__):
        raise OSError(28, os.strerror(28), "run.h5")

    monkeypatch.setattr(omnisim.Trajectory, "save", full)
    with pytest.raises(OSError, match="No space left"):
        sweep(study, tmp_path / "study.h5", workers=1)
    assert journal_of(tmp_path / "study.h5").exists()


def test_ripple_is_the_rms_of_what_repeats_with_every_roller():
    """A sine of amplitude 2 at the exchange frequency of each wheel, on what changes slowly: 2 / sqrt(2) of each, to
    1e-4; whatever has another frequency does not count."""
    config = omnisim.load("kiwi").config
    wheels = [wheel.name for wheel in config.wheels]
    time = np.linspace(0.0, 4.0, 8001)
    found = {"time": time}
    for w, name in enumerate(wheels):
        angle = (5.0 + w) * time + 0.3 * time**2
        pitches = angle * config.type_of(config.wheels[w]).roller_count
        found[f"wheels/{name}/spin_angle"] = angle
        found[f"wheels/{name}/normal_force"] = 10.0 + time + 2.0 * np.sin(pitches + w) + 3.0 * np.sin(2.0 * pitches)
    paths = tuple(f"wheels/{name}/normal_force" for name in wheels)
    assert Reading("r", "N", paths, None, None, "ripple", False).of(found, config) == pytest.approx(2**0.5, rel=1e-4)


def test_what_nobody_has_thought_of_is_a_row_too(monkeypatch):
    task = Task(load_study(GRID))
    monkeypatch.setattr(type(task.study), "checked", lambda *_: 1 / 0)
    assert task([2])[0].status == "failed: a bug in omnisim: ZeroDivisionError: division by zero"


def test_sobol_without_scipy_is_told_before_anything_runs(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.stats", None)
    with pytest.raises(StudyError, match="needs SciPy: pip install"):
        sweep(DRAWN | {"design": {"kind": "sobol", "count": 4}})


@pytest.mark.long
def test_kill_9_of_the_command_loses_no_finished_run(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text("""
        schema = 1
        scene = "kiwi"
        set = { "time.end" = 2.0 }
        vary = { "friction.coefficient" = { uniform = [0.2, 0.6] } }
        design = { kind = "random", count = 400 }
        measure = { far = { dataset = "body/position", at = "end", component = "norm" } }
    """)
    path = tmp_path / "study.h5"
    command = [sys.executable, "-c", "from omnisim_cli.main import main; main()", "sweep", str(study), "-o", str(path)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    kept = journal_of(path)
    until = time.monotonic() + 300.0
    while (not kept.exists() or kept.read_bytes().count(b"\n") < 3) and time.monotonic() < until:
        time.sleep(0.02)
    process.kill()
    process.wait()
    found = journal.read(kept, mark_of(study))
    assert found and not path.exists()
    done = subprocess.run([*command, "--resume"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "400 of 400" in done.stdout
    whole = open_study(path)
    assert all(whole["far"][row.run] == row.measures[0] for row in found)
    np.testing.assert_array_equal(whole["far"], sweep(study)["far"])


@pytest.mark.long
def test_a_disk_that_is_full_keeps_what_has_finished(tmp_path):
    """The limit of the shell on the size of a file stands for it: the journal stops there, in the middle of a line."""
    study = tmp_path / "study.toml"
    study.write_text("""
        schema = 1
        scene = "kiwi"
        set = { "time.end" = 0.2 }
        vary = { "friction.coefficient" = { uniform = [0.2, 0.6] } }
        design = { kind = "random", count = 400 }
        measure = { far = { dataset = "body/position", at = "end", component = "norm" } }
    """)
    path = tmp_path / "study.h5"
    words = [sys.executable, "-c", "from omnisim_cli.main import main; main()", "sweep", str(study), "-o", str(path)]
    limited = ["bash", "-c", 'ulimit -f 8; trap "" XFSZ; exec "$@"', "bash", *words]
    done = subprocess.run(limited, capture_output=True, text=True)
    assert done.returncode == 1 and "Traceback" not in done.stderr
    assert "--resume goes on" in done.stderr and not path.exists()
    assert 0 < len(journal.read(journal_of(path), mark_of(study))) < 400
    done = subprocess.run([*words, "--resume"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(open_study(path)["far"], sweep(study)["far"])


def test_a_full_disk_stops_the_study_with_what_has_finished(tmp_path, monkeypatch):
    path = tmp_path / "study.h5"
    written = []

    def line(self, text, write=journal.Journal._line):
        written.append(text)
        if len(written) > 3:
            raise OSError(28, os.strerror(28), str(self.path))
        write(self, text)

    with monkeypatch.context() as full:
        full.setattr(journal.Journal, "_line", line)
        with pytest.raises(OSError, match="No space left"):
            sweep(DRAWN, path, workers=1)
    assert len(json.loads(written[1])) and not path.exists()
    same(sweep(DRAWN, path, workers=1, resume=True), sweep(DRAWN, workers=1))


def test_the_command_that_repeats_a_run_repeats_it(tmp_path, grid):
    task = Task(load_study(GRID))
    words = repeat(task, 3).split()
    assert words[:3] == ["omnisim", "run", "kiwi"]
    overrides = [word for word in words[3:] if word != "--set"]
    assert omnisim.simulate(omnisim.load("kiwi", overrides))["body/position"][-1, 0] ** 2 <= grid["far"][1, 1] ** 2
    assert "friction.coefficient=0.3" in overrides and "chassis.mass=5.0" in overrides


@pytest.mark.long
def test_kept_trajectories_are_whole_files(tmp_path):
    study = GRID | {"keep": {"trajectories": "all"}}
    found = sweep(study, tmp_path / "study.h5", workers=2)
    files = sorted((tmp_path / "study_runs").iterdir())
    assert len(files) == 6
    far = [np.linalg.norm(omnisim.open_trajectory(file)["body/position"][-1]) for file in files]
    np.testing.assert_allclose(far, found["far"].ravel(), rtol=1e-14)
    with pytest.raises(StudyError, match="takes an output file"):
        sweep(study)


def test_the_last_state_is_kept_where_it_is_asked_for(grid):
    found = sweep(GRID | {"keep": {"trajectories": "final"}}, workers=1)
    place = np.hypot(found["final.body.position.x"], found["final.body.position.y"])
    np.testing.assert_allclose(place, grid["far"], rtol=1e-14)
    assert "final.wheels.left.spin_rate" in found


WRONG = {
    "unknown dataset": ({"dataset": "wheels/*/slip_velocit", "reduce": "max"}, "near: wheels/*/slip_velocity"),
    "dataset of no wheel": ({"dataset": "wheels/lft/slip_velocity", "reduce": "max"}, "did you mean 'left'"),
    "dataset of other scenes": ({"dataset": "wheels/*/current", "reduce": "max"}, "no dataset of this scene"),
    "no component": ({"dataset": "body/position", "at": "end"}, "must be one of norm, x, y, z"),
    "component of a number": ({"dataset": "body/yaw", "at": "end", "component": "x"}, "has no directions"),
    "neither time nor reduction": ({"dataset": "body/yaw"}, "at, reduce"),
    "integral at a time": ({"dataset": "body/yaw", "at": "end", "reduce": "integral"}, "needs all times"),
    "several wheels": ({"dataset": "wheels/*/spin_rate", "at": "end"}, "must have a reduce"),
    "time between rows": ({"dataset": "body/yaw", "at": 0.015}, "a multiple of time.output_interval = 0.01"),
    "time after the end": ({"dataset": "body/yaw", "at": 7.0}, "up to time.end"),
    "time that is a word": ({"dataset": "body/yaw", "at": "start"}, '"end" or a time'),
    "unknown reduction": ({"dataset": "body/yaw", "reduce": "maxx"}, "did you mean 'max'"),
    "events": ({"dataset": "events/time", "reduce": "max"}, "no dataset of this scene"),
}


@pytest.mark.parametrize("which", WRONG)
def test_a_bad_measure_is_told_before_anything_runs(which):
    measure, told = WRONG[which]
    with pytest.raises(StudyError) as caught:
        sweep(GRID | {"measure": {"it": measure}})
    assert told in str(caught.value) and "measure.it" in str(caught.value) and "\n" not in str(caught.value)
