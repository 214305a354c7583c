"""How far a long job has come, as one line of a terminal that is written over and over."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TextIO

INTERVAL = 0.1
"""Shortest time between two writes to a terminal (s)."""


class ProgressLine:
    """Shows stage, percentage and the time left of the stage; a stream that is no terminal gets a line each tenth."""

    def __init__(self, stream: TextIO, clock: Callable[[], float] = time.monotonic) -> None:
        self._stream = stream
        self._clock = clock
        self._live = stream.isatty()
        self._stage = ""
        self._began = 0.0
        self._written = 0.0
        self._tenth = -1

    def __call__(self, stage: str, fraction: float) -> None:
        """The job is in `stage`, of which `fraction` (0…1) is done."""
        now, tenth = self._clock(), int(10 * fraction)
        if stage != self._stage:
            self.end()
            self._stage, self._began, self._tenth = stage, now, -1
        if tenth > self._tenth or (self._live and now - self._written >= INTERVAL):
            self._written, self._tenth = now, tenth
            text = describe(stage, fraction, now - self._began)
            self._stream.write(f"\r\033[K{text}" if self._live else f"{text}\n")
            self._stream.flush()

    def end(self) -> None:
        """Leave the line as it is; what follows starts on a new one."""
        if self._live and self._stage:
            self._stream.write("\n")
        self._stage = ""


@contextmanager
def progress_line() -> Iterator[Callable[[str, float], None]]:
    """Progress on standard error, where results do not go."""
    line = ProgressLine(sys.stderr)
    try:
        yield line
    finally:
        line.end()


def describe(stage: str, fraction: float, elapsed: float) -> str:
    """`Matching scans  42 %  1:05 left`."""
    if fraction >= 1.0:
        return f"{stage}  done in {clock_time(elapsed)}"
    left = f"  {clock_time(elapsed * (1.0 - fraction) / fraction)} left" if fraction > 0.02 and elapsed > 1.0 else ""
    return f"{stage}  {100 * fraction:.0f} %{left}"


def clock_time(seconds: float) -> str:
    """`0:07`, `12:30`, `1:02:03`."""
    minutes, whole = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{whole:02d}" if hours else f"{minutes}:{whole:02d}"
