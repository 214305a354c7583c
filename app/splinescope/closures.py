"""The loop closures as a list to leaf through: which of them, which page, and how far each would move the map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.front_end.loop_closure import LoopClosure

ROWS = 8
"""On a page."""


class Which(Enum):
    """A choice among closures; the value is its label in the page."""

    ALL = "all"
    ACCEPTED = "accepted"
    REJECTED = "rejected"
    WAITING = "waiting"


@dataclass(frozen=True, slots=True)
class ClosurePage:
    """What of the list is shown; pages are numbered from 0."""

    which: Which = Which.ALL
    number: int = 0

    def turned(self, by: int, pages: int) -> ClosurePage:
        """Some pages on, within those that there are."""
        return ClosurePage(self.which, min(max(self.number + by, 0), max(pages - 1, 0)))


def chosen(closures: Sequence[LoopClosure], which: Which) -> list[int]:
    """Numbers of the closures of that choice, in the order of their scans."""
    numbers = [k for k, closure in enumerate(closures) if which in (Which.ALL, Which(closure.verdict))]
    return sorted(numbers, key=lambda number: (closures[number].scan, closures[number].earlier))


def pages(count: int) -> int:
    """How many pages so many closures fill."""
    return -(-count // ROWS)


def moves(
    closures: Sequence[LoopClosure], key_scans: Int[np.ndarray, "n"], key_poses: Float[np.ndarray, "n 3"]
) -> Float[np.ndarray, "c 2"]:
    """How far (m, rad) the later scan of each closure lies from where the closure would have it."""
    if not closures:
        return np.zeros((0, 2))
    earlier, later = (
        key_poses[np.searchsorted(key_scans, [getattr(closure, end) for closure in closures])]
        for end in ("earlier", "scan")
    )
    off = se2.between(np.array([closure.measured for closure in closures]), se2.between(earlier, later))
    return np.stack([np.hypot(off[:, 0], off[:, 1]), np.abs(se2.wrap(off[:, 2]))], -1)
