"""The whole command: `omnisim run` of packaged scenes with warm and with empty caches, and what imports cost."""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench.common import Claim, table
from omnisim.scene.scene import packaged_scenes

IMPORTS = ("omnisim", "omnisim.scene.scene", "omnisim.run.simulation", "numba", "numpy")


def seconds_of(command: list[str], **environment: str) -> float:
    """Wall time of a command that must succeed."""
    begun = time.perf_counter()
    done = subprocess.run(command, env=os.environ | environment, capture_output=True, text=True)
    elapsed = time.perf_counter() - begun
    if done.returncode:
        raise RuntimeError((done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1])
    return elapsed


def measure(rounds: int) -> dict:
    """Best and median seconds of every command; the reason instead if one fails."""
    command = Path(sys.executable).with_name("omnisim")
    result = {"python": timed([sys.executable, "-c", "pass"], rounds)}
    result |= {f"import {name}": timed([sys.executable, "-c", f"import {name}"], rounds) for name in IMPORTS}
    with tempfile.TemporaryDirectory() as folder:
        out = ["--quiet", "--force", "-o", str(Path(folder) / "run.h5")]
        for scene in packaged_scenes():
            run = [str(command), "run", scene, *out]
            result[f"omnisim run {scene}"] = timed(run, rounds)
        for scene in packaged_scenes()[:1]:
            result[f"omnisim run {scene}, empty cache"] = cold([str(command), "run", scene, *out])
    return result


def timed(command: list[str], rounds: int) -> dict:
    """After one unmeasured run."""
    try:
        seconds_of(command)
        values = [seconds_of(command) for _ in range(rounds)]
    except (RuntimeError, OSError) as error:
        return {"failed": str(error)}
    return {"best": min(values), "median": statistics.median(values)}


def cold(command: list[str]) -> dict:
    """One run with nothing compiled."""
    with tempfile.TemporaryDirectory() as cache:
        try:
            return {"best": (value := seconds_of(command, NUMBA_CACHE_DIR=cache)), "median": value}
        except (RuntimeError, OSError) as error:
            return {"failed": str(error)}


def report(result: dict) -> str:
    rows = [
        [name, "failed", row["failed"]] if "failed" in row else [name, f"{row['best']:.2f}", f"{row['median']:.2f}"]
        for name, row in result.items()
    ]
    return table(["command", "best, s", "median, s"], rows)


def claims(result: dict) -> list[Claim]:
    return [Claim("commands that fail", sum("failed" in row for row in result.values()), "at most", 0, 0)]
