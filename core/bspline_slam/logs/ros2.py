"""ROS 2 bags: folders, or single `.db3` and `.mcap` files, through rosbags."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from rosbags.interfaces import Connection
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
from rosbags.typesys import Stores, get_typestore

from bspline_slam.errors import LogError
from bspline_slam.logs.indexed_log import Progress
from bspline_slam.logs.magic import MCAP_MAGIC, SQLITE_MAGIC
from bspline_slam.logs.messages import (
    WANTED,
    RawMessage,
    Recording,
    canonical_type,
    printable,
)

_Reader = DirectoryReader | McapReader | Sqlite3Reader


def stored_files(folder: Path) -> list[Path]:
    """The bag files in a folder in the order of their numbers (`bag_2` before `bag_10`), compressed ones too."""
    files = [file for file in folder.iterdir() if file.is_file() and (_storage(file) or file.suffix == ".zstd")]
    return sorted(files, key=lambda file: (len(file.name), file.name))


def open_ros2(path: Path, progress: Progress) -> Recording:
    """The recording in a folder or a file. LogError for a folder that is no bag, and for a bag that is unreadable."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    topics: dict[str, str] = {}
    notes: list[str] = []
    readers = _folder_readers(path, notes) if path.is_dir() else {path.name: _file_reader(path)}
    return Recording(_messages(path, readers, topics, notes, progress), topics, store.deserialize_cdr, notes)


def _storage(file: Path) -> type[McapReader] | type[Sqlite3Reader] | None:
    with file.open("rb") as stream:
        magic = stream.read(16)
    if magic.startswith(MCAP_MAGIC):
        return McapReader
    return Sqlite3Reader if magic == SQLITE_MAGIC else None


def _file_reader(file: Path) -> _Reader:
    if _storage(file) is McapReader:
        return McapReader(file)
    return Sqlite3Reader(Path(quote(str(file))))  # the reader puts the path into a URI as it is


def _folder_readers(folder: Path, notes: list[str]) -> dict[str, _Reader]:
    """Readers of the files in a folder by name; `metadata.yaml` is needed only where the bag is compressed."""
    files = [file for file in stored_files(folder) if _storage(file)]
    if (folder / "metadata.yaml").exists():
        directory = DirectoryReader(folder)
        try:
            directory.open()
            compressed = directory.metadata.compression_mode is not None
            directory.close()
        except Exception as error:  # whatever the library stumbles over in a damaged bag
            if not files:
                raise LogError(folder, f"the bag cannot be opened, it may be damaged: {reason(error)}") from None
            notes.append(f"The bag is read without its metadata.yaml: {reason(error)}.")
        else:
            if compressed:
                return {folder.name: directory}
    if not files:
        raise LogError(folder, "the folder is no ROS 2 bag: it holds neither metadata.yaml nor a .db3 or .mcap file")
    return {file.name: _file_reader(file) for file in files}


def _messages(
    path: Path, readers: dict[str, _Reader], topics: dict[str, str], notes: list[str], progress: Progress
) -> Iterator[RawMessage]:
    for number, (name, reader) in enumerate(readers.items()):
        try:
            reader.open()
        except Exception as error:  # whatever the library stumbles over in a damaged bag
            if len(readers) == 1:
                raise LogError(
                    path, f"the bag cannot be opened, it may be cut off or damaged: {reason(error)}"
                ) from None
            notes.append(f"{name} is left out, as it cannot be opened: {reason(error)}.")
            continue
        try:
            wanted = _wanted(reader.connections, topics, notes)
            total = max(sum(connection.msgcount for connection in wanted), 1)
            for done, (connection, nanoseconds, payload) in enumerate(reader.messages(wanted) if wanted else ()):
                kind = canonical_type(connection.msgtype)
                yield RawMessage(printable(connection.topic), kind, 1e-9 * nanoseconds, bytes(payload))
                if done % 1000 == 0:
                    progress((number + min(done / total, 1.0)) / len(readers))
        except Exception as error:  # as above; what was read before it stands
            notes.append(f"{name} is damaged, what follows is left out: {reason(error)}.")
        finally:
            reader.close()


def _wanted(connections: list[Connection], topics: dict[str, str], notes: list[str]) -> list[Connection]:
    """The connections of the types that matter; all topics are entered into `topics`."""
    wanted = []
    for connection in connections:
        kind = canonical_type(connection.msgtype)
        topics[printable(connection.topic)] = kind
        encoding = getattr(connection.ext, "serialization_format", "cdr")
        if kind in WANTED and encoding != "cdr":
            notes.append(
                f"Topic {printable(connection.topic)} is left out: its messages are encoded as {encoding}, not as CDR."
            )
        elif kind in WANTED:
            wanted.append(connection)
    return wanted


def reason(error: Exception) -> str:
    """The text of a foreign error as the end of a sentence."""
    return printable(" ".join(str(error).split()) or type(error).__name__).rstrip(". ")
