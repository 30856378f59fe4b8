"""Pictures of wheels, in perspective of parallel rays: rollers in their rubber, hubs in their metal."""

import math
from collections.abc import Mapping
from io import BytesIO

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from omnisim.cad.geometry import roller_frames
from omnisim.cad.mesh import Mesh, placed, revolved, roller
from omnisim.scene.rollers import half_width, hub_radius
from omnisim.scene.wheel_schema import Disk, WheelType

RINGS, CORNERS, ROUND = 13, 20, 72  # of a roller, of a hub
AZIMUTH, ELEVATION = math.radians(42.0), math.radians(22.0)  # of the eye: from ahead towards the axle, and up
LIGHT = np.array([0.55, 0.35, 0.76])  # towards it: right, towards the eye, up
AMBIENT, EDGE = 0.4, 1.15  # how bright shade is; of the radius that is shown
RUBBER, METAL = (0.42, 0.48, 0.56), (0.86, 0.87, 0.89)
ACROSS, CELL, DPI = 6, 2.1, 90  # pictures in a line; inches of one


def sheet(wheels: Mapping[str, WheelType], suffix: str) -> bytes:
    """Wheels by name, all to their own scale with their diameter below, as an image: .png, .svg or .pdf."""
    lines = math.ceil(len(wheels) / ACROSS)
    across = min(len(wheels), ACROSS)
    figure = Figure(figsize=(CELL * across, 1.18 * CELL * lines), layout="constrained")
    panels = figure.subplots(lines, across, squeeze=False).ravel()
    for axes in panels:
        axes.set_axis_off()
    for axes, (name, kind) in zip(panels, wheels.items(), strict=False):
        portrait(axes, kind)
        rows = f"{len(kind.rows)} x " if len(kind.rows) > 1 else ""
        told = f"{name}\n{2e3 * kind.radius:.4g} mm, {rows}{kind.roller_count} rollers"
        axes.set_title(told, fontsize=8, y=-0.14, parse_math=False)
    image = BytesIO()
    with rc_context({"svg.hashsalt": "wheels"}):
        figure.savefig(image, format=suffix[1:], dpi=DPI, metadata={"Date": None} if suffix == ".svg" else None)
    return image.getvalue()


def portrait(axes: Axes, kind: WheelType) -> None:
    """The farthest part first; of each the triangles that face the eye, as bright as they face the light."""
    to_eye, right, up = view()
    towards_light = np.stack([right, to_eye, up], axis=1) @ LIGHT
    for part, colour in sorted(parts(kind), key=lambda each: float(each[0].vertices.mean(axis=0) @ to_eye)):
        triangles = part.vertices[part.faces]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        facing = normals @ to_eye > 0.0
        seen, light = triangles[facing], np.maximum(normals[facing] @ towards_light, 0.0)
        shades = np.clip(np.outer(AMBIENT + (1.0 - AMBIENT) * light, colour), 0.0, 1.0)
        flat = list(np.stack([seen @ right, seen @ up], axis=-1))
        axes.add_collection(PolyCollection(flat, facecolors=shades, edgecolors=shades, linewidths=0.3, rasterized=True))
    reach = EDGE * kind.radius
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")


def view() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vectors in the wheel's frame (h, k, z): towards the eye, to the right of the picture, up in it."""
    cos, sin = math.cos(ELEVATION), math.sin(ELEVATION)
    to_eye = np.array([-cos * math.sin(AZIMUTH), -cos * math.cos(AZIMUTH), sin])
    right = np.array([math.cos(AZIMUTH), -math.sin(AZIMUTH), 0.0])
    return to_eye, right, np.cross(to_eye, right)


def parts(kind: WheelType) -> list[tuple[Mesh, tuple[float, float, float]]]:
    """Closed meshes in the wheel's frame, and colours: rollers, and the hub as the scene has it or as it fits."""
    one = roller(kind, RINGS, CORNERS)
    found = [(placed(one, *frame), RUBBER) for frame in roller_frames(kind)]
    disk, axle = kind.disk, np.array([0.0, 1.0, 0.0])
    radius = disk.hub_radius or hub_radius(kind)
    half = 0.5 * disk.width or half_width(kind)
    rings = [(radius, -half, half)] if radius else []
    if disk.plate_radius:
        rings += plates(disk)
    for reach, low, high in rings:
        ends = np.array([low, high])
        found.append((placed(revolved(ends, np.full(2, reach), ends, ROUND), np.zeros(3), axle), METAL))
    return found


def plates(disk: Disk) -> list[tuple[float, float, float]]:
    half, inner = 0.5 * disk.width, 0.5 * disk.width - disk.plate_thickness
    return [(disk.plate_radius, -half, -inner), (disk.plate_radius, inner, half)]
