"""What a finished solve has to say for itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam.backends import solve_control_points
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.errors import SplineSlamError
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.graph import Graph
from bspline_slam.lab.evaluation import Figures, TrajectoryErrors
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Snapshot
from splinescope.map_view import largest_move


@dataclass(frozen=True, slots=True)
class Solution:
    """Figures of one solve: costs before and after and of every iteration, the largest move of a scan (m), χ² and its
    degrees of freedom, time (s), and the absolute trajectory error (m) where the log has truth."""

    back_end: str
    cost_before: float
    cost_after: float
    largest_move: float
    chi2: float
    dof: int
    costs: tuple[float, ...]
    converged: bool
    seconds: float
    ate: Figures | None = None

    @property
    def iterations(self) -> int:
        """Steps made; the first cost is that of the start."""
        return max(len(self.costs) - 1, 0)

    @property
    def chi2_per_dof(self) -> float:
        return self.chi2 / self.dof if self.dof > 0 else float("nan")


def solution_of(log: ScanLog, back_end: str, before: Snapshot, after: Snapshot, seconds: float) -> Solution | None:
    """The figures of the solve that led to `after`; None if it was never solved as a whole.

    A solve goes through rounds that each build their own problem, so both costs are those of the last one: the poses
    before, with the curves that fit them best, and the poses and curves after.
    """
    estimate = after.estimate
    if estimate is None:
        return None
    graph = estimate.graph
    poses = before.poses[graph.key_scans]
    return Solution(
        back_end=back_end,
        cost_before=cost_of(graph, poses, solve_control_points(graph, poses)),
        cost_after=cost_of(graph, estimate.poses, estimate.control_points),
        largest_move=largest_move(before, after),
        chi2=float(estimate.chi2),
        dof=round(estimate.dof),
        costs=tuple(float(record.cost) for record in estimate.iterations),
        converged=estimate.converged,
        seconds=seconds,
        ate=ate_of(log, after),
    )


def cost_of(graph: Graph, poses: Float[np.ndarray, "n 3"], control_points: Float[np.ndarray, "N 2"]) -> float:
    """½ Σ ρ(‖e‖²) over all factors of the graph."""
    return 0.5 * (pack_curves(graph).cost(poses, control_points) + pack_edges(graph).cost(poses)[0])


def ate_of(log: ScanLog, snapshot: Snapshot) -> Figures | None:
    """Errors of the positions of all scans (m) after the best rigid alignment; None where no truth can be compared."""
    if log.truth is None:
        return None
    times = log.times[: len(snapshot.poses)]
    try:
        errors = TrajectoryErrors.from_trajectories(
            Trajectory(times, snapshot.poses), Trajectory(times, log.truth[: len(times)])
        )
    except SplineSlamError:
        return None
    return Figures.of(errors.absolute_translation)
