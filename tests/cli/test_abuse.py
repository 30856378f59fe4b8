"""What a user may do to the command by mistake: one clear line with the right exit code, and nothing is lost.

Runs are so short that the kernels pass as plain Python too.
"""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from commands import SCENE, TIPS, command, contents, refused, settings
from helpers.stages import either
from synthetic import synthetic_trajectory

import omnisim
from omnisim.results.trajectory import open_trajectory as read

pytestmark = [pytest.mark.short, pytest.mark.skipif(os.name != "posix", reason="limits, pipes and mounts of POSIX")]
SHORT = settings("time.end=0.02", "time.output_interval=0.01", "time.step=0.001")
ENTRY = "from omnisim_cli.main import main; main()"


# --- scenes ---------------------------------------------------------------------------------------

DEPTH = 20_000
TITLED = 'title = "%s"\n' + re.sub("(?m)^title = .*\n", "", Path(SCENE).read_text())
SCENES = {
    "a title with NUL": (TITLED % "a\\u0000b", ("scene.toml:1: title = 'a\\x00b'", "without control characters")),
    "a title that colours": (TITLED % "\\u001b[31m", ("scene.toml:1: title = '\\x1b[31m'", "control characters")),
    "dotted keys": ("\n" + "a." * DEPTH + "a = 1", ("scene.toml:2: keys are nested more than 20 deep",)),
    "a dotted header": ("[" + "a." * DEPTH + "a]", ("scene.toml:1: keys are nested more than 20 deep",)),
    "dots in an inline table": ("x = {" + "'a'." * DEPTH + "a = 1}", ("scene.toml:1: keys are nested",)),
    "a few too many dots": ("[b]\n" + "a." * 20 + "a = 1", ("scene.toml:2: keys are nested more than 20 deep",)),
    "lists": ("x = " + "[" * DEPTH + "]" * DEPTH, ("not valid TOML: nested too deeply",)),
    "a few lists too many": ("x = 1\ny = " + "[" * 60 + "]" * 60, ("scene.toml:2: keys are nested more than 20",)),
    "inline tables": ("x = " + "{a = " * 60 + "1" + "}" * 60, ("scene.toml:1: keys are nested more than 20 deep",)),
    "10 MB of comments": ("# a comment\n" * 850_000, ("scene.toml: cannot read this file", "more than 8.4 MB")),
    "keys without end": ("".join(f"k{i} = 1\n" for i in range(DEPTH)), ("scene.toml: and more of this",)),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_of_nonsense_is_a_clear_line_at_once(name, here):
    text, parts = SCENES[name]
    (here / "scene.toml").write_text(text)
    before, begun = sorted(os.listdir()), time.process_time()
    result = command("run", "scene.toml", "--set", "time.end=1")
    assert time.process_time() - begun < 4.0  # 0.1 to 1 s alone; minutes before, or a traceback
    assert result.exit_code == 2 and result.stderr.count("\n") <= 21
    assert all(part in result.stderr.splitlines()[-1] for part in parts), result.stderr
    assert sorted(os.listdir()) == before


def test_setting_a_key_takes_no_longer_for_comments(here):
    """0.3 s where tomlkit took 25 s."""
    text = (here / "scene.toml").read_text() + "# a comment of some forty characters ......\n" * 100_000
    (here / "scene.toml").write_text(text)
    begun = time.process_time()
    scene = omnisim.load("scene.toml", ["time.end=0.5", "friction.coefficient=0.1", "initial.yaw_rate=2"])
    assert time.process_time() - begun < 4.0
    assert scene.text.count("#") == text.count("#") and scene.config.time.end == 0.5
    assert omnisim.load("scene.toml").text == text


@pytest.mark.parametrize(
    ("value", "reason"),
    [
        ("a." * DEPTH + "a=1", "nested more than 20 deep"),
        ("time.end=" + "[" * 60 + "]" * 60, "nested more than 20 deep"),
        ("title=\udcff", "must be a string without control characters"),
        ("title=a\x1b[31m", "must be a string without control characters"),
        ("x" * 100_000, "must be KEY=VALUE"),
        ("time." + "x" * 100_000 + "=1", "unknown key"),
    ],
    ids=range(6),
)
def test_a_setting_of_nonsense_is_one_short_line(value, reason, here):
    line = refused(command("run", "scene.toml", "--set", value), "--set ", reason)
    assert len(line) < 500 and line.isprintable()


@pytest.mark.parametrize("source", ["/dev/zero", "/dev/full", "/dev/null", "pipe", ".", "huge"])
@pytest.mark.parametrize("name", ["run", "info"])
def test_what_is_no_file_is_no_scene(name, source, here, monkeypatch):
    monkeypatch.setattr("omnisim.base.files.SILENCE", 0.1)
    os.mkfifo("pipe")
    with open("huge", "wb") as file:
        file.truncate(10**11)
    reason = {"pipe": "nobody writes", ".": "Is a directory", "huge": "more than 8.4 MB"}.get(source, "not a regular")
    refused(command(name, source), f"{source}: cannot read this file: ", reason)


@pytest.mark.parametrize("source", ["/dev/zero", "pipe"])
@pytest.mark.parametrize("arguments", [("view",), ("plot", "-o", "x.png"), ("export", "x.csv")], ids=str)
def test_what_is_no_file_is_no_trajectory(arguments, source, here):
    os.mkfifo("pipe")
    name, *rest = arguments
    refused(command(name, source, *rest), f"{source}: not a regular file")


def test_a_scene_may_come_through_a_pipe(here):
    program = f"cat scene.toml | {sys.executable} -c '{ENTRY}' info /dev/stdin"
    done = subprocess.run(program, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Testbench" in done.stdout, done.stderr


# --- a machine that cannot begin ------------------------------------------------------------------


def test_a_machine_that_tips_before_its_first_row_is_told_by_commands_that_show_it(here):
    """A trajectory without rows: what it would be the largest of is not asked for."""
    (here / "tips.toml").write_text(TIPS)
    told = "the machine tips at t = 0 s: wheel 'back' leaves the floor"
    for wanted in ([], settings("solver.error=1e-6")):
        result = command("run", "tips.toml", *wanted, "-o", "tips.h5", "--force")
        assert result.exit_code == 1 and told in result.stderr.splitlines()[-1], result.output
    assert len(read("tips.h5").time) == 0
    assert command("info", "tips.h5").exit_code == 0
    for shown in (("plot", "tips.h5", "-o", "tips.png"), ("view", "tips.h5", "-o", "tips.html")):
        refused(command(*shown), "no rows")
    assert command("export", "tips.h5", "tips.csv").exit_code == 0


# --- names and suffixes ---------------------------------------------------------------------------


def test_run_writes_what_the_suffix_says(here):
    result = command("run", "scene.toml", "-o", "out.csv", *SHORT)
    assert result.exit_code == 0, result.stderr
    assert Path("out.csv").read_text().startswith("time,body/position.x") and Path("out.events.csv").exists()
    for suffix in ("", ".hdf5", ".H5"):
        assert command("run", "scene.toml", "-o", f"other{suffix}", *SHORT).exit_code == 0
        assert read(f"other{suffix}").complete


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("run", "scene.toml", "-o", "out.pdf"), ("out.pdf: ", ".h5, .csv, .parquet, .mat")),
        (("view", "made.h5", "-o", "out.pdf"), ("out.pdf: a page is .html", "omnisim plot")),
        (("view", "made.h5", "-o", "out"), ("out: a page is .html",)),
        (("run", "scene.toml", "-o", "there.csv"), ("there.events.csv: exists already; --force",)),
        (("run", "made.h5", "-o", "../nowhere/x.h5"), ("there is no folder",)),
        (("run", "scene.toml", "-o", "scene.toml"), ("the input itself",)),
    ],
    ids=str,
)
def test_a_suffix_that_says_nothing_is_refused_before_anything_runs(arguments, parts, here, monkeypatch):
    if arguments[1] == "made.h5":
        omnisim.simulate(omnisim.load("scene.toml", SHORT[1::2])).save("made.h5", overwrite=True)
    (here / "there.events.csv").write_text("precious")
    before = contents(here)
    monkeypatch.setattr("omnisim.run.simulation.simulate", None)
    refused(command(*arguments), *parts)
    assert contents(here) == before


def test_a_library_that_is_not_there_is_told_before_the_run(here, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("omnisim.run.simulation.simulate", None)
    refused(command("run", "scene.toml", "-o", "out.parquet"), "pyarrow", "pip install 'omnisim-engine[parquet]'")


def test_a_trajectory_runs_again(here):
    assert command("run", "scene.toml", "-o", "first.h5", *SHORT).exit_code == 0
    original = Path("first.h5").read_bytes()
    result = command("run", "first.h5")
    assert result.exit_code == 0 and "first_again.h5 (" in result.stdout
    first, again = read("first.h5"), read("first_again.h5")
    assert all((first[path] == again[path]).all() for path in first)
    assert again.attributes["scene"] == first.attributes["scene"]
    refused(command("run", "first.h5", "-o", "first.h5"), "first.h5: exists already; --force")
    assert Path("first.h5").read_bytes() == original
    assert command("run", "first.h5", "-o", "first.h5", "--force", "--set", "time.end=0.01").exit_code == 0
    assert read("first.h5").time[-1] == 0.01


@pytest.mark.parametrize(
    ("target", "reason"),
    [("folder", "a folder"), ("../" * 50 + "etc", "a folder"), ("/dev/full", "not a reg")],
)
def test_an_output_that_is_no_file_is_refused(target, reason, here):
    (here / "folder").mkdir()
    refused(command("run", "scene.toml", "-o", target, "--force"), reason)


def test_names_may_be_unicode_and_links_stay_links(here):
    Path("größe µ.h5").symlink_to("behind.h5")
    result = command("run", "scene.toml", "-o", "größe µ.h5", *SHORT)
    assert result.exit_code == 0 and "größe µ.h5 (" in result.stdout
    assert Path("größe µ.h5").is_symlink() and read("behind.h5").complete


# --- what reaches the terminal --------------------------------------------------------------------

RED = "\x1b[31m\x07\r\x9b\u202e"


@pytest.mark.parametrize(
    "arguments",
    [
        ("info", "evil.h5"), ("run", RED), ("run", RED + ".toml"), ("info", RED + ".h5"), ("view", RED),
        ("export", "evil.h5", RED), ("run", "scene.toml", "-o", RED + ".xyz"), ("plot", "evil.h5", "-o", RED),
        ("run", "scene.toml", "--set", f"time.{RED}=1"), ("run", "scene.toml", "--set", f"solver.method={RED}"),
        ("run", "scene.toml", "--set", f"wheels.{RED}.spin_rate=1"), (RED,), ("run", f"--{RED}"), ("run", "x", RED),
        ("wheel", "scene.toml", "--type", RED), ("run", "scene.toml", "-o", RED + "/x.h5"), ("run", "evil.toml"),
        ("run", "a\nError: b"), ("export", "evil.h5", "e\x1b.csv"), ("bench", "scene.toml", "-o", RED + "/x"),
    ],
    ids=range(20),
)  # fmt: skip
def test_control_characters_never_reach_the_terminal(arguments, here):
    evil = {name: f"{name} {RED}" for name in ("title", "model", "status", "method", "omnisim_version", "tracking")}
    synthetic_trajectory(**evil, stop_wheel=RED).save("evil.h5")
    (here / "evil.toml").write_text(Path(SCENE).read_text() + "\n['\x9b']\n'\\u001b[' = 1\n")
    result = command(*arguments)
    assert not re.search("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e]", result.output), repr(result.output)
    assert result.exit_code == (0 if arguments[-1] in ("evil.h5", "e\x1b.csv") else 2), result.output
    if arguments[-1] == "evil.h5":
        assert "title \\x07 \\x9b\\u202e" in result.stdout  # click has taken the colour away: this is no terminal
    if arguments[-1].startswith("a\n"):
        assert result.stderr.startswith("Error: a\\x0aError: b")


def test_on_a_terminal_too(here):
    synthetic_trajectory(title=RED).save("evil.h5")
    terminal, end = os.openpty()
    subprocess.run([sys.executable, "-c", ENTRY, "info", "evil.h5"], stdout=end, stderr=end, check=True)
    os.close(end)
    shown = os.read(terminal, 2000)
    os.close(terminal)
    assert shown.startswith(b"title     \\x1b[31m\\x07 \\x9b\\u202e\r\n") and b"\x1b" not in shown, shown


def test_what_a_terminal_has_no_letters_for_is_written_out(here):
    environment = os.environ | {"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [sys.executable, "-c", ENTRY, "info", "made.h5"], capture_output=True, env=environment, check=False
    )
    assert done.returncode == 0 and b"rollers \\xb5" in done.stdout and done.stderr == b""


# --- readers that leave ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("shell", "code", "message"),
    [
        ("info made.h5 | head -1", 0, ""),
        ("info made.h5 > /dev/full", 1, "Error: output: No space left on device\n"),
        ("info made.h5 >&-", 0, ""),
        ("info nowhere.h5 2>&-", 2, ""),
        ("export made.h5 out.csv > /dev/full", 1, "Error: output: No space left on device\n"),
    ],
)
def test_a_reader_that_is_not_there(shell, code, message, here):
    program = f"{sys.executable} -c '{ENTRY}' {shell}"
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (code, message)


@pytest.mark.parametrize("number", either([signal.SIGTERM, signal.SIGHUP, signal.SIGINT], [signal.SIGTERM]))
def test_a_command_that_is_ended_leaves_nothing_behind(number, here):
    waiting = "import omnisim.run.simulation, time, signal\nsignal.signal(signal.SIGINT, signal.SIG_DFL)\n"
    waiting += "signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"
    # many short sleeps: a signal that comes just before the call of one is handled after it
    waiting += "sleeps = lambda *_: (print('ready', flush=True), [time.sleep(0.01) for _ in range(6000)])\n"
    waiting += "omnisim.run.simulation.simulate = sleeps\n" + ENTRY
    before = contents(here)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    child = subprocess.Popen([sys.executable, "-c", waiting, "run", "scene.toml"], **pipes)
    assert child.stdout.readline() == "ready\n" and len(os.listdir()) == len(before) + 1
    child.send_signal(number)
    _, stderr = child.communicate(timeout=30)
    assert (child.returncode, stderr) == (1, "Error: interrupted; nothing was written\n")
    assert contents(here) == before and not re.search("Traceback", stderr)
