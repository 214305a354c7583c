"""Scans between key scans: placed on the curves, and not far from where odometry between the key scans has them."""

from __future__ import annotations

from functools import cache

import numpy as np

from bspline_slam import se2
from bspline_slam.front_end.scan_matching import MatchingConfig
from bspline_slam.lab.twin import simulate_twin
from bspline_slam.localisation import LocalisationConfig, place_on_curves, surprising
from bspline_slam.scan import Records, ScanLog
from bspline_slam.segmentation import SegmentationConfig
from bspline_slam.slam import run_slam
from bspline_slam.snapshot import Snapshot
from core.rooms import twin_room


@cache
def finished() -> tuple[ScanLog, Snapshot]:
    log = simulate_twin(twin_room(), rng=np.random.default_rng(1))
    return log, run_slam(log).snapshot


def placed(poses: np.ndarray) -> np.ndarray:
    log, snapshot = finished()
    return place_on_curves(
        log, poses, snapshot.key_scans, snapshot.map, LocalisationConfig(), MatchingConfig(), SegmentationConfig(),
        lambda scan: scan, lambda share: None,
    )  # fmt: skip


def drive(count: int, rng: np.random.Generator) -> np.ndarray:
    x = 0.1 * np.arange(count)
    return np.stack([x, np.sin(x), np.arctan(np.cos(x))], -1) + rng.normal(0.0, 1e-3, (count, 3))


def records_with(odometry: np.ndarray | None, count: int) -> Records:
    return Records(np.arange(float(count)), np.arange(float(count)), odometry, np.arange(count))


def test_a_scan_far_from_what_odometry_says_is_surprising_and_no_other_is() -> None:
    rng = np.random.default_rng(1)
    truth = drive(120, rng)
    odometry, poses, keys = truth + rng.normal(0.0, 2e-3, truth.shape), truth.copy(), np.arange(0, 120, 5)
    poses[63] = se2.compose(truth[63], np.array([0.3, 0.0, 0.0]))
    poses[81] = se2.compose(truth[81], np.array([0.0, 0.0, 0.3]))
    found = surprising(records_with(odometry, 120), poses, keys, 5.0)
    assert set(found) == {63, 81}
    for scan, told in found.items():
        assert np.abs(se2.between(truth[scan], told)).max() < 0.02


def test_without_odometry_nothing_is_surprising() -> None:
    poses = drive(120, np.random.default_rng(2))
    poses[63] += 0.3
    assert surprising(records_with(None, 120), poses, np.arange(0, 120, 5), 5.0) == {}


def test_a_scan_put_at_the_wrong_place_is_brought_back() -> None:
    log, snapshot = finished()
    between = np.setdiff1d(np.arange(len(log)), snapshot.key_scans)
    wrong = snapshot.poses.copy()
    for scan in between[[3, 12, 20]]:
        wrong[scan] = se2.compose(wrong[scan], np.array([0.3, 0.2, 0.2]))
    off = se2.between(snapshot.poses, placed(wrong))[between[[3, 12, 20]]]
    assert np.hypot(off[:, 0], off[:, 1]).max() < 0.05
    assert np.abs(off[:, 2]).max() < 0.02


def test_key_scans_stay_where_they_are() -> None:
    _, snapshot = finished()
    keys = snapshot.key_scans
    np.testing.assert_array_equal(placed(snapshot.poses)[keys], snapshot.poses[keys])
