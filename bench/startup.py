"""The whole command: `omnisim run` of packaged scenes with warm and with empty caches, and where the time of one goes.

Python keeps the bytecode of its modules, as it does unless it is told otherwise.
"""

import json
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
EXAMPLE = "youbot"
PARTS = {  # of `omnisim run`, in this order in one process
    "import numpy": "import numpy",
    "import numba": "import numba",
    "import pydantic, h5py, click": "import pydantic, h5py, click",
    "omnisim's own modules": "import omnisim_cli.run, omnisim.run.simulation, omnisim.scene.scene",
    "the scene": f"import omnisim; scene = omnisim.load({EXAMPLE!r})",
    "its kernels, from disk": "import omnisim.run.scene_march as run; march = run.SceneMarch(scene); march.begin()",
    "the march": "march.march()",
    "all datasets": "run = march.trajectory(); run['body/position']",
    "the file": "run.save(path, overwrite=True)",
}
TIMER = """
import json, sys, time
path, parts, found, names = sys.argv[1], json.loads(sys.argv[2]), {}, {}
names["path"] = path
for name, code in parts.items():
    begun = time.perf_counter()
    exec(code, names)
    found[name] = time.perf_counter() - begun
print(json.dumps(found))
"""


def seconds_of(command: list[str], **environment: str) -> float:
    """Wall time of a command that must succeed."""
    begun = time.perf_counter()
    said(command, **environment)
    return time.perf_counter() - begun


def said(command: list[str], **environment: str) -> str:
    """What a command prints that must succeed."""
    variables = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(command, env=variables | environment, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError((done.stderr.strip() or f"exit code {done.returncode}").splitlines()[-1])
    return done.stdout


def measure(rounds: int) -> dict:
    """Best and median seconds of every command; the reason instead if one fails. Median seconds of the PARTS of one."""
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
        timer = [sys.executable, "-c", TIMER, str(Path(folder) / "parts.h5"), json.dumps(PARTS)]
        parts = [json.loads(said(timer)) for _ in range(rounds)]
    return {"commands": result, "parts": {name: statistics.median(part[name] for part in parts) for name in PARTS}}


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
        for name, row in result["commands"].items()
    ]
    parts = [[name, f"{1e3 * seconds:.0f}"] for name, seconds in result["parts"].items()]
    return "\n\n".join(
        [
            table(["command", "best, s", "median, s"], rows),
            f"Where the time of `omnisim run {EXAMPLE}` goes, beside the start of Python, one after the other:",
            table(["part", "median, ms"], parts),
        ]
    )


def claims(result: dict) -> list[Claim]:
    commands = result["commands"]
    failed = sum("failed" in row for row in commands.values())
    found = [Claim("commands that fail", failed, "at most", 0, 0)]
    run, numba = commands[f"omnisim run {EXAMPLE}"], commands["import numba"]
    if not failed:
        taken = run["best"] - numba["best"]
        text = f"s that `omnisim run {EXAMPLE}` takes from the second time on, beside `import numba`"
        found.append(Claim(text, taken, "at most", 0.6, 3.0))
    return found
