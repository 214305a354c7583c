"""Point to curve: the scans between key scans, placed on the finished splines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.backends.protocol import Cancelling, never
from bspline_slam.calibration import scan_records
from bspline_slam.errors import Cancelled
from bspline_slam.odometry_filter import filled, filtered_odometry
from bspline_slam.scan import Records, ScanLog
from bspline_slam.scan_matching import MatchingConfig, Target, point_set, refine, target
from bspline_slam.segmentation import SegmentationConfig
from bspline_slam.spline_map import SplineMap

LEAST_ERROR = np.array([0.005, 0.005, 0.005])
"""Odometry between key scans is never known better than this (m, m, rad)."""


@dataclass(frozen=True, slots=True)
class LocalisationConfig:
    """How finely curves are sampled (m), how far the pose between two key scans is trusted (m, rad), the gates (m), and
    the share of beams that must lie on curves for the result to be taken.

    A pose that odometry between the key scans puts elsewhere, by more than `surprise` of its usual errors, has to win
    against that one: by `better`, the share of beams on curves that it has more.
    """

    spacing: float = 0.03
    position: float = 0.03
    heading: float = 0.01
    gates: tuple[float, ...] = (0.1, 0.1, 0.08, 0.08)
    least_inliers: float = 0.5
    surprise: float = 5.0
    better: float = 0.05


def curve_target(splines: SplineMap, spacing: float) -> Target:
    """All curves of a map, sampled with their normals."""
    points, normals = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for spline in splines:
        t, samples = spline.sample(spacing)
        points.append(samples)
        normals.append(spline.curve.normals(t))
    return target(np.concatenate(points), np.concatenate(normals))


def place_on_curves(
    log: ScanLog,
    poses: Float[np.ndarray, "scans 3"],
    key_scans: Int[np.ndarray, "n"],
    splines: SplineMap,
    config: LocalisationConfig,
    matching: MatchingConfig,
    segmentation: SegmentationConfig,
    progress: Callable[[float], None],
    cancelled: Cancelling = never,
) -> Float[np.ndarray, "scans 3"]:
    """Poses of all scans with those that are no key scans refined point-to-curve. Raises Cancelled."""
    if len(splines) == 0:
        return poses
    curves = curve_target(splines, config.spacing)
    information = np.diag([config.position**-2, config.position**-2, config.heading**-2])
    placed = poses.copy()
    between = np.setdiff1d(np.arange(len(poses)), key_scans)
    elsewhere = surprising(log.records, poses, key_scans, config.surprise)
    for k, scan in enumerate(between.tolist()):
        if cancelled():
            raise Cancelled("cancelled while the scans between key scans were placed")
        points = point_set(log[scan], matching, segmentation)
        match = refine(curves, points, poses[scan], matching, prior_information=information, gates=config.gates)
        if scan in elsewhere:
            told = elsewhere[scan]
            other = refine(curves, points, told, matching, prior_information=information, gates=config.gates)
            if match.inliers < max(other.inliers + config.better, config.least_inliers):
                match, placed[scan] = other, told
        if match.inliers >= config.least_inliers:
            placed[scan] = match.pose
        if k % 100 == 0:
            progress(k / len(between))
    return placed


def surprising(
    records: Records, poses: Float[np.ndarray, "scans 3"], key_scans: Int[np.ndarray, "n"], limit: float
) -> dict[int, Float[np.ndarray, "3"]]:
    """The scans whose pose lies farther from where odometry between the key scans has it than `limit` standard
    deviations, as most scans tell them, and where that is."""
    odometry = filtered_odometry(records, poses)
    if odometry is None:
        return {}
    places = scan_records(records, len(poses))
    told = filled(odometry, np.arange(len(odometry), dtype=float), places[key_scans], poses[key_scans])[places]
    off = np.abs(se2.between(told, poses))
    others = np.setdiff1d(np.arange(len(poses)), key_scans)
    usual = 1.4826 * np.median(off[others], axis=0) if len(others) else np.zeros(3)
    far = np.flatnonzero((off > limit * np.maximum(usual, LEAST_ERROR)).any(1))
    return {scan: told[scan] for scan in far.tolist()}
