"""`omnisim run`: from a scene to a trajectory file."""

from __future__ import annotations

import math
import os
import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from omnisim.base.formatting import aligned, visible

from .compiling import compilation_noted
from .screen import BAD_INPUT, Failure, Progress, note, warn

if TYPE_CHECKING:
    from omnisim.results.trajectory import Trajectory
    from omnisim.scene.scene import Scene

HDF5 = ("", ".h5", ".hdf5", ".hdf", ".he5", ".nc", ".nc4")
COARSE = 1e-3  # relative error of the energy balance beyond which a run is worth a warning


@click.command()
@click.argument("scene")
@click.option("-o", "output", metavar="FILE", help="Output file, its suffix says the format; else STEM.h5 here.")
@click.option("--set", "overrides", metavar="KEY=VALUE", multiple=True, help="Change a key of the scene; repeatable.")
@click.option("--force", is_flag=True, help="Replace an output file that exists.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def run(scene: str, output: str | None, overrides: tuple[str, ...], force: bool, quiet: bool) -> None:
    """Simulate SCENE and write the trajectory to an HDF5 file.

    Ctrl-C finishes the step and writes what was computed; a second one gives up. Where FILE cannot be written in the
    end, the current folder and the temporary one are tried. A trajectory file is a SCENE too: it runs again, by default
    into STEM_again.h5.

    \b
    omnisim run scene.toml                                  writes scene.h5
    omnisim run scene.toml -o fine.h5 --set time.step=1e-5
    omnisim run scene.toml -o scene.csv                     .parquet, .mat, .mcap too, for other tools
    omnisim run scene.h5 --set friction.coefficient=0.2     writes scene_again.h5
    omnisim run scene.toml --set solver.error=1e-6          by the step that this error needs
    omnisim run six_rollers --set wheels.wheel.spin_rate=20 --set friction.coefficient=0.1
    """
    from omnisim.base.files import is_hdf5
    from omnisim.scene.scene import load

    stored = is_hdf5(scene)
    loaded = load(scene, overrides)
    name = f"{loaded.name}{'_again' * stored}.h5" if output is None else output
    path = result_path(name, "" if stored else scene, force)  # with --force in place of the run that holds the scene
    if not quiet:
        warn(loaded.warnings)
    trajectory, kept, problem = simulate_and_save(loaded, path, force, quiet)
    if not quiet:
        click.echo(report(trajectory, kept))
    for warning in (coarse(trajectory), missed(trajectory)):
        if warning and not quiet:
            note(warning)
    failures = [f"{problem}; the run is in {visible(str(kept))}"] if problem else []
    if not trajectory.complete:
        failures.append(f"{trajectory.attributes['status']} ({visible(str(kept))} holds what was computed)")
    if failures:
        raise Failure("\n".join(failures))


def result_path(text: str, source: str, force: bool) -> Path:
    """Where to write, checked with all files beside it; Failure also for a suffix that says nothing we can write."""
    from omnisim.exports.formats import FORMATS, ExportError, outputs

    from .output import output_path

    path = output_path(text, source, force)
    suffix = Path(text).suffix.lower()
    if suffix in HDF5:
        return path
    if suffix not in FORMATS:
        raise Failure(f"{visible(text)}: the suffix says the format; take one of .h5, {', '.join(FORMATS)}", BAD_INPUT)
    try:
        for beside in outputs(text)[1:]:
            output_path(str(beside), source, force)
    except ExportError as error:
        raise Failure(str(error), BAD_INPUT) from None
    return path


def simulate_and_save(scene: Scene, path: Path, force: bool, quiet: bool) -> tuple[Trajectory, Path, str]:
    """The trajectory, the file that it is in, and what was in the way if that is not `path`; Failure if the user gives
    up or no folder takes it.
    """
    from omnisim.run.simulation import simulate

    from .output import unwritten

    with Progress(quiet) as progress:
        with compilation_noted([scene], quiet):
            trajectory = simulate(scene, progress)
        if trajectory.complete:
            progress(1.0)
        try:
            save(trajectory, path, force)
        except (OSError, ValueError, MemoryError) as error:
            problem = unwritten(error, path)
            kept = rescued(trajectory, path.stem)
            if not kept:
                raise Failure(f"{problem}; no other folder takes it: the run is lost") from None
            return trajectory, kept, problem
    return trajectory, path, ""


def save(trajectory: Trajectory, path: Path, force: bool) -> None:
    """Write what the suffix says. Raises OSError, and ValueError for what the format cannot hold."""
    from omnisim.exports import formats

    if path.suffix.lower() in formats.FORMATS:
        formats.write(trajectory, path, overwrite=force)
    else:
        trajectory.save(path, overwrite=force)


def rescued(trajectory: Trajectory, stem: str) -> Path | None:
    """The file in the current or the temporary folder that holds the trajectory now, under a name that was free."""
    for folder in (os.getcwd, tempfile.gettempdir):
        with suppress(OSError):  # there is no such folder, or it takes nothing
            place = Path(folder())
            free = (place / f"{stem}{number}.h5" for number in ("", *(f"_{n}" for n in range(2, 1000))))
            path = next(path for path in free if not path.exists())
            trajectory.save(path)
            return path
    return None


def report(trajectory: Trajectory, path: Path) -> str:
    """The summary of a run, for people."""
    from omnisim.results.report import accuracy, odometry, peaks

    from .output import megabytes

    a = trajectory.attributes
    rows = len(trajectory.time)
    kinds = Counter(trajectory["events/kind"].tolist())
    events = {} if "energy/elastic" in trajectory else {"exchange": kinds.pop("exchange", 0)}
    events |= kinds  # where wheels touch with several rollers, none takes over from another
    return aligned({
        "scene": a["title"] or "(no title)",
        "model": a["model"],
        "method": f"{a['method']}, step {a['step']:g} s, {a['tracking']} tracking",
        "error": accuracy(trajectory),
        "speed": speed(a["stop_time"], a["wall_time"]),
        "steps": f"{a['steps']}, with {a['rhs_evaluations']} right-hand sides",
        "events": ", ".join(f"{count} {kind}{'s' * (count != 1)}" for kind, count in events.items()) or "none",
        "energy": energy(trajectory),
        "peaks": peaks(trajectory),
        "odometry": odometry(trajectory),
        "file": f"{visible(str(path))} ({rows} rows, {megabytes(path)})",
        "status": a["status"],
    })  # fmt: skip


def coarse(trajectory: Trajectory) -> str:
    """What to say of a run whose energies do not balance; empty if they do."""
    from omnisim.results.comparison import unaccounted

    missing = unaccounted(trajectory)
    if missing < COARSE or not trajectory.complete:  # else the status has said more
        return ""
    return f"Warning: energy is unaccounted for, {missing:.1%} of what was there or came in: time.step is too coarse"


def missed(trajectory: Trajectory) -> str:
    """What to say of a complete run whose error is not as small as the scene wants it; empty if it is."""
    a = trajectory.attributes
    if not trajectory.complete or a.get("error_estimate", math.inf) <= a.get("error_target", math.inf):
        return ""
    return f"Warning: no step tried brings the error below solver.error = {a['error_target']:g}"


def speed(simulated: float, wall_time: float) -> str:
    """Real-time factor and wall time of the march."""
    factor = simulated / wall_time if wall_time > 0.0 else 0.0
    shown = f"{factor:.0f}" if factor >= 100.0 else f"{factor:.3g}"
    times = f"{shown} times real time: " if factor else ""
    return f"{times}{simulated:g} s in {wall_time:.3g} s of wall time"


def energy(trajectory: Trajectory) -> str:
    """How well the energies balance, absolutely and relatively."""
    from omnisim.results.comparison import energy_error

    error = energy_error(trajectory)
    relative = f", {error.relative:.2g} of {error.scale_name}" if error.scale else ""
    return f"balanced to {error.absolute:.2g} J in every row{relative}"
