"""ROS 1 bags (format 2.0), read chunk by chunk from the front.

The index at the end of a bag is not used: bags whose index is irregular, or that were cut off before it was written,
are read like any other, and an index pass has to see every chunk anyway.
Format: http://wiki.ros.org/Bags/Format/2.0
"""

from __future__ import annotations

import mmap
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from rosbags.rosbag1.reader import decompressors
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from bspline_slam.errors import LogError
from bspline_slam.logs.indexed_log import Progress
from bspline_slam.logs.magic import BAG_MAGIC
from bspline_slam.logs.messages import (
    TRANSFORMS,
    WANTED,
    RawMessage,
    Recording,
    canonical_type,
    printable,
)

_VERSION = b"#ROSBAG V2.0\n"
_MESSAGE, _INDEX, _CHUNK, _CONNECTION = 2, 4, 5, 7
_INDEX_ENTRY = 12


class CutOff(Exception):
    """The bytes end in the middle of a record, of which `header` and `body` are there."""

    def __init__(self, header: dict[bytes, bytes] | None = None, body: bytes = b"") -> None:
        self.header = header
        self.body = body


_DAMAGE = (CutOff, ValueError, LookupError, struct.error, OSError, EOFError, RuntimeError)


def open_ros1(path: Path, data: bytes | mmap.mmap, progress: Progress) -> Recording:
    """The recording in the bytes of a bag. LogError for a version other than 2.0."""
    if data[: len(_VERSION)] != _VERSION:
        version = printable(data[len(BAG_MAGIC) : len(BAG_MAGIC) + 3].decode("latin-1"))
        raise LogError(path, f"the bag has format {version}, only 2.0 can be read; `rosbag fix` converts it")
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
    topics: dict[str, str] = {}
    notes: list[str] = []
    return Recording(_messages(data, topics, notes, progress), topics, store.deserialize_ros1, notes)


def _messages(
    data: bytes | mmap.mmap, topics: dict[str, str], notes: list[str], progress: Progress
) -> Iterator[RawMessage]:
    connections: dict[int, tuple[str, str]] = {}
    damaged = 0
    position = len(_VERSION)
    while position < len(data):
        try:
            header, body, position = _record(data, position)
        except CutOff as cut:
            notes.append(f"The bag is cut off or damaged at byte {position}: only what stands before that is read.")
            if cut.header is not None:
                with suppress(*_DAMAGE):
                    yield from _records(cut.header, cut.body, connections, topics)
            break
        try:
            yield from _records(header, body, connections, topics)
        except _DAMAGE:
            damaged += 1
        progress(position / len(data))
    if damaged:
        notes.append(f"{damaged} damaged chunks or records of the bag are left out.")


def _records(
    header: dict[bytes, bytes], body: bytes, connections: dict[int, tuple[str, str]], topics: dict[str, str]
) -> Iterator[RawMessage]:
    """The messages in a record; a chunk holds records itself, and a connection record names a topic."""
    kind = header[b"op"][0]
    if kind == _CHUNK:
        content = decompressors[header[b"compression"].decode()](body)
        inner = 0
        while inner < len(content):
            part, inner_body, inner = _record(content, inner)
            if part[b"op"][0] != _CHUNK:
                yield from _records(part, inner_body, connections, topics)
    elif kind == _CONNECTION:
        topic = printable(header[b"topic"].decode())
        about = _fields(body)
        connections[_integer(header[b"conn"])] = topic, canonical_type(about[b"type"].decode())
        topics[topic] = canonical_type(about[b"type"].decode())
    elif kind == _MESSAGE:
        topic, message_type = connections[_integer(header[b"conn"])]
        if message_type in WANTED:
            seconds, nanoseconds = struct.unpack("<II", header[b"time"])
            yield RawMessage(topic, message_type, seconds + 1e-9 * nanoseconds, body)


def _record(data: bytes | mmap.mmap, position: int) -> tuple[dict[bytes, bytes], bytes, int]:
    """Header fields and body of the record at `position`, and the position after it.

    Index records say the number of their entries; some writers announce more bytes than these take.
    """
    packed, position = _sized(data, position)
    header = _fields(packed)
    if header.get(b"op") == bytes([_INDEX]) and b"count" in header:
        return header, b"", position + 4 + _INDEX_ENTRY * _integer(header[b"count"])
    try:
        body, position = _sized(data, position)
    except CutOff:
        raise CutOff(header, data[position + 4 :]) from None
    return header, body, position


def _sized(data: bytes | mmap.mmap, position: int) -> tuple[bytes, int]:
    start = position + 4
    if start > len(data):
        raise CutOff
    end = start + _integer(data[position:start])
    if end > len(data):
        raise CutOff
    return data[start:end], end


def _fields(header: bytes) -> dict[bytes, bytes]:
    """`name=value` fields, each preceded by its length."""
    fields: dict[bytes, bytes] = {}
    position = 0
    while position < len(header):
        entry, position = _sized(header, position)
        name, _, value = entry.partition(b"=")
        fields[name] = value
    return fields


def _integer(value: bytes) -> int:
    return int.from_bytes(value, "little")
