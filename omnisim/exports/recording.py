"""A run as an MCAP file of ROS 2 messages, which Foxglove, RViz and readers of rosbags open, and its URDF beside it.

The container is written by the library `mcap`, what is in it serialised by `rosbags`. What ROS 2 looks for beyond its
messages, as rosbag2 writes it: the profile, the quality of service of each channel, the metadata "rosbag2".
"""

import json
from collections.abc import Iterator
from heapq import merge
from io import BytesIO
from pathlib import Path
from typing import Any

from omnisim.base.formatting import visible
from omnisim.base.version import VERSION
from omnisim.cad.robot_files import robot_files, urdf_text
from omnisim.exports.arrows import scales
from omnisim.exports.frames import Frames
from omnisim.exports.messages import store
from omnisim.exports.topics import Topic, topics
from omnisim.results.layout import Recorded
from omnisim.results.tables import ExportError, extra
from omnisim.scene.scene import parse

PROFILE, ENCODING, SCHEMA = "ros2", "cdr", "ros2msg"  # names of the registry of MCAP
FOREVER = {"sec": 9223372036, "nsec": 854775807}
LATCHED = {  # by the numbers of rmw/types.h: keep the last one, reliably, for those who come later
    "history": 1, "depth": 1, "reliability": 1, "durability": 1, "deadline": FOREVER, "lifespan": FOREVER,
    "liveliness": 1, "liveliness_lease_duration": FOREVER, "avoid_ros_namespace_conventions": False,
}  # fmt: skip
METADATA_VERSION = 8  # of rosbag2: the last in which quality of service is told by numbers, as Humble reads it


def files(trajectory: Recorded, path: Path) -> dict[Path, bytes]:
    """What each file is to hold: the recording, the URDF, a mesh of a roller of each wheel type in use.

    In the recording meshes have the whole path of those files, since RViz finds no others; in the URDF their names.

    Raises ExportError for a name that cannot be that of a model, and SceneError if the scene cannot be read.
    """
    if not path.stem.isprintable():
        raise ExportError(f"{visible(str(path))}: the name of a model must be printable")
    config = parse(trajectory.attributes["scene"], "scene of the file").config
    frames = Frames(trajectory, config)
    description = path.with_suffix(".urdf")
    said = urdf_text(config, description, lambda mesh: mesh.resolve().as_uri())
    return {path: recording(frames, said)} | robot_files(config, description)


def recording(frames: Frames, description: str) -> bytes:
    """The file; description: of the machine."""
    with extra("mcap"):
        from mcap.writer import Writer
    image, lengths = BytesIO(), scales(frames)
    writer = Writer(image, enable_data_crcs=True)
    writer.start(PROFILE, f"omnisim {VERSION}")
    channels = Channels(writer)
    last = count = 0
    for time, channel, number, data in merge(
        *(channels.messages(topic) for topic in topics(frames, lengths, description)), key=lambda found: found[0]
    ):
        writer.add_message(channel, time, data, time, number)
        last, count = time, count + 1
    run = frames.trajectory.attributes
    told = {name: str(run[name]) for name in ("omnisim_version", "title", "scene", "model", "status")}
    writer.add_metadata("omnisim", told | {"m_per_N": repr(lengths.force), "m_per_m/s": repr(lengths.slip)})
    writer.add_metadata("rosbag2", {"serialized_metadata": bag_metadata(last, count)})
    writer.finish()
    return image.getvalue()


class Channels:
    """Those of a file, made as topics are."""

    def __init__(self, writer: Any):
        self.writer = writer
        self.schemas: dict[str, int] = {}

    def messages(self, topic: Topic) -> Iterator[tuple[int, int, int, bytes]]:
        """Time (ns), channel, number and bytes of each. Topics without any have a channel as well."""
        if topic.type not in self.schemas:
            definition, _ = store().generate_msgdef(topic.type, ros_version=2)
            self.schemas[topic.type] = self.writer.register_schema(topic.type, SCHEMA, definition.encode())
        service = json.dumps([LATCHED]) if topic.latched else ""
        told = {"offered_qos_profiles": service, "topic_type_hash": store().hash_rihs01(topic.type)}
        channel = self.writer.register_channel(topic.name, ENCODING, self.schemas[topic.type], told)
        for number, (time, message) in enumerate(topic.messages):
            yield time, channel, number, bytes(store().serialize_cdr(message, topic.type, little_endian=True))


def bag_metadata(last: int, count: int) -> str:
    """What rosbag2 asks of a file before it counts for itself, in YAML, which JSON is."""
    return json.dumps({
        "version": METADATA_VERSION, "storage_identifier": "mcap", "duration": {"nanoseconds": last},
        "starting_time": {"nanoseconds_since_epoch": 0}, "message_count": count, "topics_with_message_count": [],
        "compression_format": "", "compression_mode": "", "relative_file_paths": [], "files": [], "custom_data": {},
        "ros_distro": "humble",
    })  # fmt: skip
