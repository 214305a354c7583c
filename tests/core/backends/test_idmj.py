"""What joining on relative feature information promises, and what it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.idmj import features_alone


@pytest.mark.parametrize("seed", range(3))
def test_without_pose_factors_nothing_is_lost(world, seed):
    graph = features_alone(world(np.random.default_rng(seed)).graph)
    direct, ours = (back_end(name).solve(graph) for name in ("direct", "idmj"))
    assert ours.converged
    assert np.abs(se2.wrap(direct.poses - ours.poses)).max() < 1e-6
    assert np.abs(direct.control_points - ours.control_points).max() < 1e-6
    assert ours.chi2 == pytest.approx(direct.chi2, rel=1e-9)
    expected, found = (back_end(name).covariances(direct, poses=[0, 7], splines=[100]) for name in ("direct", "idmj"))
    for pose in (0, 7):
        np.testing.assert_allclose(found.poses[pose], expected.poses[pose], rtol=1e-5, atol=1e-12)
    np.testing.assert_allclose(found.splines[100], expected.splines[100], rtol=1e-5, atol=1e-9)


def test_pose_factors_have_no_say_in_the_map(world):
    graph = world(np.random.default_rng(3)).graph
    wrong = replace(
        graph,
        pose_factors=tuple(replace(edge, measured=edge.measured + 0.05) for edge in graph.pose_factors),
    )
    one, other = (back_end("idmj").solve(each) for each in (graph, wrong))
    np.testing.assert_allclose(one.control_points, other.control_points, atol=1e-9)
    assert np.abs(one.poses - other.poses).max() > 1e-4


def test_with_pose_factors_the_map_is_another_and_knows_less(world):
    graph = world(np.random.default_rng(4)).graph
    direct, ours = (back_end(name).solve(graph) for name in ("direct", "idmj"))
    assert np.abs(direct.control_points - ours.control_points).max() > 1e-4
    full, less = (back_end(name).covariances(direct, splines=[101]).splines[101] for name in ("direct", "idmj"))
    assert np.linalg.eigvalsh(less - full).min() > -1e-9 * np.abs(less).max()
    assert np.trace(less) > np.trace(full)


def test_poses_are_the_best_in_the_map_that_was_found(world):
    """The gradient of the whole cost by the poses is zero, for they are found by everything that speaks of them."""
    graph = world(np.random.default_rng(5)).graph
    ours = back_end("idmj").solve(graph)
    gradient = np.zeros((len(ours.poses), 3))
    for factor in graph.spline_factors:
        pose, points = ours.poses[factor.pose], ours.control_points[factor.first :][: factor.A.shape[1] // 2]
        gradient[factor.pose] += factor.jacobians(pose, points)[0].T @ factor.residual(pose, points)
    for edge in graph.pose_factors:
        pose_i, pose_j = ours.poses[edge.i], ours.poses[edge.j]
        e = edge.residual(pose_i, pose_j)
        weight = 1.0 if edge.kernel is None else 1.0 / (1.0 + e @ e / edge.kernel**2)
        for pose, jacobian in zip((edge.i, edge.j), edge.jacobians(pose_i, pose_j), strict=True):
            gradient[pose] += weight * jacobian.T @ e
    for prior in graph.pose_priors:
        gradient[prior.pose] += prior.sqrt_information.T @ prior.residual(ours.poses[prior.pose])
    assert np.abs(gradient).max() < 1e-2
    assert np.abs(gradient).max() < 1e-4 * np.abs(graph.spline_factors[0].A).max() ** 2


def test_a_pose_that_saw_nothing_hangs_on_its_pose_factors(world):
    graph = world(np.random.default_rng(6), noise=0.0, outlier=False)
    blind = replace(
        graph.graph, spline_factors=tuple(factor for factor in graph.graph.spline_factors if factor.pose != 5)
    )
    ours = back_end("idmj").solve(blind)
    assert np.abs(se2.between(graph.poses, ours.poses)).max() < 1e-6
