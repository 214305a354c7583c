"""Which format a log has: told by its content, never by its suffix.

The readers of ROS logs are loaded when there is one to read: rosbags takes its time.
"""

from __future__ import annotations

import mmap
from dataclasses import replace
from pathlib import Path

from bspline_slam.errors import LogError
from bspline_slam.logs.carmen import read_carmen
from bspline_slam.logs.content import content_hash, packer, unpack
from bspline_slam.logs.indexed_log import IndexedLog, Progress, unwatched
from bspline_slam.logs.magic import BAG_MAGIC, MCAP_MAGIC, SQLITE_MAGIC
from bspline_slam.logs.truth import companion, truth_at
from bspline_slam.scan import ScanLog

_ARCHIVES = {
    b"PK\x03\x04": "zip",
    b"\x28\xb5\x2f\xfd": "zstd",
    b"7z\xbc\xaf\x27\x1c": "7z",
}
_PEEK = 4096


def open_log(path: str | Path, topic: str | None = None, progress: Progress | None = None) -> ScanLog:
    """Open a laser log: CARMEN text (also packed by gzip, bzip2 or xz), a ROS 1 bag, or a ROS 2 bag (folder, `.db3` or
    `.mcap`).

    `topic` chooses the laser of a ROS log (default: the one with most scans). `progress` is called with the share of
    the index pass that is done (0 … 1). Raises LogError, one clear sentence, when nothing can be read; what is unusual
    in a log that can be read is told by its `notes`. True poses in a file `<log>.truth.tum` beside it are taken along.
    """
    path = Path(path)
    watch = progress or unwatched
    try:
        log = _read_folder(path, topic, watch) if path.is_dir() else _read_file(path, topic, watch)
        log = _with_truth(log)
    except OSError as error:
        raise LogError(path, f"it cannot be read: {error.strerror or error}") from error
    watch(1.0)
    return log


def _read_folder(path: Path, topic: str | None, progress: Progress) -> IndexedLog:
    from bspline_slam.logs.ros2 import stored_files

    return _read_ros2(path, topic, progress, stored_files(path))


def _read_file(path: Path, topic: str | None, progress: Progress) -> IndexedLog:
    if not path.exists():
        raise LogError(path, "no such file or folder")
    if not path.is_file():
        raise LogError(path, "it is neither a file nor a folder")
    with path.open("rb") as stream:
        start = stream.read(_PEEK)
    if not start:
        raise LogError(path, "the file is empty")
    if start.startswith((MCAP_MAGIC, SQLITE_MAGIC)):
        return _read_ros2(path, topic, progress, [path])
    if start.startswith(BAG_MAGIC):
        with path.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return _read_ros1(path, data, topic, progress)
    data, notes = path.read_bytes(), []
    if packer(start) is not None:
        data, notes = unpack(path, data)
        if data.startswith(BAG_MAGIC):
            return _with_notes(_read_ros1(path, data, topic, progress), notes)
    _refuse_binary(path, data[:_PEEK])
    return _with_notes(read_carmen(path, data, content_hash([path]), topic, progress), notes)


def _read_ros1(path: Path, data: bytes | mmap.mmap, topic: str | None, progress: Progress) -> IndexedLog:
    from bspline_slam.logs.ros import read_ros
    from bspline_slam.logs.ros1 import open_ros1

    return read_ros(path, open_ros1(path, data, progress), content_hash([path]), topic)


def _read_ros2(path: Path, topic: str | None, progress: Progress, files: list[Path]) -> IndexedLog:
    from bspline_slam.logs.ros import read_ros
    from bspline_slam.logs.ros2 import open_ros2

    return read_ros(path, open_ros2(path, progress), content_hash(files), topic)


def _refuse_binary(path: Path, start: bytes) -> None:
    """LogError for content that is neither text nor a format known above."""
    if not start:
        raise LogError(path, "the file is empty once unpacked")
    archive = next((name for magic, name in _ARCHIVES.items() if start.startswith(magic)), None)
    if archive is not None:
        raise LogError(path, f"this is a packed file ({archive}): unpack it first")
    if start.startswith((MCAP_MAGIC, SQLITE_MAGIC)):
        raise LogError(path, "this is a packed ROS 2 bag: unpack it first")
    if b"\0" in start:
        raise LogError(path, "the content is binary, but neither a ROS 1 bag nor a ROS 2 bag (.db3 or .mcap)")


def _with_truth(log: IndexedLog) -> IndexedLog:
    """The log with the true poses from the file beside it, unless it has its own."""
    file = companion(log.path)
    if log.truth is not None or file is None:
        return log
    truth, notes = truth_at(file, log.records.stamps[log.records.scan_of_record >= 0])
    return replace(_with_notes(log, notes), truth=truth)


def _with_notes(log: IndexedLog, first: list[str]) -> IndexedLog:
    return replace(log, notes=(*first, *log.notes)) if first else log
