"""Where a command may write: checked before it runs, when nothing is touched. And how: whole or not at all."""

import os
import signal
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

import click

from omnisim.base.formatting import visible

from .screen import BAD_INPUT, ENDING, Failure


def megabytes(path: Path) -> str:
    """The size of a file, for people: two digits, and no powers of ten."""
    return f"{float(f'{path.stat().st_size / 1e6:.2g}'):g} MB"


def output_path(text: str, source: str, force: bool) -> Path:
    """The output file, or Failure if what is made from `source` could not or should not be written there.

    While the command runs the file is its own: another one that is to write it fails.
    """
    from omnisim.base.files import reserved

    context = click.get_current_context()
    try:
        problem = obstacle(text, Path(os.path.realpath(text)), source, force)
        if not problem:
            context.with_resource(reserved(Path(text)))
    except OSError as error:
        problem = f"cannot write there: {error.strerror}"
    if problem:
        raise Failure(f"{visible(text)}: {problem}", BAD_INPUT)
    return Path(text)


def obstacle(text: str, target: Path, source: str, force: bool) -> str:
    """Why `target`, which `text` names, cannot be the output file; empty if it can. Or OSError."""
    if text.endswith(("/", os.sep)) or target.is_dir():
        return "a folder; the output needs the name of a file"
    if not target.parent.is_dir():
        return f"there is no folder {visible(str(target.parent))}"
    if target.exists():
        if not target.is_file():
            return "not a regular file"
        if os.path.exists(source) and os.path.samefile(source, target):
            return "the input itself; choose another output file"
        if not force:
            return "exists already; --force replaces it"
    with tempfile.TemporaryFile(dir=target.parent):
        return ""


def output_folder(text: str, names: Iterable[str], force: bool) -> Path:
    """The folder for files of these names, or Failure if they could or should not be written there."""
    folder = Path(text)
    shown = visible(text)
    if folder.exists() and not folder.is_dir():
        raise Failure(f"{shown}: not a folder", BAD_INPUT)
    if not folder.absolute().parent.is_dir():
        raise Failure(f"{shown}: there is no folder {visible(str(folder.parent))}", BAD_INPUT)
    there = [name for name in names if (folder / name).exists()]
    if there and not force:
        raise Failure(f"{visible(str(folder / there[0]))}: exists already; --force replaces it", BAD_INPUT)
    return folder


def deliver_into(folder: Path, images: Mapping[Path, bytes], force: bool) -> None:
    """The same as `deliver` for files in a folder, which is made if need be."""
    new = not folder.exists()
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise Failure(f"{visible(str(folder))}: cannot be made: {error.strerror}") from None
    try:
        deliver(images, force)
    except Failure:
        if new:
            with suppress(OSError):
                folder.rmdir()
        raise


def deliver(images: Mapping[Path, bytes], force: bool) -> None:
    """Write what files are to hold; Failure with the path of the one that cannot be written, and then none is."""
    from omnisim.base.files import write_whole

    with interruptible():
        try:
            write_whole(images, overwrite=force)
        except OSError as error:
            raise Failure(unwritten(error, next(iter(images)))) from None


def unwritten(error: Exception, path: Path) -> str:
    """What to say of a file that could not be written, `path` unless the error names another one."""
    path = getattr(error, "filename", None) or path
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    if isinstance(error, FileExistsError):
        reason = "another process has made it meanwhile"
    return f"{visible(str(path))}: cannot be written: {reason}"


@contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C and SIGTERM clean up in this block, and leave no file."""

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    numbers = [n for n in ENDING if signal.getsignal(n) != signal.SIG_IGN]
    handlers = {number: signal.signal(number, interrupted) for number in numbers}
    try:
        yield
    except KeyboardInterrupt:
        raise Failure("interrupted; nothing was written") from None
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
