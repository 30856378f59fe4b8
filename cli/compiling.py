"""What a user sees while kernels are compiled: for what, and how far it is."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from . import screen

if TYPE_CHECKING:
    from omnisim.scene.scene import Scene

WIDTH = 36
PATIENCE = 1.0  # s of compiling before there is a bar


class Bar:
    """Kernels done of those expected, on one line of stderr, if that is a terminal.

    It leaves the cursor alone: Ctrl-C may end the process at any time.
    """

    def __init__(self, expected: frozenset[Any]):
        self.expected = expected
        self.begun = time.perf_counter()
        self.drawn = False

    def draw(self) -> None:
        if time.perf_counter() - self.begun < PATIENCE or not (sys.stderr and sys.stderr.isatty()):
            return
        done, total = sum(bool(kernel.overloads) for kernel in self.expected), len(self.expected)
        filled = "#" * (WIDTH * done // total)
        self._write(f"\r  [{filled:-<{WIDTH}}] {done} of about {total} kernels")
        self.drawn, screen.unfinished_lines = True, 1

    def end(self) -> None:
        if self.drawn:
            self._write("\n")
        screen.unfinished_lines = 0

    def _write(self, text: str) -> None:
        stream = getattr(sys.stderr, "stream", sys.stderr)
        with suppress(OSError):  # the terminal is closed
            stream.write(text)
            stream.flush()


@contextmanager
def compilation_noted(scenes: Iterable[Scene], quiet: bool = False) -> Iterator[None]:
    """Says so, once, when Numba begins to compile a kernel that its cache does not hold, and for what kind of scene;
    then shows a bar for each long compilation."""
    from numba.core import event

    class Announcement(event.Listener):
        noted, depth, bar = False, 0, None

        def on_start(self, _: event.Event) -> None:
            self.depth += 1
            if self.depth == 1:  # to tell the kind of a scene may compile a kernel itself
                self.begin()

        def on_end(self, _: event.Event) -> None:
            self.depth -= 1
            if self.bar:
                self.bar.draw()
                if not self.depth:
                    self.bar.end()

        def begin(self) -> None:
            from omnisim.run.warming import kernels_of, kind_of

            kinds = list(dict.fromkeys(map(kind_of, scenes)))
            if not self.noted:
                screen.note(f"compiling kernels for {', then for '.join(map(str, kinds))}: once, about a minute")
            self.noted = True
            self.bar = Bar(frozenset().union(*map(kernels_of, kinds)))

    if quiet:
        yield
        return
    with event.install_listener("numba:compile", Announcement()):
        yield
