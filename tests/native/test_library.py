"""Machines as libraries of C: they move as `omnisim run` has them move, and no caller brings them down."""

import ctypes
import os
import re
import shutil
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from commands import command, contents, refused
from memory import resident
from native_machine import REFUSED, RUNNING, STOPPED, Library, Machine, columns, make
from scenes import reference_scene

import omnisim
from omnisim.native import object_code
from omnisim.native.building import SOURCES, native
from omnisim.native.library import prefix_of
from omnisim.native.memory import Memory
from omnisim.native.parameters import parameters_of

COASTING = ("initial.yaw_rate=6.0", "initial.velocity=[0.3, 0.2]", "wheels.wheel.spin_rate=-1.0", "time.end=2.5",
            "time.output_interval=0.05", "solver.method=radau5", "friction.law=coulomb", "time.step=5e-4")  # fmt: skip
SCENES = {
    "coulomb_wheel": lambda: omnisim.load("coulomb_wheel"),
    "kiwi": lambda: omnisim.load("kiwi"),
    "youbot": lambda: omnisim.load("youbot"),
    "motors": lambda: omnisim.load("platform24v", ["time.end=1.0"]),
    "coasting": lambda: reference_scene("testbench_psi30", *COASTING),  # implicit, comes to rest on two rollers
    "kiwi_ramp": lambda: omnisim.load("kiwi_ramp", ["time.end=0.2"]),  # free in space
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder and prefix of the library of a scene, made when a test asks for it first."""
    there = {}

    def ask(name, cpu="generic"):
        key = f"{name}_{cpu}"
        if key not in there:
            there[key] = make(SCENES[name](), tmp_path_factory.getbasetemp() / key, cpu)
        return there[key]

    return ask


@pytest.fixture
def opened(made):
    return lambda *which: Machine(Library(*made(*which)))


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_a_machine_moves_as_omnisim_run_has_it(opened, name):
    trajectory = omnisim.simulate(SCENES[name]())
    machine = opened(name)
    times = trajectory.time
    rows = machine.rows(times[1], len(times) - 1)
    expected = columns(trajectory, machine.library.names)
    assert rows.shape == expected.shape and machine.time() == pytest.approx(times[-1], rel=1e-15)
    error = np.abs(rows - expected) / np.maximum(np.abs(expected).max(axis=0), 1.0)
    worst = machine.library.names[np.argmax(error.max(axis=0))]
    assert error.max() < 1e-12, worst  # measured 1e-14 to 7e-14, in space 1.3e-13


@pytest.mark.long
@pytest.mark.parametrize("name", ["coulomb_wheel", "youbot"])
def test_code_for_this_processor_moves_bit_for_bit_as_omnisim_run(opened, name):
    trajectory = omnisim.simulate(SCENES[name]())
    machine = opened(name, "native")
    state = [i for i, known in enumerate(machine.library.names) if "spin" in known or known.startswith("body/yaw")]
    rows = machine.rows(trajectory.time[1], len(trajectory.time) - 1)
    assert np.array_equal(rows[:, state], columns(trajectory, machine.library.names)[:, state])


@pytest.mark.long
def test_processors_without_vectors_and_joined_products_have_code_of_their_own(monkeypatch, tmp_path):
    """Which a library holds beside the other, and alone here: as near to the run, and none of its instructions."""
    monkeypatch.setattr(object_code, "LEVELS", {})
    folder, prefix = make(SCENES["coulomb_wheel"](), tmp_path / "plain")
    library = Library(folder, prefix)
    trajectory = omnisim.simulate(SCENES["coulomb_wheel"]())
    rows = Machine(library).rows(trajectory.time[1], len(trajectory.time) - 1)
    expected = columns(trajectory, library.names)
    assert (np.abs(rows - expected) / np.maximum(np.abs(expected).max(axis=0), 1.0)).max() < 1e-12  # measured 2e-14
    code = subprocess.run(["objdump", "-d", folder / f"lib{prefix}.so"], capture_output=True, text=True, check=True)
    assert "mulsd" in code.stdout and not re.search("%[yz]mm|vfmadd|vmulsd", code.stdout)


@pytest.mark.long
def test_how_often_a_machine_is_looked_at_changes_nothing(opened):
    often, seldom = opened("coulomb_wheel"), opened("coulomb_wheel")
    often.rows(0.001, 500)
    assert seldom.step(0.5) == RUNNING
    assert np.array_equal(often.row(), seldom.row())


@pytest.mark.long
def test_inputs_act_as_those_of_a_loop(opened):
    machine, loop = opened("youbot"), omnisim.Loop("youbot")
    for i in range(60):
        if i % 3 == 0:
            rate = 3.0 * np.sin(0.3 * i)
            assert machine.give("wheels/front_left/rate", rate) == RUNNING
            loop.drive("front_left", rate)
        if i == 20:  # between two knots of the scene's command
            assert machine.command(0.2, 0.1, -0.5) == RUNNING
            loop.command(0.2, 0.1, -0.5)
        if i % 7 == 0:
            push = 4.0 * np.cos(i)
            assert machine.give("wrench/force.x", push) == RUNNING
            loop.wrench((push, 0.0, 0.0))
        assert machine.step(0.02) == RUNNING and loop.advance(0.02)
    names = [f"wheels/{wheel}/{what}" for wheel in loop.names for what in ("spin_rate", "normal_force", "drive_torque")]
    found = [machine.get(machine.library.find_output(name.encode())) for name in names]
    expected = np.array([loop.spin_rates, loop.normal_forces, loop.drive_torques]).T.ravel()
    assert np.abs(np.array(found) - expected).max() < 1e-11  # measured 1.3e-12, of 60 N


def moments(machine):
    """Where a saved state is hard to come back to: while it slips, right at an exchange, on two rollers."""
    names = machine.library.names
    slip = [i for i, name in enumerate(names) if "slip_velocity" in name]
    share = [i for i, name in enumerate(names) if "contact_share" in name]
    exchange = names.index("events/exchange")
    before = machine.row()
    while machine.step(machine.library.grid()) == RUNNING and machine.time() < 2.5:
        row = machine.row()
        if np.abs(row[slip]).max() > 1e-3:
            yield "slip"
        if row[exchange] > before[exchange]:
            yield "exchange"
        if row[share].min() < 1.0:
            yield "shared"
        before = row


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "moment"),
    [("coulomb_wheel", "slip"), ("youbot", "exchange"), ("coasting", "shared"), ("kiwi_ramp", "exchange")],
)
def test_a_state_that_is_restored_repeats_the_run_bit_for_bit(opened, name, moment):
    machine = opened(name)
    if name == "kiwi_ramp":
        machine.step(0.05)
    else:
        assert moment in moments(machine)
    kept, interval = machine.state(), 20 * machine.library.grid()
    once = machine.rows(interval, 30)
    assert len(once) == 31
    for other in (machine, opened(name)):
        other.step(7 * machine.library.grid())
        assert other.restore(kept) == RUNNING
        assert np.array_equal(other.rows(interval, 30), once)


@pytest.mark.long
def test_a_state_of_another_library_is_refused(opened):
    wheel, other = opened("coulomb_wheel"), opened("coasting")
    assert wheel.restore(other.state()) == REFUSED and wheel.said == "this is no state of a machine of this library"
    assert wheel.restore(ctypes.create_string_buffer(wheel.library.state_size())) == REFUSED
    assert wheel.step(0.001) == RUNNING and wheel.said == ""


@pytest.mark.long
def test_what_cannot_be_meant_is_refused_and_changes_nothing(opened):
    machine, untouched = opened("youbot"), opened("youbot")
    rate = machine.library.find_input(b"wheels/front_left/rate")
    for seconds in (-0.01, 0.0, 1.2e-4, float("nan"), float("inf"), 1e300):
        assert machine.step(seconds) == REFUSED
        assert "is no multiple of the scene's time.step, 0.0005 s" in machine.said
    assert machine.set(rate, float("nan")) == REFUSED
    assert machine.said == "wheels/front_left/rate must be a finite number, not nan"
    assert machine.set(-1, 1.0) == REFUSED and machine.said == "there is no input -1"
    assert machine.command(float("inf"), 0.0, 0.0) == REFUSED
    assert machine.said == "a command must be three finite numbers"
    assert machine.library.find_input(b"nothing") == -1 and np.isnan(machine.get(10_000))
    assert np.array_equal(machine.rows(0.01, 20), untouched.rows(0.01, 20))


@pytest.mark.long
def test_a_machine_that_is_stopped_says_so_as_a_loop_does(opened):
    machine, loop = opened("youbot"), omnisim.Loop("youbot")
    machine.give("wrench/force.z", 1000.0)
    loop.wrench((0.0, 0.0, 1000.0))
    assert machine.step(0.01) == STOPPED and not loop.advance(0.01)
    assert machine.said == loop.status and "leaves the floor" in loop.status
    assert machine.step(0.01) == STOPPED and machine.said == loop.status  # for good
    assert machine.reset() == RUNNING and machine.step(0.01) == RUNNING


PARAMETERS = {
    "friction.coefficient": 0.35,
    "wheels.front_left.drive.proportional": 0.8,
    "wheels.rear_right.drive.torque_limit": 1.1,
}


@pytest.mark.long
def test_parameters_are_those_of_the_scene(opened):
    machine = opened("youbot")
    untouched = machine.rows(0.01, 40)
    for name, value in PARAMETERS.items():
        number = machine.library.find_parameter(name.encode())
        assert machine.set_parameter(number, value) == RUNNING and machine.get_parameter(number) == value
        assert machine.time() == 0.0
    trajectory = omnisim.simulate(omnisim.load("youbot", [f"{name}={value}" for name, value in PARAMETERS.items()]))
    rows = machine.rows(0.01, 300)
    expected = columns(trajectory, machine.library.names)
    assert np.abs(rows - expected).max() < 1e-10 and not np.array_equal(rows[:41], untouched)
    kept = machine.state()
    assert machine.reset() == RUNNING and np.array_equal(machine.rows(0.01, 40), untouched)
    assert machine.restore(kept) == RUNNING and np.array_equal(machine.row(), rows[-1])


@pytest.mark.long
def test_a_parameter_out_of_its_range_is_refused(opened):
    machine = opened("youbot")
    number = machine.library.find_parameter(b"friction.coefficient")
    machine.step(0.01)
    for value in (-0.1, 7.0, float("nan")):
        assert machine.set_parameter(number, value) == REFUSED
        assert machine.said.startswith("friction.coefficient must be within 0.15 and 2.4, not")
    assert machine.set_parameter(-1, 1.0) == REFUSED and machine.said == "there is no parameter -1"
    assert machine.get_parameter(number) == 0.6 and machine.time() == 0.01


@pytest.mark.long
def test_machines_of_one_library_march_side_by_side_in_threads(opened):
    alone = opened("youbot").rows(0.01, 50)
    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda machine: machine.rows(0.01, 50), [opened("youbot") for _ in range(8)]))
    assert all(np.array_equal(rows, alone) for rows in found)


@pytest.mark.long
def test_ten_million_steps_and_a_thousand_machines_take_no_more_memory(opened):
    machine = opened("coulomb_wheel")
    assert machine.step(100.0) == RUNNING
    before = resident()
    for _ in range(100):
        machine.give("wrench/yaw_torque", 1e-9)
        assert machine.step(100.0) == RUNNING
    assert machine.time() == pytest.approx(10_100.0)
    for _ in range(1000):
        assert opened("coulomb_wheel").step(0.01) == RUNNING
    assert resident() - before < 2.0  # MB, measured 0.0


@pytest.mark.long
def test_the_library_needs_libm_and_libc_and_shows_what_its_header_declares(made):
    folder, prefix = made("youbot")
    library = str(folder / f"lib{prefix}.so")
    needed = subprocess.run(["ldd", library], capture_output=True, text=True, check=True).stdout
    found = {line.split()[0].partition(".")[0].rpartition("/")[2] for line in needed.splitlines()}
    assert found == {"linux-vdso", "libm", "libc", "ld-linux-x86-64"}
    shown = subprocess.run(["nm", "-D", "--defined-only", library], capture_output=True, text=True, check=True).stdout
    declared = re.findall(r"(\w+)\(", (folder / f"{prefix}.h").read_text())
    functions = {name for name in declared if name.startswith(f"{prefix}_")} - {f"{prefix}_grid_"}
    assert {line.split()[-1] for line in shown.splitlines()} == functions


@pytest.mark.long
def test_the_example_is_built_and_runs_as_another_user_without_an_environment(made):
    other = {"user": 65534, "group": 65534} if os.getuid() == 0 else {}
    with tempfile.TemporaryDirectory() as name:  # not below the user's own folder, where nobody else may look
        here = Path(name)
        here.chmod(0o755)
        shutil.copytree(made("youbot")[0], here / "youbot")
        for task in (("-S", "youbot", "-B", "build"), ("--build", "build")):
            subprocess.run(["cmake", *task], cwd=here, check=True, capture_output=True)
        said = subprocess.run(
            [here / "build/example"], capture_output=True, text=True, check=True, env={}, cwd="/", **other
        ).stdout
    yaw = [float(text) for text in re.findall(r"yaw = (\S+) rad", said)]
    assert len(yaw) == 15 and abs(yaw[-1] - 1.5) < 0.05 and "3.000 s marched in" in said


@pytest.mark.long
def test_header_and_layer_are_c_without_a_warning(made, tmp_path):
    folder, prefix = made("coulomb_wheel")
    (tmp_path / "caller.c").write_text(f'#include "{prefix}.h"\nint main(void) {{ return {prefix}_grid() > 1.0; }}\n')
    strict = ("-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror")
    subprocess.run(
        ["cc", *strict, f"-I{folder}", "caller.c", f"-L{folder}", f"-l{prefix}", "-o", "caller"],
        cwd=tmp_path,
        check=True,
    )


def test_parameters_are_what_a_machine_is_proportional_to():
    scene = omnisim.load("youbot")
    machine = native(scene)
    found = {one.name: one for one in parameters_of(scene, machine.marched[1], Memory(machine))}
    assert {name for name in found if "wheels" not in name} == {"friction.coefficient"}  # no mass, no length
    assert {name.rpartition(".")[2] for name in found if "wheels" in name} == {
        "proportional",
        "integral",
        "torque_limit",
    }
    assert (found["friction.coefficient"].least, found["friction.coefficient"].most) == (0.15, 2.4)


def test_what_a_machine_begins_with_is_the_same_every_time():
    """Nothing of this process is in it."""
    first, second = (Memory(native(omnisim.load("kiwi"))).start for _ in range(2))
    assert first == second


# --- the command ----------------------------------------------------------------------------------


def test_names_of_scenes_become_names_of_c():
    assert [prefix_of(name) for name in ("youbot", "my-robot 2", "2wd")] == ["youbot", "my_robot_2", "machine_2wd"]


def test_the_layer_is_part_of_the_package():
    assert {"machine.c", "machine.h", "example.cpp", "CMakeLists.txt"} <= {path.name for path in SOURCES.iterdir()}


def test_without_a_compiler_nothing_is_written(folder, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    refused(command("library", "youbot", "-o", "made"), "a C compiler is needed", "CC names no-such-compiler")
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", str(folder))
    refused(command("library", "youbot", "-o", "made"), "none of cc, gcc, clang is there")
    assert contents(folder) == {}


def test_a_scene_whose_step_is_picked_for_an_error_is_refused(folder):
    result = command("library", "youbot", "-o", "made", "--set", "solver.error=1e-6")
    refused(result, "youbot", "solver.error: native code marches with a step that is known")
    assert not list(folder.iterdir())


def test_files_that_are_there_stay(folder):
    (folder / "made").mkdir()
    (folder / "made/youbot.h").write_text("mine")
    refused(command("library", "youbot", "-o", "made"), "made/youbot.h: exists already; --force replaces it")
    assert contents(folder / "made") == {"youbot.h": b"mine"}
    refused(command("library", "youbot", "-o", "none/made"), "there is no folder none")
    refused(command("library", "youbot", "-o", "made/youbot.h"), "made/youbot.h: not a folder")
    refused(command("library", "youbott", "-o", "made"), "youbott")


def test_a_unit_without_a_compiler_a_known_step_or_its_suffix_is_not_written(folder, monkeypatch):
    result = command("fmu", "youbot", "-o", "made.fmu", "--set", "solver.error=1e-6")
    refused(result, "youbot", "solver.error: native code marches with a step that is known")
    monkeypatch.setenv("CC", "no-such-compiler")
    refused(command("fmu", "youbot", "-o", "made.fmu"), "a C compiler is needed", "CC names no-such-compiler")
    refused(
        command("fmu", "youbot", "-o", "made.zip"), "made.zip: the name of a Functional Mock-up Unit ends with .fmu"
    )
    assert contents(folder) == {}


@pytest.mark.long
def test_the_command_writes_the_folder(folder):
    result = command("library", "coulomb_wheel", "-o", "made")
    assert result.exit_code == 0, result.output
    assert set(contents(folder / "made")) == {
        "libcoulomb_wheel.so", "coulomb_wheel.h", "example.cpp", "CMakeLists.txt", "scene.toml"
    }  # fmt: skip
    assert "Eight rollers under Coulomb friction" in (folder / "made/coulomb_wheel.h").read_text()
    assert Machine(Library(folder / "made", "coulomb_wheel")).step(0.01) == RUNNING
