"""What the estimator is busy with, in words and numbers for the page."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Work(Enum):
    """The jobs of the estimator; the value says them in the page."""

    PROCESSING = "Processing the log"
    OPTIMISING = "Optimising the map"
    COVARIANCES = "Measuring the map"
    EDITING = "Making the edits"


STAGES = {
    "scans": "Matching scans and growing the map",
    "pose graph": "Solving the pose graph",
    "adjustment": "Adjusting the map",
    "scans between": "Placing the scans between key scans",
    "edits": "Making the hand edits",
    "rebuild": "Building the map anew",
}
"""The pipeline's stages in words."""


def stage_in_words(stage: str) -> str:
    """What is being done; a stage that is told in words already begins with a capital."""
    return STAGES.get(stage, f"{stage[:1].upper()}{stage[1:]}")


@dataclass(frozen=True, slots=True)
class Activity:
    """A running job: its stage, how far it is (0…1) and how long it still takes (s), None where unknown.

    `adjusted` counts the scans up to which the map of a run that still reads is adjusted.
    """

    work: Work
    job: int
    stage: str
    fraction: float | None = None
    seconds_left: float | None = None
    adjusted: int = 0


def counted(number: int, noun: str) -> str:
    """So many things: `1 scan`, `8,541 scans`."""
    return f"{number:,} {noun}" if number == 1 else f"{number:,} {noun}s"


def duration(seconds: float) -> str:
    """A length of time in words: `8 s`, `3 min 20 s`, `2 h 05 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"
