"""Files are written whole or not at all, by one process at a time, and read only as far as they may be long."""

from __future__ import annotations

import errno
import hashlib
import os
import secrets
import select
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    from fcntl import LOCK_EX, LOCK_NB, flock
except ImportError:  # no POSIX: files are not reserved there
    flock = None  # type: ignore[assignment]

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"
SILENCE = 2.0  # s that a pipe without a writer is waited for
UNLINKED = (errno.EPERM, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EMLINK)  # where there are no hard links
_reserved: dict[Path, Path] = {}  # the lock of each target that this process has reserved

# --- reading --------------------------------------------------------------------------------------


def read_small(path: Path, most: int) -> bytes:
    """What a file or a pipe holds. Raises OSError: more than `most` bytes, a device, a pipe that nobody writes to."""
    descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with open(descriptor, "rb", buffering=0) as file:
        found = os.fstat(descriptor)
        if stat.S_ISDIR(found.st_mode):
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        if not (stat.S_ISREG(found.st_mode) or stat.S_ISFIFO(found.st_mode)):
            raise OSError(errno.EINVAL, "not a regular file")
        if stat.S_ISFIFO(found.st_mode):
            _await(descriptor)
        content = b"" if found.st_size > most else file.read(most + 1)
        if found.st_size > most or len(content) > most:
            raise OSError(errno.EFBIG, f"it has more than {most / 1e6:.1f} MB")
        return content


def _await(pipe: int) -> None:
    """Wait for what is written into a pipe, and for ever if there is a writer."""
    if not select.select([pipe], [], [], SILENCE)[0]:
        try:
            if not os.read(pipe, 1):
                raise OSError(errno.EPIPE, "a pipe that nobody writes to")
        except BlockingIOError:
            pass
    os.set_blocking(pipe, True)


def is_hdf5(path: str | os.PathLike[str]) -> bool:
    """Whether a file begins as HDF5 does, whatever its suffix; False for one that is none or cannot be read."""
    if not os.path.isfile(path):
        return False
    try:
        with open(path, "rb") as file:
            return file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except OSError:
        return False


def holds(path: Path, image: bytes) -> bool:
    """Whether a file is there already, just as it would be written."""
    return path.is_file() and path.read_bytes() == image


# --- writing --------------------------------------------------------------------------------------


def write_whole(images: Mapping[Path, bytes | memoryview], overwrite: bool) -> None:
    """Write what each file is to hold; whatever goes wrong, files that were there stay as they were.

    Temporary files are written beside them, are made sure to be on the disk, and take their places when all are there.
    Raises OSError with the path and the reason (disk full, folder missing or read-only, not a regular file), and
    FileExistsError unless it may overwrite.
    """
    temporaries: dict[Path, Path] = {}
    new: list[Path] = []
    try:
        for path, image in images.items():
            target = _target(path, overwrite)
            temporaries[path] = target.with_name(f".omnisim-{secrets.token_hex(8)}.tmp")
            with open(temporaries[path], "xb") as file:
                file.write(image)
                file.flush()
                os.fsync(file.fileno())
        for path, temporary in temporaries.items():
            if overwrite:
                os.replace(temporary, _target(path, overwrite))
            else:
                _place(temporary, _target(path, overwrite))
                new.append(_target(path, True))
    except BaseException as error:
        for target in new:  # of several files all or none
            target.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


def _target(path: Path, overwrite: bool) -> Path:
    """The file behind a link, which keeps pointing there."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        code = errno.EISDIR if target.is_dir() else errno.EINVAL  # /dev/null must survive
        raise OSError(code, "not a regular file", str(path))
    if not overwrite and target.exists():
        raise FileExistsError(errno.EEXIST, "exists already; overwrite=True replaces it", str(path))
    return target


def _place(temporary: Path, target: Path) -> None:
    """Give the file its name; FileExistsError even if another process was quicker by a moment."""
    try:
        os.link(temporary, target)
    except OSError as error:
        if error.errno not in UNLINKED:
            raise
        os.rename(temporary, target)


# --- one writer at a time -------------------------------------------------------------------------


@contextmanager
def reserved(path: Path) -> Iterator[None]:
    """No other process gets this reservation of an output file meanwhile. Raises OSError with the process that has it.

    What counts is the lock on a hidden file beside it, not that file: the system takes the lock from a process that
    dies, so what a crash leaves behind is in nobody's way.
    """
    target = Path(os.path.realpath(path))
    lock = target.with_name(f".omnisim-{hashlib.sha256(os.fsencode(target.name)).hexdigest()[:16]}.lock")
    if flock is None or target in _reserved:
        yield
        return
    descriptor = _locked(lock, path)
    _reserved[target] = lock
    try:
        yield
    finally:
        lock.unlink(missing_ok=True)
        os.close(descriptor)
        _reserved.pop(target, None)


def release_all() -> None:
    """Take away the hidden files of all reservations: for a process that ends without further ado."""
    for lock in _reserved.values():
        with suppress(OSError):
            lock.unlink()


def _locked(lock: Path, path: Path) -> int:
    """A descriptor of the hidden file, with the lock on it."""
    while True:
        try:
            descriptor = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
        except PermissionError:  # what another user's crash has left behind
            descriptor = os.open(lock, os.O_RDONLY)
        try:
            flock(descriptor, LOCK_EX | LOCK_NB)
            mine = os.path.exists(lock) and os.path.samestat(os.fstat(descriptor), os.stat(lock))
        except BlockingIOError:
            who = os.read(descriptor, 20).decode("ascii", "replace")
            os.close(descriptor)
            raise OSError(errno.EBUSY, f"another omnisim (process {who}) is about to write it", str(path)) from None
        except FileNotFoundError:
            mine = False
        except OSError:  # a file system without locks
            return descriptor
        if mine:
            break
        os.close(descriptor)  # its owner has just taken it away
    with suppress(OSError):  # a full disk has no room for the number, and needs none
        os.ftruncate(descriptor, 0)
        os.write(descriptor, str(os.getpid()).encode())
    return descriptor
