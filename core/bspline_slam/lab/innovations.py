"""Innovations: how far each key scan saw the map from where all the rest of the log expects it.

At the optimum of a least-squares problem let e be the whitened residuals of one key scan's observations, J their
Jacobian, Σ the covariance of the estimate and H = J Σ Jᵀ. What the scan would have found with the rest of the log
alone, before it was taken in, is (I − H)⁻¹ e, with the covariance (I − H)⁻¹. So its normalised innovation squared is
NIS = eᵀ (I − H)⁻¹ e: nothing has to be solved again without the scan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.adjustment.spline_graph import build_graph
from bspline_slam.backends import back_end
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.protocol import Cancelling, Estimate, never
from bspline_slam.backends.sparse_cholesky import Factor
from bspline_slam.backends.statistics import measures
from bspline_slam.backends.threads import single_thread
from bspline_slam.calibration.laser_noise import calibrated
from bspline_slam.errors import Cancelled
from bspline_slam.graph import SplineFactor
from bspline_slam.lab.scan_test import ScanTest
from bspline_slam.sights import collect_sights, find_feet
from bspline_slam.slam_config import SlamConfig, model_of
from bspline_slam.snapshot import Snapshot

LEAST_SHARE = 0.01
"""Directions of an innovation in which noise makes less than this share of the variance are left out: there the rest
of the log expects nothing in particular."""
MOST_SCANS = 100
"""Of a longer log so many key scans are looked at, evenly spread."""


def plain_estimate(snapshot: Snapshot, config: SlamConfig, cancelled: Cancelling = never) -> Estimate:
    """The optimum next to a solved map when every beam counts as much as the noise of the laser says.

    Robust weights would take out of the innovations just what they are to show. Raises Cancelled and SolverError.
    """
    poses, gate = snapshot.poses[snapshot.key_scans], config.adjustment.gates[-1]
    sights, model = collect_sights(snapshot.observations, snapshot.map), model_of(config)
    if config.adjustment.estimate_noise:
        model = calibrated(model, snapshot.map, sights, find_feet(sights, snapshot.map, poses, gate), poses)
    graph = build_graph(
        snapshot.observations, poses, snapshot.map, snapshot.pose_factors, sights,
        replace(config.adjustment, outlier=np.inf), model, gate,
    )  # fmt: skip
    return back_end("direct").solve(graph, cancelled=cancelled)


Progress = Callable[[float], None]


def innovations(estimate: Estimate, progress: Progress = lambda share: None, cancelled: Cancelling = never) -> ScanTest:
    """NIS of the key scans that saw splines, each against all others, the estimate being an optimum.

    The observations are those that factors sum up; how beams scatter within one is not in them. Raises Cancelled.
    """
    factor = (
        FullProblem.from_graph(estimate.graph)
        .linearise(State(estimate.poses, estimate.control_points))
        .factorise()
    )  # fmt: skip
    by_pose: dict[int, list[SplineFactor]] = {}
    for seen in filter(measures, estimate.graph.spline_factors):
        by_pose.setdefault(seen.pose, []).append(seen)
    poses = sorted(by_pose)
    chosen = [poses[k] for k in np.unique(np.linspace(0, len(poses) - 1, min(MOST_SCANS, len(poses))).astype(int))]
    found = []
    with single_thread():
        for pose in chosen:
            if cancelled():
                raise Cancelled("cancelled among the innovations")
            found.append(normalised_innovation(estimate, factor, by_pose[pose]))
            progress(len(found) / len(chosen))
    squares, dof = np.array(found).reshape(-1, 2).T
    return ScanTest(estimate.graph.key_scans[chosen], squares, dof)


def normalised_innovation(estimate: Estimate, factor: Factor, seen: list[SplineFactor]) -> tuple[float, float]:
    """NIS of observations of one pose, and its degrees of freedom."""
    residual, jacobian, unknowns = _stacked(estimate, seen)
    right = np.zeros((estimate.graph.unknowns, len(unknowns)))
    right[unknowns, np.arange(len(unknowns))] = 1.0
    covariance = factor.solve(right)[unknowns]
    share, directions = np.linalg.eigh(np.eye(len(residual)) - jacobian @ covariance @ jacobian.T)
    kept = share > LEAST_SHARE
    along = directions[:, kept].T @ residual
    return float(np.sum(along**2 / share[kept])), float(kept.sum())


def _stacked(
    estimate: Estimate, seen: list[SplineFactor]
) -> tuple[Float[np.ndarray, "r"], Float[np.ndarray, "r u"], Int[np.ndarray, "u"]]:
    """Residuals of one pose's observations, their Jacobian, and the unknowns that it is by."""
    k, poses = seen[0].pose, len(estimate.poses)
    points = np.unique(np.concatenate([np.arange(s.first, s.first + s.A.shape[1] // 2) for s in seen]))
    jacobian = np.zeros((sum(len(s.b) for s in seen), 3 + 2 * len(points)))
    residual, row = np.zeros(len(jacobian)), 0
    for one in seen:
        observed = estimate.control_points[one.first : one.first + one.A.shape[1] // 2]
        rows, column = slice(row, row + len(one.b)), 3 + 2 * int(np.searchsorted(points, one.first))
        residual[rows] = one.residual(estimate.poses[k], observed)
        jacobian[rows, :3], jacobian[rows, column : column + one.A.shape[1]] = one.jacobians(
            estimate.poses[k], observed
        )
        row += len(one.b)
    of_points = (3 * poses + 2 * points[:, None] + np.arange(2)).ravel()
    return residual, jacobian, np.concatenate([3 * k + np.arange(3), of_points])
