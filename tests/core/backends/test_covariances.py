"""Marginal covariances against the inverse of the dense Gauss-Newton matrix."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from bspline_slam.backends import BACK_ENDS, back_end
from bspline_slam.backends.protocol import Estimate
from bspline_slam.errors import Cancelled


def dense_matrix(estimate: Estimate) -> np.ndarray:
    """The Gauss-Newton matrix by the Jacobians of the factors, one after another."""
    graph, n = estimate.graph, 3 * len(estimate.poses)
    H = np.zeros((graph.unknowns, graph.unknowns))

    def add(parts: list[tuple[int, np.ndarray]], weight: float = 1.0) -> None:
        J = np.zeros((len(parts[0][1]), graph.unknowns))
        for begin, block in parts:
            J[:, begin : begin + block.shape[1]] = block
        H[:] += weight * J.T @ J

    for factor in graph.spline_factors:
        points = estimate.control_points[factor.first : factor.first + factor.A.shape[1] // 2]
        by_pose, by_points = factor.jacobians(estimate.poses[factor.pose], points)
        add([(3 * factor.pose, by_pose), (n + 2 * factor.first, by_points)])
    for factor in graph.pose_factors:
        pose_i, pose_j = estimate.poses[factor.i], estimate.poses[factor.j]
        e = factor.residual(pose_i, pose_j)
        weight = 1.0 if factor.kernel is None else float(1 / (1 + e @ e / factor.kernel**2))
        by_i, by_j = factor.jacobians(pose_i, pose_j)
        add([(3 * factor.i, by_i), (3 * factor.j, by_j)], weight)
    for prior in graph.pose_priors:
        add([(3 * prior.pose, prior.sqrt_information)])
    for prior in graph.shape_priors:
        add([(n + 2 * prior.first, prior.A)])
    return H


@pytest.mark.parametrize("name", ["direct", "sam"])
def test_marginals_are_blocks_of_the_inverse(world, name):
    solver = back_end(name)
    estimate = solver.solve(world(np.random.default_rng(0)).graph)
    inverse = np.linalg.inv(dense_matrix(estimate))
    marginals = solver.covariances(estimate, poses=[0, 5, 11], splines=[100, 102])
    assert set(marginals.poses) == {0, 5, 11}
    assert set(marginals.splines) == {100, 102}
    for pose, covariance in marginals.poses.items():
        expected = inverse[3 * pose : 3 * pose + 3, 3 * pose : 3 * pose + 3]
        np.testing.assert_allclose(covariance, expected, rtol=1e-5, atol=1e-12)
    for spline, covariance in marginals.splines.items():
        first = 3 * 12 + 16 * (spline - 100)
        expected = inverse[first : first + 16, first : first + 16]
        np.testing.assert_allclose(covariance, expected, rtol=1e-5, atol=1e-9)


@pytest.mark.parametrize("name", ["direct", "sam", "pose_graph"])
def test_nothing_asked_nothing_given(world, name):
    solver = back_end(name)
    marginals = solver.covariances(solver.solve(world(np.random.default_rng(1)).graph))
    assert marginals.poses == {}
    assert marginals.splines == {}


def test_pose_graph_marginals_know_no_spline(world):
    graph = world(np.random.default_rng(2)).graph
    estimates = {name: back_end(name).solve(graph) for name in ("direct", "pose_graph")}
    spread = {
        name: np.trace(back_end(name).covariances(estimate, poses=[6]).poses[6][:2, :2])
        for name, estimate in estimates.items()
    }
    assert spread["direct"] < spread["pose_graph"]


@pytest.mark.parametrize("name", [name for name in BACK_ENDS if name != "bs_slam"])  # which is `ekf` with beams
def test_covariances_are_given_up_where_nobody_waits_for_them(world, name):
    solver = back_end(name)
    estimate = solver.solve(world(np.random.default_rng(3)).graph)
    asked = itertools.count()
    with pytest.raises(Cancelled):
        solver.covariances(estimate, poses=range(12), splines=[100, 101], cancelled=lambda: next(asked) > 0)
    assert next(asked) == 2
