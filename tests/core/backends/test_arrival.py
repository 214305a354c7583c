"""A graph taken apart by key scans loses nothing, and names nothing before it has entered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends.arrival import arrivals, carried_on, entries, first_seen, predicted_pose
from bspline_slam.graph import PoseFactor


@pytest.mark.parametrize("seed", range(3))
def test_everything_comes_once(world, seed):
    graph = world(np.random.default_rng(seed)).graph
    coming = arrivals(graph)
    assert [arrival.pose for arrival in coming] == list(range(len(graph.poses)))
    entered = np.concatenate([arrival.control_points for arrival in coming])
    assert np.array_equal(np.sort(entered), np.arange(len(graph.control_points)))
    for kind in ("spline_factors", "pose_factors", "pose_priors", "shape_priors"):
        told = [id(factor) for arrival in coming for factor in getattr(arrival, kind)]
        assert sorted(told) == sorted(id(factor) for factor in getattr(graph, kind))


@pytest.mark.parametrize("seed", range(3))
def test_nothing_is_named_before_it_enters(world, seed):
    graph = world(np.random.default_rng(seed)).graph
    enters = entries(graph)
    for arrival in arrivals(graph):
        assert np.all(enters[arrival.control_points] == arrival.pose)
        for factor in (*arrival.spline_factors, *arrival.shape_priors):
            assert enters[factor.first : factor.first + factor.A.shape[1] // 2].max() <= arrival.pose
        assert all(max(factor.i, factor.j) == arrival.pose for factor in arrival.pose_factors)


def test_the_prediction_is_the_best_compromise_of_all_motion_factors(world):
    graph = world(np.random.default_rng(1)).graph
    first = next(factor for factor in graph.pose_factors if (factor.i, factor.j) == (2, 3))
    other = PoseFactor(2, 3, first.measured + np.array([0.2, -0.1, 0.1]), np.diag([5.0, 50.0, 200.0]), "matching")
    coming = arrivals(replace(graph, pose_factors=(*graph.pose_factors, other)))[3]
    last = np.array([1.0, 2.0, 3.0])
    pose = predicted_pose(graph, coming, last)
    slope = sum(f.jacobians(last, pose)[1].T @ f.residual(last, pose) for f in (first, other))
    assert np.abs(slope).max() < 1e-6


def test_without_motion_factors_the_starting_values_predict(world):
    graph = world(np.random.default_rng(2)).graph
    alone = replace(graph, pose_factors=())
    last = np.array([1.0, 2.0, 3.0])
    pose = predicted_pose(alone, arrivals(alone)[4], last)
    np.testing.assert_allclose(se2.between(last, pose), se2.between(graph.poses[3], graph.poses[4]), atol=1e-12)
    np.testing.assert_array_equal(predicted_pose(alone, arrivals(alone)[0], None), graph.poses[0])


def test_newcomers_and_poses_to_come_hang_on_the_pose_at_hand(world):
    graph = world(np.random.default_rng(3)).graph
    arrival = arrivals(graph)[0]
    back = se2.transform(graph.poses[0], first_seen(graph, arrival))
    np.testing.assert_allclose(back, graph.control_points[arrival.control_points], atol=1e-12)
    np.testing.assert_allclose(carried_on(graph, graph.poses[:5]), graph.poses, atol=1e-12)
    rigid = np.array([3.0, 1.0, 0.5])
    ahead = carried_on(graph, se2.compose(rigid, graph.poses[:5]))
    np.testing.assert_allclose(se2.between(rigid, ahead[7]), graph.poses[7], atol=1e-12)
