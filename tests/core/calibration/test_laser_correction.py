"""Corrected scans are those of a robot at rest with a laser without bias."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.calibration.laser import LaserCalibration, oddness, sweep_share
from bspline_slam.calibration.laser_correction import LaserCorrection
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import SegmentationConfig, segment_scan
from core.rooms import ROOM, room_scan

POSE, VELOCITY = np.array([3.0, 1.2, 0.4]), np.array([0.5, -0.1, 0.7])
TOLD = LaserCalibration(0.04, 0.01, 0.015)
BEAMS = 361


def moving_scan() -> LaserScan:
    """Taken on the way, from `POSE` in the middle of the sweep."""
    beams = np.arange(BEAMS)
    since = TOLD.sweep * sweep_share(beams, BEAMS) + TOLD.interlace * oddness(beams)
    scan = room_scan(se2.compose(POSE, since[:, None] * VELOCITY), np.random.default_rng(1), noise=0.0)
    return replace(scan, ranges=scan.ranges + TOLD.offset)


def off_walls(points: np.ndarray) -> np.ndarray:
    """Distances (m) of points in the robot frame from the nearest wall."""
    ends = se2.transform(POSE, points)
    a, d = ROOM[:, 0], ROOM[:, 1] - ROOM[:, 0]
    share = np.clip(((ends[:, None] - a) * d).sum(-1) / (d * d).sum(-1), 0.0, 1.0)
    return np.linalg.norm(a + share[..., None] * d - ends[:, None], axis=-1).min(1)


def correction(told: LaserCalibration) -> LaserCorrection:
    return LaserCorrection(told, VELOCITY[None], BEAMS)


def test_beams_of_a_corrected_scan_end_on_the_walls() -> None:
    scan = moving_scan()
    assert off_walls(scan.points_robot).max() > 0.03
    still = correction(TOLD).scan(scan)
    assert off_walls(still.points_robot).max() < 1e-3
    assert (np.diff(still.bearings) >= 0.0).all()


def test_segments_are_corrected_as_their_scan_is() -> None:
    scan = moving_scan()
    for segment in correction(TOLD).segments(segment_scan(scan, SegmentationConfig()), scan.pose_robot_sensor[:2]):
        assert off_walls(segment.points).max() < 1e-3


def test_beams_that_did_not_come_back_stay() -> None:
    scan = moving_scan()
    scan.ranges[10:20] = np.inf
    still = correction(TOLD).scan(scan)
    assert np.isinf(still.ranges).sum() == 10
    assert still.valid.sum() == scan.valid.sum()


def test_without_anything_to_correct_a_scan_is_left_alone() -> None:
    scan = moving_scan()
    assert correction(LaserCalibration()).scan(scan) is scan
