"""The sparse factor against dense algebra, on graphs with loops, long splines and lone control points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bspline_slam.backends import supernodes
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State
from bspline_slam.backends.pattern import Blocks, Pattern
from bspline_slam.errors import SolverError
from bspline_slam.graph import Graph
from bspline_slam.kernels import ordering, symbolic

SIZES = [{"poses": 2, "walls": 1}, {"poses": 12}, {"poses": 60, "walls": 9, "points": 7}, {"poses": 9, "points": 40}]


def linearised(graph: Graph, *, whole_splines: bool = False):
    problem = FullProblem.from_graph(graph, whole_splines=whole_splines)
    return problem.linearise(State(graph.poses, graph.control_points))


def dense(blocks: Blocks, pattern: Pattern) -> np.ndarray:
    """All blocks where they belong, both halves."""
    n, (count, width) = 3 * len(blocks.pose), pattern.curve_filled.shape
    H = np.zeros((n + 2 * count, n + 2 * count))
    for i, block in enumerate(blocks.pose):
        H[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = np.tril(block) + np.tril(block, -1).T
    for (i, j), block in zip(pattern.edges, blocks.edge, strict=True):
        H[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] = block
        H[3 * j : 3 * j + 3, 3 * i : 3 * i + 3] = block.T
    for (k, i), block in zip(pattern.sights, blocks.sight, strict=True):
        H[n + 2 * k : n + 2 * k + 2, 3 * i : 3 * i + 3] = block
        H[3 * i : 3 * i + 3, n + 2 * k : n + 2 * k + 2] = block.T
    for k in range(count):
        for d in range(min(width, count - k)):
            a, b = n + 2 * k, n + 2 * (k + d)
            H[a : a + 2, b : b + 2] = blocks.curve[k, d]
            H[b : b + 2, a : a + 2] = blocks.curve[k, d].T
    return H + STEP_INFORMATION * np.eye(len(H))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("widest", [4, 96])
def test_solutions_and_inverse_are_those_of_dense_algebra(world, monkeypatch, size, widest):
    monkeypatch.setattr(supernodes, "WIDEST", widest)
    system = linearised(world(np.random.default_rng(0), outlier=size["poses"] > 9, **size).graph, whole_splines=True)
    H = dense(system.blocks, system.analysis.pattern)
    factor = system.factorise()
    right = np.random.default_rng(1).normal(size=(len(H), 3))
    expected = np.linalg.solve(H, right)
    np.testing.assert_allclose(factor.solve(right), expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())
    inverse, (poses, curve) = np.linalg.inv(H), factor.inverse_blocks()
    n, tolerance = 3 * len(poses), 1e-9 * np.abs(inverse).max()
    for i, block in enumerate(poses):
        np.testing.assert_allclose(block, inverse[3 * i : 3 * i + 3, 3 * i : 3 * i + 3], rtol=1e-6, atol=tolerance)
    for k, d in zip(*np.nonzero(system.analysis.pattern.curve_filled), strict=True):
        a, b = n + 2 * k, n + 2 * (k + d)
        np.testing.assert_allclose(curve[k, d], inverse[a : a + 2, b : b + 2], rtol=1e-6, atol=tolerance)


def test_damping_is_added_to_the_diagonal(world):
    system = linearised(world(np.random.default_rng(2)).graph)
    H = dense(system.blocks, system.analysis.pattern) + 50 * np.eye(system.analysis.order.size)
    gradient = system.blocks.gradient
    expected = -np.linalg.solve(H, np.append(gradient.poses.ravel(), gradient.control_points.ravel()))
    step = system.step(50.0)
    np.testing.assert_allclose(np.append(step.poses.ravel(), step.control_points.ravel()), expected, atol=1e-10)


def test_the_matrix_of_newton_is_the_derivative_of_the_gradient(world):
    graph = world(np.random.default_rng(5), start_error=0.3).graph
    problem, poses = FullProblem.from_graph(graph), 3 * len(graph.poses)
    start = np.append(graph.poses.ravel(), graph.control_points.ravel())

    def gradient(unknowns: np.ndarray) -> np.ndarray:
        state = State(unknowns[:poses].reshape(-1, 3), unknowns[poses:].reshape(-1, 2))
        found = problem.linearise(state).blocks.gradient
        return np.append(found.poses.ravel(), found.control_points.ravel())

    nudges = 1e-5 * np.eye(len(start))
    expected = np.array([(gradient(start + nudge) - gradient(start - nudge)) / 2e-5 for nudge in nudges])
    system = problem.linearise(State(graph.poses, graph.control_points))
    newton = dense(system.blocks.newton(), system.analysis.pattern)
    gauss_newton = dense(system.blocks, system.analysis.pattern)
    assert np.abs(gauss_newton - expected).max() > 1.0
    np.testing.assert_allclose(newton, expected + STEP_INFORMATION * np.eye(len(start)), atol=1e-7 * expected.max())


def test_where_newton_s_matrix_is_indefinite_the_step_is_that_of_gauss_and_newton(world):
    system = linearised(world(np.random.default_rng(6)).graph)
    gradient = system.blocks.gradient
    system.blocks.bent_pose[3] -= 1e9 * np.eye(3)
    expected = -system.factorise().solve(np.append(gradient.poses.ravel(), gradient.control_points.ravel())[:, None])
    step = system.step(0.0)
    np.testing.assert_allclose(np.append(step.poses.ravel(), step.control_points.ravel()), expected[:, 0])


def test_a_matrix_that_is_not_positive_names_the_unknown(world):
    system = linearised(world(np.random.default_rng(3)).graph)
    system.blocks.pose[4] -= 1e9 * np.eye(3)
    with pytest.raises(SolverError, match="nothing determines"):
        system.factorise()


def test_poses_alone(world):
    graph = world(np.random.default_rng(4)).graph
    alone = replace(
        graph, spline_ids=graph.spline_ids[:0], spline_first=graph.spline_first[:1], spline_factors=(),
        control_points=graph.control_points[:0], shape_priors=(),
    )  # fmt: skip
    system = linearised(alone)
    poses, curve = system.factorise().inverse_blocks()
    inverse = np.linalg.inv(dense(system.blocks, system.analysis.pattern))
    assert curve.shape[0] == 0
    np.testing.assert_allclose(poses[7], inverse[21:24, 21:24], rtol=1e-8)


@given(st.integers(1, 40), st.integers(0, 120), st.integers(0, 1000))
def test_orders_are_permutations_and_structures_hold_the_fill(nodes, links, seed):
    rng = np.random.default_rng(seed)
    matrix = np.eye(nodes, dtype=bool)
    matrix[rng.integers(0, nodes, links), rng.integers(0, nodes, links)] = True
    matrix |= matrix.T
    start = np.append(0, np.cumsum(matrix.sum(axis=1) - 1))
    neighbours = np.concatenate([np.flatnonzero(row & (np.arange(nodes) != i)) for i, row in enumerate(matrix)])
    order = ordering.minimum_degree(start, neighbours.astype(np.int64), rng.integers(1, 4, nodes))
    assert np.array_equal(np.sort(order), np.arange(nodes))
    filled = matrix[np.ix_(order, order)]
    for j in range(nodes):
        below = j + 1 + np.flatnonzero(filled[j + 1 :, j])
        filled[np.ix_(below, below)] = True
    position = np.argsort(order)
    parent = symbolic.elimination_tree(start, neighbours.astype(np.int64), order, position)
    begin, rows = symbolic.row_structures(start, neighbours.astype(np.int64), order, position, parent)
    for j in range(nodes):
        below = j + 1 + np.flatnonzero(filled[j + 1 :, j])
        assert np.array_equal(np.sort(rows[begin[j] : begin[j + 1]]), below)
        assert parent[j] == (below[0] if len(below) else -1)


def test_a_postorder_ends_each_tree_with_its_root():
    parent = np.array([3, 3, 5, 5, -1, 6, -1])
    post = symbolic.postorder(parent)
    place = np.argsort(post)
    assert np.array_equal(np.sort(post), np.arange(7))
    assert all(place[j] < place[p] for j, p in enumerate(parent) if p >= 0)
