"""Kernels compiled before they are needed: once for every kind of scene, in processes side by side.

All scenes of one kind share all kernels, whatever their numbers: a kind is which parts of Parameters and Run are there,
and whether the machine has anything that few have.
What marches and observes machines side by side is left to the first environment of a kind, which compiles it in 10 to
15 s: no other room needs it.
"""

import ast
import inspect
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from itertools import product
from os import PathLike
from typing import NamedTuple

from omnisim.base.kernel import Kernel
from omnisim.base.methods import EXPLICIT
from omnisim.base.records import lean
from omnisim.contact.roller_profile import length, profile_radius, tip_radius
from omnisim.dynamics.packing import pack
from omnisim.dynamics.parameters import SELDOM
from omnisim.march.march import march
from omnisim.march.observation import observe
from omnisim.march.stiffness import explanation, resolve
from omnisim.run.loop import Loop
from omnisim.run.timing import tracking_cost
from omnisim.scene.scene import Scene, SceneError, as_scene, load

BRIEF = ("time.end=0.01", "time.step=0.001", "time.output_interval=0.01")
SMALL, FREE = "six_rollers", "kiwi_ramp"  # scenes, made of any kind: one held upright, one free in space
RESISTED = "wheel_types.omni.roller.rolling_resistance=1e-3"  # of these: few machines have that
FORMULATIONS, LAWS, METHODS = ("reduced", "multibody"), ("regularized", "coulomb"), ("rk4", "radau5")
POLLED = 0.05  # s, between two looks at what compiles
WORKER = "import sys; from omnisim.run.warming import compile_now; compile_now(sys.argv[1:])"


class Kind(NamedTuple):
    """What kernels are compiled for."""

    multibody: bool = False
    set_valued: bool = False  # friction
    implicit: bool = False  # steps, all or some
    free: bool = False  # in space
    seldom: bool = False  # the machine has anything SELDOM

    def __str__(self) -> str:
        what = "the multibody formulation" if self.multibody else "the reduced formulation"
        if self.free:
            what = "machines free in space"
        friction = "set-valued friction" if self.set_valued else "smooth friction"
        told = f"{what} with {friction} and {'implicit' if self.implicit else 'explicit'} steps"
        if self.seldom and not self.multibody:
            told += ", of machines with motors, friction in bearings or the like"
        return told

    @property
    def overrides(self) -> tuple[str, ...]:
        """Those that make the small scene one of this kind."""
        return (
            *BRIEF,
            f"solver.formulation={FORMULATIONS[self.multibody]}",
            f"friction.law={LAWS[self.set_valued]}",
            f"solver.method={METHODS[self.implicit]}",
            *((RESISTED,) if self.seldom else ()),
        )

    @property
    def scene(self) -> Scene:
        """A small one of this kind. Raises SceneError if there is none."""
        return load(FREE if self.free else SMALL, self.overrides)


def kind_of(scene: Scene) -> Kind:
    parameters = pack(scene.config)
    there = parameters.workspace.articulated is not None, parameters.workspace.resting is not None
    seldom = not lean(parameters.machine.dtype)
    return Kind(*there, resolve(scene.config, parameters) != EXPLICIT, parameters.space is not None, seldom)


def kinds() -> Iterator[Kind]:
    """All that a scene can be of."""
    for flags in product((False, True), repeat=len(Kind._fields)):
        kind = Kind(*flags)
        try:
            scene = kind.scene
        except SceneError:  # not every formulation has every method
            continue
        if kind_of(scene) == kind:  # bodies are nothing that many have
            yield kind


def warm(
    scenes: Iterable[Scene | str | PathLike[str]] | None = None,
    progress: Callable[[Kind], object] | None = None,
    processes: int | None = None,
) -> list[Kind]:
    """Compile what runs of these scenes need, or all that there is, unless it is on disk already: their kinds.

    progress: called with a kind when it is done. processes: at once, by default as many as there are processors.
    Raises RuntimeError if one of them fails.
    """
    found = kinds() if scenes is None else dict.fromkeys(kind_of(as_scene("warm", scene)) for scene in scenes)
    wanted = list(found)
    running = dict[subprocess.Popen[bytes], Kind]()
    waiting = list(wanted)  # neighbours have little in common that both would compile
    most = processes or os.cpu_count() or 1
    while waiting or running:
        while waiting and len(running) < most:
            kind = waiting.pop(0)
            flags = [str(int(flag)) for flag in kind]
            running[subprocess.Popen([sys.executable, "-c", WORKER, *flags])] = kind
        child = first_to_end(running)
        kind = running.pop(child)
        if child.returncode:
            for other in running:
                other.terminate()
            raise RuntimeError(f"compiling kernels for {kind} failed")
        if progress:
            progress(kind)
    return wanted


def first_to_end(running: Iterable[subprocess.Popen[bytes]]) -> subprocess.Popen[bytes]:
    """The process that ends next."""
    while True:
        for child in running:
            if child.poll() is not None:
                return child
        time.sleep(POLLED)


def compile_now(flags: Iterable[str]) -> None:
    """Compile, in this process, what scenes of the kind with these flags, "0" or "1", need."""
    scene = Kind(*(flag == "1" for flag in flags)).scene
    Loop(scene).trajectory()
    parameters = pack(scene.config)
    explanation(scene.config, parameters)
    if parameters.space is None:
        tracking_cost(scene)
    for size in (length, tip_radius):
        size(parameters.wheels[0])
    profile_radius(parameters.wheels[0], 0.0)


def kernels_of(kind: Kind) -> set[Kernel]:
    """About those that are compiled for a run of this kind: all that march and observation reach in their sources but
    for branches that ask for what is not there."""
    *parts, seldom = kind
    there = dict(zip(("articulated", "resting", "newton", "space"), parts, strict=True))
    there |= {} if seldom else dict.fromkeys(SELDOM, False)
    found: set[Kernel] = set()
    waiting = [kernel for kernel in (march, observe) if isinstance(kernel, Kernel)]  # compilation may be switched off
    while waiting:
        kernel = waiting.pop()
        if kernel not in found:
            found.add(kernel)
            source = Names(there)
            source.visit(ast.parse(inspect.getsource(kernel.py_func)))
            values = map(kernel.py_func.__globals__.get, source.names)
            waiting += [value for value in values if isinstance(value, Kernel)]
    return found


class Names(ast.NodeVisitor):
    """The names in a source but for those in branches that are never taken; there: by member whether it is not None, or
    not 0."""

    def __init__(self, there: dict[str, bool]):
        self.there = there
        self.names = set[str]()

    def visit_Name(self, node: ast.Name) -> None:
        self.names.add(node.id)

    def visit_If(self, node: ast.If) -> None:
        known = self.decided(node.test)
        if known is None:
            self.visit(node.test)
        for part in [*node.body] * (known is not False) + [*node.orelse] * (known is not True):
            self.visit(part)

    def decided(self, test: ast.expr) -> bool | None:
        """Whether a condition holds, None if that is not known from what is there."""
        if isinstance(test, ast.BoolOp):
            parts = [self.decided(part) for part in test.values]
            ending = isinstance(test.op, ast.Or)
            if ending in parts:
                return ending
            return None if None in parts else not ending
        if isinstance(test, ast.Attribute):
            return self.there.get(test.attr)
        if isinstance(test, ast.Compare) and isinstance(test.left, ast.Attribute) and test.left.attr in self.there:
            return self.there[test.left.attr] == isinstance(test.ops[0], ast.IsNot)
        return None
