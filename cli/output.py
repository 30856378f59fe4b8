"""Where a command may write: checked before it runs, and nothing is touched."""

import os
import tempfile
from pathlib import Path

from omnisim_cli.screen import BAD_INPUT, Failure


def output_path(text: str, source: str, force: bool) -> Path:
    """The output file, or Failure if what is made from `source` could not or should not be written there."""
    try:
        problem = obstacle(text, Path(os.path.realpath(text)), source, force)
    except OSError as error:
        problem = f"cannot write there: {error.strerror}"
    if problem:
        raise Failure(f"{text}: {problem}", BAD_INPUT)
    return Path(text)


def obstacle(text: str, target: Path, source: str, force: bool) -> str:
    """Why `target`, which `text` names, cannot be the output file; empty if it can. Or OSError."""
    if text.endswith(("/", os.sep)) or target.is_dir():
        return "a folder; the output needs the name of a file"
    if not target.parent.is_dir():
        return f"there is no folder {target.parent}"
    if target.exists():
        if not target.is_file():
            return "not a regular file"
        if os.path.exists(source) and os.path.samefile(source, target):
            return "the input itself; choose another output file"
        if not force:
            return "exists already; --force replaces it"
    with tempfile.TemporaryFile(dir=target.parent):
        return ""
