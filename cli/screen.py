"""What a user sees besides results: messages, failures, the progress of a run. And only sees: see `Shown`."""

import os
import signal
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from typing import Any, Self, TextIO

import click

from omnisim.base.formatting import visible

STOPPED, BAD_INPUT = 1, 2  # exit codes
BAR_LENGTH = 1000
unfinished_lines = 0  # on the terminal: 1 while a bar is drawn that a message must not continue
ENDING = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]


class Shown:
    """A text stream for people: what would act on their terminal is written out, what it has no letters for too.

    All that a command prints goes through here, so no title, name or path in a message needs to be thought of. Tabs
    and newlines pass. `stream` is for what is meant to act, the progress bar.
    """

    def __init__(self, stream: TextIO, lenient: bool):
        self.stream, self.lenient = stream, lenient
        self.over = False  # the command has ended; what comes now is colorama's, which resets the colours at exit

    def write(self, text: str) -> int:
        if self.over:
            return len(text)
        shown = visible(text, but="\t\n")
        encoding = self.stream.encoding or "utf-8"
        with self._errors():
            self.stream.write(shown.encode(encoding, "backslashreplace").decode(encoding))
        return len(text)

    def flush(self) -> None:
        with self._errors():
            self.stream.flush()

    def _errors(self) -> Any:
        """Nobody who reads messages any more is no reason to lose a run; a result that cannot be told is an error."""
        return suppress(OSError) if self.lenient else nullcontext()

    def __getattr__(self, name: str) -> Any:
        if name == "buffer":
            raise AttributeError(name)  # there is no way around this
        return getattr(self.stream, name)


@contextmanager
def shown() -> Iterator[None]:
    """stdout and stderr are Shown in this block."""
    before = sys.stdout, sys.stderr
    inside = [stream and Shown(stream, lenient) for stream, lenient in zip(before, (False, True), strict=True)]
    sys.stdout, sys.stderr = inside
    try:
        yield
    finally:
        if sys.stdout is inside[0]:  # click replaces one that nobody reads
            sys.stdout = before[0]
        sys.stderr = before[1]
        for stream in filter(None, inside):
            stream.over = True


class Failure(click.ClickException):
    """A message for the user, and the exit code."""

    def __init__(self, message: str, exit_code: int = STOPPED):
        super().__init__(message)
        self.exit_code = exit_code  # type: ignore[misc]  # click means it so

    def format_message(self) -> str:
        return self.message.replace("\n", "\n       ")  # below what follows "Error: "


def note(text: str) -> None:
    """A message on stderr, out of the way of results."""
    click.echo(text, err=True)


def warn(lines: Iterable[str]) -> None:
    """What is doubtful, one line each on stderr."""
    for line in lines:
        note(f"Warning: {line}")


def leave_at_once(*_: object) -> None:
    """Handler of Ctrl-C while there is nothing to save.

    The process ends here: KeyboardInterrupt would be lost in callbacks of the compiler, with a traceback.
    """
    if "omnisim.base.files" in sys.modules:
        sys.modules["omnisim.base.files"].release_all()
    with suppress(OSError):
        os.write(2, b"\n" * unfinished_lines + b"Error: interrupted; nothing was written\n")
    os._exit(STOPPED)


class StopWish:
    """Takes Ctrl-C or SIGTERM as a wish to `stop`, between `listen` and the end of the `with` block."""

    def __init__(self) -> None:
        self.stop = False
        self.handlers: dict[int, Any] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, exception: type[BaseException] | None, *_: object) -> None:
        for number, handler in self.handlers.items():
            signal.signal(number, handler)

    def listen(self) -> None:
        for number in ENDING:
            if signal.getsignal(number) != signal.SIG_IGN:  # a background job keeps ignoring Ctrl-C
                self.handlers[number] = signal.signal(number, self._on_signal)

    def _on_signal(self, *_: object) -> None:
        again = self.stop
        self.stop = True
        if again:
            self.give_up()

    def give_up(self) -> None:
        """At the second signal."""
        raise KeyboardInterrupt


class Progress(StopWish):
    """Follows a run: shows a bar if stderr is a terminal, and takes Ctrl-C or SIGTERM as a wish to stop.

    The signals are taken from the first call on, when the kernels are ready, to the end of the `with` block,
    which includes saving. A second one gives up.
    """

    def __init__(self, quiet: bool):
        super().__init__()
        self.quiet = quiet
        self.bar: Any = None  # of click
        self.begun = self.given_up = False

    def __call__(self, fraction: float) -> bool:
        """Whether to stop; called by `simulate` with the fraction done."""
        if not self.begun:
            self._begin()
        if self.bar:
            done = int(BAR_LENGTH * fraction)
            with suppress(OSError):  # the terminal is closed
                if done < self.bar.pos:  # another run, in search of a step
                    self._show_bar()
                self.bar.update(done - self.bar.pos)
        if self.stop and fraction < 1.0:
            self._end_bar()
            if not self.quiet:
                note("stopping, and writing what was computed; another Ctrl-C gives up")
        return self.stop

    def __exit__(self, exception: type[BaseException] | None, *rest: object) -> None:
        super().__exit__(exception, *rest)
        self._end_bar()
        if self.given_up and exception:  # of any kind: HDF5 turns an interrupt within into an error of its own
            raise Failure("interrupted; nothing was written") from None

    def _begin(self) -> None:
        self.begun = True
        self.listen()
        if is_watched(self.quiet):
            self._show_bar()

    def _show_bar(self) -> None:
        self.bar = click.progressbar(length=BAR_LENGTH, file=getattr(sys.stderr, "stream", sys.stderr))

    def _end_bar(self) -> None:
        if self.bar:
            with suppress(OSError):
                self.bar.render_finish()
        self.bar = None

    def give_up(self) -> None:
        self.given_up = True
        super().give_up()


def is_watched(quiet: bool) -> bool:
    """Whether somebody sees a bar."""
    return not quiet and bool(sys.stderr) and sys.stderr.isatty()
