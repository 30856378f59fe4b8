"""Where a run may write: checked before it runs, and nothing is touched."""

import os
import tempfile
from pathlib import Path

from omnisim_cli.screen import BAD_INPUT, Failure


def output_path(text: str, scene: str, force: bool) -> Path:
    """The output file, or Failure if a run of `scene` could not or should not write there."""
    try:
        problem = obstacle(text, Path(os.path.realpath(text)), scene, force)
    except OSError as error:
        problem = f"cannot write there: {error.strerror}"
    if problem:
        raise Failure(f"{text}: {problem}", BAD_INPUT)
    return Path(text)


def obstacle(text: str, target: Path, scene: str, force: bool) -> str:
    """Why `target`, which `text` names, cannot be the output file; empty if it can. Or OSError."""
    if text.endswith(("/", os.sep)) or target.is_dir():
        return "a folder; -o takes the name of a file"
    if not target.parent.is_dir():
        return f"there is no folder {target.parent}"
    if target.exists():
        if not target.is_file():
            return "not a regular file"
        if os.path.exists(scene) and os.path.samefile(scene, target):
            return "the scene itself; choose another output file"
        if not force:
            return "exists already; --force replaces it, -o FILE writes to another"
    with tempfile.TemporaryFile(dir=target.parent):
        return ""
