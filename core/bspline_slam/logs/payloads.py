"""Payloads put aside on disk, to be decoded one at a time when they are asked for."""

from __future__ import annotations

import os
import tempfile


class Payloads:
    """A temporary file that only grows; it vanishes with this object. Reading is safe from several threads."""

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile(prefix="splinescope-")  # noqa: SIM115 (lives as long as the log)
        self._size = 0

    def append(self, payload: bytes) -> tuple[int, int]:
        """Put a payload aside; returns the place to `read` it from."""
        place = (self._size, len(payload))
        self._file.write(payload)
        self._size += len(payload)
        return place

    def flush(self) -> None:
        """Make everything appended so far readable."""
        self._file.flush()

    def read(self, place: tuple[int, int]) -> bytes:
        """The payload at a place."""
        start, size = place
        return os.pread(self._file.fileno(), size, start)
