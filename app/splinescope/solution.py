"""What a finished solve has to say for itself."""

from __future__ import annotations

from dataclasses import dataclass

from bspline_slam.slam import Snapshot
from splinescope.map_view import largest_move


@dataclass(frozen=True, slots=True)
class Solution:
    """Figures of one solve: costs before and after, the largest move of a scan (m), χ² and its degrees of freedom,
    time (s)."""

    back_end: str
    cost_before: float
    cost_after: float
    largest_move: float
    chi2: float
    dof: int
    iterations: int
    converged: bool
    seconds: float

    @property
    def chi2_per_dof(self) -> float:
        return self.chi2 / self.dof if self.dof > 0 else float("nan")


def solution_of(back_end: str, before: Snapshot | None, after: Snapshot, seconds: float) -> Solution | None:
    """The figures of the solve that led to `after`; None if it was never solved as a whole."""
    estimate = after.estimate
    if estimate is None or not estimate.iterations:
        return None
    return Solution(
        back_end=back_end,
        cost_before=float(estimate.iterations[0].cost),
        cost_after=float(estimate.iterations[-1].cost),
        largest_move=largest_move(before, after) if before is not None else 0.0,
        chi2=float(estimate.chi2),
        dof=int(estimate.dof),
        iterations=len(estimate.iterations) - 1,
        converged=estimate.converged,
        seconds=seconds,
    )
