"""Files are written whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Mapping
from pathlib import Path


def write_whole(images: Mapping[Path, bytes | memoryview]) -> None:
    """Write what each file is to hold; whatever goes wrong, files that were there stay as they were.

    Temporary files are written beside them, are made sure to be on the disk, and take their places when all are there.
    Raises OSError with the path and the reason (disk full, folder missing or read-only, not a regular file).
    """
    temporaries: dict[Path, Path] = {}
    try:
        for path, image in images.items():
            target = _target(path)
            temporaries[path] = target.with_name(f".omnisim-{secrets.token_hex(8)}.tmp")
            with open(temporaries[path], "xb") as file:
                file.write(image)
                file.flush()
                os.fsync(file.fileno())
        for path, temporary in temporaries.items():
            os.replace(temporary, _target(path))
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        for temporary in temporaries.values():
            temporary.unlink(missing_ok=True)


def _target(path: Path) -> Path:
    """The file behind a link, which keeps pointing there."""
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():
        code = errno.EISDIR if target.is_dir() else errno.EEXIST  # /dev/null must survive
        raise OSError(code, "not a regular file", str(path))
    return target
