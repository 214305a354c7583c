"""Joining local maps reaches the optimum of the whole graph, whatever order and start."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State
from bspline_slam.backends.graph_maps import first_maps, first_seen, local_maps_of
from bspline_slam.backends.islsjf import JoinWatch, join_in_order


@pytest.mark.parametrize("seed", range(3))
def test_the_optimum_is_that_of_direct(world, seed):
    graph = world(np.random.default_rng(seed)).graph
    direct, joined = back_end("direct").solve(graph), back_end("islsjf").solve(graph)
    assert joined.converged
    assert np.abs(se2.wrap(direct.poses - joined.poses)).max() < 1e-6
    assert np.abs(direct.control_points - joined.control_points).max() < 1e-6
    assert joined.chi2 == pytest.approx(direct.chi2, rel=1e-9)
    assert joined.dof == pytest.approx(direct.dof, rel=1e-6)


def test_local_maps_hold_the_whole_graph(world):
    """Their cost, gradient and information are those of the graph, robust kernels included."""
    graph = world(np.random.default_rng(3), start_error=0.1).graph
    maps, problem = local_maps_of(graph), FullProblem.from_graph(graph)
    state = State(graph.poses, graph.control_points)
    assert len(maps) == len(graph.poses)
    assert maps.cost(state) == pytest.approx(problem.cost(state), rel=1e-12)
    ours, theirs = maps.linearise(state), problem.linearise(state)
    gradient = theirs.blocks.gradient
    expected = np.append(gradient.poses.ravel(), gradient.control_points.ravel())
    np.testing.assert_allclose(ours.gradient, expected, atol=1e-9 * np.abs(expected).max())
    for damping in (0.0, 100.0):
        one, other = ours.step(damping), theirs.step(damping)
        np.testing.assert_allclose(one.poses, other.poses, atol=1e-8)
        np.testing.assert_allclose(one.control_points, other.control_points, atol=1e-6)


def test_the_jacobian_is_that_of_the_residual(world):
    graph = world(np.random.default_rng(4), poses=5, walls=2).graph
    maps, state = local_maps_of(graph), State(graph.poses, graph.control_points)
    J = maps.W.toarray() @ maps.jacobian(state).toarray()
    for k in range(J.shape[1]):
        ahead, behind = (moved(state, k, step) for step in (1e-6, -1e-6))
        numeric = (maps.residual(ahead) - maps.residual(behind)) / 2e-6
        np.testing.assert_allclose(J[:, k], numeric, atol=1e-6 * (1 + np.abs(J).max()))


def moved(state: State, unknown: int, step: float) -> State:
    """The state with one unknown changed."""
    flat = np.append(state.poses.ravel(), state.control_points.ravel())
    flat[unknown] += step
    return State(flat[: state.poses.size].reshape(-1, 3), flat[state.poses.size :].reshape(-1, 2))


def test_parts_sum_up_to_the_whole(world):
    graph = world(np.random.default_rng(5)).graph
    maps, state = local_maps_of(graph), State(graph.poses, graph.control_points)
    parts = [maps.part(0, 4), maps.part(4, 5), maps.part(5, len(maps))]
    assert sum(len(part) for part in parts) == len(maps)
    assert sum(part.cost(state) for part in parts) == pytest.approx(maps.cost(state), rel=1e-12)
    summed = sum(part.linearise(state).matrix.toarray() for part in parts)
    np.testing.assert_allclose(summed, maps.linearise(state).matrix.toarray(), atol=1e-6)


@pytest.mark.parametrize("count", [1, 5, 12])
def test_the_graph_of_the_first_maps_is_what_they_hold(world, count):
    graph = world(np.random.default_rng(12), start_error=0.1).graph
    state, first = State(graph.poses, graph.control_points), local_maps_of(graph).first(count)
    problem = FullProblem.from_graph(first_maps(graph, count))
    assert first.cost(state) == pytest.approx(problem.cost(state), rel=1e-12)
    one, other = first.linearise(state).step(10.0), problem.linearise(state).step(10.0)
    np.testing.assert_allclose(one.poses, other.poses, atol=1e-8)
    np.testing.assert_allclose(one.control_points, other.control_points, atol=1e-8)


def test_a_map_knows_nothing_of_what_comes_later(world):
    graph = world(np.random.default_rng(6)).graph
    maps, seen = local_maps_of(graph), first_seen(graph)
    for k in range(len(maps)):
        one = maps.part(k, k + 1)
        assert one.pose.max(initial=0) <= k
        assert seen[one.point].max(initial=0) <= k


def test_joining_does_not_mind_where_the_start_lies(world):
    """New states are placed from the frame of their map, so a start that is turned as a whole is turned back."""
    built = world(np.random.default_rng(7), noise=0.0, outlier=False, start_error=0.0)
    turned = np.array([3.0, -1.0, 0.7])
    graph = built.graph
    start = State(se2.compose(turned, graph.poses), se2.transform(turned, graph.control_points))
    maps = local_maps_of(graph)
    joined = join_in_order(maps, maps.first, start, JoinWatch(maps, maps, start))
    assert np.abs(se2.between(built.poses, joined.poses)).max() < 1e-5
    assert np.abs(joined.control_points - built.control_points).max() < 1e-4


def test_joining_tells_where_it_is(world):
    """Record by record, numbered on, and in every one of them a whole map; the first and the last are the result's."""
    graph, seen = world(np.random.default_rng(11), poses=40).graph, []
    estimate = back_end("islsjf").solve(graph, progress=seen.append)
    joining = len(seen) - len(estimate.iterations)
    assert joining > 3
    assert [record.index for record in seen] == list(range(len(seen)))
    assert [record.cost for record in seen[joining + 1 :]] == [record.cost for record in estimate.iterations[1:]]
    assert all(a.seconds <= b.seconds for a, b in pairwise(seen))
    maps = local_maps_of(graph)
    for record in seen:
        assert record.cost == pytest.approx(maps.cost(State(record.poses, record.control_points)), rel=1e-12)


def test_a_start_at_the_optimum_is_kept(world):
    graph = world(np.random.default_rng(9)).graph
    best = back_end("direct").solve(graph)
    again = back_end("islsjf").solve(replace(graph, poses=best.poses, control_points=best.control_points))
    np.testing.assert_allclose(again.poses, best.poses, atol=1e-7)
    np.testing.assert_allclose(again.control_points, best.control_points, atol=1e-6)


def test_covariances_are_those_of_direct(world):
    graph = world(np.random.default_rng(10)).graph
    solver = back_end("islsjf")
    estimate = solver.solve(graph)
    ours = solver.covariances(estimate, poses=[4], splines=[101])
    joint = local_maps_of(graph).linearise(State(estimate.poses, estimate.control_points))
    inverse = np.linalg.inv(joint.matrix.toarray() + STEP_INFORMATION * np.eye(graph.unknowns))
    first = 3 * 12 + 16
    np.testing.assert_allclose(ours.poses[4], inverse[12:15, 12:15], rtol=1e-5, atol=1e-12)
    np.testing.assert_allclose(ours.splines[101], inverse[first : first + 16, first : first + 16], rtol=1e-5, atol=1e-9)
