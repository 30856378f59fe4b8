"""`omnisim data`: what comes with the package: scenes, wheels that are sold, measured robots."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from omnisim.base.formatting import columns

from .screen import BAD_INPUT, Failure

if TYPE_CHECKING:
    from omnisim.scene.wheel_schema import WheelType

PICTURES = (".png", ".svg", ".pdf")
OF_SCENES = ("fm202", "soccer_kit", "soccer_robot", "youbot")  # whose wheels are those of a machine that there is


@click.command()
@click.argument("names", metavar="[NAME...]", nargs=-1)
@click.option("-o", "output", metavar="FILE", help="A .toml copies NAME; .png, .svg or .pdf shows wheels, else all.")
@click.option("--force", is_flag=True, help="Replace an output file that exists.")
def data(names: tuple[str, ...], output: str | None, force: bool) -> None:
    """List what comes with the package; print NAME, a scene or a wheel, or copy it to a file of your own.

    Every wheel says in its file where each number is from, or how it is estimated.

    \b
    omnisim data                                    names: scenes, wheels that are sold, measured robots
    omnisim data lekiwi_omni_102                    its file, with its sources
    omnisim data lekiwi_omni_102 -o mine.toml       a copy to change
    omnisim data -o wheels.png                      pictures of wheels that there are: .png, .svg, .pdf
    omnisim data youbot fm202 -o two.png            of the wheels of these
    """
    from omnisim.scene.packaged import packaged_text

    chosen = [known(name) for name in names]
    if output is None:
        click.echo("\n\n".join(map(packaged_text, chosen)) or catalogue())
        return
    from .output import deliver, output_path

    suffix = Path(output).suffix.lower()
    if suffix not in PICTURES and (suffix != ".toml" or len(names) != 1):
        raise Failure(f"{output}: must be {', '.join(PICTURES)} or, of one NAME, .toml", BAD_INPUT)
    path = output_path(output, "", force)
    deliver({path: packaged_text(*chosen).encode() if suffix == ".toml" else pictures(chosen, suffix)}, force)
    click.echo(path)


def known(name: str) -> str:
    """The name of a packaged scene or wheel; Failure for any other."""
    from omnisim.scene.packaged import packaged_scenes, packaged_wheels
    from omnisim.scene.problems import did_you_mean

    names = [*packaged_scenes(), *packaged_wheels()]
    if name not in names:
        hint = did_you_mean(name, names) or "."
        raise Failure(f"{name}: nothing of this name comes with the package{hint} See: omnisim data", BAD_INPUT)
    return name


def pictures(names: list[str], suffix: str) -> bytes:
    """Of the wheel types of these scenes, or of all packaged wheels and OF_SCENES."""
    try:
        from omnisim.cad.portrait import sheet
    except ImportError:
        raise Failure("pictures need matplotlib: pip install 'omnisim-engine[plot]'", BAD_INPUT) from None
    from omnisim.scene.packaged import packaged_wheels
    from omnisim.scene.scene import load

    types: dict[str, WheelType] = {}
    for name in names or [*packaged_wheels(), *OF_SCENES]:
        kinds = load(name).config.wheel_types
        types |= {name if len(kinds) == 1 else f"{name}: {key}": kind for key, kind in kinds.items()}
    return sheet(types, suffix)


# --- the list -------------------------------------------------------------------------------------


def catalogue() -> str:
    from omnisim.fitting.fit_file import packaged_fits

    sections = {
        "scenes: omnisim run NAME": scene_table(),
        "wheels that are sold: omnisim wheel NAME": wheel_table(),
        "measured robots: omnisim fit NAME": columns([("", name) for name in packaged_fits()]),
    }
    return "\n\n".join(f"{heading}\n{body}" for heading, body in sections.items())


def scene_table() -> str:
    from omnisim.scene.packaged import packaged_scenes
    from omnisim.scene.scene import load

    return columns([(name, load(name).config.title) for name in packaged_scenes()], indent="  ")


def wheel_table() -> str:
    """Sizes of each packaged wheel, as they are in its scene."""
    from omnisim.scene.masses import wheel_mass
    from omnisim.scene.packaged import packaged_wheels
    from omnisim.scene.scene import load

    rows: list[tuple[str, ...]] = [("", "diameter", "rollers", "angle", "mass", "")]
    for name in packaged_wheels():
        config = load(name).config
        (kind,) = config.wheel_types.values()
        rings = f"{len(kind.rows)} x " if len(kind.rows) > 1 else ""
        size, grams = f"{2e3 * kind.radius:.4g} mm", 1e3 * wheel_mass(kind)
        mass = f"{grams:.0f} g" if grams >= 100.0 else f"{grams:.3g} g"
        rows.append((name, size, f"{rings}{kind.roller_count}", f"{kind.roller_angle_deg:g} deg", mass, config.title))
    return columns(rows, indent="  ")
