"""Which segment saw which spline, and why: candidates, distances, the gate, the runner-up."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.kernels import explaining
from bspline_slam.relation import Relation


class Verdict(Enum):
    """What became of a piece of a segment."""

    MATCHED = "matched"  # it saw a spline of the map
    EXTENDED = "extended"  # it saw a spline and made it longer
    NEW = "new"  # it started a spline
    GATED = "gated out"  # its best candidate lies beyond the gate, and it is too short to start a spline
    IGNORED = "ignored"  # left out (clutter, or by hand)


class Candidate(NamedTuple):
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
    first. `by` is "rule" or "hand".
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


@dataclass(frozen=True, slots=True)
class AssociationConfig:
    """Gates (m): across the curve, along it beyond an end, cosine between normals; least sizes of pieces and of
    new splines.

    New stretches of curve stay within `smooth` of their beam ends.
    `extension` is how near to an end of its spline a piece must reach for the beams beyond it to lengthen that
    spline.
    `join_gap` and `join_turn` bound the gap and the bend (rad) between two ends that one segment shows to be one
    curve.
    """

    gate: float = 0.10
    along: float = 0.12
    agreement: float = 0.7
    candidates: int = 4
    least_points: int = 3
    new_points: int = 4
    new_length: float = 0.2
    smooth: float = 0.05
    sparse_gap: float = 0.3
    sparse_ratio: float = 2.5
    extension: float = 0.3
    join_gap: float = 0.25
    join_turn: float = np.deg2rad(25.0)


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """For each point of one segment up to K splines near it: id (−1: none), parameter, signed distance across (m)."""

    spline: Int[np.ndarray, "m K"]
    t: Float[np.ndarray, "m K"]
    across: Float[np.ndarray, "m K"]

    def reach_of(self, spline: int, a: int, b: int) -> tuple[float, float]:
        """Least and largest parameter of `spline` at points a … b − 1, NaN where it explains none of them."""
        return explaining.reached(self.spline, self.t, a, b, spline)

    def part(self, a: int, b: int) -> Explanation:
        """Points a … b − 1."""
        return Explanation(self.spline[a:b], self.t[a:b], self.across[a:b])


@dataclass(frozen=True, eq=False, slots=True)
class Piece:
    """Points a … b − 1 of a segment, given to `spline`, or to none."""

    a: int
    b: int
    spline: int | None


def cut_into_pieces(seen: Explanation, config: AssociationConfig) -> list[Piece]:
    """Cut one segment where the spline that explains it changes, the best explanation first; pieces in order,
    without gaps."""
    rows = explaining.pieces(seen.spline, seen.across, config.least_points, NEARLY, HOLE).tolist()
    return [Piece(a, b, spline if spline >= 0 else None) for a, b, spline in rows]


NEARLY = 0.8
"""Of splines that explain at least this share as many points as the best, the one that lies closest is taken."""
HOLE = 1
"""So many unexplained points in a row do not end a stretch."""


def candidates_of(seen: Explanation, a: int, b: int) -> tuple[Candidate, ...]:
    """All splines near points a … b − 1, those that explain most of them first, ties by distance."""
    found = explaining.candidates(seen.spline, seen.across, a, b)
    return tuple(map(Candidate, *(column.tolist() for column in found)))
