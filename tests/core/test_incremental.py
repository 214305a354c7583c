"""The map adjusted while the log is read: nearer to the truth than the front end, on the way to the same optimum."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from bspline_slam import se2
from bspline_slam.backends import back_end, solve_control_points
from bspline_slam.errors import Cancelled
from bspline_slam.incremental import Adjusted, adjust_so_far, same_stretch
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Slam
from bspline_slam.slam_config import SlamConfig
from bspline_slam.snapshot import Snapshot

OFFICE = Path(__file__).parents[2] / "sample_logs" / "office.log.gz"
CONFIG = SlamConfig()


@dataclass(frozen=True, eq=False)
class Reading:
    """A log read up to some scans: the front end's snapshots there, each adjusted, and the batch result at the end.

    At these scans loops are closed. Between them the office leads through a stretch that nothing ties to what was seen
    before, so that nobody can know there by how much the path has drifted.
    """

    log: ScanLog
    front: list[Snapshot]
    adjusted: list[Adjusted]
    batch: Snapshot


@pytest.fixture(scope="module")
def reading() -> Reading:
    log = open_log(OFFICE)
    slam = Slam(log)
    steps = islice(slam.steps(), 601)
    front = [slam.snapshot() for step in steps if step.scan in (150, 550, 600)]
    return Reading(log, front, [adjust_so_far(each, CONFIG) for each in front], slam.finish())


def error(log: ScanLog, poses: np.ndarray) -> float:
    """Mean distance from the truth (m), first poses laid over each other."""
    assert log.truth is not None
    off = se2.between(se2.between(poses[0], poses), se2.between(log.truth[0], log.truth[: len(poses)]))
    return float(np.hypot(off[:, 0], off[:, 1]).mean())


def test_adjusting_while_reading_brings_the_estimate_nearer_to_the_truth(reading: Reading) -> None:
    front = [error(reading.log, each.poses) for each in reading.front]
    live = [error(reading.log, a.applied(each).poses) for a, each in zip(reading.adjusted, reading.front, strict=True)]
    assert np.mean(live) < 0.7 * np.mean(front)


def test_what_was_read_since_goes_along(reading: Reading) -> None:
    (*_, earlier, later), (*_, adjusted, _) = reading.front, reading.adjusted
    assert adjusted.fits(later)
    live, last = adjusted.applied(later), earlier.key_scans[-1]
    scans = slice(int(last), None)
    np.testing.assert_allclose(
        se2.between(live.poses[last], live.poses[scans]), se2.between(later.poses[last], later.poses[scans]), atol=1e-9
    )
    assert [spline.id for spline in live.map] == [spline.id for spline in later.map]
    assert [step.scan for step in live.steps] == later.key_scans.tolist()
    np.testing.assert_allclose([step.pose for step in live.steps], live.poses[later.key_scans], atol=1e-9)
    assert error(reading.log, live.poses) < error(reading.log, later.poses)


def test_what_was_adjusted_stands_as_long_as_nothing_has_changed(reading: Reading) -> None:
    front, adjusted = reading.front[-1], reading.adjusted[-1]
    live = adjusted.applied(front)
    np.testing.assert_allclose(live.poses[front.key_scans], adjusted.poses, atol=1e-9)
    for spline in live.map:
        if spline.id in adjusted.splines:
            wanted = adjusted.splines[spline.id][1].curve.control_points
            np.testing.assert_allclose(spline.curve.control_points, wanted, atol=1e-9)


def test_a_map_that_moves_as_a_whole_takes_its_adjustment_along(reading: Reading) -> None:
    front, adjusted = reading.front[-1], reading.adjusted[-1]
    motion = np.array([0.02, -0.03, 0.001])
    elsewhere = replace(
        front,
        poses=se2.compose(motion, front.poses),
        map=replace(front.map, splines=tuple(spline.moved(motion) for spline in front.map)),
    )
    here, there = adjusted.applied(front), adjusted.applied(elsewhere)
    np.testing.assert_allclose(there.poses, se2.compose(motion, here.poses), atol=1e-9)
    for a, b in zip(here.map, there.map, strict=True):
        wanted = se2.transform(motion, a.curve.control_points)
        np.testing.assert_allclose(b.curve.control_points, wanted, atol=1e-9)


def test_a_front_end_that_went_elsewhere_is_not_adjusted_from_before(reading: Reading) -> None:
    front, adjusted = reading.front[-1], reading.adjusted[-1]
    assert adjusted.fits(front)
    assert not adjusted.fits(replace(front, poses=front.poses + np.array([0.0, 0.2, 0.0])))


def test_a_spline_that_grew_is_another_stretch(reading: Reading) -> None:
    spline = reading.front[-1].map.splines[0]
    low, high = spline.span
    assert same_stretch(spline, spline.moved(np.array([1.0, 2.0, 3.0])))
    assert not same_stretch(spline, replace(spline, span=(low, high - 0.1)))


def test_the_last_of_it_leads_to_the_optimum_of_the_batch(reading: Reading) -> None:
    batch, live = reading.batch.estimate, reading.adjusted[-1]
    assert batch is not None
    assert np.abs(batch.poses - live.poses).max() > 1e-4
    start = replace(batch.graph, poses=live.poses, control_points=solve_control_points(batch.graph, live.poses))
    solved = back_end("direct").solve(start)
    np.testing.assert_allclose(solved.poses, batch.poses, atol=1e-6)
    np.testing.assert_allclose(solved.control_points, batch.control_points, atol=1e-6)


def test_it_can_be_given_up(reading: Reading) -> None:
    with pytest.raises(Cancelled):
        adjust_so_far(reading.front[0], CONFIG, lambda: True)
