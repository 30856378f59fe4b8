"""What a user of the command meets: output, messages, exit codes, files."""

import os
import re
import signal
import subprocess
import sys
import time
from io import StringIO
from pathlib import Path

import pytest
from commands import SCENE, command, settings
from helpers.stages import either

import omnisim
from omnisim_cli import screen
from omnisim_cli.main import cli

pytestmark = pytest.mark.usefixtures("folder")
ENTRY = "from omnisim_cli.main import main; main()"
SAYING_READY = """
import signal
from omnisim_cli import main, screen

def begin(progress, original=screen.Progress._begin):
    original(progress)
    print("ready", flush=True)

screen.Progress._begin = begin
signal.signal(signal.SIGINT, signal.SIG_DFL)  # a test that runs in the background may ignore it
main.main()
"""  # as the entry point does, but says when the kernels are ready
LONG = ("time.end=1e6", "time.output_interval=1.0")


def process(program, *arguments, **options):
    """The command in a process of its own, for signals and pipes."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True} | options
    return subprocess.Popen([sys.executable, "-c", program, *arguments], **pipes)


# --- run ------------------------------------------------------------------------------------------


def test_run_writes_stem_h5_here_and_sums_up_on_stdout(folder):
    result = command("run", SCENE)
    assert result.exit_code == 0, result.stderr
    assert os.listdir(folder) == ["testbench_psi0.h5"]
    for fact in ("Testbench, six rollers", "times real time", "2000, with 8", "15 exchanges",
                 "of the initial kinetic energy", "testbench_psi0.h5 (41 rows", "complete"):  # fmt: skip
        assert fact in result.stdout
    assert omnisim.open_trajectory("testbench_psi0.h5").complete


def test_run_with_overrides_writes_what_repeats_it(folder):
    arguments = settings("wheels.wheel.spin_rate=3", "solver.method=heun")
    assert command("run", SCENE, "-o", "slow.h5", *arguments).exit_code == 0
    (folder / "again.toml").write_text(omnisim.open_trajectory("slow.h5").attributes["scene"])
    assert command("run", "again.toml").exit_code == 0
    first, second = (omnisim.open_trajectory(name) for name in ("slow.h5", "again.h5"))
    assert first.attributes["method"] == "heun" and first["wheels/wheel/spin_rate"][0] == 3.0
    assert all((first[path] == second[path]).all() for path in first)


def test_a_packaged_scene_runs_by_name(folder):
    assert command("run", "six_rollers", *settings("time.end=0.1")).exit_code == 0
    assert os.listdir(folder) == ["six_rollers.h5"]


def test_quiet_prints_nothing_on_success_and_the_reason_on_an_early_stop():
    result = command("run", SCENE, "--quiet")
    assert (result.exit_code, result.output) == (0, "")
    result = command("run", SCENE, "--quiet", "--force", *settings("friction.slip_speed=1e-9"))
    assert (result.exit_code, result.stdout) == (1, "")
    assert "unstable at t = " in result.stderr


def test_a_step_picked_for_an_error_is_told_with_its_estimate():
    result = command("run", "six_rollers", *settings("solver.error=1e-6"))
    assert result.exit_code == 0, result.stderr
    assert re.search(r"^method +rk4, step 0\.0002 s", result.stdout, re.MULTILINE)
    assert re.search(r"^error +about \S+ estimated, 1e-06 wanted$", result.stdout, re.MULTILINE)
    a = omnisim.open_trajectory("six_rollers.h5").attributes
    assert (a["step"], a["error_target"]) == (0.0002, 1e-6) and 0.0 < a["error_estimate"] <= 1e-6
    assert f"about {a['error_estimate']:.1e} estimated, 1e-06 wanted" in command("info", "six_rollers.h5").stdout


def test_an_error_that_no_step_reaches_is_warned_of():
    beyond = settings("solver.error=1e-14", "time.end=0.2")
    result = command("run", "six_rollers", *beyond)
    assert result.exit_code == 0, result.stderr
    assert "Warning: no step tried brings the error below solver.error = 1e-14" in result.stderr
    assert command("run", "six_rollers", *beyond, "--force", "--quiet").stderr == ""


def test_a_run_whose_energies_do_not_balance_is_warned_of(folder):
    coarse = settings("friction.slip_speed=1.0", "time.step=0.05", "wheels.wheel.spin_rate=60")
    result = command("run", SCENE, *coarse)
    assert result.exit_code == 0, result.stderr
    assert "Warning: energy is unaccounted for" in result.stderr
    assert command("run", SCENE, *coarse, "--force", "--quiet").stderr == ""


def test_a_run_whose_energy_comes_from_nowhere_stops():
    """Of 1e300 kg forces are lost in rounding: the wheels roll on while the chassis stands."""
    result = command("run", "soccer_kit", *settings("chassis.mass=1e300", "time.end=0.1"))
    assert result.exit_code == 1
    assert "more than 5 % of the energy" in result.stderr and "soccer_kit.h5" in result.stderr


def test_energy_of_what_stands_is_not_missed():
    """Rounding of a machine that its motors cannot move, 1e-27 J, is no error of the motion."""
    result = command("run", "youbot", *settings("chassis.mass=1e300", "time.end=0.5"))
    assert result.exit_code == 0 and "energy" not in result.stderr


@pytest.mark.parametrize(
    ("overrides", "reason"),
    [
        (["friction.slip_speed=1e-9"], "unstable at t = "),
        (["wrench.times=[0, 1]", "wrench.force=[[0, 0, 0], [0, 0, 20]]"], "wheel 'wheel' leaves the floor at t = 0."),
    ],
)
def test_a_run_that_stops_early_says_why_and_writes_what_it_has(overrides, reason):
    result = command("run", SCENE, "-o", "part.h5", *settings(*overrides))
    assert result.exit_code == 1
    said = result.stderr.splitlines()[-1]
    assert said.startswith("Error: ") and reason in said and "part.h5" in said
    part = omnisim.open_trajectory("part.h5")
    assert not part.complete and part["events/kind"][-1] == "stop" and len(part.time) >= 1


def test_an_existing_file_is_replaced_with_force_only(folder):
    (folder / "out.h5").write_text("precious")
    result = command("run", SCENE, "-o", "out.h5")
    assert result.exit_code == 2 and "out.h5" in result.stderr and "--force" in result.stderr
    assert (folder / "out.h5").read_text() == "precious"
    assert command("run", SCENE, "-o", "out.h5", "--force").exit_code == 0
    assert omnisim.open_trajectory("out.h5").complete


def test_a_scene_is_not_overwritten_by_its_own_result(folder):
    text = Path(SCENE).read_text()
    (folder / "scene.toml").write_text(text)
    result = command("run", "scene.toml", "-o", "scene.toml", "--force")
    assert result.exit_code == 2 and "the input itself" in result.stderr
    assert (folder / "scene.toml").read_text() == text


@pytest.mark.parametrize("broken", ["write", "link"])
def test_a_file_that_cannot_be_written_is_one_line(broken, monkeypatch, folder):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("omnisim.results.hdf5.write_whole" if broken == "write" else "omnisim.base.files.os.link", full)
    result = command("run", SCENE)
    assert result.exit_code == 1
    last = result.stderr.splitlines()[-1]
    assert last.startswith("Error: testbench_psi0.h5: cannot be written: No space left on device")
    assert os.listdir(folder) == []


# --- bad input ------------------------------------------------------------------------------------

BAD = [
    (["run", "nowhere.toml"], ["nowhere.toml", "no such file"]),
    (["run", "six_roler"], ["six_roler", "did you mean 'six_rollers'"]),
    (["run", "broken.toml"], ["broken.toml:3", "not valid TOML"]),
    (["run", "wrong.toml"], ["wrong.toml:10", "time.step", "-0.001", "> 0"]),
    (["run", "stepless.toml"], ["stepless.toml:8", "time.step", "missing", "or the scene has a solver.error"]),
    (["bench", "stepless.toml", "--set", "solver.error=1e-6"], ["time.step", "missing", "or must be given"]),
    (["run", "folder"], ["folder", "directory"]),
    (["run", SCENE, "--set", "time.stp=1"], ["--set time.stp=1", "did you mean 'step'"]),
    (["run", SCENE, "--set", "wheels.weel.spin_rate=1"], ["no wheel is called 'weel'", "did you mean 'wheel'"]),
    (["run", SCENE, "--set", "time.step"], ["--set time.step", "KEY=VALUE"]),
    (["run", SCENE, "--set", "time.step=3e-3"], ["time.output_interval", "must be an integer"]),
    (["run", SCENE, "-o", "nowhere/out.h5"], ["nowhere/out.h5", "no folder"]),
    (["run", SCENE, "-o", "folder"], ["folder", "the name of a file"]),
    (["run", SCENE, "-o", "nowhere/"], ["nowhere/", "the name of a file"]),
    (["run", SCENE, "-o", "folder", "--force"], ["folder", "the name of a file"]),
    (["run", SCENE, "-o", ""], ["the name of a file"]),
    (["run", SCENE, "-o", "x" * 300], ["cannot write there"]),
    (["run", SCENE, "--forse"], ["--forse", "--force"]),
    (["run"], ["SCENE"]),
    (["compare", "implicit"], ["'B'"]),
    (["compare", "implict", "explicit"], ["'implict'", "'implicit'"]),
    (["compare", "implicit", "explicit", "six"], ["six", "Packaged scenes"]),
    (["bench", "six_roler"], ["six_roler", "did you mean 'six_rollers'"]),
    (["bench", SCENE, "--method", "rk5"], ["'rk5'", "'rk4'"]),
    (["bench", SCENE, "--law", "dry"], ["'dry'", "'coulomb'"]),
    (["bench", SCENE, "--law", "viscous"], ["friction.viscosity", "missing"]),
    (["bench", SCENE, "--step", "0"], ["--step", "x>0"]),
    (["bench", SCENE, "--step", "nan"], ["step of nan s", "must divide the output interval, 0.05 s"]),
    (
        ["bench", SCENE, "--step", "3e-3", "-o", "report"],
        ["step of 0.003 s", "must divide the output interval, 0.05 s"],
    ),
    (["bench", SCENE, "--repeats", "0"], ["--repeats", "x>=1"]),
    (["bench", SCENE, "-o", "broken.toml"], ["broken.toml", "the name of a folder"]),
    (["bench", SCENE, "-o", "nowhere/report"], ["there is no folder nowhere"]),
    (["info", "nowhere.h5"], ["nowhere.h5"]),
    (["info", "damaged.h5"], ["damaged.h5", "truncated or damaged"]),
    (["rum", SCENE], ["'rum'", "'run'"]),
]


@pytest.fixture
def traps(folder):
    """Files and folders that BAD trips over."""
    text = Path(SCENE).read_text()
    (folder / "broken.toml").write_text(text.replace("[scene]", "[scene", 1).replace("\n\n", "\n", 1))
    (folder / "wrong.toml").write_text(text.replace("step = 0.001", "step = -0.001"))
    (folder / "stepless.toml").write_text(text.replace("step = 0.001", ""))
    (folder / "damaged.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(500))
    (folder / "folder").mkdir()
    return sorted(os.listdir(folder))


@pytest.mark.parametrize(("arguments", "parts"), BAD, ids=lambda value: " ".join(value)[:40])
def test_bad_input_is_explained_and_touches_nothing(arguments, parts, traps):
    result = command(*arguments)
    assert result.exit_code == 2
    assert result.stdout == "" and "Traceback" not in result.stderr
    message = result.stderr[result.stderr.index("Error: ") :]
    for part in parts:
        assert part in message
    assert message.count("Error: ") == 1
    assert sorted(os.listdir()) == traps


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_is_found_before_the_run(folder):
    (folder / "locked").mkdir(mode=0o500)
    result = command("run", SCENE, "-o", "locked/out.h5")
    assert result.exit_code == 2 and "Permission denied" in result.stderr


def test_a_bug_is_one_line(monkeypatch):
    monkeypatch.setattr("omnisim.run.simulation.simulate", lambda *_: 1 / 0)
    result = command("run", SCENE)
    assert result.exit_code == 1
    assert result.stderr.startswith("Error: a bug in omnisim: ZeroDivisionError")
    assert result.stderr.count("\n") == 1


# --- signals and pipes ----------------------------------------------------------------------------


@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
@pytest.mark.parametrize("number", either([signal.SIGINT, signal.SIGTERM], [signal.SIGINT]))
def test_ctrl_c_finishes_the_step_and_writes_the_file(number, folder):
    child = process(SAYING_READY, "run", SCENE, "-o", "part.h5", *settings(*LONG))
    assert child.stdout.readline() == "ready\n"
    time.sleep(0.3)
    child.send_signal(number)
    stdout, stderr = child.communicate(timeout=60)
    assert child.returncode == 1
    assert "interrupted by the user at t = " in stderr and "part.h5 (" in stdout
    part = omnisim.open_trajectory("part.h5")
    assert part.attributes["status"].startswith("interrupted") and part["events/kind"][-1] == "stop"
    assert 1.0 < part.time[-1] <= part.attributes["stop_time"] < 1e6
    assert os.listdir(folder) == ["part.h5"]


@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
def test_ctrl_c_ends_the_search_for_a_step():
    child = process(SAYING_READY, "run", SCENE, "-o", "part.h5", *settings("time.end=1000", "solver.error=1e-13"))
    assert child.stdout.readline() == "ready\n"
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    stdout, stderr = child.communicate(timeout=60)
    assert child.returncode == 1
    assert "interrupted by the user" in stderr and "1e-13 wanted" in stdout
    assert omnisim.open_trajectory("part.h5").attributes["error_target"] == 1e-13


@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
def test_ctrl_c_ends_a_bench_with_the_rounds_that_are_complete():
    arguments = (*settings("time.end=0.2"), "--method", "rk4", "--step", "1e-3", "--repeats", "1000000")
    child = process(SAYING_READY, "bench", "six_rollers", *arguments)
    assert child.stdout.readline() == "ready\n"
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    stdout, stderr = child.communicate(timeout=60)
    assert child.returncode == 1
    assert re.search(r"interrupted after \d+ of 1000000 repeats", stderr) and "Fastest with errors" in stdout


@pytest.mark.skipif(os.name != "posix", reason="sends POSIX signals")
def test_ctrl_c_during_compilation_ends_at_once(folder):
    child = process(SAYING_READY, "run", SCENE, env=os.environ | {"NUMBA_CACHE_DIR": str(folder / "cold")})
    assert child.stderr.readline().startswith("compiling kernels for the reduced formulation")
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    stdout, stderr = child.communicate(timeout=10)
    assert (child.returncode, stdout, stderr) == (1, "", "Error: interrupted; nothing was written\n")
    assert not (folder / "testbench_psi0.h5").exists()


@pytest.mark.skipif(os.name != "posix", reason="a shell with pipes")
def test_a_reader_that_leaves_early_is_no_error():
    for arguments in (["run", SCENE, "-o", "out.h5"], ["info", "out.h5"]):
        child = process(ENTRY, *arguments)
        child.stdout.close()
        assert re.sub("compiling kernels for.*\n", "", child.stderr.read()) == ""
        child.wait()
    assert omnisim.open_trajectory("out.h5").complete


# --- warmup, help ---------------------------------------------------------------------------------


def test_warmup_compiles_and_says_where(folder):
    result = command("warmup", SCENE)
    assert result.exit_code == 0, result.stderr
    assert "the reduced formulation with smooth friction and explicit steps: ready" in result.stderr
    assert re.match(r"kernels ready after \S+ s, in \S+", result.stdout)
    assert os.listdir(folder) == []


@pytest.mark.parametrize("name", list(cli.commands))
def test_help_has_an_example(name):
    result = command(name, "--help")
    assert result.exit_code == 0
    assert f"omnisim {name} " in result.stdout.partition("\n")[2]


def test_help_and_version_do_not_wait_for_numpy():
    code = "import sys; from omnisim_cli.main import cli; cli(sys.argv[1:], standalone_mode=False); "
    code += "sys.exit('numpy' in sys.modules or 'pydantic' in sys.modules)"
    for argument in ("--help", "--version"):
        done = subprocess.run([sys.executable, "-c", code, argument], capture_output=True, text=True, check=False)
        assert done.returncode == 0 and done.stdout.startswith(("Usage", "omnisim 0"))


def test_nothing_is_printed_once_the_command_has_ended(monkeypatch):
    """As colorama would at the end of the process: it resets the colours of the stream that it found."""
    stream = StringIO()
    monkeypatch.setattr("sys.stdout", stream)
    with screen.shown():
        kept = sys.stdout
        kept.write("a result")
    kept.write("\x1b[0m")
    assert stream.getvalue() == "a result"
