"""Logs: opened, or refused."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bspline_slam.scan import ScanLog


@dataclass(frozen=True, slots=True)
class OpenLog:
    """Read the log at `path` and process it; `title` is shown instead of the path's own name where given."""

    path: Path
    title: str | None = None


@dataclass(frozen=True, eq=False, slots=True)
class LogOpened:
    """The log asked for by `request` is readable."""

    request: OpenLog
    log: ScanLog


@dataclass(frozen=True, slots=True)
class LogRefused:
    """The log asked for by `request` cannot be read, and why."""

    request: OpenLog
    sentence: str


LogCommand = OpenLog | LogOpened | LogRefused
