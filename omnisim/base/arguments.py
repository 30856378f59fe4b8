"""Arguments of public functions that cannot be meant: one sentence each, before anything runs."""

import math
import os
from typing import Any


def shown(value: Any) -> str:
    """A value of the wrong kind, short, and what it is."""
    text = repr(value)
    return f"{text if len(text) <= 60 else text[:57] + '...'} ({type(value).__name__})"


def path_text(function: str, value: Any, wanted: str = "a path") -> str:
    """A path as text. Raises TypeError for anything else: open() would take 3 for a file that is open already."""
    text = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(text, str):
        raise TypeError(f"{function} takes {wanted}, not {shown(value)}")
    return text


def number(what: str, value: Any) -> float:
    """A number. Raises TypeError for what is none."""
    try:
        if not isinstance(value, str | bytes | bool):
            return float(value)
    except (TypeError, ValueError):
        pass
    raise TypeError(f"{what} must be a number, not {shown(value)}")


def finite(what: str, value: Any) -> float:
    """A finite number. Raises TypeError for what is no number, ValueError for one that is not finite."""
    found = number(what, value)
    if not math.isfinite(found):
        raise ValueError(f"{what} must be a finite number, not {found}")
    return found


def callable_or_none(function: str, name: str, value: Any, takes: str) -> None:
    """Raises TypeError unless the argument is a function or None."""
    if value is not None and not callable(value):
        raise TypeError(f"{function}: {name} must be a function of {takes}, not {shown(value)}")
