"""The limit that the physics sets: arithmetic counted in the C loops, by what this machine takes for each operation.

The C loops are compiled once more, with numbers that count their operations (peers/counted.cc), and march through the
very run that is timed; omnisim's own kernels run as plain Python on such numbers (counting.py). Two bounds follow from
the counts of the C loops:

    floor           sum of count * cost, each operation at the rate at which independent ones follow one another
    critical path   until the last state is ready if every operation starts once its operands are there

Both are for scalar arithmetic with the sines and cosines of the C library, at costs measured in the same rounds
(peers/operations.c), and know of no memory. Vectors, fused operations and divisions beside other work go below the
floor, what is stored and loaded goes on top of it. The same sum of omnisim's own operations tells how much of its
distance is arithmetic.
"""

import ctypes
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bench.common import Claim, interleaved, ready, table
from bench.peers.c_loop import FLAGS, FOLDER, LOOPS, Loop, build, compiled, prepare, results

# Each operation is measured from such a number, which keeps its results usual: azimuths of rollers are small angles.
OPERATIONS = {"addition": 1.0, "multiplication": 1.000001, "division": 1.3, "root": 1.3, "sine and cosine": 0.25}
TIMES = 100_000  # operations in a round
LANES = 12  # independent ones at once, of operations.c
COUNTED = np.dtype([("value", np.float64), ("ready", np.float64), ("stored", np.int64)])  # of counted.cc
BYTES = 8  # of a stored number


class Count(NamedTuple):
    """How often each of OPERATIONS is done, bytes read from and written to arrays, and the critical path, ns."""

    operations: list[float]
    read: float
    written: float
    path: float


def measure(rounds: int) -> dict:
    """Costs of operations, and of each loop the counts and the ns per step; empty without the compilers."""
    if not all(map(shutil.which, ("gcc", "g++"))):
        return {}
    contestants = operations()
    for name, loop in LOOPS.items():
        contestants |= {(name, how): go for how, go in marches(loop).items()}
    seconds = interleaved(contestants, rounds)
    latency, throughput = costs(seconds, "chain", 1), costs(seconds, "lanes", LANES)
    result = {"cost": dict(zip(OPERATIONS, zip(median(latency), median(throughput), strict=True), strict=True))}
    own = own_counts()
    for name, loop in LOOPS.items():
        of_rhs, of_step = count(loop, median(latency))
        floor, steps = throughput @ of_step.operations, loop.scene().config.time.steps
        times = {how: np.array(seconds[name, how]) / steps * 1e9 for how in ("omnisim", *FLAGS)}
        result[name] = {
            "rhs": of_rhs._asdict(),
            "step": of_step._asdict(),
            "floor": median(floor),
            "own": own[name] | {"ns": median(throughput @ own[name]["step"])},
            "ns_per_step": {how: median(values) for how, values in times.items()},
            "ratio": {how: median(values / floor) for how, values in times.items()},
        }
    return result


def median(values: np.ndarray) -> list[float] | float:
    """Over the rounds."""
    return np.median(values, axis=0).tolist()


def operations() -> dict[tuple[str, str], Callable[[], Callable[[], object]]]:
    """Chains and lanes of all operations, as contestants."""
    library = compiled(FOLDER / "operations.c", "gcc", "-O3", "-fno-tree-vectorize")
    contestants = {}
    for form in ("chain", "lanes"):
        for name, number in OPERATIONS.items():
            function = library[f"{form}_{name.replace(' ', '_')}"]
            go = partial(function, ctypes.c_long(TIMES), ctypes.c_double(number))
            contestants[form, name] = lambda go=go: go
    return contestants


def costs(seconds: dict[tuple[str, str], list[float]], form: str, at_once: int) -> np.ndarray:
    """ns of each operation in each round (R, 5); roots come with a multiplication, sines with one and an addition."""
    one = np.array([seconds[form, name] for name in OPERATIONS]).T / (TIMES * at_once) * 1e9
    one[:, 3] -= one[:, 1]
    one[:, 4] -= one[:, 0] + one[:, 1]
    return one


def marches(loop: Loop) -> dict[str, Callable[[], Callable[[], object]]]:
    """omnisim and every build of the C loop, as contestants."""
    scene = loop.scene()
    contestants = {"omnisim": lambda: ready(scene).go}
    for flags in FLAGS:
        library = build(loop, flags)
        contestants[flags] = lambda library=library: prepare(loop, library, ready(scene))
    return contestants


def count(loop: Loop, latency: list[float]) -> tuple[Count, Count]:
    """Counts of one right-hand side, and of one step: the mean of a whole march, exchanges and rows included."""
    march = ready(loop.scene())
    constants = loop.constants(march)
    names = f'-DSOURCE="{loop.source.name}"', f"-DSYSTEM={type(constants).__name__}"
    library = compiled(FOLDER / "counted.cc", "g++", "-O2", *names)
    (ctypes.c_double * len(latency)).in_dll(library, "latency")[:] = latency
    system, y, rates = constants_of(constants), counted(march.run.y[loop.order]), counted(march.run.rates)
    slopes = counted(np.zeros(len(y)))
    rows, extremes = (counted(np.zeros(values.shape)) for values in results(loop, march))
    dt = constant(march.run.clock.dt)
    library.evaluate(*map(pointer, (system, y, slopes)))
    of_rhs = taken(library, slopes, 1)
    numbers = ctypes.c_long(march.steps), ctypes.c_long(march.steps_per_row)
    library.march(*map(pointer, (system, y, rates, dt)), *numbers, pointer(rows), pointer(extremes))
    return of_rhs, taken(library, y, march.steps)


def own_counts() -> dict[str, dict[str, list[float]]]:
    """How often omnisim itself does each of OPERATIONS: of every scene "rhs" and "step"."""
    command = [sys.executable, "-m", "bench.counting"]
    environment, root = os.environ | {"NUMBA_DISABLE_JIT": "1"}, Path(__file__).parents[1]
    done = subprocess.run(command, env=environment, cwd=root, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def counted(values: np.ndarray) -> np.ndarray:
    """Numbers in memory for counted.cc, ready at once."""
    result = np.zeros(np.shape(values), COUNTED)
    result["value"], result["stored"] = values, True
    return result


def constant(values: np.ndarray) -> np.ndarray:
    """Constants for counted.cc."""
    result = np.zeros(np.shape(values), COUNTED)
    result["value"], result["ready"] = values, -np.inf
    return result


def constants_of(system: ctypes.Structure) -> np.ndarray:
    """Those of a C loop, doubles and a last integer, as bytes for counted.cc."""
    *values, _ = np.frombuffer(bytes(system))
    return np.frombuffer(constant(values).tobytes() + bytes(system)[-BYTES:], np.uint8)


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    """It keeps its array alive."""
    return array.ctypes.data_as(ctypes.c_void_p)


def taken(library: ctypes.CDLL, results: np.ndarray, steps: int) -> Count:
    """What was counted since the last time, by step; `results` end the critical path. Sine and cosine make one pair."""
    counts = (ctypes.c_long * (len(OPERATIONS) + 2)).in_dll(library, "counts")
    *operations, read, written = (number / steps for number in counts)
    operations[-1] /= 2
    counts[:] = [0] * len(counts)
    return Count(operations, BYTES * read, BYTES * written, float(results["ready"].max()) / steps)


def report(result: dict) -> str:
    if not result:
        return "No gcc or no g++ on this machine: not measured."
    cost, scenes = result["cost"], {name: result[name] for name in LOOPS}
    prices = [[name, *(f"{value:.2f}" for value in values)] for name, values in cost.items()]
    amounts = []
    for scene, row in scenes.items():
        for name, key in (("right-hand side", "rhs"), ("step", "step")):
            by_c = *row[key]["operations"], row[key]["read"], row[key]["written"]
            amounts.append([scene, name, "C", *(f"{number:.0f}" for number in by_c)])
            amounts.append([scene, name, "omnisim", *(f"{number:.0f}" for number in row["own"][key]), "", ""])
    kinds = ["additions", "multiplications", "divisions", "roots", "sines with cosines", "bytes read", "bytes written"]
    distances = []
    for scene, row in scenes.items():
        for how, taken in row["ns_per_step"].items():
            own = row["own"]["ns"] if how == "omnisim" else row["floor"]
            bounds = (f"{value:.0f}" for value in (row["step"]["path"], row["floor"], own, taken))
            distances.append([scene, how, *bounds, f"{row['ratio'][how]:.2f}"])
    columns = ["critical path, ns", "floor, ns per step", "own arithmetic, ns", "taken, ns", "taken / floor"]
    return "\n\n".join(
        [
            "Bytes are of arrays: states, derivatives, and what the wheels keep meanwhile.",
            table(["scene", "one", "by", *kinds], amounts),
            table(["operation", "in a chain, ns", "independent, ns"], prices),
            table(["scene", "loop", *columns], distances),
        ]
    )


def claims(_result: dict) -> list[Claim]:
    return []  # a bound of the arithmetic is no target
