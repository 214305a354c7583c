"""Which segment saw which spline, and why: candidates, distances, the gate, the runner-up."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """What became of a piece of a segment."""

    MATCHED = "matched"  # it saw a spline of the map
    EXTENDED = "extended"  # it saw a spline and made it longer
    NEW = "new"  # it started a spline
    GATED = "gated out"  # its best candidate lies beyond the gate, and it is too short to start a spline
    IGNORED = "ignored"  # left out (clutter, or by hand)


class Relation(Enum):
    """The stretch of the full spline that a piece saw (paper, section 4.1)."""

    FULL = "full"
    PART = "part"
    EXTENSION = "extension"


@dataclass(frozen=True, slots=True)
class Candidate:
    """A spline that came into question: RMS distance along the normal (m) and the share of the piece's beams it
    explains."""

    spline: int
    distance: float
    overlap: float


@dataclass(frozen=True, eq=False, slots=True)
class Association:
    """The decision for beams `first … last` of one segment.

    `spline` is the id it was given to (None when gated out or ignored). `distance` is the RMS of the accepted
    candidate (NaN when there was none) and `gate` the limit it was held against (m). `candidates` are sorted best
    first.
    `by` is "rule" or "hand".
    """

    scan: int
    segment: int
    first: int
    last: int
    verdict: Verdict
    spline: int | None
    distance: float
    gate: float
    candidates: tuple[Candidate, ...] = ()
    relation: Relation | None = None
    by: str = "rule"

    @property
    def runner_up(self) -> Candidate | None:
        """The best candidate that was not chosen."""
        return next((candidate for candidate in self.candidates if candidate.spline != self.spline), None)
