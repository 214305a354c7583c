"""The journal: every action on a log, on disk before anybody sees its effect.

An append-only text file, one JSON object per line: first what the edits belong to, then one line per action. `check` of
a line is a hash over it and over that of the line before, so that a damaged, missing or foreign line is noticed. A line
counts once it is complete: what was being written when the program was killed is dropped.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bspline_slam.config import config_to_dict
from bspline_slam.edits.history import History, Operation, operation_from_dict, operation_to_dict
from bspline_slam.errors import EditError
from bspline_slam.scan import ScanLog

FORMAT = "splinescope-edits"
VERSION = 1
SEED = "0" * 16


@dataclass(frozen=True, eq=False, slots=True)
class Origin:
    """What edits belong to: the log by path and content hash, and the resolved configuration of its run."""

    log: str
    content_hash: str
    configuration: Mapping[str, Any]

    @classmethod
    def of(cls, log: ScanLog, config: Any) -> Origin:
        """That of the edits of a run over the log with this configuration."""
        return cls(str(log.path), log.content_hash, config_to_dict(config))


@dataclass(frozen=True, eq=False, slots=True)
class Recorded:
    """What a journal holds: `size` bytes of it are whole, and `check` is that of its last line."""

    origin: Origin
    history: History
    notes: tuple[str, ...]
    size: int
    check: str


class Journal:
    """A journal open for writing; one program at a time may hold it. State: the file, and the history in it."""

    def __init__(self, path: Path, origin: Origin) -> None:
        """Go on with the journal at `path`, or begin it. Raises EditError where it belongs to another result, is
        damaged, in use, or cannot be written."""
        self.path = path
        self._file = _claimed(path)
        try:
            recorded = _parsed(path, self._file.read())
            if recorded is None:
                recorded = Recorded(origin, History(), (), 0, SEED)
            _check_origin(path, recorded.origin, origin)
            self.origin, self.history, self.notes = recorded.origin, recorded.history, recorded.notes
            self._check = recorded.check
            self._file.truncate(recorded.size)
            if recorded.size == 0:
                self._write(_head(origin))
                _sync_folder(path.parent)
        except BaseException:
            self._file.close()
            raise

    def append(self, operation: Operation) -> History:
        """The history after an operation that is safe on disk now. Raises EditError for one that makes no sense, and
        where nothing can be written or somebody has removed the file; the history is as before then."""
        history = self.history.after(operation)
        self._write(operation_to_dict(operation))
        self.history = history
        return history

    def close(self) -> None:
        """Let others write."""
        self._file.close()

    def _write(self, content: Mapping[str, Any]) -> None:
        if os.fstat(self._file.fileno()).st_nlink == 0:
            raise EditError(f"{self.path} has been removed: edits would be lost; open the log again to begin it anew")
        check = _check(self._check, content)
        before = self._file.seek(0, os.SEEK_END)
        try:
            self._file.write((json.dumps({"check": check, **content}, ensure_ascii=False) + "\n").encode())
            os.fsync(self._file.fileno())
        except OSError as error:
            self._file.truncate(before)
            raise EditError(f"{self.path} cannot be written: {error.strerror}") from None
        self._check = check


def read_journal(path: Path) -> Recorded:
    """What the journal at `path` holds. Raises EditError where there is none, or a damaged one."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise EditError(f"{path.name} cannot be read: {error.strerror}") from None
    recorded = _parsed(path, content)
    if recorded is None:
        raise EditError(f"{path.name} is no journal of edits")
    return recorded


def _claimed(path: Path) -> Any:
    """The file, open for reading and appending, in nobody else's hands."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o644), "r+b", buffering=0)
    except OSError as error:
        raise EditError(f"{path} cannot be written: {error.strerror}") from None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise EditError(f"{path.name} is open in another SplineScope: close that one first") from None
    return file


def _parsed(path: Path, content: bytes) -> Recorded | None:
    """What the lines say; None where not even the first one is whole."""
    *lines, torn = content.split(b"\n")
    check, size, origin, history = SEED, 0, None, History()
    for number, line in enumerate(lines, 1):
        try:
            data = _checked(line, check)
            if number == 1:
                origin = _origin(path, data)
            else:
                history = history.after(operation_from_dict(data))
        except _Damaged:
            if number > 1:
                raise EditError(f"{path.name}:{number}: the line is damaged; remove it and those after it") from None
            raise EditError(f"{path.name} is no journal of edits, or its first line is damaged") from None
        except EditError as error:
            raise EditError(f"{path.name}:{number}: {error}") from None
        check, size = _check(check, data), size + len(line) + 1
    if origin is None:
        if torn and not b'{"check": "'.startswith(torn[:11]):
            raise EditError(f"{path.name} is no journal of edits")
        return None
    notes = (f"The last action in {path.name} was not written to its end and is left out.",) if torn else ()
    return Recorded(origin, history, notes, size, check)


class _Damaged(Exception):
    """A line is not what was written."""


def _checked(line: bytes, before: str) -> dict[str, Any]:
    """A line's content, if its hash is right."""
    try:
        data = json.loads(line)
        told = data.pop("check")
    except (ValueError, KeyError, AttributeError, TypeError):
        raise _Damaged from None
    if told != _check(before, data):
        raise _Damaged
    return data


def _check(before: str, content: Mapping[str, Any]) -> str:
    return hashlib.sha256((before + json.dumps(content)).encode()).hexdigest()[:16]


def _head(origin: Origin) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "version": VERSION,
        "log": origin.log,
        "content_hash": origin.content_hash,
        "configuration": dict(origin.configuration),
    }


def _origin(path: Path, data: Mapping[str, Any]) -> Origin:
    match data:
        case {"format": "splinescope-edits", "version": int(version)} if version != VERSION:
            raise EditError(f"version {version} of the journal, this program reads {VERSION}")
        case {"format": "splinescope-edits", "log": str(log), "content_hash": str(hashed), "configuration": dict(made)}:
            return Origin(log, hashed, made)
    raise EditError(f"{path.name} is no journal of edits")


def _check_origin(path: Path, found: Origin, wanted: Origin) -> None:
    if found.content_hash != wanted.content_hash:
        raise EditError(f"the edits in {path.name} belong to another log: {found.log}")
    if found.configuration != wanted.configuration:
        raise EditError(f"the edits in {path.name} belong to a run of this log with another configuration")


def _sync_folder(folder: Path) -> None:
    """Make the name of a new file last."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
