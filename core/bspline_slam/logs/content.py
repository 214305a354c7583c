"""The bytes of a log: read, hashed and unpacked."""

from __future__ import annotations

import hashlib
import zlib
from collections.abc import Iterable
from pathlib import Path

from bspline_slam.errors import LogError

GZIP_MAGIC = b"\x1f\x8b"
_PIECE = 1 << 16


def content_hash(files: Iterable[Path]) -> str:
    """SHA-256 of the files' bytes, one after the other."""
    digest = hashlib.sha256()
    for file in files:
        with file.open("rb") as stream:
            while piece := stream.read(_PIECE):
                digest.update(piece)
    return digest.hexdigest()


def unpack(path: Path, packed: bytes) -> tuple[bytes, list[str]]:
    """What a gzip file holds, all its members; of a cut or damaged one, what stands before the damage."""
    pieces: list[bytes] = []
    position, damage = 0, ""
    while packed.startswith(GZIP_MAGIC, position) and not damage:
        unpacker = zlib.decompressobj(wbits=31)
        while not unpacker.eof and not damage:
            piece = packed[position : position + _PIECE]
            try:
                pieces.append(unpacker.decompress(piece))
            except zlib.error:
                damage = "is damaged"
            position += len(piece) - len(unpacker.unused_data)
            if not piece:
                damage = "is cut off"
    data = b"".join(pieces)
    if damage and not data:
        raise LogError(path, f"the gzip file {damage}: nothing can be unpacked")
    return data, [f"The gzip file {damage}: what stands before that is read."] if damage else []
