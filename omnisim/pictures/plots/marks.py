"""Events as marks: what each kind looks like, and how many of many are drawn."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from omnisim.base.status import EVENT_KINDS
from omnisim.pictures.plots.style import QUIET, Runs

MARKERS = {
    "exchange": ".", "stick": "v", "slip": "^", "lift_off": "P", "touch_down": "X",
    "share_begin": "<", "share_end": ">", "stop": "s", "contact_begin": ".", "contact_end": ".",
}  # fmt: skip
OFTEN = ("exchange", "contact_begin", "contact_end")  # at every roller


def kinds_of(runs: Runs) -> list[str]:
    """The kinds of events that the runs have."""
    return [kind for kind in EVENT_KINDS if any(kind in run["events/kind"] for run in runs.values())]


def mark(kind: str, colour: str) -> dict[str, Any]:
    """Those at every roller, which are many, are small and grey."""
    if kind in OFTEN:
        return {"marker": MARKERS[kind], "markersize": 4, "color": QUIET}
    edge = {"markeredgecolor": colour, "markeredgewidth": 0.7}
    return {"marker": MARKERS[kind], "markersize": 4.5, "markerfacecolor": "white", **edge}


def stride(counts: Sequence[int], most: int) -> int:
    """Every so many of each of some series of marks is drawn, so that each has about `most` of them."""
    return -(-max(counts, default=0) // most) or 1


def thinned(values: np.ndarray, every: int) -> np.ndarray:
    """Every so many of some values, the first and the last among them."""
    last = len(values) - 1
    return values[np.unique(np.append(np.arange(0, last + 1, every), last))] if every > 1 else values


def named(kind: str, every: int, count: int, between: str = ", ") -> str:
    """A kind of events for a legend; where not all are drawn, how many are."""
    name = kind.replace("_", " ")
    return name if every == 1 else f"{name}{between}every {ordinal(every)} of {count}"


def ordinal(number: int) -> str:
    """1st, 2nd, 3rd, 4th, ..."""
    ending = "th" if number // 10 % 10 == 1 else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"
