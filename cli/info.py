"""`omnisim info`: what a scene models and why, or what a trajectory file holds."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from omnisim_cli.screen import BAD_INPUT, Failure, aligned, compilation_noted

if TYPE_CHECKING:
    import numpy as np

    from omnisim.parameters import Parameters
    from omnisim.scene import Scene

HDF5_SIGNATURE = b"\x89HDF\r\n\x1a\n"


@click.command()
@click.argument("source", metavar="SCENE|FILE")
def info(source: str) -> None:
    """Say what SCENE models, what it leaves out and why; or what the trajectory FILE holds.

    \b
    omnisim info scene.toml
    omnisim info scene.h5
    """
    if is_hdf5(source):
        click.echo(about_trajectory(source))
    else:
        from omnisim.scene import load

        click.echo(about_scene(load(source)))


def is_hdf5(source: str) -> bool:
    """By content, so that a wrong suffix is no trap."""
    try:
        with open(source, "rb") as file:
            return file.read(len(HDF5_SIGNATURE)) == HDF5_SIGNATURE
    except OSError:
        return False  # the name of a packaged scene, or an error that loading explains


def about_trajectory(path: str) -> str:
    from omnisim.storage import TrajectoryError, read
    from omnisim.trajectory import summary

    try:
        return summary(read(path))
    except TrajectoryError as error:
        raise Failure(str(error), BAD_INPUT) from None


def about_scene(scene: Scene) -> str:
    """The model with its reasons, the size of the run, and the wheels."""
    from omnisim.model import describe
    from omnisim.parameters import pack

    config = scene.config
    with compilation_noted():
        parameters = pack(config)
        sections = [aligned(run_facts(scene, parameters)), describe(config).text]
        for wheel, record in zip(config.wheels, parameters.wheels, strict=True):
            heading = f"wheel '{wheel.name}' of type '{wheel.type}'"
            sections.append(f"{heading}\n{aligned(wheel_facts(record), indent='  ')}")
    return "\n\n".join(sections)


def run_facts(scene: Scene, parameters: Parameters) -> dict[str, str]:
    from omnisim.stiffness import explanation

    time, solver = scene.config.time, scene.config.solver
    return {
        "scene": scene.config.title or "(no title)",
        "source": scene.source,
        "method": explanation(scene.config, parameters),
        "tracking": solver.tracking,
        "run": f"{time.end:g} s in {time.steps} steps of {time.step:g} s",
        "output": f"{time.outputs + 1} rows, one every {time.output_interval:g} s",
    }


def wheel_facts(wheel: np.record) -> dict[str, str]:
    """Sizes that follow from the scene's."""
    from omnisim.roller import length, profile_radius, tip_radius

    psi = math.degrees(math.atan2(wheel.sin_psi, wheel.cos_psi))
    margin = wheel.radius * wheel.cos_alpha - wheel.roller_distance
    jump = 2.0 * wheel.roller_distance * math.tan(wheel.alpha) * abs(wheel.tan_psi)
    return {
        "wheel radius": f"{wheel.radius:g} m",
        "rollers": f"{wheel.rollers}, axes at {wheel.roller_distance:g} m, angle {psi:g} deg",
        "roller length": f"{length(wheel):.6g} m",
        "roller radius": f"{profile_radius(wheel, 0.0):.6g} m amid, {tip_radius(wheel):.6g} m at the tips",
        "margin": f"{max(margin, 0.0):.6g} m until the tips are points (R cos alpha - R1)",
        "exchange": f"every {math.degrees(2.0 * wheel.alpha):g} deg; the contact jumps {jump:.6g} m sideways",
        "axle inertia": f"{wheel.axle_inertia:.6g} kg m^2 (J_k: disk and rollers about the axle)",
    }
