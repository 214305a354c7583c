"""Point to curve: the scans between key scans, placed on the finished splines."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.backends.protocol import Cancelling, never
from bspline_slam.bent_path import bent_through
from bspline_slam.calibration.odometry import scan_records
from bspline_slam.calibration.odometry_filter import filtered_odometry
from bspline_slam.errors import Cancelled
from bspline_slam.front_end.scan_matching import MatchingConfig, Target, surface_arguments, target
from bspline_slam.kernels import placing as kernels
from bspline_slam.scan import LaserScan, Records, ScanLog
from bspline_slam.segmentation import SegmentationConfig
from bspline_slam.spline_map import SplineMap

LEAST_ERROR = np.array([0.005, 0.005, 0.005])
"""Odometry between key scans is never known better than this (m, m, rad)."""
THREADS, TOGETHER = 2, 64
"""Threads that place scans, so many at a time; each scan for itself, so that nothing hangs on how fast they are."""


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
    sampled = [spline.curve.sample_with_normals(spacing, spline.span) for spline in splines]
    points, normals = ([np.zeros((0, 2)), *(one[column] for one in sampled)] for column in (1, 2))
    return target(np.concatenate(points), np.concatenate(normals))


def place_on_curves(
    log: ScanLog,
    poses: Float[np.ndarray, "scans 3"],
    key_scans: Int[np.ndarray, "n"],
    splines: SplineMap,
    config: LocalisationConfig,
    matching: MatchingConfig,
    segmentation: SegmentationConfig,
    correct: Callable[[LaserScan], LaserScan],
    progress: Callable[[float], None],
    cancelled: Cancelling = never,
) -> Float[np.ndarray, "scans 3"]:
    """Poses of all scans with those that are no key scans refined point-to-curve, `correct`ed before. Raises
    Cancelled."""
    if len(splines) == 0:
        return poses
    curves = curve_target(splines, config.spacing)
    placed = poses.copy()
    between = np.setdiff1d(np.arange(len(poses)), key_scans)
    elsewhere = surprising(log.records, poses, key_scans, config.surprise)
    put = _Placing(curves, poses, elsewhere, config, matching, segmentation, correct)
    with ThreadPoolExecutor(THREADS, "placing") as pool:
        begun: deque[Future[dict[int, Float[np.ndarray, "3"]]]] = deque()
        for first in range(0, len(between), TOGETHER):
            if cancelled():
                raise Cancelled("cancelled while the scans between key scans were placed")
            begun.append(pool.submit(put.all, [log[scan] for scan in between[first : first + TOGETHER].tolist()]))
            while len(begun) > (THREADS if first + TOGETHER < len(between) else 0):
                for scan, pose in begun.popleft().result().items():
                    placed[scan] = pose
            progress(first / len(between))
    return placed


@dataclass(frozen=True, eq=False, slots=True)
class _Placing:
    """What it takes to put scans on curves, from their `poses` or from where odometry has them (`elsewhere`)."""

    curves: Target
    poses: Float[np.ndarray, "scans 3"]
    elsewhere: Mapping[int, Float[np.ndarray, "3"]]
    config: LocalisationConfig
    matching: MatchingConfig
    segmentation: SegmentationConfig
    correct: Callable[[LaserScan], LaserScan]

    def all(self, scans: Sequence[LaserScan]) -> dict[int, Float[np.ndarray, "3"]]:
        """Where each scan lies, for the most part without the lock of the interpreter."""
        return {scan.index: self.one(scan) for scan in scans}

    def one(self, scan: LaserScan) -> Float[np.ndarray, "3"]:
        """The better of the places that it is refined to; where it began, if too little of it lies on curves there."""
        scan, start, least = self.correct(scan), self.poses[scan.index], self.config.least_inliers
        pose, inliers = self.refined(scan, start)
        if scan.index in self.elsewhere:
            told = self.elsewhere[scan.index]
            other, others = self.refined(scan, told)
            if inliers < max(others + self.config.better, least):
                start, pose, inliers = told, other, others
        return pose if inliers >= least else start

    def refined(self, scan: LaserScan, start: Float[np.ndarray, "3"]) -> tuple[Float[np.ndarray, "3"], float]:
        """The pose on curves nearest to `start`, and the share of beams that lie on them."""
        c = self.config
        information = np.diag([c.position**-2, c.position**-2, c.heading**-2])
        beams, limits = surface_arguments(scan, self.matching, self.segmentation)
        pose, inliers = kernels.place(
            beams, limits, self.curves.arguments, start, information, self.matching.sigma, np.array(c.gates),
            self.matching.inlier_gate,
        )  # fmt: skip
        return np.append(pose[:2], se2.wrap(pose[2])), inliers


def surprising(
    records: Records, poses: Float[np.ndarray, "scans 3"], key_scans: Int[np.ndarray, "n"], limit: float
) -> dict[int, Float[np.ndarray, "3"]]:
    """The scans whose pose lies farther from where odometry between the key scans has it than `limit` standard
    deviations, as most scans tell them, and where that is."""
    odometry = filtered_odometry(records, poses)
    if odometry is None:
        return {}
    places = scan_records(records, len(poses))
    told = bent_through(odometry, places[key_scans], poses[key_scans])[places]
    off = np.abs(se2.between(told, poses))
    others = np.setdiff1d(np.arange(len(poses)), key_scans)
    usual = 1.4826 * np.median(off[others], axis=0) if len(others) else np.zeros(3)
    far = np.flatnonzero((off > limit * np.maximum(usual, LEAST_ERROR)).any(1))
    return {scan: told[scan] for scan in far.tolist()}
