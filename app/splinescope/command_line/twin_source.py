"""The twin that the options of a command name."""

from __future__ import annotations

from pathlib import Path

from bspline_slam.errors import ConfigError
from bspline_slam.lab.finished_run import FinishedRun
from bspline_slam.lab.twin import Twin


def read_twin(results: Path, log: Path | None) -> Twin:
    """The twin of the run in that folder; the log it was made from, where given, tells where it scans."""
    run = FinishedRun.from_folder(results)
    return Twin.from_run(run, None if log is None else run.open_log(log))


def chosen_stretch(twin: Twin, words: str | None) -> Twin:
    """Scans `FIRST:LAST` of the twin, LAST left out; all of it for None. Raises ConfigError for other words."""
    if words is None:
        return twin
    first, colon, last = words.partition(":")
    if not colon or not first.isdigit() or not last.isdigit():
        raise ConfigError(f"--scans is FIRST:LAST, two numbers of scans, got {words}")
    return twin.stretch(int(first), int(last))
