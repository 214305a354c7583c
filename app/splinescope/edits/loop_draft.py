"""Two key scans laid over one another, to close a loop by hand: coarsely by a person, exactly by the scan matcher."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.edits.edit import CloseLoop
from splinescope.computing.edit_messages import LoopMatched


@dataclass(frozen=True, eq=False, slots=True)
class LoopDraft:
    """The key scan `scan`, seen from the key scan `earlier` at `guess` (x, y, θ).

    `points` are its beam ends (robot frame) and `place` is where `earlier` was taken in the world. `verdict` is what
    the scan matcher says, once it was asked. `marks` are the two points of a pair that were clicked so far.
    """

    earlier: int
    scan: int
    place: Float[np.ndarray, "3"]
    guess: Float[np.ndarray, "3"]
    points: Float[np.ndarray, "m 2"]
    verdict: str = ""
    marks: tuple[tuple[float, float], ...] = ()

    @property
    def pose(self) -> Float[np.ndarray, "3"]:
        """Where the ghost scan lies in the world."""
        return se2.compose(self.place, self.guess)

    @property
    def ghost(self) -> Float[np.ndarray, "m 2"]:
        """The beam ends of the ghost scan in the world."""
        return se2.transform(self.pose, self.points)

    def moved(self, x: float, y: float, turn: float) -> LoopDraft:
        """The ghost scan shifted in the world (m) and turned about itself (rad)."""
        pose = self.pose + np.array([x, y, turn])
        return replace(self, guess=se2.between(self.place, pose), verdict="", marks=())

    def marked(self, x: float, y: float) -> LoopDraft:
        """One more clicked point: first one of the ghost scan, then where it belongs in the map; with the second pair
        the ghost scan goes there."""
        marks = (*self.marks, (x, y))
        if len(marks) < 4:
            return replace(self, marks=marks)
        a, to_a, b, to_b = np.array(marks)
        turn = float(np.arctan2(*(to_b - to_a)[::-1]) - np.arctan2(*(b - a)[::-1]))
        middle, to_middle = (a + b) / 2, (to_a + to_b) / 2
        turned = se2.rotation(turn) @ (self.pose[:2] - middle) + to_middle
        pose = np.array([turned[0], turned[1], float(se2.wrap(self.pose[2] + turn))])
        return replace(self, guess=se2.between(self.place, pose), verdict="", marks=())

    def matched(self, found: LoopMatched) -> tuple[LoopDraft, CloseLoop] | None:
        """The ghost scan where the scan matcher lays it, and the edit that closes the loop there; None where it found
        nothing."""
        if found.measured is None or found.sqrt_information is None:
            return None
        x, y, heading = found.measured.tolist()
        (a, b, c), (d, e, f), (g, h, i) = found.sqrt_information.tolist()
        close = CloseLoop(
            self.earlier, self.scan, (x, y, heading), ((a, b, c), (d, e, f), (g, h, i)), found.score, found.inliers
        )
        return replace(self, guess=found.measured, verdict=found.sentence), close
