"""`omnisim view`: a trajectory as a page that shows the machine in 3-D."""

import webbrowser
from pathlib import Path

import click

from omnisim.base.formatting import visible

from .screen import BAD_INPUT, Failure

PAGES = (".html", ".htm")


@click.command()
@click.argument("file")
@click.option("-o", "output", metavar="OUT.html", help="Output file; else STEM.html in the current directory.")
@click.option("--force", is_flag=True, help="Replace an output file that exists.")
@click.option("--open", "show", is_flag=True, help="Show the page in the browser.")
def view(file: str, output: str | None, force: bool, show: bool) -> None:
    """Make a page of the trajectory FILE: the machine in 3-D, its contacts and forces, moving.

    The page is one file, and needs no network: mail it, or put it beside a paper.

    \b
    omnisim view youbot.h5                  writes youbot.html
    omnisim view youbot.h5 -o demo.html --open
    """
    from omnisim.base.trajectory_file import TrajectoryError
    from omnisim.pictures.viewer import NothingToShow, page
    from omnisim.results.trajectory import open_trajectory
    from omnisim.scene.scene import SceneError

    from .output import deliver, megabytes, output_path

    if output is not None and Path(output).suffix.lower() not in PAGES:
        raise Failure(f"{visible(output)}: a page is {' or '.join(PAGES)}; `omnisim plot` makes pictures", BAD_INPUT)
    path = output_path(f"{Path(file).stem}.html" if output is None else output, file, force)
    try:
        text = page(open_trajectory(file))
    except TrajectoryError as error:
        raise Failure(str(error), BAD_INPUT) from None
    except (NothingToShow, SceneError) as error:
        raise Failure(f"{file}: {error}", BAD_INPUT) from None
    deliver({path: text.encode()}, force)
    click.echo(f"{visible(str(path))} ({megabytes(path)})")
    if show:
        webbrowser.open(path.resolve().as_uri())
