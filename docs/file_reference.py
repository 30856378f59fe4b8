"""Writes docs/pages/file.md, what a trajectory file holds, from omnisim/results/layout.py: python -m docs.file_reference"""

from pathlib import Path

from omnisim.base.trajectory_file import FORMAT
from omnisim.results.layout import ATTRIBUTES, LABELS, OPTIONAL_ATTRIBUTES, TABLE, Quantity

PAGE = Path(__file__).parent / "pages/file.md"
INTRODUCTION = f"""# Trajectory file

Written by `python -m docs.file_reference` from the table that checks every trajectory.

A run is one HDF5 file (format `{FORMAT}`). Every dataset has `units`, a `description`, and a dimension scale on each
axis, so that HDF5 tools, netCDF and xarray all read it. Numbers are float64 or int64 and always finite, text is UTF-8.
Angles are continuous, never wrapped. A row at the instant of an event holds the state after it. A run that stops early
has the rows it reached, and a `stop` event.

## What happens to it

- Written whole or not at all: beside it first, then under its name. `run`, `export`, `view`, `plot` and `wheel` replace a file
  only with `--force`, `Trajectory.save` and `omnisim.export.write` only with `overwrite=True`.
- On a full disk what was there stays as it was, and the message names the path. A run that its file does not take is
  kept under a free name in the current folder, or else the temporary one; the message says where, the exit code is 1.
- One writer at a time: while a command runs its output is reserved (a lock on a hidden file beside it), and a second command
  that is to write it says so. A crash leaves no reservation behind.
- Checked when it is opened: numbers carry HDF5's fletcher32, a dataset of text the CRC-32 of its characters as the attribute
  `crc32`, the scene as `scene_crc32` of the root: of texts in UTF-8, each followed by a zero byte. A flipped bit is reported
  with the name of the dataset. Large datasets are in chunks of rows of about 1 MB. It takes HDF5 1.10 (of 2016) to read the
  file, whose metadata have checksums as well. Files of earlier versions, without any, still open.
- It runs again: `omnisim run youbot.h5` simulates the scene in it, with `--set` as you like, and writes `youbot_again.h5`.

T is the number of output times, N_r that of rollers of a wheel, E that of events. NAME is the name of a wheel.
"""
MEANING = {
    "format": "what the file is", "format_version": "of the format", "omnisim_version": "that wrote it",
    "title": "of the scene", "scene": "the whole TOML text with all overrides: loading it repeats the run",
    "wheels": "names, in the order of the scene", "model": "what is modelled, in one line",
    "tracking": "of the contact", "method": "as used", "step": "s", "steps": "taken",
    "rhs_evaluations": "calls of the right-hand side", "wall_time": "of the march, s",
    "status": "`complete`, or a sentence that says why the run stopped", "stop_time": "last time reached, s",
    "stop_wheel": "wheel that stopped the run, or empty", "error_target": "`solver.error` of the scene",
    "error_estimate": "estimated error, m or rad", "formulation": "of the equations of motion",
}  # fmt: skip
SIZES = {"time": "T", "event": "E", "roller": "N_r"} | {axis: str(len(labels)) for axis, labels in LABELS.items()}
GROUPS = {
    "": "Scales of the root", "body": "Body", "odometry": "Odometry", "wheels/{wheel}": "Wheels",
    "wheels/{wheel}/rollers": "Rollers", "constraints": "Constraints", "energy": "Energy", "events": "Events",
}  # fmt: skip
EXTREMES = """
## Extremes of the march

What peaks between two rows is in no row. So `interval_max/PATH` and, of what has a sign, `interval_min/PATH` hold the
largest and the least value that a quantity took in any accepted step and after any event since the row before, both
rows included; row 0 has those of the start. They do not depend on `output_interval`, and see what the step sees: halve
the step to learn what a peak still gains. Of vectors they hold the length. What happens after the last row of a run that
stopped early is in none of them.
"""


def page() -> str:
    """The whole page as Markdown."""
    lines = [INTRODUCTION, "## Attributes of the root\n", "| attribute | type | |", "| --- | --- | --- |"]
    for name, kind in ATTRIBUTES.items():
        where = " (where it applies)" if name in OPTIONAL_ATTRIBUTES else ""
        kind_name = "list of str" if kind is tuple else kind.__name__
        lines.append(f"| `{name}` | {kind_name} | {MEANING[name]}{where} |")
    for group, title in GROUPS.items():
        members = [row for row in TABLE if row.path.rpartition("/")[0] == group]
        lines += ["", f"## {title}\n", "| dataset | shape | units | |", "| --- | --- | --- | --- |"]
        lines += map(line, members)
    lines += [EXTREMES, "| dataset | shape | units | |", "| --- | --- | --- | --- |"]
    lines += [line(row) for row in TABLE if row.path.startswith("interval_")]
    return "\n".join([*lines, "", "Datasets in *italics* are only in files of scenes that have them.", ""])


def line(row: Quantity) -> str:
    path = row.path.format(wheel="NAME")
    shape = ", ".join(SIZES[axis.rpartition("/")[2]] for axis in row.axes)
    along = LABELS.get(row.path) if row.is_scale else None
    values = f": {', '.join(along)}" if along else ""
    name = f"*`{path}`*" if row.optional else f"`{path}`"
    return f"| {name} | ({shape}) | {row.units} | {row.description}{values} |"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
