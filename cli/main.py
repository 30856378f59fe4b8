"""The command line: its commands, and what becomes of their failures."""

import signal
import sys
import warnings
from typing import Any

import click

from .bench import bench
from .compare import compare
from .data import data
from .export import export
from .fit import fit
from .fmu import fmu
from .info import info
from .library import library
from .new import new
from .plot import plot
from .run import run
from .screen import BAD_INPUT, ENDING, Failure, leave_at_once, shown, warn
from .sweep import sweep
from .view import view
from .warmup import warmup
from .wheel import wheel


class Commands(click.Group):
    """A group that turns every failure into one message and an exit code; no traceback reaches a user, and no control
    character a terminal.
    """

    def main(self, *arguments: Any, **options: Any) -> Any:
        with shown(), warnings.catch_warnings():
            warnings.showwarning = lambda message, *_, **__: warn([str(message)])
            return super().main(*arguments, **options)

    def invoke(self, ctx: click.Context):
        try:
            return super().invoke(ctx)
        except (click.ClickException, click.exceptions.Exit, click.Abort, BrokenPipeError):
            raise
        except Exception as error:
            if sys.flags.dev_mode:
                raise
            raise explained(error) from None


def explained(error: Exception) -> Failure:
    """The message and exit code for an exception that no command expects."""
    from omnisim.scene.document import InputError  # here: --help answers without it

    if isinstance(error, InputError):
        return Failure(str(error), BAD_INPUT)
    if isinstance(error, MemoryError):
        return Failure(f"not enough memory: {error}")
    if isinstance(error, OSError):
        return Failure(f"{error.filename or 'output'}: {error.strerror or error}")
    what = f"{type(error).__name__}: {error}".replace("\n", " ")
    return Failure(f"a bug in omnisim: {what}; PYTHONDEVMODE=1 shows where")


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110})
@click.version_option(package_name="omnisim-engine", prog_name="omnisim", message="%(prog)s %(version)s")
def cli() -> None:
    """Simulate omni and mecanum wheels with real rollers.

    SCENE is a TOML file, or else the name of a packaged scene.

    \b
    omnisim data                            packaged scenes and wheels
    omnisim new robot.toml                  asks for a few numbers, and writes a scene
    omnisim info authors_testbench          what a scene models, and why
    omnisim run scene.toml                  writes scene.h5
    omnisim sweep study.toml                many runs, keys of the scene varied
    omnisim fit fit.toml -o fitted          keys of a scene estimated from logs of a machine
    omnisim info scene.h5                   what a trajectory holds
    omnisim export scene.h5 scene.csv       for spreadsheets; .parquet, .mat, .mcap
    omnisim view scene.h5                   the machine in 3-D, as a web page
    omnisim plot scene.h5                   pictures of it
    omnisim compare implicit explicit       the two contact trackings side by side
    omnisim bench scene.toml                speed against error, by method and step
    omnisim wheel youbot -o youbot.png      dimensions, drawing, mesh, or model for other simulators
    omnisim library youbot -o youbot        a library of C that runs without Python
    omnisim fmu youbot -o youbot.fmu        the machine for tools that import FMI

    Exit codes: 0 done; 1 the run stopped early or was interrupted; 2 bad input, checked before anything runs.
    """


for command in (data, new, run, sweep, fit, info, plot, view, export, compare, bench, wheel, library, fmu, warmup):
    cli.add_command(command)


def main() -> None:
    """Entry point of the command `omnisim`."""
    for number in ENDING:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, leave_at_once)
    cli(prog_name="omnisim")
