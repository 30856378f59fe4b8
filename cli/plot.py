"""`omnisim plot`: pictures of trajectory files."""

from __future__ import annotations

from collections.abc import Collection
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import click

from omnisim.base.formatting import visible

from .screen import BAD_INPUT, Failure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from omnisim.results.trajectory import Trajectory
    from omnisim.studies.result import StudyResult

VIEWS = (
    "story", "path", "drives", "contact", "slip", "forces", "ride", "rollers", "ripple", "odometry", "energy",
    "bearings", "trackings",
)  # fmt: skip
STUDY = "omnisim-study"
FORMATS = (".png", ".svg", ".pdf")
NO_WINDOW = "no display to open a window on; -o FILE writes the picture to a file"


@click.command()
@click.argument("files", metavar="FILE...", nargs=-1, required=True)
@click.option("--view", metavar="NAME", type=click.Choice(VIEWS), default="story", help=f"One of {', '.join(VIEWS)}.")
@click.option("-o", "output", metavar="OUT", help=f"Picture to write, {', '.join(FORMATS)}; else a window opens.")
@click.option("--force", is_flag=True, help="Replace a picture that exists.")
def plot(files: tuple[str, ...], view: str, output: str | None, force: bool) -> None:
    """Show the trajectory in FILE: by default its story on one page, or a single view. Of the file of a study, what its
    runs have measured, over the keys that it varies.

    Several files are laid over each other. `trackings` compares two, as the paper's figures 5 to 7 do; `bearings`
    needs a run with output.bearing_loads = true, `odometry` a machine, `ride` one that is free in space.

    \b
    omnisim plot youbot.h5
    omnisim plot slow.h5 fast.h5 --view slip -o slip.pdf
    omnisim plot implicit.h5 explicit.h5 --view trackings -o trackings.png
    """
    path = None if output is None else picture_path(output, files, force)
    study = study_in(files)
    if study is None:
        figure = drawn(view, read_all(dict.fromkeys(files)), interactive=path is None)
    else:
        view = "study"
        figure = drawn(view, study, interactive=path is None)
    if path is None:
        from matplotlib import pyplot

        pyplot.show()  # until the window is closed
    else:
        from .output import deliver

        deliver({path: encoded(figure, path.suffix.lower())}, force)
        click.echo(f"{visible(str(path))} ({view})")


def picture_path(output: str, files: tuple[str, ...], force: bool) -> Path:
    """Where to write, or Failure."""
    from .output import output_path

    if Path(output).suffix.lower() not in FORMATS:
        raise Failure(f"{visible(output)}: the suffix says the format; take one of {', '.join(FORMATS)}", BAD_INPUT)
    return [output_path(output, file, force) for file in files][-1]


def read_all(files: Collection[str]) -> dict[str, Trajectory]:
    """Trajectories by title, or by file if titles do not tell them apart; Failure for what is no trajectory."""
    from omnisim.base.trajectory_file import TrajectoryError
    from omnisim.results.trajectory import open_trajectory

    try:
        found = [open_trajectory(file) for file in files]
    except TrajectoryError as error:
        raise Failure(str(error), BAD_INPUT) from None
    titles = [trajectory.attributes["title"] for trajectory in found]
    names = titles if len(set(titles)) == len(files) and all(titles) else files
    return dict(zip(names, found, strict=True))


def study_in(files: tuple[str, ...]) -> StudyResult | None:
    """The study that the only file holds; None if it is none. Failure where a study is one of several files."""
    from omnisim.base.trajectory_file import format_of

    if STUDY not in map(format_of, files):
        return None
    if len(files) > 1:
        raise Failure("a study is shown by itself: one file", BAD_INPUT)
    from omnisim.studies.result import open_study

    return open_study(files[0])


def drawn(view: str, shown: dict[str, Trajectory] | StudyResult, interactive: bool) -> Figure:
    """The figure; Failure without matplotlib, without a display if there must be one, or without data for the view."""
    try:
        import matplotlib

        if not interactive:
            matplotlib.use("agg")
        from omnisim.pictures import plots
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "matplotlib":
            raise
        raise Failure("plots need matplotlib: pip install 'omnisim-engine[plot]'", BAD_INPUT) from None
    if interactive and not has_window():
        raise Failure(NO_WINDOW, BAD_INPUT)
    try:
        return plots.VIEWS[view](shown) if isinstance(shown, dict) else plots.study(shown)
    except plots.PlotError as error:
        raise Failure(str(error), BAD_INPUT) from None


def has_window() -> bool:
    """Whether pyplot can open one."""
    from matplotlib import pyplot

    try:
        return pyplot.figure().canvas.required_interactive_framework is not None
    except Exception:  # each toolkit has its own way to say that there is no display
        return False
    finally:
        pyplot.close("all")


def encoded(figure: Figure, suffix: str) -> bytes:
    """The picture as a file, the same for the same data."""
    from matplotlib import rc_context

    image = BytesIO()
    metadata = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    with rc_context({"svg.hashsalt": "omnisim"}):
        figure.savefig(image, format=suffix[1:], dpi=150, metadata=metadata.get(suffix))
    return image.getvalue()
