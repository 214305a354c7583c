"""The bytes of a log: read, hashed and unpacked."""

from __future__ import annotations

import bz2
import hashlib
import lzma
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from bspline_slam.errors import LogError

PACKERS: dict[bytes, tuple[str, Callable[[], Any]]] = {
    b"\x1f\x8b": ("gzip", lambda: zlib.decompressobj(wbits=31)),
    b"BZh": ("bzip2", bz2.BZ2Decompressor),
    b"\xfd7zXZ\x00": ("xz", lzma.LZMADecompressor),
}
"""Packed files that are read as they are: how they begin, what they are called, what unpacks them."""
_PIECE = 1 << 16


def content_hash(files: Iterable[Path]) -> str:
    """SHA-256 of the files' bytes, one after the other."""
    digest = hashlib.sha256()
    for file in files:
        with file.open("rb") as stream:
            while piece := stream.read(_PIECE):
                digest.update(piece)
    return digest.hexdigest()


def packer(start: bytes) -> bytes | None:
    """How a file that begins so is packed: its key in PACKERS; None where it is not."""
    return next((magic for magic in PACKERS if start.startswith(magic)), None)


def unpack(path: Path, packed: bytes) -> tuple[bytes, list[str]]:
    """What a packed file holds, all its members; of a cut or damaged one, what stands before the damage."""
    magic = packer(packed)
    assert magic is not None
    name, unpacker_of = PACKERS[magic]
    pieces: list[bytes] = []
    position, damage = 0, ""
    while packed.startswith(magic, position) and not damage:
        unpacker = unpacker_of()
        while not unpacker.eof and not damage:
            piece = packed[position : position + _PIECE]
            try:
                pieces.append(unpacker.decompress(piece))
            except (zlib.error, lzma.LZMAError, OSError):
                damage = "is damaged"
            position += len(piece) - len(unpacker.unused_data)
            if not piece:
                damage = "is cut off"
    data = b"".join(pieces)
    if damage and not data:
        raise LogError(path, f"the {name} file {damage}: nothing can be unpacked")
    return data, [f"The {name} file {damage}: what stands before that is read."] if damage else []
