"""The tests of one estimate: what they must give when the truth, or the map without the scan, is at hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import back_end
from bspline_slam.backends.direct import FullProblem
from bspline_slam.backends.gauss_newton import State
from bspline_slam.backends.protocol import Estimate
from bspline_slam.backends.statistics import measures
from bspline_slam.errors import Cancelled
from bspline_slam.lab import innovations as lab
from bspline_slam.lab.consistency import (
    BEARING_NOISE,
    ODOMETRY,
    RANGE_NOISE,
    Experiment,
    problem_from_truth,
    settled,
    told_the_truth,
)
from bspline_slam.lab.scan_consistency import pose_errors, scan_consistency
from bspline_slam.lab.simulation import simulate
from bspline_slam.lab.world_file import open_world
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot
from bspline_slam.spline_map import SplineMap


@pytest.fixture(scope="module")
def estimates() -> list[Estimate]:
    """Drives past three curves, estimated by an estimator that knows the noise."""
    world, config = open_world("three_splines"), told_the_truth(Experiment("three_splines"))
    found = []
    for run in range(3):
        rng = np.random.default_rng([5, run])
        log = simulate(world, rng=rng, noise=RANGE_NOISE, bearing_noise=BEARING_NOISE, odometry=ODOMETRY)
        found.append(settled(problem_from_truth(world, log, config), config)[1])
    return found


def test_innovations_of_an_honest_estimator_are_as_large_as_expected(estimates: list[Estimate]) -> None:
    tests = [lab.innovations(estimate) for estimate in estimates]
    dof = sum(test.dof.sum() for test in tests)
    assert sum(test.squares.sum() for test in tests) / dof == pytest.approx(1.0, abs=0.05)
    assert np.concatenate([test.inside for test in tests]).mean() > 0.85
    assert np.array_equal(tests[0].scans, estimates[0].graph.key_scans)


def test_nothing_needs_to_be_solved_again_without_the_scan(
    estimates: list[Estimate], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lab, "LEAST_SHARE", 1e-9)
    estimate, k = estimates[0], 9
    graph, here = estimate.graph, State(estimate.poses, estimate.control_points)
    mine = [f for f in graph.spline_factors if f.pose == k and measures(f)]
    others = tuple(f for f in graph.spline_factors if not (f.pose == k and measures(f)))
    rest = FullProblem.from_graph(replace(graph, spline_factors=others)).linearise(here)
    moved, (residual, jacobian, unknowns) = (
        rest.factorise().step(rest.blocks.gradient),
        lab._stacked(estimate, mine),
    )
    innovation = residual + jacobian @ np.concatenate([moved.poses.ravel(), moved.control_points.ravel()])[unknowns]
    covariance = rest.factorise().solve(np.eye(graph.unknowns)[:, unknowns])[unknowns]
    spread = np.eye(len(residual)) + jacobian @ covariance @ jacobian.T
    expected = innovation @ np.linalg.solve(spread, innovation)
    test = lab.innovations(estimate)
    assert test.squares[k] == pytest.approx(expected, rel=1e-4)
    assert test.dof[k] == len(residual)


def test_a_scan_that_lies_about_its_ranges_stands_out(estimates: list[Estimate]) -> None:
    estimate = estimates[0]
    lying = tuple(replace(f, b=f.b + 3.0) if f.pose == 6 and measures(f) else f for f in estimate.graph.spline_factors)
    test = lab.innovations(back_end("direct").solve(replace(estimate.graph, spline_factors=lying)))
    assert test.worst == estimate.graph.key_scans[6]
    assert not test.inside[6]


def test_pose_errors_do_not_depend_on_the_frame_of_the_truth(estimates: list[Estimate]) -> None:
    estimate = estimates[0]
    scans = int(estimate.graph.key_scans[-1]) + 1
    rng = np.random.default_rng(2)
    truth = np.zeros((scans, 3))
    truth[estimate.graph.key_scans] = estimate.poses + rng.normal(0.0, 0.01, estimate.poses.shape)
    covariances = {k: np.diag([1e-4, 1e-4, 1e-4]) for k in range(len(estimate.poses))}
    here = pose_errors(estimate, covariances, truth)
    there = pose_errors(estimate, covariances, se2.compose(np.array([3.0, -2.0, 0.0]), truth))
    assert np.allclose(here.squares, there.squares)
    turned = pose_errors(estimate, covariances, se2.compose(np.array([3.0, -2.0, 2.5]), truth))
    assert np.allclose(here.squares, turned.squares)
    assert np.array_equal(here.scans, estimate.graph.key_scans[1:])
    assert np.all(here.dof == 3.0)


def test_a_perfect_estimate_has_no_pose_errors(estimates: list[Estimate]) -> None:
    estimate = estimates[0]
    truth = np.zeros((int(estimate.graph.key_scans[-1]) + 1, 3))
    truth[estimate.graph.key_scans] = estimate.poses
    covariances = {k: 1e-6 * np.eye(3) for k in range(len(estimate.poses))}
    assert pose_errors(estimate, covariances, truth).squares == pytest.approx(0.0, abs=1e-12)


def test_the_test_can_be_cancelled_between_scans(estimates: list[Estimate]) -> None:
    asked = count()
    with pytest.raises(Cancelled):
        lab.innovations(estimates[0], cancelled=lambda: next(asked) > 2)


def test_a_map_that_was_never_solved_is_not_tested() -> None:
    snapshot = Snapshot(np.zeros((3, 3)), np.arange(3), (), SplineMap(), ())
    assert scan_consistency(snapshot, SlamConfig(), {}, np.zeros((3, 3))) is None
