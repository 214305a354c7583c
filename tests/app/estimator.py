"""A stand-in for the estimator with the same signatures: odometry is believed, every fifth scan is a key scan."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from bspline_slam import se2
from bspline_slam.association import Association, Candidate, Verdict
from bspline_slam.backends.protocol import Estimate, IterationRecord, Marginals
from bspline_slam.errors import Cancelled
from bspline_slam.fitting import FittingConfig, uniform_through
from bspline_slam.graph import Graph, PosePrior
from bspline_slam.lab.scan_consistency import ScanConsistency
from bspline_slam.lab.scan_test import ScanTest
from bspline_slam.scan import ScanLog
from bspline_slam.segmentation import ScanSegment, segment_scan
from bspline_slam.sights import KeyObservations
from bspline_slam.slam import SlamConfig, SlamStep, Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap

KEY_EVERY = 5
PROGRESS = Callable[[str, float, IterationRecord | None], None]


class Slam:
    """Makes one spline of every long segment of every key scan."""

    def __init__(
        self, log: ScanLog, config: SlamConfig | None = None, *, cancelled: Callable[[], bool] = lambda: False
    ) -> None:
        self._log, self._config, self._cancelled = log, config or SlamConfig(), cancelled
        self._poses: list[np.ndarray] = []
        self._steps: list[SlamStep] = []
        self._splines: list[MapSpline] = []

    def steps(self) -> Iterator[SlamStep]:
        for scan in self._log:
            if self._cancelled():
                raise Cancelled("stopped")
            odometry = self._log.odometry
            pose = np.zeros(3) if odometry is None else se2.between(odometry[0], odometry[scan.index])
            self._poses.append(pose)
            key = scan.index % KEY_EVERY == 0
            step = SlamStep(scan.index, pose, pose, key, False, 0.9)
            if key:
                segments = segment_scan(scan)
                known = [self._associate(segment, pose) for segment in segments]
                step = replace(step, segments=segments, associations=tuple(known))
                self._steps.append(step)
            yield step

    def _associate(self, segment: ScanSegment, pose: np.ndarray) -> Association:
        first, last = int(segment.beams[0]), int(segment.beams[-1])
        if len(segment.points) < 8:
            return Association(
                segment.scan, segment.index, first, last, Verdict.GATED, None, 0.2, 0.1, (Candidate(0, 0.2, 0.5),)
            )
        number = len(self._splines)
        curve = uniform_through(se2.transform(pose, segment.points), FittingConfig())
        self._splines.append(
            MapSpline(number, curve, curve.domain, segment.scan, 1, (f"started at scan {segment.scan}",))
        )
        return Association(segment.scan, segment.index, first, last, Verdict.NEW, number, float("nan"), 0.1)

    def snapshot(self) -> Snapshot:
        key_scans = np.array([step.scan for step in self._steps], dtype=int)
        poses = np.array(self._poses).reshape(-1, 3)
        seen = tuple(KeyObservations(s.scan, s.segments, s.associations, 181, np.zeros(2)) for s in self._steps)
        splines = SplineMap(tuple(self._splines))
        return Snapshot(poses, key_scans, tuple(self._steps), splines, (), observations=seen)

    def finish(self, progress: PROGRESS, cancelled: Callable[[], bool]) -> Snapshot:
        return adjust(self._log, self.snapshot(), self._config, "direct", progress, cancelled)


def adjust(
    log: ScanLog,
    snapshot: Snapshot,
    config: SlamConfig,
    back_end: str,
    progress: PROGRESS,
    cancelled: Callable[[], bool],
) -> Snapshot:
    """Ten iterations that move everything a little, at falling cost."""
    points = np.concatenate([s.curve.control_points for s in snapshot.map] or [np.zeros((0, 2))])
    keys = snapshot.poses[snapshot.key_scans]
    records = []
    for index in range(11):
        if cancelled():
            raise Cancelled("stopped")
        aside = 0.1 * (1 - 0.5**index) * np.array([1.0, 0.0, 0.0])
        record = IterationRecord(index, 1000.0 * 0.5**index + 10, 0.1, 0.1, 0.0, keys + aside, points + aside[:2])
        records.append(record)
        progress("Adjusting the map", index / 10, record)
    counts = [len(s.curve.control_points) for s in snapshot.map]
    last = records[-1]
    priors = tuple(PosePrior(i, pose, 10.0 * np.eye(3)) for i, pose in enumerate(last.poses))
    ids, first = np.array([s.id for s in snapshot.map]), np.cumsum([0, *counts])
    graph = Graph(snapshot.key_scans, keys, ids, first, points, pose_priors=priors)
    splines, start = [], 0
    for spline, count in zip(snapshot.map, counts, strict=True):
        moved = spline.curve.with_control_points(last.control_points[start : start + count])
        splines.append(replace(spline, curve=moved))
        start += count
    estimate = Estimate(graph, last.poses, last.control_points, tuple(records), True, 900.0, 1000)
    poses = snapshot.poses + np.array([0.1, 0.0, 0.0])
    return replace(snapshot, poses=poses, map=SplineMap(tuple(splines)), estimate=estimate)


def marginals(
    snapshot: Snapshot, back_end: str, poses: Sequence[int], splines: Sequence[int], cancelled: Callable[[], bool]
) -> Marginals:
    """The same circle of 1 cm around every control point and every key pose."""
    if cancelled():
        raise Cancelled("stopped")
    sizes = {i: 2 * len(snapshot.map[i].curve.control_points) for i in splines}
    return Marginals({k: 1e-4 * np.eye(3) for k in poses}, {i: 1e-4 * np.eye(size) for i, size in sizes.items()})


def scan_consistency(
    snapshot: Snapshot,
    config: SlamConfig,
    covariances: Mapping[int, np.ndarray],
    truth: np.ndarray | None,
    progress: Callable[[float], None],
    cancelled: Callable[[], bool],
) -> ScanConsistency | None:
    """All as it should be but for the last key scan, which lies far off."""
    scans = np.array(snapshot.key_scans)
    squares = np.full(len(scans), 3.0)
    squares[-1:] = 60.0
    test = ScanTest(scans, squares, np.full(len(scans), 3.0))
    return ScanConsistency(None if truth is None else test, test)
