"""Rollers and wheels as closed triangle meshes, and files of them: binary STL and OBJ."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from omnisim.base.files import write_whole
from omnisim.cad.geometry import roller_frames
from omnisim.scene.rollers import drawn, half_width, hub_radius
from omnisim.scene.wheel_schema import WheelType

RINGS, CORNERS = 81, 160  # of a roller: vertices lie on the exact surface, volume and inertia are within 1e-3
DRAWN = 33, 64  # of a roller that is drawn and touches nothing: 0.2 MB
FINE = 257, 320  # of one that touches, where every edge costs energy: about the 200000 triangles that MuJoCo reads
POINTED = 1e-6  # of the wheel radius: a smaller end disc is a point
STL_HEAD = 80  # bytes
STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class Mesh(NamedTuple):
    """Vertices (V, 3), m, and faces (F, 3), counterclockwise from outside."""

    vertices: np.ndarray
    faces: np.ndarray


def roller(kind: WheelType, rings: int = RINGS, corners: int = CORNERS) -> Mesh:
    """The profile at about `rings` stations about the axis z, each a polygon of `corners` on the surface."""
    u, r = drawn(kind, rings)
    round_ = r > POINTED * kind.radius
    return revolved(u[round_], r[round_], u[[0, -1]], corners)


def revolved(z: np.ndarray, r: np.ndarray, ends: np.ndarray, corners: int) -> Mesh:
    """A solid of revolution about z through circles of radius r at heights z, closed by a vertex at each of `ends`."""
    turn = 2.0 * np.pi * np.arange(corners) / corners
    circles = np.stack([np.outer(r, np.cos(turn)), np.outer(r, np.sin(turn)), np.outer(z, np.ones(corners))], axis=-1)
    vertices = np.concatenate([circles.reshape(-1, 3), [[0.0, 0.0, ends[0]], [0.0, 0.0, ends[1]]]])
    index = np.arange(len(z) * corners).reshape(len(z), corners)
    following = np.roll(index, -1, axis=1)
    low, low_next, high, high_next = index[:-1], following[:-1], index[1:], following[1:]
    bottom, top = (np.full(corners, len(vertices) - count) for count in (2, 1))
    sides = np.stack([low, low_next, high_next, low, high_next, high], axis=-1).reshape(-1, 3)
    caps = [np.column_stack([following[0], index[0], bottom]), np.column_stack([index[-1], following[-1], top])]
    return Mesh(vertices, np.concatenate([sides, *caps]))


def whole(kind: WheelType) -> Mesh:
    """All rollers of a wheel in its frame, and a plain cylinder as hub, since a scene says nothing of the disk's shape.

    Every part is closed in itself.
    """
    part = roller(kind)
    parts = [placed(part, *frame) for frame in roller_frames(kind)]
    radius, half = hub_radius(kind), half_width(kind)
    if radius > 0.0:
        ends = np.array([-half, half])
        hub = revolved(ends, np.full(2, radius), ends, CORNERS)
        parts.append(placed(hub, np.zeros(3), np.array([0.0, 1.0, 0.0])))
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    faces = [part.faces + start for part, start in zip(parts, starts, strict=True)]
    return Mesh(np.concatenate([part.vertices for part in parts]), np.concatenate(faces))


def placed(part: Mesh, centre: np.ndarray, axis: np.ndarray) -> Mesh:
    """The mesh with its z turned to the unit vector `axis` and its origin moved to `centre`."""
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    return Mesh(part.vertices @ np.array([side, np.cross(axis, side), axis]) + centre, part.faces)


def write(mesh: Mesh, path: Path, note: str) -> None:
    """An .obj or, by any other suffix, a binary .stl; metres. `note` (ASCII) goes into its head. Raises OSError."""
    write_whole({path: obj(mesh, note) if path.suffix.lower() == ".obj" else stl(mesh, note)}, overwrite=True)


def controller_note(name: str, kind: WheelType) -> str:
    """What whoever programs the controller has to know, for the head of a file."""
    return f"omnisim, metres; rolling radius for the controller {kind.radius:g} m ({name})"


def stl(mesh: Mesh, note: str) -> bytes:
    """80 bytes of text, the number of triangles, and each with its normal."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    triangles = np.zeros(len(corners), STL_TRIANGLE)
    triangles["normal"] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    triangles["corners"] = corners
    head = note.encode("ascii")[:STL_HEAD].ljust(STL_HEAD)
    return head + np.array(len(corners), "<u4").tobytes() + triangles.tobytes()


def obj(mesh: Mesh, note: str) -> bytes:
    lines = [f"# {note}"]
    lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (mesh.faces + 1).tolist()]
    return ("\n".join(lines) + "\n").encode("ascii")
