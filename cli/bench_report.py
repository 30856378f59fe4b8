"""What `omnisim bench` tells: tables and a verdict on the screen, the same in Markdown, all numbers in JSON."""

import json
import os
import platform
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from itertools import groupby

from omnisim.base.formatting import columns, hanging
from omnisim.base.methods import TABLEAUX
from omnisim.run.work_precision import Precision, Row, Setting, fastest, finest_orders

FILES = ("report.json", "report.md", "work_precision.png", "work_precision.svg")
GOALS = (1e-6, 1e-9)
HEADER = (
    *("", "method", "tracking", "step, s", "error", "order", "s per s", "x real time"),
    *("whole, ms", "steps", "evaluations", "events"),
)
WORDS = 3  # columns of words, which stand to the left
LEGEND = (
    "error: the largest over all rows, of position (m), yaw and spin angles (rad). order: observed, from the next "
    "step longer by half or more. s per s: wall time of the march per simulated second. whole: wall time of the whole "
    "call. evaluations: right-hand sides. *: on the Pareto front, nobody is as fast and as accurate."
)


def shown(found: Precision) -> str:
    """One scene for the screen."""
    stopped = [hanging("stopped: ", reason) for reason in stops(found)]
    table = columns(aligned_right([HEADER, *cells(found)]))
    return "\n".join([headline(found), table, *stopped, hanging("", verdict(found))])


def headline(found: Precision) -> str:
    """Which motion, and by which reference it is judged."""
    config = found.scene.config
    what = f"{found.scene.source}, {config.friction.law} friction, {config.time.end:g} s, "
    return f"{what}{config.time.outputs + 1} rows, medians of {found.repeats}\n{trust(found)}"


def trust(found: Precision) -> str:
    by, confirmed_by, far = found.reference.by, found.reference.confirmed_by, found.reference.distance
    pair = f"{by.method} at {by.step:g} s, confirmed by {confirmed_by.method} at {confirmed_by.step:g} s"
    return f"reference: {pair} to {far:.1e}"


def cells(found: Precision) -> list[tuple[str, ...]]:
    """The rows of the table, HEADER's columns; what a run that stopped has not is a dash."""
    return [row_cells(row, found.reference.distance) for row in found.rows]


def row_cells(row: Row, trusted: float) -> tuple[str, ...]:
    work = str(row.steps), str(row.evaluations), str(row.events)
    start = "*" * row.front, row.method, row.tracking, f"{row.step:g}"
    if row.error is None:
        return (*start, "stopped", "-", "-", "-", "-", *work)
    order = "-" if row.order is None else f"{row.order:.2f}"
    speed = f"{row.march:.2e}", real_time(row), f"{1e3 * row.whole:.2f}"
    return (*start, error_text(row, trusted), order, *speed, *work)


def error_text(row: Row, trusted: float) -> str:
    """The error as far as the reference can tell it."""
    return f"<{trusted:.1e}" if row.error < trusted else f"{row.error:.1e}"


def real_time(row: Row) -> str:
    return f"{float(f'{1.0 / row.march:.3g}'):g}"


def aligned_right(rows: Sequence[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Cells of numbers filled up on the left."""
    widths = [0 if place < WORDS else max(map(len, column)) for place, column in enumerate(zip(*rows, strict=True))]
    return [tuple(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)) for row in rows]


def stops(found: Precision) -> Iterable[str]:
    """Why runs stopped early, in short: for each method and tracking what its shortest step among them says."""
    stopped = [row for row in found.rows if row.error is None]
    for (method, tracking), group in groupby(stopped, key=lambda row: row[:2]):
        rows = list(group)
        steps = ", ".join(f"{row.step:g}" for row in rows)
        yield f"{method}{how(tracking)} at {steps} s: {rows[-1].status.partition(';')[0]}"


def named(row: Row) -> str:
    return f"{row.method}{how(row.tracking)} at {row.step:g} s"


def verdict(found: Precision) -> str:
    """Two sentences: the fastest settings for the GOALS, and the observed orders of explicit methods."""
    best = "; ".join(f"below {goal:.0e}: {winner(found, goal)}" for goal in GOALS)
    orders = {key: order for key, order in finest_orders(found).items() if key[0] in TABLEAUX}
    told = ", ".join(f"{method}{how(tracking)} {order:.2f}" for (method, tracking), order in orders.items())
    return f"Fastest with errors {best}. Observed order at the finest pair of steps: {told or 'none can be told'}."


def winner(found: Precision, goal: float) -> str:
    row = fastest(found, goal)
    if row is None:
        return "none"
    return f"{named(row)}, {real_time(row)} times real time"


def how(tracking: str) -> str:
    return "" if tracking == "explicit" else f" ({tracking} tracking)"


# --- files ----------------------------------------------------------------------------------------


def as_markdown(measured: Sequence[Precision], pictured: bool) -> str:
    """The whole report as a page."""
    parts = ["# Speed against error", machine(), LEGEND.replace("*:", "\\*:")]
    if pictured:
        parts.append("![seconds per simulated second against error](work_precision.png)")
    for found in measured:
        parts += [f"## {title(found)}", *section(found)]
    return "\n\n".join(parts) + "\n"


def section(found: Precision) -> list[str]:
    """The paragraphs on one scene."""
    stopped = [f"- stopped: {reason}" for reason in stops(found)]
    return ["\n".join(["```", headline(found), "```"]), markdown_table(found), *stopped, verdict(found)]


def title(found: Precision) -> str:
    return f"{found.scene.name}, {found.scene.config.friction.law}"


def machine() -> str:
    """Where and with what it was measured."""
    engine = version("omnisim-engine")
    python = platform.python_version()
    return f"omnisim {engine}, Python {python}, {platform.system()} {platform.machine()}, {os.cpu_count()} cores"


def markdown_table(found: Precision) -> str:
    lines = [HEADER, ("---",) * WORDS + ("---:",) * (len(HEADER) - WORDS)]
    lines += [(cell.replace("*", "\\*"), *rest) for cell, *rest in cells(found)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def as_json(measured: Sequence[Precision]) -> str:
    """Every number, unrounded, with its unit in its key; null for what a run that stopped has not."""
    return json.dumps({"machine": machine(), "scenes": [scene_data(found) for found in measured]}, indent=1) + "\n"


def scene_data(found: Precision) -> dict:
    config = found.scene.config
    reference = found.reference
    return {
        "scene": found.scene.source,
        "title": config.title,
        "law": config.friction.law,
        "end_s": config.time.end,
        "output_interval_s": config.time.output_interval,
        "repeats": found.repeats,
        "reference": {
            "by": setting_data(reference.by),
            "confirmed_by": setting_data(reference.confirmed_by),
            "distance": reference.distance,
        },
        "rows": [row_data(row) for row in found.rows],
        "verdict": verdict(found),
    }


def setting_data(setting: Setting) -> dict:
    return {"method": setting.method, "tracking": setting.tracking, "step_s": setting.step}


def row_data(row: Row) -> dict:
    return {
        **setting_data(Setting(*row[:3])),
        "error": row.error,
        "observed_order": row.order,
        "wall_s_per_simulated_s": row.march,
        "whole_call_s": row.whole,
        "steps": row.steps,
        "rhs_evaluations": row.evaluations,
        "events": row.events,
        "pareto": row.front,
        "status": row.status,
    }
