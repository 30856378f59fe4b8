"""`omnisim fit`: keys of a scene estimated from logs of a machine."""

from __future__ import annotations

import math
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from omnisim.base.formatting import aligned, visible

from .compiling import compilation_noted
from .screen import Failure, StopWish, is_watched, note

if TYPE_CHECKING:
    from omnisim.fitting.least_squares import Trial
    from omnisim.fitting.paths import Errors
    from omnisim.fitting.result import FitResult

NAMES = ("fitted.toml", "fit.json", "paths.png", "residuals.png")


@click.command()
@click.argument("fit_file", metavar="FIT.toml")
@click.option("-o", "output", metavar="FOLDER", help="Folder for fitted.toml, fit.json and pictures.")
@click.option("--workers", type=click.IntRange(1), metavar="N", help="Processes; else one for each core.")
@click.option("--force", is_flag=True, help="Replace files that exist.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def fit(fit_file: str, output: str | None, workers: int | None, force: bool, quiet: bool) -> None:
    """Estimate keys of a scene from logs of the machine, as FIT.toml says: with deviations, intervals, what the logs
    cannot tell, and the error of every log before and after, beside that of ideal kinematics.

    Ctrl-C ends the search with the best so far. Without a folder the result is only printed.

    \b
    omnisim fit omni4.toml -o omni4_fit
    omnisim run omni4_fit/fitted.toml
    """
    from omnisim.fitting.fit_file import load_fit
    from omnisim.fitting.fitting import fit as search
    from omnisim.fitting.simulation import Interrupted, prepared

    from .output import output_folder

    folder = None if output is None else output_folder(output, NAMES, force)
    made = load_fit(fit_file)
    with compilation_noted([made.scene], quiet):
        prepared(made)
    try:
        with Follower(quiet) as follower:
            found = search(made, workers=workers, progress=follower, stop=lambda: follower.stop)
    except (Interrupted, KeyboardInterrupt):
        raise Failure("interrupted; nothing was written") from None
    if not quiet:
        click.echo(summary(found))
    if folder is not None:
        write(found, folder, force)
        if not quiet:
            click.echo(f"folder  {visible(str(folder))}")
    if found.solution.interrupted:
        raise Failure("interrupted; the estimates are the best so far")


def write(found: FitResult, folder: Path, force: bool) -> None:
    """All files of the result, pictures if there is matplotlib; Failure if they cannot be written."""
    from .output import deliver_into

    images = found.files(folder)
    try:
        import matplotlib

        matplotlib.use("agg")
        from omnisim.pictures import plots

        from .plot import encoded

        images |= {
            folder / name: encoded(draw(found), ".png")
            for name, draw in (("paths.png", plots.fit_paths), ("residuals.png", plots.fit_residuals))
        }
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != "matplotlib":
            raise
        note("no pictures: they need matplotlib: pip install 'omnisim-engine[plot]'")
    deliver_into(folder, images, force)


class Follower(StopWish):
    """Follows a search: a line for each point if stderr is a terminal, and Ctrl-C or SIGTERM as a wish to stop."""

    def __init__(self, quiet: bool):
        super().__init__()
        self.quiet = quiet

    def __enter__(self) -> Follower:
        self.listen()
        return self

    def __call__(self, trial: Trial) -> bool:
        """Whether to stop."""
        if trial.number == 1 and not self.quiet:
            note("searching; Ctrl-C ends it with the best so far")
        if is_watched(self.quiet):
            with suppress(OSError):
                stream: Any = getattr(sys.stderr, "stream", sys.stderr)
                stream.write(f"point {trial.number}: {trial.rms:.4g} deviations off, best {trial.best:.4g}\n")
                stream.flush()
        return self.stop

    def _on_signal(self, *_: object) -> None:
        super()._on_signal()
        if not self.quiet:
            note("stopping, with the best so far; another Ctrl-C gives up")


def summary(found: FitResult) -> str:
    """What a fit has found, for people."""
    made = found.fit
    used = sum(entry.log.use == "fit" for entry in found.logs)
    position, yaw = found.known.correlated_rows
    told = {
        "fit": f"{visible(made.scene.config.title or made.scene.name)}: {len(made.parameters)} keys from {used} of "
        f"{len(found.logs)} logs",
        "search": f"{found.status}; {found.solution.trials} points, {found.runs} runs",
    }
    if math.isfinite(position):
        told["rows"] = f"{position:.3g} of positions and {yaw:.3g} of yaw count as one: residuals follow each other"
    if found.step_error is not None:
        told["step"] = f"half of it changes no place by more than {1e3 * found.step_error:.2g} mm"
    if found.early:
        told["early"] = (
            f"{len(found.early)} runs with these estimates stop before their log ends; {visible(found.early[0])}"
        )
    told |= {f"note {i}": visible(sentence) for i, sentence in enumerate(found.known.untold, 1)}
    return "\n".join([aligned(told), "", *estimates(found), "", *table(found)])


def estimates(found: FitResult) -> list[str]:
    """Values with deviations and intervals, and those that ideal kinematics takes."""
    ideal = found.ideal or {}
    width = max(map(len, found.estimates))
    lines = [f"{'estimate':{width}}{'value':>12}{'deviation':>12}{'95 % interval':>26}{'ideal kinematics':>19}"]
    for key, one in found.estimates.items():
        interval = f"{shown(one.low)} to {shown(one.high)}"
        kinematic = shown(ideal[key]) if key in ideal else ""
        lines.append(f"{key:{width}}{shown(one.value):>12}{shown(one.deviation):>12}{interval:>26}{kinematic:>19}")
    return lines


def shown(value: float) -> str:
    return f"{value:.5g}" if math.isfinite(value) else "unknown"


def table(found: FitResult) -> list[str]:
    """Errors of all logs: at the end, and along the path."""
    heads = ("before", "after", "ideal, nominal", "ideal, fitted")
    width = max(len(entry.log.file) for entry in found.logs)
    lines = [f"{'at the end, rms':{width}}      " + "".join(f"{head:>24}" for head in heads)]
    for entry in found.logs:
        cells = "".join(f"{cell(one):>24}" for one in entry.errors().values())
        lines.append(f"{visible(entry.log.file):{width}}  {entry.log.use:6}{cells}")
    return lines


def cell(one: Errors | None) -> str:
    if one is None:
        return "none"
    return f"{1e3 * one.end_position:.0f} mm {math.degrees(one.end_yaw):.1f} deg, {1e3 * one.rms_position:.0f} mm"
