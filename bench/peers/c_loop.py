"""The march against plain C loops of the same equations, compiled when the benchmark runs: a bare wheel and a machine.

Marches of milliseconds run in turn, many rounds of all, and those rounds count that took least in all: a neighbour on
a shared core only slows down, by up to 1.7 times, and whoever issues more instructions more; the clock of the processor
changes slowly, and is the same for all of one round.

The targets are for plain `gcc -O3`. Two more builds are measured, for the compiler is not always right: packing the
state into vector registers makes each stage wait for scalars that were written just before.

A step of the bare wheel's loop is a unit of time, too, in which one machine can be compared with another: so many does
the wheel whose slip stops, `coulomb_wheel`, take for 2 s with errors below LIMIT.
"""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import omnisim
from bench.common import Claim, March, bare_wheel, interleaved, marching, quiet, ready, simulation, table
from bench.laws import FEW_ROWS, Setup, error_of
from bench.machine_scenes import slipping_platform
from omnisim.dynamics.state import YAW, Contents, X, Y, places_of
from omnisim.scene.scene import Scene, changed

ROUNDING = 1e-11  # of all states and rows, relative to the largest value of each state (at least 1); C sums plainly
AGREEMENT = 1e-5  # of the error of a step: an exchange is located by steps of C's own, but aimed at by the march
PLAIN = "gcc -O3"
FLAGS = (PLAIN, "gcc -O3 -march=native", "gcc -O3 -fno-tree-vectorize")
MARCHES_PER_ROUND = 50
WHEELS = 4  # of mecanum_rk4.c
STOPS, LIMIT = Setup(0.0, "dopri5", 1.25e-2), 1e-6  # of coulomb_wheel; m, rad
IN_STEPS = {  # of the bare wheel's loop: what is counted, target, alarm
    "march": ("a march of coulomb_wheel, 2 s, less than", 1000.0, 3000.0),
    "simulate": ("all of `omnisim.simulate`, with 21 rows, less than", 2500.0, 7500.0),
}

ROLLING = (
    "radius",
    "roller_distance",
    "spin_mobility",
    "axial_mobility",
    "cos_psi",
    "sin_psi",
    "tan_psi",
    "alpha",
    "phase",
    "axial_inertia",
)  # of any wheel, as our parameters have it
BODY = ("mobility", "yaw_mobility", "slip_speed")
BARE = ("friction_limit", "torque", "force_x", "force_y", "yaw_torque")
PLACED = ("axle_inertia", "ahead", "aside", "torque", "per_spin_x", "per_spin_y", "per_spin_yaw")
CARRIED = ("height", "moment_x", "moment_y", "centre_x", "centre_y", "weight", "friction", "odometry_yaw")


def doubles(names: tuple[str, ...]) -> list[tuple[str, type]]:
    return [(name, ctypes.c_double) for name in names]


class Wheel(ctypes.Structure):
    """`Wheel` of wheel_rk4.c."""

    _fields_ = [*doubles(BODY + ROLLING + BARE), ("rollers", ctypes.c_long)]


class MecanumWheel(ctypes.Structure):
    """`Wheel` of mecanum_rk4.c."""

    _fields_ = doubles(ROLLING + PLACED)


class Machine(ctypes.Structure):
    """`Machine` of mecanum_rk4.c."""

    _fields_ = [
        *doubles(BODY + CARRIED),
        ("wheels", MecanumWheel * WHEELS),
        ("rollers", ctypes.c_long),
    ]


def constants_of_wheel(march: March) -> Wheel:
    """Of a bare wheel under a constant drive and wrench."""
    machine, wheel = march.parameters.machine, march.parameters.wheels[0]
    force_x, force_y, force_z, yaw_torque, torque = constant_inputs(march)
    limit = machine.friction * (machine.mass * machine.gravity - force_z)
    return Wheel(*body(machine), *rolling(wheel), limit, torque, force_x, force_y, yaw_torque, int(wheel.rollers))


def constants_of_machine(march: March) -> Machine:
    """Of a machine on four parallel mecanum wheels under constant drives and no wrench."""
    machine, wheels, inputs = march.parameters.machine, march.parameters.wheels, constant_inputs(march)
    assert not inputs[:-WHEELS].any(), "the C loop of machines knows no wrench"
    assert (wheels.cos_heading == 1.0).all(), "the C loop of machines knows wheels that head forward"
    weight = machine.mass * machine.gravity
    carried = machine.height, *machine.moment, *machine.centre, weight, machine.friction, machine.odometry_yaw
    placed = [
        MecanumWheel(*rolling(wheel), wheel.axle_inertia, *wheel.offset, torque, *wheel.odometry)
        for wheel, torque in zip(wheels, inputs[-WHEELS:], strict=True)
    ]
    return Machine(*body(machine), *carried, (MecanumWheel * WHEELS)(*placed), int(wheels.rollers[0]))


def body(machine: np.record) -> tuple[float, ...]:
    """BODY of a machine."""
    return 1.0 / machine.mass, 1.0 / machine.yaw_inertia, machine.slip_speed


def rolling(wheel: np.record) -> list[float]:
    """ROLLING of a wheel."""
    return [wheel[name] for name in ROLLING]


def constant_inputs(march: March) -> np.ndarray:
    """Wrench and drives of a march, which must be constant."""
    inputs = march.parameters.inputs
    assert len(inputs) == 1 and not inputs[..., 1].any(), "the C loops know constant drives and wrenches only"
    return inputs[0, :, 0]


def order_of_wheel() -> list[int]:
    at = places_of(Contents(wheels=1))
    order = [X, Y, YAW, at.velocity, at.velocity + 1, at.yaw_rate, at.friction_loss, at.drive_work, at.wrench_work]
    return [*order, at.spin_angle, at.spin_rate, at.roller_rate]


def order_of_machine() -> list[int]:
    at, slots = places_of(Contents(WHEELS, odometry=1)), 2
    positions = [X, Y, YAW, *range(at.spin_angle, at.spin_angle + WHEELS)]
    rates = [at.velocity, at.velocity + 1, at.yaw_rate, *range(at.spin_rate, at.spin_rate + WHEELS)]
    rollers = range(at.roller_rate, at.roller_rate + slots * WHEELS, slots)
    return [*positions, *rates, *rollers, at.friction_loss, at.drive_work, at.odometry, at.odometry + 1]


def extremes_of_wheel(march: March) -> list[np.ndarray]:
    """EXTREMES of wheel_rk4.c, from the first row on."""
    seen = march.rows.extremes[:, 0]
    return [seen["friction_square"], seen["slip_square"], *seen["drive_power"].T]


def extremes_of_machine(march: March) -> list[np.ndarray]:
    """The same of mecanum_rk4.c."""
    found = []
    for seen in march.rows.extremes.T:
        found += [seen["friction_square"], seen["slip_square"], *seen["normal_force"].T, *seen["drive_power"].T]
    return [*found, *march.rows.odometry_extremes.T]


class Loop(NamedTuple):
    """A C loop: its source, the constants of a march as it takes them, where its states stand in ours, its extremes.

    scene: what it is measured on. target, alarm: how many times as long the march may take, against PLAIN.
    """

    source: Path
    constants: Callable[[March], ctypes.Structure]
    order: list[int]
    extremes: Callable[[March], list[np.ndarray]]
    scene: Callable[[], Scene]
    target: float
    alarm: float


FOLDER = Path(__file__).parent
WHEEL = Loop(
    FOLDER / "wheel_rk4.c", constants_of_wheel, order_of_wheel(), extremes_of_wheel, partial(bare_wheel, 1e-4), 1.1, 2.5
)
MACHINE = Loop(
    FOLDER / "mecanum_rk4.c",
    constants_of_machine,
    order_of_machine(),
    extremes_of_machine,
    slipping_platform,
    1.25,
    3.0,
)
BY_PROCESSOR = (
    "That differs by processor: on an EPYC of the fourth generation 0.93, of either scene; on one of the first, where "
    "what is decoded anew in every step comes at 9 bytes a cycle, half as much again"
)
STEPS_BY_PROCESSOR = "That differs by processor: 893 on an Intel Xeon, 1440 on an EPYC of the first generation"
LOOPS = {"bare wheel": WHEEL, "mecanum machine": MACHINE}


def build(loop: Loop, command: str = PLAIN) -> ctypes.CDLL | None:
    """A C loop as a library, compiled with the compiler and flags of `command`; None without the compiler."""
    library = compiled(loop.source, *command.split())
    if library is not None:
        library.march.restype = ctypes.c_long
    return library


def compiled(source: Path, compiler: str, *flags: str) -> ctypes.CDLL | None:
    """A source as a library; None without the compiler."""
    if not shutil.which(compiler):
        return None
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "library.so"
        subprocess.run([compiler, *flags, "-shared", "-fPIC", source, "-o", library, "-lm"], check=True)
        return ctypes.CDLL(str(library))


def results(loop: Loop, march: March) -> tuple[np.ndarray, np.ndarray]:
    """Rows (T, n) of a march and the extremes (T, E) of the intervals that they end, as the C loop has them: without
    the start."""
    return march.rows.y[1:, loop.order], np.stack(loop.extremes(march), axis=-1)[1:]


def prepare(loop: Loop, library: ctypes.CDLL, march: March) -> Callable[[], tuple[np.ndarray, ...]]:
    """A function that runs the C loop for `march`; it returns rates (W, N), and its `results`."""
    constants, y, rates = loop.constants(march), march.run.y[loop.order], march.run.rates.copy()
    rows, extremes = (np.empty(values.shape) for values in results(loop, march))
    numbers = ctypes.c_double(march.run.clock.dt), ctypes.c_long(march.steps), ctypes.c_long(march.steps_per_row)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (y, rates, rows, extremes)]  # they keep them alive

    def go() -> tuple[np.ndarray, ...]:
        library.march(ctypes.byref(constants), *pointers[:2], *numbers, *pointers[2:])
        return rates, rows, extremes

    return go


def disagreement(loop: Loop, march: March, rates: np.ndarray, *found: np.ndarray) -> float:
    """Largest difference between a finished march and a C loop, relative to the scale of each quantity."""
    pairs = [(march.run.rates, rates)]
    pairs += [
        (column, other)
        for ours, theirs in zip(results(loop, march), found, strict=True)
        for column, other in zip(ours.T, theirs.T, strict=True)
    ]
    return max(float(np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1.0)) for ours, theirs in pairs)


def allowed(scene: Scene, march: March) -> float:
    """The `disagreement` of two marches that move alike: by rounding, or much less than their steps err, which a
    quarter of the step tells."""
    fine = ready(changed(scene, {"time.step": scene.config.time.step / 4.0})).go().run.y
    error = float(np.abs(march.run.y - fine).max() / max(np.abs(fine).max(), 1.0))
    return max(ROUNDING, AGREEMENT * error)


def measure(rounds: int) -> dict:
    """Of each loop and all flags: ns per step and ratio march / C loop, of quiet rounds, and what `coulomb_wheel` takes
    in steps of C; empty without a compiler."""
    if not shutil.which(PLAIN.split()[0]):
        return {}
    return {name: measured(loop, rounds) for name, loop in LOOPS.items()} | {"coulomb_wheel": in_steps(rounds)}


def measured(loop: Loop, rounds: int) -> dict:
    """One loop by all flags, beside omnisim."""
    scene = loop.scene()
    contestants = {"omnisim": lambda: ready(scene).go}
    differences, march = {}, ready(scene).go()
    bound = allowed(scene, march)
    for name in FLAGS:
        library = build(loop, name)
        differences[name] = disagreement(loop, march, *prepare(loop, library, ready(scene))())
        apart = f"{differences[name]:.1e} apart, {bound:.1e} allowed"
        assert differences[name] < bound, f"{name}: not the same motion, {apart}"
        contestants[name] = lambda library=library: prepare(loop, library, ready(scene))
    mean = quiet(interleaved(contestants, MARCHES_PER_ROUND * rounds))
    steps = scene.config.time.steps
    return {
        name: {
            "ns_per_step": seconds / steps * 1e9,
            "ratio": mean["omnisim"] / seconds,
            "difference": differences.get(name, 0.0),
        }
        for name, seconds in mean.items()
    }


def in_steps(rounds: int) -> dict:
    """March and whole call of `coulomb_wheel` by STOPS, in steps of the bare wheel's C loop, and their error."""
    wheel, stops = WHEEL.scene(), STOPS.scene(FEW_ROWS)
    error, library = error_of(omnisim.simulate(stops)), build(WHEEL)
    assert error < LIMIT, f"coulomb_wheel: {error:.1e} off"
    contestants = {
        "C": lambda: prepare(WHEEL, library, ready(wheel)),
        "march": lambda: marching(stops),
        "simulate": lambda: simulation(stops),
    }
    mean = quiet(interleaved(contestants, MARCHES_PER_ROUND * rounds))
    step = mean["C"] / wheel.config.time.steps
    return {"march": mean["march"] / step, "simulate": mean["simulate"] / step, "error": error}


def report(result: dict) -> str:
    if not result:
        return "No gcc on this machine: not measured."
    rows = [
        [scene, name, f"{row['ns_per_step']:.0f}", f"{row['ratio']:.2f}", f"{row['difference']:.0e}"]
        for scene in LOOPS
        for name, row in result[scene].items()
    ]
    stops = result["coulomb_wheel"]
    return "\n\n".join(
        [
            table(["scene", "loop", "ns per step", "omnisim takes, times", "largest difference"], rows),
            f"`coulomb_wheel`, 2 s by `{STOPS.method}` at {STOPS.step:g} s, {stops['error']:.1e} off at its end, takes "
            f"as long as {stops['march']:.0f} steps of the bare wheel by `{PLAIN}`, all of `omnisim.simulate` with 21 "
            f"rows as {stops['simulate']:.0f}.",
        ]
    )


def claims(result: dict) -> list[Claim]:
    if not result:
        return []
    beside_c = [
        Claim(
            f"a march of the {scene}, by that of the C loop ({PLAIN})",
            result[scene][PLAIN]["ratio"],
            "at most",
            loop.target,
            loop.alarm,
            BY_PROCESSOR,
        )
        for scene, loop in LOOPS.items()
    ]
    in_c = [
        Claim(
            f"{what} {LIMIT:g} off, in steps of the bare wheel's C loop",
            result["coulomb_wheel"][part],
            "at most",
            *limits,
            STEPS_BY_PROCESSOR if part == "march" else "",
        )
        for part, (what, *limits) in IN_STEPS.items()
    ]
    return beside_c + in_c
