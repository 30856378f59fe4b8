"""`omnisim warmup`: compiles every kernel, so that no later run has to wait."""

import time

import click

from .screen import note

TINY = ("time.end=0.01", "time.step=0.001", "time.output_interval=0.01")


@click.command()
def warmup() -> None:
    """Compile every kernel now, so that the first run starts at once.

    Compiled kernels stay on disk until omnisim, Numba or the processor change.
    """
    note("compiling kernels ...")
    begun = time.perf_counter()
    from omnisim.base.kernel import CACHE_DIRECTORY
    from omnisim.dynamics.packing import pack
    from omnisim.march.stiffness import explanation
    from omnisim.run import timing
    from omnisim.scene.scene import load

    from .info import wheel_facts

    for tracking in ("explicit", "implicit"):
        scene = load("six_rollers", [*TINY, f"solver.tracking={tracking}"])
        timing.simulate(scene)
        timing.tracking_cost(scene)
        parameters = pack(scene.config)
        explanation(scene.config, parameters)
        wheel_facts(parameters.wheels[0])
    click.echo(f"kernels ready after {time.perf_counter() - begun:.2g} s, in {CACHE_DIRECTORY}")
