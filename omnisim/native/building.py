"""From a scene to a shared library: kernels as object code, the C layer compiled beside it, both linked."""

import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from omnisim.base.methods import METHODS
from omnisim.base.version import VERSION
from omnisim.march.march import march
from omnisim.march.observation import observe
from omnisim.march.spatial_observation import observe_in_space
from omnisim.native.memory import Machine, Memory, machine_of
from omnisim.native.object_code import Entry, constant, object_code, targets
from omnisim.native.parameters import Parameter, parameters_of
from omnisim.native.sources import header
from omnisim.scene.problems import ConfigError
from omnisim.scene.scene import Scene, SceneError

COMPILERS = ("cc", "gcc", "clang")
# Signs of a product and a sum are not joined: what the layer tells is what omnisim tells.
COMPILE = ("-std=c99", "-O2", "-fPIC", "-fvisibility=hidden", "-fno-strict-aliasing", "-ffp-contract=off")
SOURCES = files("omnisim.native") / "c"


class NativeError(Exception):
    """A machine that cannot be made native code; the message is one line."""


class Built(NamedTuple):
    """A machine as object files. prefix: of its public names; identity: 16 hexadecimal digits that tell it from all
    others; known: scene.h."""

    machine: Machine
    memory: Memory
    parameters: list[Parameter]
    prefix: str
    identity: str
    objects: list[bytes]
    known: str


def compiler() -> list[str]:
    """The C compiler: $CC, or else the first there is. Raises NativeError if there is none."""
    chosen = os.environ.get("CC")
    for candidate in [shlex.split(chosen)] if chosen else [[name] for name in COMPILERS]:
        if candidate and shutil.which(candidate[0]):
            return candidate
    missing = f"CC names {chosen}, which is not there" if chosen else f"none of {', '.join(COMPILERS)} is there"
    raise NativeError(f"a C compiler is needed to make native code: {missing}; on Debian or Ubuntu: apt install gcc")


def source(name: str, prefix: str) -> str:
    """A source of the C layer in which all public names begin with the prefix in the place of "omnisim"."""
    text = (SOURCES / name).read_text(encoding="utf-8")
    text = text.replace('"machine.h"', f'"{prefix}.h"').replace("@PREFIX@", prefix)
    return re.sub(r"\bomnisim_", f"{prefix}_", text)


def native(scene: Scene) -> Machine:
    """The machine of a scene. Raises SceneError for one whose step is picked for an error, or that cannot begin."""
    config = scene.config
    if config.solver.error is not None:
        raise SceneError(
            f"{scene.source}: solver.error: native code marches with a step that is known; "
            "give time.step in its place (`omnisim run` tells the one that it picks)"
        )
    try:
        return machine_of(config, METHODS[config.solver.method].stages)
    except ConfigError as error:
        raise SceneError(scene.document.told(error.problems)) from None


def build(scene: Scene, prefix: str, cpu: str) -> Built:
    """The kernels of a scene, whose public names begin with the prefix; cpu: as `targets` takes it.

    Raises SceneError, and NativeError without a C compiler and on other systems than Linux.
    """
    if not sys.platform.startswith("linux"):
        raise NativeError("native code is made on Linux alone so far")
    compiler()
    machine = native(scene)
    if not hasattr(march, "compile"):
        raise NativeError("NUMBA_DISABLE_JIT is set: kernels have to be compiled")
    memory = Memory(machine)
    looked = observe if machine.parameters.space is None else observe_in_space
    entries = [Entry(f"{prefix}_march", march, machine.marched), Entry(f"{prefix}_observe", looked, machine.observed)]
    kinds = targets(cpu)
    objects = [*object_code(entries, memory, kinds), constant(f"{prefix}_start", memory.start)]
    identity = hashlib.sha256(b"".join([VERSION.encode(), *objects])).hexdigest()[:16]
    parameters = parameters_of(scene, machine.marched[1], memory)
    known = header(scene.config, machine, memory, parameters, identity, kinds)
    return Built(machine, memory, parameters, prefix, identity, objects, known.replace("omnisim_", f"{prefix}_"))


def shared_library(built: Built, layer: str | None = None, variables: str = "") -> bytes:
    """The library of a machine; with a layer, a source that speaks a standard, what it shows is what that exports.

    variables: a header that the layer includes. Raises NativeError without a C compiler.
    """
    command, prefix = compiler(), built.prefix
    sources = ["machine.c", *([layer] if layer else [])]
    hidden = [f"-D{prefix}_API="] if layer else []
    with tempfile.TemporaryDirectory(prefix="omnisim-") as name:
        folder = Path(name)
        kernels = [f"kernels{i}.o" for i in range(len(built.objects))]
        for own, image in zip(kernels, built.objects, strict=True):
            (folder / own).write_bytes(image)
        texts = {f"{prefix}.h": source("machine.h", prefix), "fmi.h": source("fmi.h", prefix), "scene.h": built.known}
        texts |= {"variables.h": variables} | {own: source(own, prefix) for own in sources}
        for own, text in texts.items():
            (folder / own).write_text(text, encoding="utf-8")
        called(command, folder, *COMPILE, *hidden, "-c", *sources)
        objects = [own.replace(".c", ".o") for own in sources]
        linked = "-shared", f"-Wl,-soname,lib{prefix}.so", *objects, *kernels, "-o", "machine.so", "-lm"
        called(command, folder, *linked)
        return (folder / "machine.so").read_bytes()


def called(command: list[str], folder: Path, *arguments: str) -> None:
    """Run the compiler. Raises NativeError with what it says first."""
    done = subprocess.run([*command, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        said = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr.strip())
        raise NativeError(f"{command[0]} cannot compile the C layer: {said}")
