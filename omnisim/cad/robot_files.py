"""A machine as files for other simulators: its description, by the suffix of the path, and meshes beside it.

Every roller of a wheel type has the same mesh; MJCF and URDF of one machine draw the same ones.
"""

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from omnisim.cad.mesh import DRAWN, FINE, controller_note, roller, stl
from omnisim.cad.mjcf import mjcf
from omnisim.cad.robot_description import text
from omnisim.cad.urdf import urdf
from omnisim.scene.schema import Config
from omnisim.scene.wheel_schema import WheelType


def robot_files(config: Config, path: Path, prefix: str = "") -> dict[Path, bytes]:
    """What each file is to hold, the description first: .urdf, or else MJCF, of the name that `path` has.

    prefix: of the names of meshes in a URDF, such as package://NAME/.
    """
    used = {wheel.type: config.type_of(wheel) for wheel in config.wheels}
    drawn = drawn_files(config, path)
    images = {drawn[name]: mesh_image(name, kind, DRAWN) for name, kind in used.items()}
    if path.suffix.lower() == ".urdf":
        said = urdf_text(config, path, lambda file: prefix + file.name)
    else:
        touching = {name: path.with_name(f"{path.stem}_{name}_contact.stl") for name in used}
        images |= {touching[name]: mesh_image(name, kind, FINE) for name, kind in used.items()}
        names = ({name: file.name for name, file in files.items()} for files in (drawn, touching))
        said = text(mjcf(config, path.stem, *names))
    return {path: said.encode()} | images


def urdf_text(config: Config, path: Path, named: Callable[[Path], str]) -> str:
    """A URDF of the name that `path` has; named: what it calls a mesh."""
    meshes = {name: named(file) for name, file in drawn_files(config, path).items()}
    return text(urdf(config, path.stem, meshes))


def drawn_files(config: Config, path: Path) -> dict[str, Path]:
    """The mesh of a roller of each wheel type in use, beside the description."""
    return {wheel.type: path.with_name(f"{path.stem}_{wheel.type}_roller.stl") for wheel in config.wheels}


def mesh_image(name: str, kind: WheelType, resolution: tuple[int, int]) -> bytes:
    return stl(roller(kind, *resolution), controller_note(name, kind))


def package_folder(path: Path, package: str) -> Path | None:
    """The nearest folder above the file that is the ROS package: by its own name or by that in its package.xml."""
    return next((folder for folder in path.resolve().parents if is_package(folder, package)), None)


def is_package(folder: Path, package: str) -> bool:
    try:
        named = (ElementTree.parse(folder / "package.xml").findtext("name") or "").strip()
    except (OSError, ElementTree.ParseError):
        named = folder.name
    return named == package
