"""What holds for every back end, and between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import BACK_ENDS, ONE_PASS, back_end
from bspline_slam.backends.gauss_newton import ROUNDING
from bspline_slam.backends.protocol import Estimate
from bspline_slam.errors import Cancelled, ConfigError, SolverError
from bspline_slam.graph import Graph, SplineFactor

FULL = ("direct", "sam")
"""Back ends that solve poses and control points together."""
ITERATING = tuple(name for name in BACK_ENDS if name not in ONE_PASS)
"""Back ends that go over the whole graph again and again."""


def assert_same_state(a: Estimate, b: Estimate, tolerance: float) -> None:
    assert np.abs(a.poses[:, :2] - b.poses[:, :2]).max() < tolerance
    assert np.abs(se2.wrap(a.poses[:, 2] - b.poses[:, 2])).max() < tolerance
    assert np.abs(a.control_points - b.control_points).max() < tolerance


def assert_at_truth(estimate: Estimate, world, tolerance: float) -> None:
    error = se2.between(world.poses, estimate.poses)
    assert np.abs(error).max() < tolerance
    assert np.abs(estimate.control_points - world.control_points).max() < tolerance


def test_names():
    assert BACK_ENDS[0] == "direct"
    assert BACK_ENDS[-1] == "pose_graph"
    assert set(ONE_PASS) < set(BACK_ENDS)
    assert [back_end(name).name for name in BACK_ENDS] == list(BACK_ENDS)
    with pytest.raises(ConfigError, match="choose one of direct, sam, "):
        back_end("magic")


@pytest.mark.parametrize("name", ITERATING)
@pytest.mark.parametrize("seed", range(3))
def test_noise_free_optimum_is_the_truth(world, name, seed):
    built = world(np.random.default_rng(seed), noise=0.0, outlier=False)
    estimate = back_end(name).solve(built.graph)
    assert estimate.converged
    assert_at_truth(estimate, built, 1e-8)
    constant = sum(factor.constant for factor in built.graph.spline_factors)
    assert estimate.chi2 == pytest.approx(constant, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_direct_and_sam_reach_the_same_optimum(world, seed):
    graph = world(np.random.default_rng(seed)).graph
    direct, sam = (back_end(name).solve(graph) for name in FULL)
    assert_same_state(direct, sam, 1e-6)
    assert direct.iterations[-1].cost == pytest.approx(sam.iterations[-1].cost, rel=1e-9)
    assert direct.chi2 == pytest.approx(sam.chi2, rel=1e-9)
    assert direct.dof == pytest.approx(sam.dof, rel=1e-6)


@pytest.mark.parametrize("name", ITERATING)
def test_records_tell_a_descent(world, name):
    graph, seen = world(np.random.default_rng(5), start_error=0.2).graph, []
    estimate = back_end(name).solve(graph, progress=seen.append)
    costs = np.array([record.cost for record in estimate.iterations])
    assert [record.index for record in seen] == list(range(len(seen)))
    assert [record.index for record in estimate.iterations] == list(range(len(costs)))
    assert len(seen) == len(costs) or name == "islsjf"  # which tells of its joining too
    assert [record.cost for record in seen[1 - len(costs) :]] == list(costs[1:])
    assert np.all(np.diff(costs) <= ROUNDING * (1 + costs[:-1]))
    assert np.array_equal(seen[0].poses, graph.poses)
    assert np.array_equal(seen[0].control_points, graph.control_points)
    assert np.array_equal(seen[-1].poses, estimate.poses)
    assert np.array_equal(seen[-1].control_points, estimate.control_points)


@pytest.mark.parametrize("name", ITERATING)
def test_far_starts_still_descend(world, name):
    graph = world(np.random.default_rng(6)).graph
    lost = replace(graph, poses=graph.poses + np.random.default_rng(7).normal(size=graph.poses.shape))
    estimate = back_end(name).solve(lost)
    costs = np.array([record.cost for record in estimate.iterations])
    assert np.all(np.diff(costs) <= ROUNDING * (1 + costs[:-1]))
    assert np.all(np.abs(estimate.poses[:, 2]) <= np.pi)


@pytest.mark.parametrize("name", ITERATING)
def test_moving_the_world_moves_the_solution(world, name):
    rigid = np.array([20.0, -7.0, 2.5])
    here = back_end(name).solve(world(np.random.default_rng(8), start_error=0.0).graph)
    there = back_end(name).solve(moved(here.graph, rigid))
    error = se2.between(se2.compose(rigid, here.poses), there.poses)
    assert np.abs(error).max() < 1e-6
    assert np.abs(se2.transform(rigid, here.control_points) - there.control_points).max() < 1e-6


def moved(graph: Graph, rigid: np.ndarray) -> Graph:
    """The whole problem in another world frame."""
    turn = np.kron(np.eye(len(graph.control_points)), se2.rotation(rigid[2]))
    shapes = []
    for prior in graph.shape_priors:
        width = prior.A.shape[1]
        A = prior.A @ turn[:width, :width].T
        shapes.append(replace(prior, A=A, b=prior.b + A @ np.tile(rigid[:2], width // 2)))
    priors = []
    for prior in graph.pose_priors:
        root = prior.sqrt_information.copy()
        root[:, :2] = root[:, :2] @ se2.rotation(rigid[2]).T
        priors.append(replace(prior, mean=se2.compose(rigid, prior.mean), sqrt_information=root))
    return replace(
        graph,
        poses=se2.compose(rigid, graph.poses),
        control_points=se2.transform(rigid, graph.control_points),
        pose_priors=tuple(priors),
        shape_priors=tuple(shapes),
    )


@pytest.mark.parametrize("name", [name for name in BACK_ENDS if name != "bs_slam"])
def test_cancelling_works_at_any_time(world, name):
    """Whenever it hears that nobody waits any more, a back end leaves without asking again; it asks often."""
    graph, asked = world(np.random.default_rng(9)).graph, []
    back_end(name).solve(graph, cancelled=lambda: bool(asked.append(None)))
    times = len(asked)
    assert times > 3
    for stop in np.linspace(1, times, 5).astype(int):
        asked.clear()
        with pytest.raises(Cancelled):
            back_end(name).solve(graph, cancelled=lambda stop=stop: bool(asked.append(None)) or len(asked) >= stop)
        assert len(asked) == stop


@pytest.mark.parametrize("name", [name for name in BACK_ENDS if name != "bs_slam"])
def test_a_loose_pose_is_named(world, name):
    graph = world(np.random.default_rng(10)).graph
    loose = replace(
        graph,
        pose_factors=tuple(factor for factor in graph.pose_factors if 7 not in (factor.i, factor.j)),
        spline_factors=tuple(factor for factor in graph.spline_factors if factor.pose != 7),
    )
    with pytest.raises(SolverError, match=r"pose 7 \(scan 70\)"):
        back_end(name).solve(loose)


@pytest.mark.parametrize("name", ITERATING)
def test_a_map_without_prior_is_refused(world, name):
    graph = world(np.random.default_rng(11)).graph
    with pytest.raises(SolverError, match="no pose has a prior"):
        back_end(name).solve(replace(graph, pose_priors=()))


@pytest.mark.parametrize("name", FULL)
def test_a_spline_that_nothing_sees_is_named(world, name):
    graph = world(np.random.default_rng(12)).graph
    unseen = tuple(factor for factor in graph.spline_factors if not 8 <= factor.first < 16)
    with pytest.raises(SolverError, match="spline 101"):
        back_end(name).solve(replace(graph, spline_factors=unseen))


@pytest.mark.parametrize("name", ITERATING)
def test_what_nothing_observes_stays_where_it_started(world, name):
    graph = world(np.random.default_rng(13), walls=2).graph
    gone = replace(
        graph,
        shape_priors=(),
        spline_factors=tuple(factor for factor in graph.spline_factors if factor.first + 5 != 8),
    )
    estimate = back_end(name).solve(gone)
    np.testing.assert_allclose(estimate.control_points[7], graph.control_points[7], atol=1e-9)


def observed_parameters(estimate: Estimate) -> int:
    """How many parameters of the control points all observations together determine."""
    rows = []
    for factor in estimate.graph.spline_factors:
        seen = slice(factor.first, factor.first + factor.A.shape[1] // 2)
        _, jacobian = factor.jacobians(estimate.poses[factor.pose], estimate.control_points[seen])
        rows.append(np.zeros((len(jacobian), estimate.control_points.size)))
        rows[-1][:, 2 * seen.start : 2 * seen.stop] = jacobian
    return int(np.linalg.matrix_rank(np.concatenate(rows)))


@pytest.mark.parametrize("name", ITERATING)
def test_degrees_of_freedom_count_what_was_measured_less_what_it_determines(world, name):
    graph = world(np.random.default_rng(14), poses=6, walls=1).graph
    rows = sum(factor.readings for factor in graph.spline_factors) + 3 * len(graph.pose_factors)
    weak, given, strong = (
        back_end(name).solve(replace(graph, shape_priors=tuple(replace(p, A=k * p.A) for p in graph.shape_priors)))
        for k in (1e-4, 1.0, 1e4)
    )
    assert weak.dof == pytest.approx(rows - 3 * 5 - observed_parameters(weak), abs=0.1)
    assert weak.dof < given.dof < strong.dof < rows - 3 * 5


def test_a_gauge_counts_neither_in_chi_square_nor_in_degrees_of_freedom(world):
    graph = world(np.random.default_rng(15)).graph
    before = back_end("direct").solve(graph)
    there = se2.transform(se2.inverse(before.poses[2]), before.control_points[3:4])[0]
    gauge = SplineFactor(2, 3, 1e-4 * np.eye(2), 1e-4 * (there + 100.0))
    after = back_end("direct").solve(replace(graph, spline_factors=(*graph.spline_factors, gauge)))
    assert after.chi2 == pytest.approx(before.chi2, abs=1e-3)
    assert after.dof == pytest.approx(before.dof, abs=1e-3)


@pytest.mark.parametrize("name", ITERATING)
def test_the_cost_is_half_the_robust_squares(world, name):
    graph = world(np.random.default_rng(15)).graph
    start = back_end(name).solve(graph).iterations[0]
    squares = [
        factor.residual(graph.poses[factor.pose], graph.control_points[factor.first :][:5])
        for factor in graph.spline_factors
    ] + [prior.residual(graph.control_points[prior.first :][:8]) for prior in graph.shape_priors]
    cost = 0.0 if name == "pose_graph" else sum(float(e @ e) for e in squares)
    cost += sum(float(e @ e) for prior in graph.pose_priors for e in [prior.residual(graph.poses[prior.pose])])
    for factor in () if name == "idmj" else graph.pose_factors:
        e = factor.residual(graph.poses[factor.i], graph.poses[factor.j])
        c = np.inf if factor.kernel is None else factor.kernel
        cost += float(e @ e) if np.isinf(c) else float(c**2 * np.log1p(e @ e / c**2))
    assert start.cost == pytest.approx(cost / 2, rel=1e-12)
