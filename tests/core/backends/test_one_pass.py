"""What holds for every back end that goes through the key scans once, on the sample log and on synthetic graphs."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.adjustment.adjustment_config import AdjustmentConfig
from bspline_slam.backends import ONE_PASS, back_end, one_pass
from bspline_slam.backends.one_pass import RECORDS, records_of
from bspline_slam.backends.protocol import Estimate
from bspline_slam.bspline import BSpline
from bspline_slam.errors import Cancelled, SolverError
from bspline_slam.graph import Graph
from bspline_slam.logs import open_log
from bspline_slam.slam import run_slam
from bspline_slam.slam_config import SlamConfig

STATED = tuple(name for name in ONE_PASS if name != "bs_slam")
"""Those that make do with factors; the other one needs beams."""


@pytest.fixture(scope="module")
def real() -> Graph:
    """The last problem of a run over the sample log, at its starting values, with beams, its curves held firmly along
    themselves, for filters linearise once."""
    log = open_log(Path(__file__).parents[3] / "sample_logs" / "three_splines.log.gz")
    firm = AdjustmentConfig(slide=0.4 * AdjustmentConfig().slide)
    estimate = run_slam(log, SlamConfig(adjustment=firm)).snapshot.estimate
    assert estimate is not None
    return estimate.graph


def curves(estimate: Estimate) -> list[BSpline]:
    """The splines of an estimate of a graph with beams."""
    graph = estimate.graph
    assert graph.beams is not None
    cuts = pairwise(graph.spline_first.tolist())
    return [
        curve.with_control_points(estimate.control_points[a:b])
        for curve, (a, b) in zip(graph.beams.curves, cuts, strict=True)
    ]


@pytest.mark.parametrize("name", ONE_PASS)
def test_every_key_scan_leaves_a_record(real, name):
    seen = []
    estimate = back_end(name).solve(real, progress=seen.append)
    assert [record.index for record in seen] == list(range(len(seen)))
    assert len(seen) == records_of(len(real.poses)) + (name == "isam2")
    assert all(a is b for a, b in zip(seen, estimate.iterations, strict=True))
    assert np.array_equal(seen[0].poses, real.poses)
    assert np.array_equal(seen[-1].poses, estimate.poses)
    assert np.array_equal(seen[-1].control_points, estimate.control_points)
    assert all(np.isfinite(record.cost) and a.seconds <= record.seconds for a, record in pairwise(seen))
    assert estimate.converged


@pytest.mark.parametrize("name", ONE_PASS)
def test_the_last_pose_and_the_map_are_those_of_the_batch(real, name):
    """A filter ends with all that is known of them; only its linearisations and the loop closures are missing."""
    batch, estimate = back_end("direct").solve(real), back_end(name).solve(real)
    assert np.abs(se2.between(batch.poses[-1], estimate.poses[-1])).max() < 0.005
    for one, other in zip(curves(batch), curves(estimate), strict=True):
        _, points = other.sample(0.05)
        feet = one(one.foot_points(points))
        assert np.sqrt(np.mean(np.sum((points - feet) ** 2, axis=1))) < 0.01
    assert estimate.dof == pytest.approx(batch.dof, rel=1e-3)
    assert estimate.chi2 < 1.2 * batch.chi2


@pytest.mark.parametrize("name", ONE_PASS)
def test_covariances_are_close_to_those_of_the_batch(real, name):
    last, spline = len(real.poses) - 1, int(real.spline_ids[0])
    solver = back_end(name)
    found = solver.covariances(solver.solve(real), poses=[0, last], splines=[spline])
    batch = back_end("direct").covariances(back_end("direct").solve(real), poses=[last], splines=[spline])
    ratio = np.sqrt(np.diag(found.poses[last]) / np.diag(batch.poses[last]))
    assert np.all((ratio > 0.7) & (ratio < 1.4))
    assert np.trace(found.poses[0]) < 1e-8
    for covariance in (found.poses[last], found.splines[spline]):
        np.testing.assert_allclose(covariance, covariance.T, rtol=1e-9, atol=1e-15)
        assert np.linalg.eigvalsh(covariance).min() > 0
    assert found.splines[spline].shape == batch.splines[spline].shape


@pytest.mark.parametrize("name", ONE_PASS)
def test_cancel_leaves_between_key_scans(real, name):
    seen = []
    with pytest.raises(Cancelled, match="after 3 key scans"):
        back_end(name).solve(real, progress=seen.append, cancelled=lambda: len(seen) == 4)
    assert len(seen) == 4


def test_slow_key_scans_are_told_of_though_they_leave_no_record(world, monkeypatch):
    monkeypatch.setattr(one_pass, "SILENCE", 0.0)
    graph, seen = world(np.random.default_rng(0), poses=RECORDS + 11, walls=1).graph, []
    estimate = back_end("ekf").solve(graph, progress=seen.append)
    assert len(seen) == 1 + RECORDS + 11
    assert len(estimate.iterations) == records_of(RECORDS + 11)
    assert all(0 <= b.index - a.index <= 1 for a, b in pairwise(seen))
    assert seen[-1].index == len(estimate.iterations) - 1


def test_long_logs_leave_a_bounded_number_of_records(world):
    graph = world(np.random.default_rng(0), poses=RECORDS + 11, walls=1).graph
    estimate = back_end("ekf").solve(graph)
    assert len(estimate.iterations) == records_of(RECORDS + 11) <= RECORDS + 1
    assert np.array_equal(estimate.iterations[-1].poses, estimate.poses)


@pytest.mark.parametrize("name", STATED)
def test_a_pose_tied_by_splines_alone_is_found(world, name):
    built = world(np.random.default_rng(1), noise=0.0, outlier=False, start_error=0.003)
    kept = tuple(factor for factor in built.graph.pose_factors if 7 not in (factor.i, factor.j))
    estimate = back_end(name).solve(replace(built.graph, pose_factors=kept))
    assert np.linalg.norm((estimate.poses - built.poses)[7, :2]) < 0.02


@pytest.mark.parametrize("name", STATED)
def test_values_that_are_no_numbers_are_refused(world, name):
    graph = world(np.random.default_rng(11)).graph
    poses = graph.poses.copy()
    poses[3, 0] = np.nan
    with pytest.raises(SolverError, match="not finite"):
        back_end(name).solve(replace(graph, poses=poses))


def test_isam2_is_within_a_millimetre_of_the_batch_optimum(real, world):
    for graph in (real, *(world(np.random.default_rng(seed)).graph for seed in range(3))):
        batch, estimate = back_end("direct").solve(graph), back_end("isam2").solve(graph)
        assert np.abs((batch.poses - estimate.poses)[:, :2]).max() < 1e-3
        assert np.abs(batch.control_points - estimate.control_points).max() < 1e-3
        assert estimate.chi2 == pytest.approx(batch.chi2, rel=1e-4)


def test_the_beams_of_a_graph_are_the_readings_behind_its_factors(real):
    beams = real.beams
    assert beams is not None
    assert len(beams.pose) == sum(factor.readings for factor in real.spline_factors)
    ends = beams.origins + beams.ranges[:, None] * beams.directions
    world = se2.transform(real.poses[beams.pose], ends)
    for k, curve in enumerate(beams.curves):
        mine = beams.spline == k
        off = np.linalg.norm(curve(beams.parameters[mine]) - world[mine], axis=1)
        assert np.sqrt(np.mean(off**2)) < 0.03
    assert np.all(beams.sigma > 0.005)
