"""`omnisim run`: from a scene to a trajectory file."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import click

from omnisim.text import aligned
from omnisim_cli.screen import Failure, Progress, compilation_noted, note, warn

if TYPE_CHECKING:
    from omnisim.scene import Scene
    from omnisim.trajectory import Trajectory

COARSE = 1e-3  # relative error of the energy balance beyond which a run is worth a warning


@click.command()
@click.argument("scene")
@click.option("-o", "output", metavar="FILE", help="Output file; else STEM.h5 in the current directory.")
@click.option("--set", "overrides", metavar="KEY=VALUE", multiple=True, help="Change a key of the scene; repeatable.")
@click.option("--force", is_flag=True, help="Replace an output file that exists.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def run(scene: str, output: str | None, overrides: tuple[str, ...], force: bool, quiet: bool) -> None:
    """Simulate SCENE and write the trajectory to an HDF5 file.

    Ctrl-C finishes the step and writes what was computed; a second one gives up.

    \b
    omnisim run scene.toml                                  writes scene.h5
    omnisim run scene.toml -o fine.h5 --set time.step=1e-5
    omnisim run scene.toml --set solver.error=1e-6          by the step that this error needs
    omnisim run six_rollers --set wheels.wheel.spin_rate=20 --set friction.coefficient=0.1
    """
    from omnisim.scene import load
    from omnisim_cli.output import output_path

    loaded = load(scene, overrides)
    path = output_path(f"{loaded.name}.h5" if output is None else output, scene, force)
    if not quiet:
        warn(loaded.warnings)
    trajectory = simulate_and_save(loaded, path, quiet)
    if not quiet:
        click.echo(report(trajectory, path))
    for warning in (coarse(trajectory), missed(trajectory)):
        if warning and not quiet:
            note(warning)
    if not trajectory.complete:
        raise Failure(f"{trajectory.attributes['status']} ({path} holds what was computed)")


def simulate_and_save(scene: Scene, path: Path, quiet: bool) -> Trajectory:
    """The trajectory, which is then in the file; Failure if the user gives up or it cannot be written."""
    from omnisim.simulation import simulate

    with Progress(quiet) as progress:
        with compilation_noted(quiet):
            trajectory = simulate(scene, progress)
        if trajectory.complete:
            progress(1.0)
        try:
            trajectory.save(path)
        except OSError as error:
            raise Failure(f"{path}: cannot be written: {error.strerror or error}; the run is lost") from None
    return trajectory


def report(trajectory: Trajectory, path: Path) -> str:
    """The summary of a run, for people."""
    from omnisim.report import accuracy, odometry, peaks

    a, rows = trajectory.attributes, len(trajectory.time)
    kinds = Counter(trajectory["events/kind"].tolist())
    events = {"exchange": kinds.pop("exchange", 0)} | kinds
    return aligned({
        "scene": a["title"] or "(no title)",
        "model": a["model"],
        "method": f"{a['method']}, step {a['step']:g} s, {a['tracking']} tracking",
        "error": accuracy(trajectory),
        "speed": speed(a["stop_time"], a["wall_time"]),
        "steps": f"{a['steps']}, with {a['rhs_evaluations']} right-hand sides",
        "events": ", ".join(f"{count} {kind}{'s' * (count != 1)}" for kind, count in events.items()),
        "energy": energy(trajectory),
        "peaks": peaks(trajectory),
        "odometry": odometry(trajectory),
        "file": f"{path} ({rows} rows, {path.stat().st_size / 1e6:.2g} MB)",
        "status": a["status"],
    })  # fmt: skip


def coarse(trajectory: Trajectory) -> str:
    """What to say of a run whose energies do not balance; empty if they do."""
    from omnisim.analysis import unaccounted

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
    from omnisim.analysis import energy_error

    error = energy_error(trajectory)
    relative = f", {error.relative:.2g} of {error.scale_name}" if error.scale else ""
    return f"balanced to {error.absolute:.2g} J{relative}"
