"""`omnisim bench`: speed against error, by method, contact tracking, friction law and step."""

from __future__ import annotations

import os
from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .compare import KINDS
from .compiling import compilation_noted
from .screen import BAD_INPUT, Failure, Progress, note

if TYPE_CHECKING:
    from omnisim.run.work_precision import Precision, Setting
    from omnisim.scene.scene import Scene

SCENES = ("six_rollers", "coulomb_wheel", "kiwi")
METHODS = ("heun", "rk4", "dopri5", "bs5", "radau5", "auto")
LAWS = ("regularized", "saturated", "coulomb", "brush", "viscous", "none")


@click.command()
@click.argument("scenes", metavar="[SCENE]...", nargs=-1)
@click.option("--method", "methods", type=click.Choice(METHODS), multiple=True, help="Repeatable; else every method.")
@click.option(
    "--tracking", "trackings", type=click.Choice(KINDS["tracking"][0]), multiple=True, help="Repeatable; else explicit."
)
@click.option("--law", "laws", type=click.Choice(LAWS), multiple=True, help="Repeatable; else that of the scene.")
@click.option(
    "--step",
    "steps",
    metavar="SECONDS",
    type=click.FloatRange(min=0.0, min_open=True),
    multiple=True,
    help="Repeatable; else 10, 5, 2, 1 and 0.5 times the step of the scene.",
)
@click.option("--repeats", metavar="N", type=click.IntRange(min=1), default=5, show_default=True, help="Timed runs.")
@click.option("--set", "overrides", metavar="KEY=VALUE", multiple=True, help="Change a key of the scenes; repeatable.")
@click.option("-o", "--output", metavar="FOLDER", help="Write report.json, report.md and work_precision.png and .svg.")
def bench(
    scenes: tuple[str, ...],
    methods: tuple[str, ...],
    trackings: tuple[str, ...],
    laws: tuple[str, ...],
    steps: tuple[float, ...],
    repeats: int,
    overrides: tuple[str, ...],
    output: str | None,
) -> None:
    """Measure speed against error of each SCENE (else: six_rollers, coulomb_wheel, kiwi).

    Errors are the largest over all rows of output of position (m), yaw and spin angles (rad), against a
    converged reference that two runs agree on. Runs take turns; times are medians. Ctrl-C ends the run and
    shows what was measured; a second one gives up.

    \b
    omnisim bench
    omnisim bench scene.toml --method rk4 --method auto --step 1e-3 --step 1e-4
    omnisim bench coulomb_wheel --tracking explicit --tracking implicit -o report
    """
    for library in ("OPENBLAS", "MKL"):  # more threads gain nothing in small solves, and wait for each other
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")  # before the first import of NumPy
    from omnisim.run.work_precision import Setting, ladder
    from omnisim.scene.scene import load

    changes = [(*overrides, f"friction.law={law}") for law in laws] or [overrides]
    entries = [load(name, change) for name in scenes or SCENES for change in changes]
    plan = []
    for scene in entries:
        choice = product(methods or METHODS, trackings or ("explicit",), ladder(scene, steps))
        plan.append((scene, [Setting(*chosen) for chosen in dict.fromkeys(choice)]))
    folder = None if output is None else report_folder(output)
    measured, failures = measure_all(plan, repeats)
    if folder and measured:
        write(measured, folder)
    if failures:
        raise Failure("\n".join(failures))


def report_folder(text: str) -> Path:
    """Where to write, made if need be; Failure if that is no folder or holds a report already."""
    from .bench_report import FILES

    folder = Path(text)
    try:
        folder.mkdir(exist_ok=True)
    except FileExistsError:
        raise Failure(f"{text}: a file; -o takes the name of a folder", BAD_INPUT) from None
    except FileNotFoundError:
        raise Failure(f"{text}: there is no folder {folder.parent}", BAD_INPUT) from None
    except OSError as error:
        raise Failure(f"{text}: cannot write there: {error.strerror}", BAD_INPUT) from None
    if not os.access(folder, os.W_OK):
        raise Failure(f"{text}: cannot write there: Permission denied", BAD_INPUT)
    if present := [name for name in FILES if (folder / name).exists()]:
        raise Failure(f"{folder / present[0]}: exists already; -o takes a folder without a report", BAD_INPUT)
    return folder


def measure_all(plan: Sequence[tuple[Scene, list[Setting]]], repeats: int) -> tuple[list[Precision], list[str]]:
    """Measure and show one scene after the other; what was measured, and what went wrong in a line each."""
    from omnisim.run.work_precision import Interrupted, Unconverged, measure

    from .bench_report import shown

    measured: list[Precision] = []
    failures: list[str] = []
    with compilation_noted([scene for scene, _ in plan]):
        for scene, settings in plan:
            note(f"{scene.source}, {scene.config.friction.law}: {len(settings)} settings, in turn ...")
            with Progress(quiet=False) as watch:

                def progress(fraction: float, watch: Progress = watch) -> None:
                    if watch(fraction):
                        raise Interrupted

                try:
                    found = measure(scene, settings, repeats, progress)
                except Unconverged as error:
                    failures.append(f"{scene.source}: no reference to measure errors by: {error}")
                    continue
                except Interrupted:
                    return measured, [*failures, f"interrupted; {scene.source} is left out"]
                watch(1.0)
            measured.append(found)
            click.echo(("\n" if len(measured) > 1 else "") + shown(found))
            if watch.stop:
                return measured, [*failures, f"interrupted after {found.repeats} of {repeats} repeats"]
    return measured, failures


def write(measured: Sequence[Precision], folder: Path) -> None:
    """The report as data, as text, and as a picture if matplotlib is there."""
    from .bench_report import FILES, as_json, as_markdown, scene_data, title
    from .output import deliver

    pictured = True
    try:
        from .bench_plot import plot
    except ModuleNotFoundError:
        note("no plot: it needs matplotlib (pip install matplotlib)")
        pictured = False
    texts = {"report.json": as_json(measured), "report.md": as_markdown(measured, pictured)}
    deliver({folder / name: text.encode() for name, text in texts.items()}, force=False)
    if pictured:
        plot([(title(found), scene_data(found)) for found in measured], folder)
    click.echo(f"\nwritten: {folder}/" + ", ".join(name for name in FILES if (folder / name).exists()))
