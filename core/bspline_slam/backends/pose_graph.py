"""The pose graph: poses from pose factors and priors alone, then all control points given the poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.linalg import solveh_banded

from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.control_points import curve_band, linearise_at, solve_control_points
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import Descent, State, Stopping, descend
from bspline_slam.backends.marginals import Solve, inverse_block, spline_unknowns
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.pattern import find_pattern
from bspline_slam.backends.protocol import Cancelling, Estimate, IterationRecord, Marginals, Progress, never, silent
from bspline_slam.backends.statistics import estimate_of
from bspline_slam.graph import Graph


class PoseGraph:
    """Gauss-Newton on the poses, robust kernels included; spline factors have no say in where the poses are.

    Costs of the iterations are those of the pose factors and priors. The last record has the control points solved;
    those before it have them at their start. χ² and its degrees of freedom are of the whole graph.
    """

    name = "pose_graph"

    def __init__(self, stopping: Stopping | None = None) -> None:
        self.stopping = stopping or Stopping()

    def solve(self, graph: Graph, *, progress: Progress = silent, cancelled: Cancelling = never) -> Estimate:
        """The optimum of the pose factors. Raises SolverError where a pose hangs on nothing, and Cancelled."""
        alone = poses_alone(graph)
        check_anchored(alone)

        def with_start(record: IterationRecord) -> None:
            progress(replace(record, control_points=graph.control_points))

        start = State(alone.poses, alone.control_points)
        descent = descend(FullProblem.from_graph(alone), start, self.stopping, with_start, cancelled)
        records = [replace(record, control_points=graph.control_points) for record in descent.records]
        state = State(descent.state.poses, solve_control_points(graph, descent.state.poses))
        step = State(np.zeros((0, 3)), state.control_points - graph.control_points)
        last = records[-1]
        records.append(
            IterationRecord(last.index + 1, last.cost, step.norm, 0.0, last.seconds, state.poses, state.control_points)
        )
        progress(records[-1])
        return estimate_of(graph, Descent(state, tuple(records), descent.converged))

    def covariances(self, estimate: Estimate, *, poses: Sequence[int] = (), splines: Sequence[int] = ()) -> Marginals:
        """Of poses: blocks of the inverse of the pose graph's own matrix, which knows of no spline.

        Of splines: the covariance given the poses, and that of the poses carried through the sensitivity of the
        control points to them. The correlation of pose factors and spline factors made of the same beams is ignored.
        """
        problem = FullProblem.from_graph(poses_alone(estimate.graph))
        solve = problem.linearise(State(estimate.poses, np.empty((0, 2)))).inverse()
        unknowns = 3 * len(estimate.poses)
        return Marginals(
            {pose: inverse_block(solve, unknowns, np.arange(3 * pose, 3 * pose + 3)) for pose in poses},
            propagated(estimate, solve, splines) if splines else {},
        )


def poses_alone(graph: Graph) -> Graph:
    """The graph without its splines."""
    return replace(
        graph,
        spline_ids=np.empty(0, dtype=np.int64),
        spline_first=np.zeros(1, dtype=np.int64),
        control_points=np.empty((0, 2)),
        spline_factors=(),
        shape_priors=(),
    )


def propagated(estimate: Estimate, solve_poses: Solve, splines: Sequence[int]) -> dict[int, Float[np.ndarray, "d d"]]:
    """Covariances of splines whose control points were solved given uncertain poses: H_cc⁻¹ + S Σ_poses Sᵀ."""
    graph, pose_unknowns = estimate.graph, 3 * len(estimate.poses)
    blocks = linearise_at(graph, State(estimate.poses, estimate.control_points))
    band = curve_band(blocks)
    sights = find_pattern(pack_curves(graph), pack_edges(graph), len(graph.control_points)).sights
    covariances = {}
    for spline in splines:
        unknowns = spline_unknowns(graph, spline) - pose_unknowns
        own_band = band[:, unknowns]
        coupling = np.zeros((len(unknowns) // 2, 2, len(estimate.poses), 3))
        mine = np.isin(2 * sights[:, 0], unknowns)
        coupling[sights[mine, 0] - unknowns[0] // 2, :, sights[mine, 1]] = blocks.sight[mine]
        sensitivity = -solveh_banded(own_band, coupling.reshape(len(unknowns), pose_unknowns), lower=True)
        given_poses = solveh_banded(own_band, np.eye(len(unknowns)), lower=True)
        carried = sensitivity @ solve_poses(sensitivity.T.copy())
        covariances[spline] = given_poses + (carried + carried.T) / 2
    return covariances
