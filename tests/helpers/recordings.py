"""Recordings of ROS 2 as readers other than omnisim find them: `rosbags` and `mcap` from the package index."""

from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple
from zlib import crc32

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

MAGIC = 8  # bytes at both ends of a file


class Said(NamedTuple):
    """A message: when (ns), its bytes and what is in them."""

    time: int
    raw: bytes
    message: Any


def by_rosbags(path: Path, release: str) -> dict[str, list[Said]]:
    """All messages by topic, read with the types of this release of ROS 2; written again they are the same bytes."""
    highlevel = pytest.importorskip("rosbags.highlevel", reason="needs rosbags")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores[release])
    with highlevel.AnyReader([path], default_typestore=store) as reader:
        found: dict[str, list[Said]] = {connection.topic: [] for connection in reader.connections}
        for connection, time, raw in reader.messages():
            message = store.deserialize_cdr(raw, connection.msgtype)
            assert store.serialize_cdr(message, connection.msgtype) == raw
            found[connection.topic].append(Said(time, raw, message))
        assert reader.message_count == sum(map(len, found.values()))
    return found


def by_mcap(path: Path) -> dict[str, list[Said]]:
    """The same by the decoder of MCAP's makers, which has only the definitions in the file; checksums are compared."""
    decoder = pytest.importorskip("mcap_ros2.decoder", reason="needs mcap-ros2-support")
    from mcap.reader import NonSeekingReader, make_reader

    found: dict[str, list[Said]] = {}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[decoder.DecoderFactory()])
        for _, channel, message, decoded in reader.iter_decoded_messages():
            found.setdefault(channel.topic, []).append(Said(message.log_time, message.data, decoded))
        file.seek(0)  # from beginning to end, with the checksum of all
        count = sum(1 for _ in NonSeekingReader(file, validate_crcs=True).iter_messages())
    assert count == sum(map(len, found.values()))
    return found


def records(path: Path) -> list[Any]:
    """The records of a file in order, chunks whole; checksums and indexes are compared with what they are of.

    By the specification of MCAP: no library checks its indexes.
    """
    from mcap import records as kinds
    from mcap.data_stream import ReadDataStream
    from mcap.stream_reader import StreamReader, breakup_chunk

    image = path.read_bytes()
    with open(path, "rb") as file:
        found = list(StreamReader(file, emit_chunks=True, validate_crcs=True).records)
    assert isinstance(found[0], kinds.Header) and isinstance(found[-1], kinds.Footer)
    footer, by_kind = found[-1], {}
    for record in found:
        by_kind.setdefault(type(record), []).append(record)
    assert 0 < footer.summary_start < footer.summary_offset_start
    assert footer.summary_crc == crc32(image[footer.summary_start : -MAGIC - 4]) != 0
    (end,) = by_kind[kinds.DataEnd]
    assert end.data_section_crc == crc32(image[: footer.summary_start - 9 - 4]) != 0  # less that record
    chunks, indexes = by_kind[kinds.Chunk], by_kind[kinds.ChunkIndex]
    assert all(early.message_end_time <= late.message_start_time for early, late in pairwise(chunks))
    said = 0
    for chunk, index in zip(chunks, indexes, strict=True):
        messages = [record for record in breakup_chunk(chunk, validate_crc=True) if isinstance(record, kinds.Message)]
        times = [message.log_time for message in messages]
        assert times == sorted(times) and chunk.uncompressed_crc != 0
        assert (times[0], times[-1]) == (chunk.message_start_time, chunk.message_end_time)
        assert (times[0], times[-1]) == (index.message_start_time, index.message_end_time)
        assert image[index.chunk_start_offset] == 6  # opcode of a chunk
        counted = 0
        for channel, offset in index.message_index_offsets.items():
            assert image[offset] == 7  # of a message index
            listed = kinds.MessageIndex.read(ReadDataStream(BytesIO(image[offset + 9 :])))
            assert listed.channel_id == channel
            assert [time for time, _ in listed.records] == [m.log_time for m in messages if m.channel_id == channel]
            counted += len(listed.records)
        assert counted == len(messages)
        said += counted
    (statistics,) = {repr(record): record for record in by_kind[kinds.Statistics]}.values()
    assert (statistics.message_count, statistics.chunk_count) == (said, len(chunks))
    return found


def matrices(transforms) -> dict[str, tuple[str, np.ndarray]]:
    """Of a message on /tf: child to parent and matrix (4, 4), which turns what is along the child into the parent."""
    found = {}
    for stamped in transforms:
        t, q = stamped.transform.translation, stamped.transform.rotation
        assert abs(np.hypot(np.hypot(q.x, q.y), np.hypot(q.z, q.w)) - 1.0) < 1e-15
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_matrix()
        matrix[:3, 3] = t.x, t.y, t.z
        assert stamped.child_frame_id not in found  # a frame has one parent
        found[stamped.child_frame_id] = stamped.header.frame_id, matrix
    return found


def in_world(found: dict[str, tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """The same of all frames in the world; a KeyError where they do not hang together."""
    placed = {"world": np.eye(4)}

    def place(frame: str) -> np.ndarray:
        if frame not in placed:
            parent, matrix = found[frame]
            placed[frame] = place(parent) @ matrix
        return placed[frame]

    return {frame: place(frame) for frame in found}


def plain(message: Any) -> Any:
    """A message as lists, numbers and texts, whichever library has made it."""
    if isinstance(message, np.ndarray):
        return message.tolist()
    if isinstance(message, (bytes, memoryview)):
        return list(message)
    if isinstance(message, (list, tuple)):
        return [plain(part) for part in message]
    if isinstance(message, (int, float, str, bool)):
        return message
    names = getattr(message, "__slots__", None) or vars(message)
    fields = [name for name in names if not (name.isupper() or name.startswith("_"))]  # neither constants nor its type
    return {name: plain(getattr(message, name)) for name in fields}
