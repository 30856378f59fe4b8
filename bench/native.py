"""Machines as native code: the library of C and its C++ example beside the march of `omnisim run`, and FMPy beside it.

The example drives a youBot round a curve, with a command every 10 ms. What it commanded becomes tables of a scene,
which `omnisim run` marches through the same motion; the two must end in the same place. The example tells the time of
its own loop.

FMPy steps the Functional Mock-up Unit by 10 ms, with all outputs recorded at each, with the pose alone, and without
any; and what it takes to ask for all of them itself, with answers that cost nothing. Beside it stands
`omnisim.simulate` with rows at the same times: all datasets, and the march alone. Nobody reads a file, and everything
is warm. All in this process is in processor time.
"""

import ctypes
import re
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import fmpy

import omnisim
from bench.common import Claim, interleaved, quiet, simulation, table
from omnisim.native.building import build
from omnisim.native.fmu import fmu
from omnisim.native.library import files, prefix_of
from omnisim.run.marching import Marching, packed_once
from omnisim.scene.scene import Scene

CONTROL = 0.01  # s
EXAMPLE, SCENES = "youbot", ("youbot", "kiwi", "coulomb_wheel")
CPUS = ("generic", "native")
POSE = ["body/position.x", "body/position.y", "body/yaw"]
RECORDED = {"all outputs": None, "the pose": POSE, "nothing": []}
MARCH, DATASETS, ALL = "the march", "omnisim.simulate, all datasets", "FMPy, all outputs"
FREE = "FMPy, all outputs, answers that cost nothing"
GETTERS = ("fmi3GetFloat64", "fmi3GetInt64")  # of the types that outputs have


def measure(rounds: int) -> dict:
    """Seconds of every contestant, round by round in turn."""
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        return {
            "calls": interleaved(
                {MARCH: marching(omnisim.load(EXAMPLE))} | in_one_call(here), rounds, time.process_time
            ),
            "example": driven(here, rounds),
            "fmpy": {name: stepped(name, here, rounds) for name in SCENES},
        }


def marching(scene: Scene) -> Callable[[], Callable[[], object]]:
    """A contestant: the march of `omnisim run`."""
    return lambda: Marching(scene.config, start=packed_once(scene.config)).march


def in_one_call(folder: Path) -> dict[str, Callable[[], Callable[[], object]]]:
    """Contestants: the library, which marches through the whole scene in one call."""
    return {f"the library, --cpu {cpu}": called(made(folder / cpu, cpu)) for cpu in CPUS}


def made(folder: Path, cpu: str) -> Path:
    """The folder of the library of the example."""
    folder.mkdir()
    for name, image in files(omnisim.load(EXAMPLE), EXAMPLE, cpu).items():
        (folder / name).write_bytes(image)
    return folder


def called(folder: Path) -> Callable[[], Callable[[], object]]:
    library = ctypes.CDLL(str(folder / f"lib{EXAMPLE}.so"))
    step, reset, opened = (getattr(library, f"{EXAMPLE}_{name}") for name in ("step", "reset", "open"))
    opened.restype = ctypes.c_void_p
    machine, end = ctypes.c_void_p(opened()), ctypes.c_double(omnisim.load(EXAMPLE).config.time.end)

    def prepare() -> Callable[[], object]:
        reset(machine)
        return lambda: step(machine, end)

    return prepare


def driven(folder: Path, rounds: int) -> dict[str, list[float]]:
    """The example and the march of the same motion. Raises RuntimeError if they are not the same."""
    programs = {f"the example, --cpu {cpu}": built(folder / cpu) for cpu in CPUS}
    scene, end = commanded()
    march = marching(scene)
    seconds: dict[str, list[float]] = {MARCH: [], **{name: [] for name in programs}}
    for _ in range(rounds):
        seconds[MARCH] += interleaved({MARCH: march}, 1)[MARCH]
        for name, program in programs.items():
            said = subprocess.run([program], capture_output=True, text=True, check=True).stdout
            pose = [float(text) for text in re.findall(r"(?:x|y|yaw) = (\S+)", said)][-3:]
            if max(abs(a - b) for a, b in zip(pose, end, strict=True)) > 1e-6:
                raise RuntimeError(f"the example ends at {pose}, omnisim at {end}")
            seconds[name].append(float(re.findall(r"marched in (\S+) s", said)[0]))
    return seconds


def built(folder: Path) -> str:
    """The program of the example."""
    given = ["example.cpp", f"-L{folder}", f"-l{EXAMPLE}", f"-Wl,-rpath,{folder}", "-o", "example"]
    subprocess.run(["g++", "-std=c++11", "-O2", *given], cwd=folder, check=True)
    return str(folder / "example")


def commanded() -> tuple[Scene, list[float]]:
    """The scene with what example.cpp commands as tables, and its pose at the end."""
    loop = omnisim.Loop(EXAMPLE)
    going = True
    while going:
        loop.command(0.3, 0.0, 0.5 + 2.0 * (0.5 * loop.time - loop.yaw))
        going = loop.advance(CONTROL)
    run = loop.trajectory()
    return omnisim.load_text(run.attributes["scene"]), [*run["body/position"][-1, :2].tolist(), run["body/yaw"][-1]]


def stepped(name: str, folder: Path, rounds: int) -> dict[str, list[float]]:
    """FMPy beside omnisim."""
    scene = omnisim.load(name, {"time.output_interval": CONTROL})
    path = folder / f"{name}.fmu"
    path.write_bytes(fmu(scene, build(scene, prefix_of(name), "generic"), "3"))
    told, unzipped = fmpy.read_model_description(str(path)), fmpy.extract(str(path), str(folder / name))
    unit, silent = (fmpy.instantiate_fmu(unzipped, told) for _ in range(2))
    for getter in GETTERS:
        setattr(silent, getter, lambda *_: None)
    run = partial(
        fmpy.simulate_fmu, unzipped, model_description=told, output_interval=CONTROL, stop_time=scene.config.time.end
    )

    def recording(unit: fmpy.fmi3.FMU3Slave, names: list[str] | None) -> Callable[[], object]:
        unit.reset()
        return partial(run, fmu_instance=unit, output=names)

    contestants = {
        MARCH: marching(scene),
        DATASETS: lambda: with_datasets(scene),
        FREE: partial(recording, silent, None),
    }
    contestants |= {f"FMPy, {what}": partial(recording, unit, names) for what, names in RECORDED.items()}
    seconds = interleaved(contestants, rounds, time.process_time)
    silent.freeInstance()
    unit.freeInstance()
    return seconds


def with_datasets(scene: Scene) -> Callable[[], object]:
    simulate = simulation(scene)
    return lambda: simulate().data


def report(result: dict) -> str:
    calls, example = (
        [[name, f"{ratio:.2f}"] for name, ratio in times_the_march(result[part]).items()]
        for part in ("calls", "example")
    )
    rows = []
    for name, seconds in result["fmpy"].items():
        mean = quiet(seconds)
        speeds = [mean[DATASETS] / mean[f"FMPy, {what}"] for what in RECORDED]
        times = [f"{1e3 * mean[what]:.2f}" for what in (MARCH, DATASETS, ALL)]
        rows.append([name, *times, *(f"{speed:.2f}" for speed in speeds), f"{mean[MARCH] / mean[ALL]:.2f}"])
    header = ["", "march, ms", "datasets, ms", "FMPy, ms", *(f"speed with {what}" for what in RECORDED)]
    return "\n\n".join(
        [
            table(["`youbot`, 3 s in one call", "times the march"], calls),
            table(["the C++ example, commands every 10 ms", "times the march of the same motion"], example),
            "FMPy, steps of 10 ms; speeds by that of `omnisim.simulate` with all datasets at the same times:",
            table([*header, "with all outputs, by the march"], rows),
        ]
    )


def times_the_march(seconds: dict[str, list[float]]) -> dict[str, float]:
    """In the quietest rounds."""
    mean = quiet(seconds)
    return {name: value / mean[MARCH] for name, value in mean.items() if name != MARCH}


def claims(result: dict) -> list[Claim]:
    found = [
        Claim(f"{name}, by the march of the same motion", ratio, "at most", 1.1, 1.5)
        for name, ratio in times_the_march(result["example"]).items()
    ]
    for name, seconds in result["fmpy"].items():
        mean = quiet(seconds)
        text = f"speed of FMPy with all outputs at 10 ms, by that of omnisim.simulate with all datasets: {name}"
        free = mean[DATASETS] / mean[FREE]
        reason = (
            f"Of its {1e3 * mean[ALL]:.2f} ms the march is {1e3 * mean[MARCH]:.2f}; for the rest FMPy asks for every "
            f"output every 10 ms, from Python: with answers that cost nothing it would be {free:.2f}"
        )
        found.append(Claim(text, mean[DATASETS] / mean[ALL], "at least", 0.5, 0.25, reason))
    return found
