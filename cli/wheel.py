"""`omnisim wheel`: what a workshop and other simulators want to know of a wheel, as text or as a file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from .screen import BAD_INPUT, Failure, note

if TYPE_CHECKING:
    from omnisim.scene.scene import Scene
    from omnisim.scene.wheel_schema import WheelType

PACKAGE = "[A-Za-z][A-Za-z0-9_-]*"
DRAWINGS = (".png", ".svg", ".pdf")
MESHES = (".stl", ".obj")
MODELS = (".xml", ".urdf")


@click.command()
@click.argument("scenes", metavar="SCENE...", nargs=-1, required=True)
@click.option("--type", "name", metavar="NAME", help="A wheel type of the scene; else its first.")
@click.option("-o", "output", metavar="FILE", help="Output file; its suffix says what it holds.")
@click.option("--part", type=click.Choice(("wheel", "roller")), help="What a mesh holds; else the wheel.")
@click.option("--package", metavar="NAME", help="ROS package of a .urdf: its meshes are package://NAME/...")
@click.option("--mass", type=click.FloatRange(0, min_open=True), metavar="KG", help="Of the platform, of several.")
@click.option("--speed", type=click.FloatRange(0, min_open=True), metavar="M/S", help="Of the same.")
@click.option("--force", is_flag=True, help="Replace output files that exist.")
def wheel(
    scenes: tuple[str, ...],
    name: str | None,
    output: str | None,
    part: str | None,
    package: str | None,
    mass: float | None,
    speed: float | None,
    force: bool,
) -> None:
    """Dimensions, room and ripple of a wheel of SCENE; its drawing, its mesh, or a model for other simulators.

    Of several scenes all wheels side by side: four of each carry one platform through the same motions.

    \b
    omnisim wheel youbot                             dimensions for the workshop
    omnisim wheel mixed --type omni -o omni.png      drawing: .png, .svg, .pdf
    omnisim wheel youbot --part roller -o roller.stl mesh in metres: .stl, .obj
    omnisim wheel youbot -o youbot.xml               the whole machine: .xml (MuJoCo), .urdf, meshes beside it
    omnisim wheel youbot kiwi -o both.png            speed, ripple, drag, energy, peak loads: a table and a picture
    """
    suffix = Path(output or "").suffix.lower()
    if len(scenes) > 1:
        from .wheel_cycle import compare

        if given := [option for option, value in (("--type", name), ("--part", part), ("--package", package)) if value]:
            raise Failure(f"{given[0]} is for the wheels of one scene", BAD_INPUT)
        if output is not None and suffix not in DRAWINGS:
            raise Failure(f"{output}: a picture of several wheels is one of {', '.join(DRAWINGS)}", BAD_INPUT)
        compare(scenes, mass, speed, output, force)
        return
    (scene,) = scenes
    if mass or speed:
        raise Failure("--mass and --speed are for several scenes, whose wheels carry a platform", BAD_INPUT)
    from omnisim.scene.scene import load

    loaded = load(scene)
    if output is not None and suffix not in (*DRAWINGS, *MESHES, *MODELS):
        known = ", ".join((*DRAWINGS, *MESHES, *MODELS))
        raise Failure(f"{output}: the suffix says what to write, one of {known}", BAD_INPUT)
    if part and suffix not in MESHES:
        raise Failure(f"--part is for meshes: {', '.join(MESHES)}", BAD_INPUT)
    if name and suffix in MODELS:
        raise Failure(f"--type: a {suffix} has all wheels of the scene", BAD_INPUT)
    if package is not None:
        check_package(package, suffix)
    name, kind = wheel_type(loaded, name)
    if output is None:
        from omnisim.scene.masses import share_of_weight

        from .wheel_text import about

        click.echo(about(name, kind, share_of_weight(loaded.config)))
    elif suffix in MODELS:
        write_model(loaded, scene, output, package, force)
    else:
        from .output import output_path

        path = output_path(output, scene, force)
        if suffix in DRAWINGS:
            write_drawing(path, name, kind)
        else:
            write_mesh(path, part or "wheel", name, kind)
        click.echo(path)


def check_package(package: str, suffix: str) -> None:
    if suffix != ".urdf":
        raise Failure("--package is for .urdf: other models name the meshes beside them", BAD_INPUT)
    if not re.fullmatch(PACKAGE, package):
        raise Failure(f"--package {package}: must be the name of a ROS package, {PACKAGE}", BAD_INPUT)


def wheel_type(scene: Scene, name: str | None) -> tuple[str, WheelType]:
    """The type of this name, or the first one."""
    from omnisim.scene.problems import did_you_mean

    kinds = scene.config.wheel_types
    name = next(iter(kinds)) if name is None else name
    if name not in kinds:
        hint = did_you_mean(name, kinds) or "."
        raise Failure(f"--type {name}: no such wheel type{hint} The scene has: {', '.join(kinds)}", BAD_INPUT)
    return name, kinds[name]


# --- files ----------------------------------------------------------------------------------------


def write_drawing(path: Path, name: str, kind: WheelType) -> None:
    try:
        from omnisim.cad.drawing import draw
    except ImportError:
        raise Failure("a drawing needs matplotlib: pip install 'omnisim-engine[plot]'", BAD_INPUT) from None
    draw(path, name, kind)


def write_mesh(path: Path, part: str, name: str, kind: WheelType) -> None:
    from omnisim.cad.mesh import controller_note, roller, whole, write
    from omnisim.scene.rollers import gap_between_rows, gap_in_row

    if part == "wheel" and min(gap_in_row(kind), gap_between_rows(kind)) < 0.0:
        where = "in one row" if len(kind.rows) == 1 else "in their rows"
        note(f"Warning: the rollers of this wheel overlap {where}, and so do those of the mesh")
    write(roller(kind) if part == "roller" else whole(kind), path, controller_note(name, kind))


def write_model(scene: Scene, source: str, output: str, package: str | None, force: bool) -> None:
    """The model, and beside it the meshes of a roller of each wheel type in use.

    A mesh that is there already, just as it would be written, stays: that of a model in the other format.
    """
    from omnisim.base.files import holds
    from omnisim.cad.robot_files import robot_files
    from omnisim.scene.problems import ConfigError
    from omnisim.scene.scene import SceneError

    from .output import deliver, output_path

    path = output_path(output, source, force)
    if not path.stem.isprintable():
        raise Failure(f"{path.stem!r}: the name of a model must be printable", BAD_INPUT)
    try:
        images = robot_files(scene.config, path, package_prefix(path, package) if package else "")
    except ConfigError as error:  # a machine free in space that cannot begin where it is put
        raise SceneError(scene.document.told(error.problems)) from None
    missing = {file: image for file, image in images.items() if file == path or not holds(file, image)}
    for file in missing:
        output_path(str(file), source, force)
    deliver(missing, force)
    click.echo("\n".join(map(str, images)))


def package_prefix(path: Path, package: str) -> str:
    """package://NAME/ and the way from the package's folder to that of the file."""
    from omnisim.cad.robot_files import package_folder

    folder = path.resolve().parent
    root = package_folder(path, package)
    if root is None:
        note(f"Warning: no folder around {path} is the package '{package}'; meshes are named as if its own were")
    return "/".join((f"package://{package}", *folder.relative_to(root or folder).parts, ""))
