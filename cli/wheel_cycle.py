"""`omnisim wheel A B ...`: wheels side by side under one platform, as a table and a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from omnisim.base.formatting import columns

from .screen import BAD_INPUT, Failure

if TYPE_CHECKING:
    from omnisim.studies.wheel_cycle import Candidate, Found

HEADS = ("", "speed", "ripple", "height", "drag", "energy", "peak load")
UNITS = ("", "%", "mm/s", "mm", "N", "J/m", "x share")
NOTES = """\
speed      faster or slower than ideal wheels would be, at rates that controllers hold
ripple     of the velocity, root mean square about its mean; of turning and drifts too
height     the chassis goes up and down by, of machines free in space
drag       energy lost by the way: to slip, bearings, rubber
energy     of the drives by the way; what they brake away is not given back
peak load  largest normal force of a wheel, of a quarter of the weight"""


def compare(scenes: tuple[str, ...], mass: float | None, speed: float | None, output: str | None, force: bool) -> None:
    """Print the table, and draw the picture if there is an output file."""
    from omnisim.scene.scene import load
    from omnisim.studies.wheel_cycle import SPEED, candidates, compare_wheels, usual_mass

    from .output import output_path

    wheels = candidates([load(scene) for scene in scenes])
    path = output_path(output, scenes[0], force) if output is not None else None
    mass, speed = mass or usual_mass(wheels), speed or SPEED
    try:
        found = compare_wheels(wheels, mass, speed)
    except ValueError as error:
        raise Failure(str(error), BAD_INPUT) from None
    head = f"four wheels each under a platform of {mass:g} kg, their centres at {speed:g} m/s"
    click.echo("\n\n".join([head, *(table(motion, wheels, found) for motion in found[0]), NOTES]))
    if path is not None:
        draw(path, head, wheels, found)
        click.echo(path)


def table(motion: str, wheels: list[Candidate], found: list[dict[str, Found | str]]) -> str:
    """A motion, a line for each wheel; below it why there is none, and what was found by other means."""
    rows: list[tuple[str, ...]] = [HEADS, UNITS]
    missing = []
    for wheel, motions in zip(wheels, found, strict=True):
        entry = motions[motion]
        rows.append((wheel.name, *cells(entry)))
        if isinstance(entry, str):
            missing.append(f"  {wheel.name}: {entry}")
        elif entry.cure:
            method, step = entry.cure
            missing.append(f"  {wheel.name}: by {method} with time.step = {step:g} s, since its own stops early")
    return "\n".join([motion, columns(rows, indent="  "), *missing])


def cells(found: Found | str) -> tuple[str, ...]:
    if isinstance(found, str):
        return ("-",) * (len(HEADS) - 1)
    height = "-" if found.height is None else f"{1e3 * found.height:.3f}"
    return (
        f"{1e2 * found.speed:+.2f}",
        f"{1e3 * found.ripple:.2f}",
        height,
        f"{found.drag:.3f}",
        f"{found.energy:.3f}",
        f"{found.load:.3f}",
    )


def draw(path, head: str, wheels: list[Candidate], found: list[dict[str, Found | str]]) -> None:
    try:
        from omnisim.pictures.plots.wheels import side_by_side
    except ImportError:
        raise Failure("a picture needs matplotlib: pip install 'omnisim-engine[plot]'", BAD_INPUT) from None
    side_by_side(head, [wheel.name for wheel in wheels], found).savefig(path)
