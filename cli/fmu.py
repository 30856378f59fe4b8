"""`omnisim fmu`: a machine as a Functional Mock-up Unit."""

from __future__ import annotations

from pathlib import Path

import click

from .screen import BAD_INPUT, Failure, note, warn


@click.command()
@click.argument("scene")
@click.option("-o", "output", metavar="FILE", required=True, help="Output file, a .fmu.")
@click.option("--fmi", "standard", type=click.Choice(("3", "2")), default="3", help="Which standard: 3.0 or 2.0.")
@click.option("--set", "overrides", metavar="KEY=VALUE", multiple=True, help="Change a key of the scene; repeatable.")
@click.option("--cpu", type=click.Choice(("generic", "native")), default="generic", help="Any, or those like this one.")
@click.option("--force", is_flag=True, help="Replace an output file that exists.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def fmu(scene: str, output: str, standard: str, overrides: tuple[str, ...], cpu: str, force: bool, quiet: bool) -> None:
    """Make SCENE a Functional Mock-up Unit for Co-Simulation: the compiled kernels themselves, which run in any tool
    that imports FMI, without Python. A C compiler is needed here, none where it runs.

    \b
    omnisim fmu youbot -o youbot.fmu                        FMI 3.0
    omnisim fmu youbot -o youbot.fmu --fmi 2
    """
    from omnisim.native.building import NativeError, build
    from omnisim.native.fmu import binaries
    from omnisim.native.fmu import fmu as made
    from omnisim.native.library import prefix_of
    from omnisim.scene.scene import load

    from .compiling import compilation_noted
    from .output import deliver, megabytes, output_path

    loaded = load(scene, overrides)
    if Path(output).suffix.lower() != ".fmu":
        raise Failure(f"{output}: the name of a Functional Mock-up Unit ends with .fmu", BAD_INPUT)
    path = output_path(output, scene, force)
    if not quiet:
        warn(loaded.warnings)
        note("compiling the machine: half a minute ...")
    try:
        binaries(standard)
        with compilation_noted([loaded], quiet):
            image = made(loaded, build(loaded, prefix_of(loaded.name), cpu), standard)
    except NativeError as error:
        raise Failure(str(error), BAD_INPUT) from None
    deliver({path: image}, force)
    if not quiet:
        click.echo(f"written: {path} ({megabytes(path)})")
