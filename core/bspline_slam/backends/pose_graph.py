"""The pose graph: poses from pose factors and priors alone, then all control points given the poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int
from scipy.linalg import solveh_banded

from bspline_slam.backends.check import check_anchored
from bspline_slam.backends.control_points import curve_band, fit_control_points
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import Descent, State, Stopping, descend
from bspline_slam.backends.marginals import control_points_of
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.pattern import find_pattern, linearise_terms
from bspline_slam.backends.protocol import (
    Cancelling,
    Estimate,
    IterationRecord,
    Marginals,
    Progress,
    never,
    silent,
    unless_cancelled,
)
from bspline_slam.backends.sparse_cholesky import Factor
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
        problem = FullProblem.from_graph(alone)
        descent = descend(problem, start, self.stopping, with_start, cancelled)
        records = [replace(record, control_points=graph.control_points) for record in descent.records]
        poses, curves, edges = descent.state.poses, pack_curves(graph), problem.edges
        state = State(poses, fit_control_points(curves, edges, poses, graph.control_points))
        step = State(np.zeros((0, 3)), state.control_points - graph.control_points)
        last = records[-1]
        records.append(
            IterationRecord(last.index + 1, last.cost, step.norm, 0.0, last.seconds, state.poses, state.control_points)
        )
        progress(records[-1])
        return estimate_of(graph, curves, edges, Descent(state, tuple(records), descent.converged))

    def covariances(
        self,
        estimate: Estimate,
        *,
        poses: Sequence[int] = (),
        splines: Sequence[int] = (),
        cancelled: Cancelling = never,
    ) -> Marginals:
        """Of poses: blocks of the inverse of the pose graph's own matrix, which knows of no spline.

        Of splines: the covariance given the poses, and that of the poses carried through the sensitivity of the
        control points to them. The correlation of pose factors and spline factors made of the same beams is ignored.
        """
        problem = FullProblem.from_graph(poses_alone(estimate.graph))
        factor = problem.linearise(State(estimate.poses, np.empty((0, 2)))).factorise()
        pose_blocks, _ = factor.inverse_blocks()
        return Marginals({pose: pose_blocks[pose] for pose in poses}, propagated(estimate, factor, splines, cancelled))


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


def propagated(
    estimate: Estimate, poses: Factor, splines: Sequence[int], cancelled: Cancelling
) -> dict[int, Float[np.ndarray, "d d"]]:
    """Covariances of control points solved given uncertain poses: H_cc⁻¹ + S Σ_poses Sᵀ, S = −H_cc⁻¹ H_c,poses."""
    graph, covariances = estimate.graph, {}
    curves, edges = pack_curves(graph), pack_edges(graph)
    pattern = find_pattern(curves, edges, len(graph.control_points))
    blocks = linearise_terms(curves, edges, pattern, State(estimate.poses, estimate.control_points))
    band = curve_band(blocks)
    for spline in unless_cancelled(cancelled, splines):
        points = control_points_of(graph, spline)
        own_band = band[:, 2 * points[0] : 2 * points[-1] + 2]
        given_poses = solveh_banded(own_band, np.eye(2 * len(points)), lower=True)
        observers, coupling = coupling_of(points, pattern.sights, blocks.sight)
        sensitivity = -solveh_banded(own_band, coupling, lower=True)
        covariances[spline] = given_poses + carried(poses, observers, sensitivity)
    return covariances


def coupling_of(
    points: Int[np.ndarray, "m"], sights: Int[np.ndarray, "q 2"], blocks: Float[np.ndarray, "q 2 3"]
) -> tuple[Int[np.ndarray, "o"], Float[np.ndarray, "d p"]]:
    """The poses that see some of these consecutive control points, and the part of the matrix between the two."""
    mine = (sights[:, 0] >= points[0]) & (sights[:, 0] <= points[-1])
    observers, column = np.unique(sights[mine, 1], return_inverse=True)
    coupling = np.zeros((len(points), 2, len(observers), 3))
    coupling[sights[mine, 0] - points[0], :, column] = blocks[mine]
    return observers, coupling.reshape(2 * len(points), 3 * len(observers))


def carried(
    poses: Factor, observers: Int[np.ndarray, "o"], sensitivity: Float[np.ndarray, "d p"]
) -> Float[np.ndarray, "d d"]:
    """S Σ Sᵀ, Σ the covariance of the poses that observe."""
    by_pose = np.zeros((poses.analysis.poses, 3, len(sensitivity)))
    by_pose[observers] = sensitivity.T.reshape(len(observers), 3, -1)
    spread = poses.solve(by_pose.reshape(-1, len(sensitivity))).reshape(by_pose.shape)[observers]
    covariance = sensitivity @ spread.reshape(sensitivity.shape[1], -1)
    return (covariance + covariance.T) / 2
