"""The filter against the batch where both must agree, and what it cannot take in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.arrival import arrivals, entries, first_seen
from bspline_slam.backends.information_filter import NEWCOMER, told_at_entry
from bspline_slam.graph import Graph, PosePrior, SplineFactor


def with_known_headings(built) -> Graph:
    """The problem made linear: every heading given and held, odometry exact in angle, no loop closures."""
    graph, truth = built.graph, built.poses
    poses = graph.poses.copy()
    poses[:, 2] = truth[:, 2]
    motions = []
    for factor in graph.pose_factors:
        if factor.kernel is None:
            measured = factor.measured.copy()
            measured[2] = se2.between(truth[factor.i], truth[factor.j])[2]
            motions.append(replace(factor, measured=measured))
    held = tuple(PosePrior(i, pose, np.diag([0.0, 0.0, 1e9])) for i, pose in enumerate(truth))
    priors = (*graph.pose_priors, *held)
    return replace(graph, poses=poses, pose_factors=tuple(motions), pose_priors=priors)


def with_newcomers(graph: Graph) -> Graph:
    """The same with what the filter believes of control points that enter."""
    root = np.eye(2) / NEWCOMER
    believed = tuple(
        SplineFactor(arrival.pose, int(k), root, root @ q)
        for arrival in arrivals(graph)
        for k, q in zip(arrival.control_points, first_seen(graph, arrival), strict=True)
    )
    return replace(graph, spline_factors=(*graph.spline_factors, *believed))


@pytest.mark.parametrize("seed", range(4))
def test_on_a_linear_problem_the_filter_is_the_batch(world, seed):
    graph = with_known_headings(world(np.random.default_rng(seed), start_error=0.2))
    joint = with_newcomers(graph)
    ekf, direct = back_end("ekf"), back_end("direct")
    filtered, batch = ekf.solve(graph), direct.solve(joint)
    np.testing.assert_allclose(filtered.poses[-1], batch.poses[-1], atol=1e-8)
    np.testing.assert_allclose(filtered.control_points, batch.control_points, atol=1e-8)
    mine, theirs = (
        solver.covariances(estimate, poses=[11], splines=[100, 102])
        for solver, estimate in ((ekf, filtered), (direct, batch))
    )
    np.testing.assert_allclose(mine.poses[11], theirs.poses[11], rtol=1e-5, atol=1e-12)
    for spline in (100, 102):
        np.testing.assert_allclose(mine.splines[spline], theirs.splines[spline], rtol=1e-5, atol=1e-9)


def test_each_filtered_pose_is_the_batch_of_what_came_before(world):
    graph = with_known_headings(world(np.random.default_rng(5), start_error=0.2))
    filtered = back_end("ekf").solve(graph)
    joint, enters = with_newcomers(graph), entries(graph)
    for last in (3, 7):
        until = replace(
            joint,
            spline_factors=tuple(f for f in joint.spline_factors if f.pose <= last),
            shape_priors=tuple(f for f in joint.shape_priors if enters[f.first : f.first + 8].max() <= last),
            pose_factors=tuple(f for f in joint.pose_factors if max(f.i, f.j) <= last),
        )
        batch = back_end("direct").solve(anchored(until, last))
        np.testing.assert_allclose(filtered.poses[last], batch.poses[last], atol=1e-8)


def anchored(graph: Graph, last: int) -> Graph:
    """Poses and control points that are still to come held where they are, so that the batch has an answer."""
    held = tuple(PosePrior(i, graph.poses[i], np.eye(3)) for i in range(last + 1, len(graph.poses)))
    known = {int(k) for f in graph.spline_factors for k in range(f.first, f.first + f.A.shape[1] // 2)}
    missing = sorted(set(range(len(graph.control_points))) - known)
    seen = se2.transform(se2.inverse(graph.poses[-1]), graph.control_points)
    loose = tuple(SplineFactor(len(graph.poses) - 1, k, np.eye(2), seen[k]) for k in missing)
    return replace(
        graph, pose_priors=(*graph.pose_priors, *held), spline_factors=(*graph.spline_factors, *loose)
    )  # fmt: skip


def test_loop_closures_have_no_say(world):
    graph = world(np.random.default_rng(6)).graph
    without = replace(graph, pose_factors=tuple(f for f in graph.pose_factors if f.kernel is None))
    one, other = (back_end("ekf").solve(given) for given in (graph, without))
    np.testing.assert_array_equal(one.poses, other.poses)
    np.testing.assert_array_equal(one.control_points, other.control_points)
    assert one.dof - other.dof == pytest.approx(3 * (len(graph.pose_factors) - len(without.pose_factors)))


def test_filtering_says_less_of_a_pose_than_looking_back(world):
    graph = world(np.random.default_rng(7), outlier=False).graph
    ekf, direct = back_end("ekf"), back_end("direct")
    filtered, batch = (solver.covariances(solver.solve(graph), poses=[4]) for solver in (ekf, direct))
    assert np.trace(batch.poses[4]) < np.trace(filtered.poses[4])


def test_what_fixes_the_parametrisation_is_the_same_statement_from_the_pose_of_entry(world):
    graph = world(np.random.default_rng(8)).graph
    rng, enters = np.random.default_rng(9), entries(graph)
    factor = SplineFactor(9, 2, rng.normal(size=(3, 8)), rng.normal(size=3))
    told = told_at_entry(graph, factor, enters)
    assert told.pose == enters[2:6].max()
    points = graph.control_points[2:6]
    before, after = factor.residual(graph.poses[9], points), told.residual(graph.poses[told.pose], points)
    np.testing.assert_allclose(after, before, atol=1e-10)
    by_points = [f.jacobians(graph.poses[f.pose], points)[1] for f in (factor, told)]
    np.testing.assert_allclose(by_points[0], by_points[1], atol=1e-10)
