"""The logs that benchmarks run on: the samples, and real recordings where a folder of them is at hand."""

from __future__ import annotations

import os
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
SAMPLES = REPOSITORY / "sample_logs"


def recordings_folder() -> Path:
    """$SPLINESCOPE_LOGS, else the folder of real logs beside the repository (it may be missing)."""
    return Path(os.environ.get("SPLINESCOPE_LOGS", REPOSITORY.parent / "shared" / "data"))


def recordings() -> list[Path]:
    """The office sample, then every CARMEN log of the folder."""
    return [SAMPLES / "office.log.gz", *sorted(recordings_folder().glob("*.log.gz"))]


def largest_recording() -> Path:
    """The biggest log at hand."""
    return max(recordings(), key=lambda path: path.stat().st_size)
