"""The map and the paths as the page draws them, made from a snapshot of the estimator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.lab.stretches import Stretches
from bspline_slam.scan import ScanLog
from bspline_slam.slam import Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap
from splinescope.quality import Quality
from splinescope.view import MapView

Poses = Float[np.ndarray, "m 3"]


def view_map(
    log: ScanLog,
    snapshot: Snapshot | None,
    covariances: Mapping[int, np.ndarray],
    quality: Quality | None = None,
    sigmas: Stretches | None = None,
) -> MapView:
    """What is known of the world: before the first snapshot that is the odometry alone."""
    estimate = snapshot.poses if snapshot is not None else np.zeros((0, 3))
    start = estimate[0] if len(estimate) else se2.IDENTITY
    return MapView(
        map=snapshot.map if snapshot is not None else SplineMap(),
        covariances=covariances,
        key_poses=snapshot.poses[snapshot.key_scans] if snapshot is not None else np.zeros((0, 3)),
        key_scans=tuple(int(scan) for scan in snapshot.key_scans) if snapshot is not None else (),
        loop_closures=snapshot.loop_closures if snapshot is not None else (),
        estimate=estimate,
        odometry=aligned(log.odometry, start),
        truth=aligned(log.truth, start),
        stretches=quality.stretches if quality is not None else None,
        sigmas=sigmas,
        times=log.times,
    )


SAME = 1e-4
"""Odometry and truth are laid at the start of the estimate; less than this (m) cannot be seen."""


def keeping(before: MapView | None, now: MapView) -> MapView:
    """The view with the arrays of the one before where they look the same, so that these are not drawn again."""
    if before is None:
        return now
    close = {"key_poses": 0.0, "estimate": 0.0, "odometry": SAME, "truth": SAME}
    same = {name: was for name, far in close.items() if alike(was := getattr(before, name), getattr(now, name), far)}
    return replace(now, **same)


def alike(a: np.ndarray | None, b: np.ndarray | None, far: float) -> bool:
    """Whether no value of two arrays differs by more than `far`."""
    return a is not None and b is not None and a.shape == b.shape and bool(np.abs(a - b).max(initial=0.0) <= far)


def aligned(path: Poses | None, start: Float[np.ndarray, "3"]) -> Poses | None:
    """The same path moved as a whole so that it begins at `start`."""
    if path is None or not len(path):
        return None
    return se2.compose(start, se2.between(path[0], path))


def dead_reckoned(
    index: int, known: int, pose: Float[np.ndarray, "3"], odometry: Poses | None
) -> Float[np.ndarray, "3"]:
    """The pose of scan `index` carried by odometry from that of scan `known`; standing still without odometry."""
    if odometry is None:
        return pose
    return se2.compose(pose, se2.between(odometry[known], odometry[index]))


def moved(snapshot: Snapshot, record: IterationRecord) -> Snapshot:
    """The snapshot with the state that a solver's iteration reached.

    The scans between key scans go along with the key scan before them. A record about another set of unknowns
    leaves alone what it does not fit.
    """
    if len(record.poses) != len(snapshot.key_scans):
        return snapshot
    poses = carried(snapshot.poses, snapshot.key_scans, record.poses)
    splines = snapshot.map
    if len(record.control_points) == splines.control_point_count:
        splines = with_control_points(splines, record.control_points)
    return replace(snapshot, poses=poses, map=splines)


def carried(poses: Poses, key_scans: np.ndarray, key_poses: Poses) -> Poses:
    """All poses after the key scans among them went to `key_poses`."""
    if not len(key_scans):
        return poses
    key = np.maximum(np.searchsorted(key_scans, np.arange(len(poses)), side="right") - 1, 0)
    return se2.compose(key_poses[key], se2.between(poses[key_scans[key]], poses))


def with_control_points(splines: SplineMap, control_points: Float[np.ndarray, "N 2"]) -> SplineMap:
    """The same splines with other control points, stacked in the order of the map."""
    edges = np.cumsum([0, *(len(spline.curve.control_points) for spline in splines)])
    return SplineMap(
        tuple(
            _reshaped(spline, control_points[first:last])
            for spline, (first, last) in zip(splines, pairwise(edges), strict=True)
        )
    )


def _reshaped(spline: MapSpline, control_points: Float[np.ndarray, "n 2"]) -> MapSpline:
    return replace(spline, curve=spline.curve.with_control_points(control_points))


def largest_move(before: Snapshot, after: Snapshot) -> float:
    """How far the scan that moved most moved between two estimates (m)."""
    count = min(len(before.poses), len(after.poses))
    if not count:
        return 0.0
    return float(np.linalg.norm(after.poses[:count, :2] - before.poses[:count, :2], axis=1).max())
