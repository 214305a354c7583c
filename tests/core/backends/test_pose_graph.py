"""The pose graph closes a loop, refuses a wrong one, and hands control points to linear least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.backends import back_end, solve_control_points


def dead_reckoned(graph):
    """The graph started from its odometry alone."""
    poses = [graph.pose_priors[0].mean]
    for factor in graph.pose_factors:
        if factor.kind == "odometry":
            poses.append(se2.compose(poses[-1], factor.measured))
    return replace(graph, poses=np.array(poses))


def test_a_loop_is_recovered_from_dead_reckoning(world):
    built = world(np.random.default_rng(0), poses=40, noise=1.0, outlier=False)
    start = dead_reckoned(built.graph)
    estimate = back_end("pose_graph").solve(start)
    before = np.linalg.norm(start.poses[:, :2] - built.poses[:, :2], axis=1)
    after = np.linalg.norm(estimate.poses[:, :2] - built.poses[:, :2], axis=1)
    assert after.mean() < 0.7 * before.mean()


def test_an_outlier_has_no_say(world):
    with_outlier = world(np.random.default_rng(1), poses=30, noise=0.0)
    estimate = back_end("pose_graph").solve(dead_reckoned(with_outlier.graph))
    assert np.abs(estimate.poses[:, :2] - with_outlier.poses[:, :2]).max() < 0.02


def test_control_points_given_the_poses_minimise_the_cost(world):
    graph = world(np.random.default_rng(2)).graph
    solved = solve_control_points(graph, graph.poses)
    gradient = np.zeros_like(solved)
    for factor in graph.spline_factors:
        points = solved[factor.first :][:5]
        by_points = factor.jacobians(graph.poses[factor.pose], points)[1]
        gradient[factor.first : factor.first + 5] += (
            by_points.T @ factor.residual(graph.poses[factor.pose], points)
        ).reshape(-1, 2)
    for prior in graph.shape_priors:
        points = solved[prior.first :][:8]
        gradient[prior.first : prior.first + 8] += (prior.A.T @ prior.residual(points)).reshape(-1, 2)
    assert np.abs(gradient).max() < 1e-6


def test_control_points_do_not_depend_on_where_they_start(world):
    graph = world(np.random.default_rng(3)).graph
    elsewhere = replace(graph, control_points=np.zeros_like(graph.control_points))
    solved = [solve_control_points(start, graph.poses) for start in (graph, elsewhere)]
    np.testing.assert_allclose(solved[0], solved[1], atol=1e-8)


def test_spline_covariance_carries_the_poses(world):
    """Against a simulation of the same linear rule: poses drawn from their covariance, then control points solved."""
    rng = np.random.default_rng(4)
    built = world(rng, poses=8, walls=1, noise=0.0, outlier=False, start_error=0.0)
    solver = back_end("pose_graph")
    estimate = solver.solve(built.graph)
    given = solver.covariances(estimate, splines=[100]).splines[100]
    H = np.zeros((24, 24))
    for factor in built.graph.pose_factors:
        by_i, by_j = factor.jacobians(built.poses[factor.i], built.poses[factor.j])
        J = np.zeros((3, 24))
        J[:, 3 * factor.i : 3 * factor.i + 3], J[:, 3 * factor.j : 3 * factor.j + 3] = by_i, by_j
        H += J.T @ J
    H[:3, :3] += built.graph.pose_priors[0].sqrt_information @ built.graph.pose_priors[0].sqrt_information
    S = np.zeros((16, 24))
    for k in range(24):
        step = np.zeros(24)
        step[k] = 1e-5
        ahead, behind = (
            solve_control_points(built.graph, built.poses + sign * step.reshape(-1, 3)) for sign in (1, -1)
        )
        S[:, k] = (ahead - behind).ravel() / 2e-5
    carried = S @ np.linalg.solve(H, S.T)
    own = given - carried
    assert np.linalg.eigvalsh(own).min() > 0
    np.testing.assert_allclose(own, inverse_of_points_alone(built), rtol=1e-3, atol=1e-6)


def inverse_of_points_alone(built) -> np.ndarray:
    """Covariance of the control points when the poses are known."""
    H = sum((prior.A.T @ prior.A for prior in built.graph.shape_priors), np.zeros((16, 16)))
    for factor in built.graph.spline_factors:
        J = np.zeros((len(factor.b), 16))
        points = built.control_points[factor.first :][:5]
        J[:, 2 * factor.first :][:, :10] = factor.jacobians(built.poses[factor.pose], points)[1]
        H += J.T @ J
    return np.linalg.inv(H)
