"""`omnisim export`: a trajectory file for spreadsheets, data frames, MATLAB and ROS 2."""

from __future__ import annotations

from pathlib import Path

import click

from omnisim.base.formatting import visible

from .screen import BAD_INPUT, Failure


@click.command()
@click.argument("file")
@click.argument("out")
@click.option("--force", is_flag=True, help="Replace output files that exist.")
def export(file: str, out: str, force: bool) -> None:
    """Write the trajectory FILE to OUT for other tools: .csv, .parquet, .mat or .mcap.

    A table has a row for each output time and a column for each component, body/position.x for one; the events go to a
    table of their own beside it. A .mat file has it all as structs. A .mcap file has the run as messages of ROS 2, for
    Foxglove and RViz; the machine stands beside it as a URDF with meshes.

    \b
    omnisim export scene.h5 scene.csv           writes scene.csv and scene.events.csv
    omnisim export scene.h5 scene.parquet       needs pyarrow
    omnisim export scene.h5 scene.mat           needs scipy
    omnisim export scene.h5 scene.mcap          needs mcap and rosbags
    """
    from omnisim.base.trajectory_file import TrajectoryError
    from omnisim.exports.formats import ExportError, images, outputs, unwritten
    from omnisim.results.trajectory import open_trajectory
    from omnisim.scene.scene import SceneError

    from .output import deliver, output_path

    try:
        known = [output_path(str(path), file, force) for path in outputs(out)]
        files = images(open_trajectory(file), out)
    except (ExportError, TrajectoryError) as error:
        raise Failure(str(error), BAD_INPUT) from None
    except SceneError as error:
        raise Failure(f"{file}: {error}", BAD_INPUT) from None
    fresh = unwritten(files, out)
    for path in fresh:
        if path not in known:
            output_path(str(path), file, force)
    deliver(fresh, force)
    click.echo(f"written: {', '.join(described(path) for path in files)}")


def described(path: Path) -> str:
    return f"{visible(str(path))} ({path.stat().st_size / 1e6:.3g} MB)"
