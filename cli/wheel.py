"""`omnisim wheel`: what a workshop and other simulators want to know of a wheel, as text or as a file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import click

from omnisim.base.formatting import aligned, columns

from .screen import BAD_INPUT, Failure, note

if TYPE_CHECKING:
    import numpy as np

    from omnisim.scene.scene import Scene
    from omnisim.scene.schema import WheelType

STATIONS = 17  # of the profile
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
        click.echo(about(name, kind))
    elif suffix in MODELS:
        for each in loaded.config.wheel_types:
            wheel_type(loaded, each)  # all of them can be drawn
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
    """The type of this name, or the first one. Failure for one whose rollers are of another shape than is drawn."""
    from omnisim.scene.problems import did_you_mean

    kinds = scene.config.wheel_types
    name = next(iter(kinds)) if name is None else name
    if name not in kinds:
        hint = did_you_mean(name, kinds) or "."
        raise Failure(f"--type {name}: no such wheel type{hint} The scene has: {', '.join(kinds)}", BAD_INPUT)
    kind = kinds[name]
    if kind.profile.kind != "exact":
        raise Failure(f"wheel type '{name}': only wheels with rollers of the exact profile are drawn", BAD_INPUT)
    return name, kind


# --- text -----------------------------------------------------------------------------------------


def about(name: str, kind: WheelType) -> str:
    from omnisim.cad.geometry import of_type

    record = of_type(kind)
    sections = {
        f"wheel type '{name}'": aligned(dimensions(kind, record), indent="  "),
        "profile of a roller: u along its axis from the middle, r from its axis": profile_table(record),
        "room": aligned(room(kind, record), indent="  "),
        "rolling straight, by the shape of the rollers": ripple_table(record),
    }
    return "\n\n".join(f"{heading}\n{body}" for heading, body in sections.items())


def dimensions(kind: WheelType, record: np.record) -> dict[str, str]:
    from omnisim.cad.geometry import solid
    from omnisim.contact.roller_profile import length, profile_radius, tip_radius

    body = solid(record, kind.roller.bore_radius)
    roller = kind.roller
    density = roller.mass / body.volume
    in_rows = f" in rows at {', '.join(mm(row.offset) for row in kind.rows)}" if len(kind.rows) > 1 else ""
    return {
        "rolling radius": f"{mm(kind.radius)}, for the controller: {kind.radius:g} m at every angle",
        "rollers": f"{kind.rollers}{in_rows}, axes at {mm(kind.roller_distance)}, angle {kind.roller_angle_deg:g} deg",
        "roller length": mm(length(record)),
        "roller diameter": f"{mm(2.0 * profile_radius(record, 0.0))} amid, {mm(2.0 * tip_radius(record))} at the tips",
        "roller volume": f"{body.volume * 1e6:.5g} cm^3; {roller.mass:g} kg is {density:.4g} kg/m^3",
        "roller inertia": f"{roller.inertia_axial:.4g} kg m^2 about its axis, {roller.inertia_transverse:.4g} across; "
        f"of a solid {density * body.axial:.4g} and {density * body.transverse:.4g}",
    }


def profile_table(record: np.record) -> str:
    import numpy as np

    from omnisim.cad.geometry import profile

    q = np.linspace(-record.alpha, record.alpha, STATIONS)
    rows = [
        (f"{u * 1e3:10.4f}", f"{r * 1e3:9.4f}", f"{2e3 * r:12.4f}") for u, r in zip(*profile(record, q), strict=True)
    ]
    return columns([("     u, mm", "    r, mm", "diameter, mm"), *rows], indent="  ")


def room(kind: WheelType, record: np.record) -> dict[str, str]:
    from omnisim.cad.geometry import gap, hub_radius
    from omnisim.scene.rollers import gap_between_rows, gap_in_row

    margin = record.radius * record.cos_alpha - record.roller_distance
    hub = hub_radius(record)
    gaps = {
        "neighbours": told(gap(record)) or "they overlap: in one row the exact rollers do not fit",
        "next but one": told(gap(record, 2)) or "they overlap: in two rows the exact rollers do not fit",
    }
    if len(kind.rows) > 1:
        gaps = {
            "in a row": told(gap_in_row(kind)) or "neighbours overlap: the exact rollers do not fit",
            "between rows": told(gap_between_rows(kind)) or "rollers overlap: the rows are too near",
        }
    return {
        "tips": f"{mm(max(margin, 0.0))} until they are points (R cos alpha - R1)",
        **gaps,
        "hub": f"{mm(hub)} is the largest radius free of rollers" if hub > 0.0 else "rollers reach the axle",
        "": "Gaps are distances of surfaces: the widest slab that fits between two rollers, so never too large.",
    }


def told(distance: float) -> str:
    return f"gap of {mm(distance)}" if distance > 0.0 else ""


def ripple_table(record: np.record) -> str:
    from omnisim.cad.geometry import ripple, shapes

    rows: list[tuple[str, ...]] = [
        ("roller", "height of the centre, peak to peak, mm", "rolling radius: mean", "lowest", "highest")
    ]
    for shape, reach in shapes(record).items():
        found = ripple(record, reach)
        relative = [
            f"{(value / record.radius - 1.0) * 100.0 + 0.0:+.3f} %"
            for value in (found.mean, found.lowest, found.highest)
        ]
        rows.append((shape, f"{(found.highest - found.lowest) * 1e3:.4f}", *relative))
    return columns(rows, indent="  ")


def mm(metres: float) -> str:
    return f"{metres * 1e3:.4f} mm"


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


def holds(file: Path, image: bytes) -> bool:
    return file.is_file() and file.read_bytes() == image


def package_prefix(path: Path, package: str) -> str:
    """package://NAME/ and the way from the package's folder to that of the file."""
    from omnisim.cad.robot_files import package_folder

    folder = path.resolve().parent
    root = package_folder(path, package)
    if root is None:
        note(f"Warning: no folder around {path} is the package '{package}'; meshes are named as if its own were")
    return "/".join((f"package://{package}", *folder.relative_to(root or folder).parts, ""))
