"""What 3-D panels draw: forces and slip at the contacts, and the machine itself, for those that find no meshes.

Arrows between two points as visualization_msgs/msg/Marker has them: scale.x is the diameter of the shaft, scale.y that
of the head. A lifetime of 0 is for ever, so what is no longer there is deleted by its name.
"""

from typing import Any

import numpy as np

from omnisim.cad.mesh import roller
from omnisim.cad.robot_description import COLOURS, LAID, Body
from omnisim.exports.arrows import Scales, arrows, radius
from omnisim.exports.frames import Frames, X, about
from omnisim.exports.messages import WORLD, Messages, header, once, quaternions, ros, times

ARROW, CUBE, CYLINDER, TRIANGLES = 0, 1, 3, 11  # types of a Marker
ADD, DELETE = 0, 2
SHAFT, HEAD = 0.03, 0.09  # diameters of arrows, wheel radii
KINDS = {"normal": (0.39, 0.71, 0.96, 1.0), "friction": (1.0, 0.42, 0.38, 1.0), "slip": (0.49, 0.85, 0.52, 1.0)}
DRAWN = 9, 16  # rings and corners of a roller: a few hundred triangles


def contact_markers(frames: Frames, lengths: Scales) -> Messages:
    """Every message tells of every arrow, shown or deleted, so that one is enough wherever a player jumps to."""
    message, point, kinds, size = ros("MarkerArray"), ros("Point"), arrows(frames, lengths), radius(frames)
    scale = ros("Vector3")(SHAFT * size, HEAD * size, 0.0)
    same = [
        marker(arrow.kind, arrow.wheel, ARROW, scale, KINDS[arrow.kind])
        | {"frame_locked": False, "text": frames.trajectory.wheels[arrow.wheel]}
        for arrow in kinds
    ]
    places = [zip(arrow.shown.tolist(), arrow.tail.tolist(), arrow.tip.tolist(), strict=True) for arrow in kinds]
    for time, *row in zip(times(frames), *places, strict=True):
        head, found = header(time, WORLD), []
        for one, (shown, tail, tip) in zip(same, row, strict=True):
            ends = [point(*tail), point(*tip)] if shown else []
            found.append(ros("Marker")(**one, header=head, action=ADD if shown else DELETE, points=ends))
        yield time, message(found)


def machine_markers(frames: Frames) -> Messages:
    """The links of the URDF, as coarse triangles, cylinders and boxes that go with their frames; once for all."""
    kinds = {wheel.type: roller(frames.config.wheel_types[wheel.type], *DRAWN) for wheel in frames.config.wheels}
    triangles = {
        name: [ros("Point")(*corner) for corner in mesh.vertices[mesh.faces].reshape(-1, 3).tolist()]
        for name, mesh in kinds.items()
    }
    found = []
    for number, body in enumerate(frames.bodies):
        kind, size = body.shape
        if kind == "roller":
            found.append(shape(body, number, TRIANGLES, (1.0, 1.0, 1.0), triangles[size]))
        elif kind == "cylinder" and size[0] > 0.0:
            found.append(shape(body, number, CYLINDER, (2.0 * size[0], 2.0 * size[0], size[1]), []))
        elif size[0] > 0.0:
            found.append(shape(body, number, CUBE, size, []))
    return once(ros("MarkerArray")(found))


def shape(body: Body, number: int, kind: int, size: tuple[float, ...], points: list[Any]) -> Any:
    """A marker in the frame of a body, its place there that of the URDF."""
    colour = COLOURS["rubber" if kind == TRIANGLES else "stand_in"]
    one = marker("machine", number, kind, ros("Vector3")(*map(float, size)), tuple(map(float, colour.split())))
    if kind != TRIANGLES:
        laid = about(X, np.array([LAID[0] if kind == CYLINDER else 0.0]))
        one["pose"] = ros("Pose")(ros("Point")(*map(float, body.centre)), next(quaternions(laid)))
    return ros("Marker")(**one, header=header(0, body.name), frame_locked=True, text="", action=ADD, points=points)


def marker(name: str, number: int, kind: int, scale: Any, colour: tuple[float, ...]) -> dict[str, Any]:
    """Fields that do not change, or that nothing here needs."""
    nothing = np.zeros(0, np.uint8)
    return {
        "ns": name,
        "id": number,
        "type": kind,
        "pose": ros("Pose")(ros("Point")(0.0, 0.0, 0.0), ros("Quaternion")(0.0, 0.0, 0.0, 1.0)),
        "scale": scale,
        "color": ros("ColorRGBA")(*colour),
        "lifetime": ros("Duration")(0, 0),
        "colors": [],
        "texture_resource": "",
        "texture": ros("CompressedImage")(header(0, ""), "", nothing),
        "uv_coordinates": [],
        "mesh_resource": "",
        "mesh_file": ros("MeshFile")("", nothing),
        "mesh_use_embedded_materials": False,
    }
