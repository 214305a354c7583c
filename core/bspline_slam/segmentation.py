"""A scan cut into segments: breakpoints, corners, and what kind of end each piece has."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float, Int


class EndKind(Enum):
    """Why a segment ends."""

    EDGE = "edge"  # the nearer side of a range jump: the thing itself ends here
    OCCLUDED = "occluded"  # the farther side: only its visibility ends here
    CORNER = "corner"  # the next segment goes on from here in another direction
    NO_RETURN = "no return"  # the next beam came back from nowhere
    FIELD_OF_VIEW = "field of view"  # the scan ends here


@dataclass(frozen=True, eq=False, slots=True)
class ScanSegment:
    """A run of neighbouring beams that saw one smooth piece of the world.

    `index` counts the segments of the scan; `beams` are beam numbers (increasing, invalid beams left out);
    `points` are their ends in the robot frame.
    """

    scan: int
    index: int
    beams: Int[np.ndarray, "m"]
    points: Float[np.ndarray, "m 2"]
    start: EndKind
    end: EndKind
