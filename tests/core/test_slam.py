"""The whole chain on the sample logs, against truth, and what a step and a snapshot promise."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.association import Verdict
from bspline_slam.backends import BACK_ENDS
from bspline_slam.errors import Cancelled, ConfigError, SolverError
from bspline_slam.estimates import adjust, marginals
from bspline_slam.fitting import FittingConfig
from bspline_slam.logs import open_log
from bspline_slam.models import ChordLengthConfig
from bspline_slam.relation import Relation
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Slam, SlamResult, run_slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import SlamStep, Snapshot

SAMPLES = Path(__file__).parents[2] / "sample_logs"


@pytest.fixture(scope="module")
def three_splines() -> ScanLog:
    return open_log(SAMPLES / "three_splines.log.gz")


@pytest.fixture(scope="module")
def result(three_splines: ScanLog) -> SlamResult:
    return run_slam(three_splines)


def absolute_error(log: ScanLog, poses: np.ndarray) -> np.ndarray:
    """Distance of each pose from the truth after the best rigid alignment (m)."""
    assert log.truth is not None
    a, b = poses[:, :2] - poses[:, :2].mean(0), log.truth[:, :2] - log.truth[:, :2].mean(0)
    turn = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    return np.linalg.norm(se2.transform(np.array([0.0, 0.0, turn]), a) - b, axis=1)


def test_three_splines_are_found_and_every_pose_is_right_to_a_centimetre(
    three_splines: ScanLog, result: SlamResult
) -> None:
    assert absolute_error(three_splines, result.snapshot.poses).max() < 0.01
    assert len(result.snapshot.map) == 3
    assert set(result.seconds) == {"scans", "adjustment"}


def test_a_snapshot_is_whole(three_splines: ScanLog, result: SlamResult) -> None:
    snapshot = result.snapshot
    assert len(snapshot.poses) == len(three_splines)
    assert [step.scan for step in snapshot.steps] == snapshot.key_scans.tolist()
    for step in snapshot.steps:
        np.testing.assert_allclose(step.pose, snapshot.poses[step.scan], atol=1e-9)
    ids = {spline.id for spline in snapshot.map}
    used = {a.spline for step in snapshot.steps for a in step.associations if a.spline is not None}
    assert ids <= used
    assert snapshot.estimate is not None
    assert 0.2 < snapshot.estimate.chi2 / snapshot.estimate.dof < 2.0


@pytest.mark.parametrize("name", BACK_ENDS)
def test_every_back_end_optimises_a_snapshot(three_splines: ScanLog, result: SlamResult, name: str) -> None:
    records: list[float] = []
    after = adjust(
        three_splines, result.snapshot, SlamConfig(), name, lambda _, __, r: records.append(r.cost) if r else None
    )
    assert records
    assert absolute_error(three_splines, after.poses).max() < (0.01 if name != "pose_graph" else 0.05)


def test_direct_and_islsjf_agree_on_three_splines(three_splines: ScanLog, result: SlamResult) -> None:
    config = SlamConfig()
    config = replace(config, adjustment=replace(config.adjustment, gates=(0.08,)))
    direct = adjust(three_splines, result.snapshot, config, "direct").estimate
    joined = adjust(three_splines, result.snapshot, config, "islsjf").estimate
    assert direct is not None
    assert joined is not None
    np.testing.assert_allclose(direct.poses, joined.poses, atol=1e-6)
    np.testing.assert_allclose(direct.control_points, joined.control_points, atol=1e-6)


def test_covariances_come_on_request(result: SlamResult) -> None:
    last = len(result.snapshot.steps) - 1
    spline = result.snapshot.map.splines[0]
    found = marginals(result.snapshot, poses=[0, last], splines=[spline.id])
    assert np.trace(found.poses[0]) < 1e-8 < np.trace(found.poses[last]) < 1e-3
    assert found.splines[spline.id].shape == (2 * len(spline.curve.control_points),) * 2
    assert np.linalg.eigvalsh(found.splines[spline.id]).min() > 0


def test_covariances_before_an_adjustment_are_refused(three_splines: ScanLog) -> None:
    slam = Slam(three_splines)
    next(iter(slam.steps()))
    with pytest.raises(SolverError, match="optimise first"):
        marginals(slam.snapshot())


def test_cancelling_stops_between_scans_and_keeps_what_was_done(three_splines: ScanLog) -> None:
    done: list[SlamStep] = []
    slam = Slam(three_splines, cancelled=lambda: len(done) >= 10)
    with pytest.raises(Cancelled, match="scan 10"):
        for step in slam.steps():
            done.append(step)  # noqa: PERF402 (what was done before the error is the point)
    assert len(slam.snapshot().poses) == 10


@pytest.mark.parametrize(
    "config",
    [SlamConfig(back_end="magic"), SlamConfig(model="magic")],
)
def test_unknown_names_are_refused_before_any_work(three_splines: ScanLog, config: SlamConfig) -> None:
    with pytest.raises(ConfigError, match='"magic": choose one of'):
        Slam(three_splines, config)


@pytest.mark.parametrize("degree", [1, 2, 4, 5])
def test_curves_of_any_order_give_the_same_poses(three_splines: ScanLog, degree: int) -> None:
    slam = Slam(three_splines, SlamConfig(fitting=FittingConfig(degree=degree)))
    for _ in slam.steps():
        pass
    assert {spline.curve.degree for spline in slam.snapshot().map} == {degree}
    snapshot = slam.finish()
    assert all(spline.curve.degree <= degree for spline in snapshot.map), "plain ones are left with less"
    assert absolute_error(three_splines, snapshot.poses).max() < 0.01
    found = marginals(snapshot, splines=[spline.id for spline in snapshot.map])
    assert all(np.linalg.eigvalsh(covariance).min() > 0 for covariance in found.splines.values())


@pytest.fixture(scope="module")
def published(three_splines: ScanLog) -> Snapshot:
    return run_slam(three_splines, SlamConfig(model="chord-length")).snapshot


def test_the_published_model_maps_three_splines_if_less_well(
    three_splines: ScanLog, result: SlamResult, published: Snapshot
) -> None:
    error = absolute_error(three_splines, published.poses)
    assert absolute_error(three_splines, result.snapshot.poses).max() < error.max() < 0.15
    long = [spline for spline in published.map if spline.length > 3.0]
    assert len(long) == 3
    for spline in published.map:
        assert len(spline.curve.control_points) <= 13
        assert spline.span == pytest.approx(spline.curve.domain)
    assert published.estimate is not None
    assert published.estimate.converged


def test_the_published_model_says_what_each_segment_was_to_its_spline(published: Snapshot) -> None:
    decided = [a for step in published.steps for a in step.associations]
    assert {a.relation for a in decided if a.spline is not None} == set(Relation)
    assert all(a.relation is Relation.EXTENSION for a in decided if a.verdict is Verdict.EXTENDED)
    assert all(a.relation is None for a in decided if a.spline is None)


@pytest.mark.parametrize("degree", [1, 5])
def test_the_published_model_works_with_any_order(three_splines: ScanLog, degree: int) -> None:
    config = SlamConfig(
        model="chord-length", fitting=FittingConfig(degree=degree), chord_length=ChordLengthConfig(control_points=10)
    )
    snapshot = run_slam(three_splines, config).snapshot
    assert {spline.curve.degree for spline in snapshot.map} == {degree}
    assert {len(spline.curve.control_points) for spline in snapshot.map if spline.length > 3.0} == {10}
    assert absolute_error(three_splines, snapshot.poses).max() < 0.3


def test_a_configuration_that_no_curve_fits_is_refused_before_any_work(three_splines: ScanLog) -> None:
    with pytest.raises(ConfigError, match="from 1 to 5"):
        Slam(three_splines, SlamConfig(fitting=FittingConfig(degree=7)))


def test_without_odometry_the_map_is_made_from_scans_alone(three_splines: ScanLog) -> None:
    slam = Slam(three_splines)
    for scan in three_splines:
        slam.process(scan, None)
    assert absolute_error(three_splines, slam.finish().poses).max() < 0.02


def test_the_same_log_gives_the_same_map(three_splines: ScanLog, result: SlamResult) -> None:
    again = run_slam(three_splines).snapshot
    for one, other in zip(result.snapshot.map, again.map, strict=True):
        assert one.id == other.id
        np.testing.assert_array_equal(one.curve.control_points, other.curve.control_points)


@pytest.fixture(scope="module")
def office() -> tuple[ScanLog, Snapshot]:
    log = open_log(SAMPLES / "office.log.gz")
    return log, run_slam(log).snapshot


def test_the_office_is_mapped_to_three_centimetres(office: tuple[ScanLog, Snapshot]) -> None:
    log, snapshot = office
    error = absolute_error(log, snapshot.poses)
    assert np.sqrt(np.mean(error**2)) < 0.03
    assert error.max() < 0.1
    assert log.odometry is not None
    assert np.sqrt(np.mean(absolute_error(log, log.odometry) ** 2)) > 0.5


def test_loops_of_the_office_are_closed_and_accepted_ones_are_true(office: tuple[ScanLog, Snapshot]) -> None:
    log, snapshot = office
    accepted = [closure for closure in snapshot.loop_closures if closure.accepted]
    rejected = [closure for closure in snapshot.loop_closures if not closure.accepted]
    assert len(accepted) > 10
    assert log.truth is not None
    for closure in accepted:
        truth = se2.between(log.truth[closure.earlier], log.truth[closure.scan])
        off = se2.between(truth, closure.measured)
        assert off @ np.linalg.solve(closure.covariance, off) < 2.0**2
        known = np.sqrt(np.diag(closure.covariance)) < 0.05
        assert np.abs(off[known]).max(initial=0.0) < 0.05
    assert all(closure.reason for closure in rejected)
    loops = [factor for factor in snapshot.pose_factors if factor.kind == "loop"]
    ties = sorted((int(snapshot.key_scans[loop.i]), int(snapshot.key_scans[loop.j])) for loop in loops)
    assert ties == sorted((closure.earlier, closure.scan) for closure in accepted)


def test_direct_and_sam_agree_on_the_office(office: tuple[ScanLog, Snapshot]) -> None:
    log, snapshot = office
    config = SlamConfig()
    config = replace(config, adjustment=replace(config.adjustment, gates=(0.08,)))
    direct = adjust(log, snapshot, config, "direct").estimate
    sam = adjust(log, snapshot, config, "sam").estimate
    assert direct is not None
    assert sam is not None
    np.testing.assert_allclose(direct.poses, sam.poses, atol=1e-6)
    np.testing.assert_allclose(direct.control_points, sam.control_points, atol=1e-6)
