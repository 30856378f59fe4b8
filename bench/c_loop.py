"""The march against a plain C loop of the same equations, compiled when the benchmark runs.

The target is for plain `gcc -O3`. Two more builds are measured, for the compiler is not always right: packing the
state into vector registers makes each stage wait for scalars that were written just before.
"""

import ctypes
import shutil
import statistics
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from common import March, bare_wheel, interleaved, median_ratio, ready, table

from omnisim.state import YAW, X, Y, places_of

SOURCE = Path(__file__).with_name("wheel_rk4.c")
TARGET = 1.5  # times the C loop
AGREEMENT = 1e-11  # of all states and rows, relative to the largest value of each state (at least 1); C sums plainly
PLAIN = "gcc -O3"
FLAGS = (PLAIN, "gcc -O3 -march=native", "gcc -O3 -fno-tree-vectorize")
FROM_MACHINE = ("mass", "yaw_inertia", "slip_speed")
FROM_WHEEL = (
    "axle_inertia",
    "axial_inertia",
    "radius",
    "roller_distance",
    "cos_psi",
    "sin_psi",
    "tan_psi",
    "alpha",
    "phase",
)
FROM_SCENE = ("friction_limit", "torque", "force_x", "force_y", "yaw_torque")

AT = places_of(1, 2, 0, 0, 0)
ORDER = [X, Y, YAW, AT.velocity, AT.velocity + 1, AT.yaw_rate, AT.friction_loss, AT.drive_work, AT.wrench_work]
ORDER += [AT.spin_angle, AT.spin_rate, AT.roller_rate]  # where the states of C stand in ours


class Wheel(ctypes.Structure):
    """`Wheel` of wheel_rk4.c."""

    _fields_ = [(name, ctypes.c_double) for name in FROM_MACHINE + FROM_WHEEL + FROM_SCENE] + [
        ("rollers", ctypes.c_long)
    ]


def build(command: str = PLAIN) -> ctypes.CDLL | None:
    """The C loop as a library, compiled with the compiler and flags of `command`; None without the compiler."""
    compiler, *flags = command.split()
    if not shutil.which(compiler):
        return None
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "wheel_rk4.so"
        subprocess.run([compiler, *flags, "-shared", "-fPIC", SOURCE, "-o", library, "-lm"], check=True)
        loaded = ctypes.CDLL(str(library))
    loaded.march.restype = ctypes.c_long
    return loaded


def wheel_of(march: March) -> Wheel:
    """The constants of a march, for C; drive and wrench must be constant."""
    machine, wheel, inputs = march.parameters.machine, march.parameters.wheels[0], march.parameters.inputs
    assert len(inputs) == 1 and not inputs[..., 1].any(), "the C loop knows constant drives and wrenches only"
    force_x, force_y, force_z, yaw_torque, torque = inputs[0, :, 0]
    limit = machine.friction * (machine.mass * machine.gravity - force_z)
    scene = zip(FROM_SCENE, (limit, torque, force_x, force_y, yaw_torque), strict=True)
    constants = (
        {name: machine[name] for name in FROM_MACHINE} | {name: wheel[name] for name in FROM_WHEEL} | dict(scene)
    )
    return Wheel(**constants, rollers=int(wheel.rollers))


def prepare(library: ctypes.CDLL, march: March) -> Callable[[], tuple[np.ndarray, np.ndarray]]:
    """A function that runs the C loop for `march`; it returns rows (T, 12) from the first output on, and rates."""
    wheel, y, rates = wheel_of(march), march.run.y[ORDER], march.run.rates[0].copy()
    rows = np.empty((len(march.rows.y) - 1, len(y)))
    numbers = ctypes.c_double(march.run.clock.dt), ctypes.c_long(march.steps), ctypes.c_long(march.steps_per_row)
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in (y, rates, rows)]  # each keeps its array alive

    def go() -> tuple[np.ndarray, np.ndarray]:
        library.march(ctypes.byref(wheel), *pointers[:2], *numbers, pointers[2])
        return rows, rates

    return go


def disagreement(march: March, rows: np.ndarray, rates: np.ndarray) -> float:
    """Largest difference between a finished march and the C loop, relative to the scale of each state."""
    scale = np.maximum(np.abs(rows).max(axis=0), 1.0)
    of_rates = np.abs(march.run.rates[0] - rates) / np.maximum(np.abs(rates), 1.0)
    return float(max((np.abs(march.rows.y[1:, ORDER] - rows) / scale).max(), of_rates.max()))


def measure(rounds: int, step: float = 1e-4) -> dict:
    """Median ratio march / C loop for each set of flags, with ns per step; empty without a compiler."""
    scene = bare_wheel(step)
    contestants = {"omnisim": lambda: ready(scene).go}
    differences = {}
    for name in FLAGS:
        library = build(name)
        if library is None:
            return {}
        differences[name] = disagreement(ready(scene).go(), *prepare(library, ready(scene))())
        assert differences[name] < AGREEMENT, f"{name}: not the same motion, {differences[name]:.1e} apart"
        contestants[name] = lambda library=library: prepare(library, ready(scene))
    seconds = interleaved(contestants, rounds)
    steps = scene.config.time.steps
    return {
        name: {
            "ns_per_step": statistics.median(values) / steps * 1e9,
            "ratio": median_ratio(seconds["omnisim"], values),
            "difference": differences.get(name, 0.0),
        }
        for name, values in seconds.items()
    }


def report(result: dict) -> str:
    if not result:
        return "No gcc on this machine: not measured."
    rows = [
        [name, f"{row['ns_per_step']:.0f}", f"{row['ratio']:.2f}", f"{row['difference']:.0e}"]
        for name, row in result.items()
    ]
    return table(["loop", "ns per step", "omnisim takes, times", "largest difference"], rows)
