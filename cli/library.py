"""`omnisim library`: a machine as native code for C and C++."""

from __future__ import annotations

import click

from omnisim.base.formatting import visible

from .screen import BAD_INPUT, Failure, note, warn


@click.command()
@click.argument("scene")
@click.option("-o", "output", metavar="FOLDER", required=True, help="Folder for the library and what belongs to it.")
@click.option("--set", "overrides", metavar="KEY=VALUE", multiple=True, help="Change a key of the scene; repeatable.")
@click.option("--cpu", type=click.Choice(("generic", "native")), default="generic", help="Any, or those like this one.")
@click.option("--force", is_flag=True, help="Replace files that exist.")
@click.option("--quiet", is_flag=True, help="Print errors only.")
def library(scene: str, output: str, overrides: tuple[str, ...], cpu: str, force: bool, quiet: bool) -> None:
    """Make SCENE a shared library of C, with a header and an example for CMake: the compiled kernels themselves, which
    run without Python. A C compiler is needed here, none where it runs.

    \b
    omnisim library youbot -o youbot
    cmake -S youbot -B build && cmake --build build && build/example
    """
    from omnisim.native.building import NativeError
    from omnisim.native.library import file_names, files, prefix_of
    from omnisim.scene.scene import load

    from .compiling import compilation_noted
    from .output import deliver_into, output_folder

    loaded = load(scene, overrides)
    prefix = prefix_of(loaded.name)
    folder = output_folder(output, file_names(prefix), force)
    if not quiet:
        warn(loaded.warnings)
        note("compiling the machine: half a minute ...")
    try:
        with compilation_noted([loaded], quiet):
            images = files(loaded, prefix, cpu)
    except NativeError as error:
        raise Failure(str(error), BAD_INPUT) from None
    deliver_into(folder, {folder / name: image for name, image in images.items()}, force)
    if not quiet:
        size = len(images[f"lib{prefix}.so"]) / 1e6
        click.echo(f"written: {visible(str(folder))}: lib{prefix}.so ({size:.2g} MB), {prefix}.h, and an example")
