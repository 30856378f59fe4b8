"""`omnisim warmup`: compiles kernels, so that no later run has to wait."""

import time

import click

from .screen import note


@click.command()
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
def warmup(scenes: tuple[str, ...]) -> None:
    """Compile now what runs of these scenes need, or else every kernel, so that the first run starts at once.

    Scenes of one kind share all kernels: kinds differ in formulation, upright or free in space, in set-valued or smooth
    friction, in implicit or explicit steps, and in whether a machine has motors, friction in bearings or the like.
    Compiled kernels stay on disk until omnisim, Numba or the processor change.

    \b
    omnisim warmup                          all kinds
    omnisim warmup youbot scene.toml        those of these scenes
    """
    begun = time.perf_counter()
    from omnisim.base.kernel import CACHE_DIRECTORY
    from omnisim.run.warming import warm
    from omnisim.scene.scene import load

    loaded = [load(scene) for scene in scenes] or None
    note("compiling kernels, once, where they are not on disk ...")
    warm(loaded, lambda kind: note(f"{kind}: ready after {time.perf_counter() - begun:.2g} s"))
    click.echo(f"kernels ready after {time.perf_counter() - begun:.2g} s, in {CACHE_DIRECTORY}")
