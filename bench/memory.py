"""Memory: the peak of the whole command, beside what Python and Numba take before it begins, and what a row takes."""

import subprocess
import sys
import tempfile
from pathlib import Path

import omnisim
from bench.common import Claim, table

SCENES = ("six_rollers", "thirty_two_rollers", "kiwi", "youbot")
IMPORTS = ("import numba", "import omnisim.run.simulation")
BEFORE = {"python": "pass"} | {line: line for line in IMPORTS}
FINER = 5  # times as many rows, to tell what one takes
MEGABYTE = 1024**2
# A process counts what its parent held when it was started, so a small one starts it.
LAUNCHER = """
import resource, subprocess, sys
done = subprocess.run(sys.argv[1:], capture_output=True, text=True)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(done.stderr if done.returncode else 0)
"""


def peak_of(command: list[str]) -> int:
    """Largest resident memory of a command that must succeed, bytes."""
    launcher = [sys.executable, "-S", "-c", LAUNCHER, *command]
    done = subprocess.run(launcher, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    return int(done.stdout) * (1 if sys.platform == "darwin" else 1024)


def measure(rounds: int) -> dict:
    """Least peak (bytes) of every command; of runs also the rows, and bytes by row in memory and in the file."""
    result = {}
    for name, code in BEFORE.items():
        result[name] = {"peak": min(peak_of([sys.executable, "-c", code]) for _ in range(rounds))}
    for name in SCENES:
        interval = omnisim.load(name).config.time.output_interval
        coarse, fine = (run(name, interval / finer, rounds) for finer in (1, FINER))
        rows = fine["rows"] - coarse["rows"]
        by_row = {f"{key} by row": (fine[key] - coarse[key]) / rows for key in ("peak", "file")}
        result[f"omnisim run {name}"] = coarse | by_row
    return result


def run(name: str, interval: float, rounds: int) -> dict:
    """Peak and file (bytes) and rows of `omnisim run` of a packaged scene, after one unmeasured run."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.h5"
        command = [str(Path(sys.executable).with_name("omnisim")), "run", name, "--quiet", "--force", "-o", str(file)]
        command += ["--set", f"time.output_interval={interval!r}"]
        peaks = [peak_of(command) for _ in range(rounds + 1)][1:]
        rows = len(omnisim.open_trajectory(file)["time"])
        return {"peak": min(peaks), "file": file.stat().st_size, "rows": rows}


def report(result: dict) -> str:
    rows = [
        [
            name,
            f"{row['peak'] / MEGABYTE:.0f}",
            *(f"{row[key]:.0f}" if key in row else "" for key in ("rows", "peak by row", "file by row")),
        ]
        for name, row in result.items()
    ]
    return table(["command", "peak, MiB", "rows", "bytes by row, in memory", "in the file"], rows)


def claims(_result: dict) -> list[Claim]:
    return []  # no target is set
