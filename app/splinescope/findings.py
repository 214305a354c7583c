"""What is known of one log: its scans, what the estimator made of them so far, and how both are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam.association import Association
from bspline_slam.lab.scan_consistency import ScanConsistency
from bspline_slam.lab.stretches import Stretches
from bspline_slam.scan import ScanLog
from bspline_slam.slam import SlamStep, Snapshot
from splinescope.map_view import dead_reckoned, keeping, view_map
from splinescope.quality import Quality
from splinescope.result import Result
from splinescope.scan_view import view_scan
from splinescope.view import MapView, ScanView


class Findings:
    """The open log (None: none is open) with steps, snapshot, `quality`, covariances, `sigmas` across the
    curves and `consistency` as they arrive.

    `processed` counts the scans done. `map_view` and `scan_view` give the same object as long as it looks the same.
    """

    def __init__(self, log: ScanLog | None = None) -> None:
        self.log = log
        self.steps: dict[int, SlamStep] = {}
        self.processed = 0
        self.snapshot: Snapshot | None = None
        self.covariances: Mapping[int, Float[np.ndarray, "d d"]] = {}
        self.quality: Quality | None = None
        self.sigmas: Stretches | None = None
        self.consistency: ScanConsistency | None = None
        self._map_view: MapView | None = None
        self._seen: MapView | None = None
        self._scan_view: tuple[tuple[object, ...], ScanView] | None = None

    def record(self, steps: Iterable[SlamStep]) -> None:
        """Take in what was done with some scans; a later word on the same scan replaces the earlier one."""
        for step in steps:
            self.steps[step.scan] = step
            self.processed = max(self.processed, step.scan + 1)

    def decide(self, associations: Mapping[int, tuple[Association, ...]]) -> None:
        """Some key scans are decided otherwise."""
        for scan in associations.keys() & self.steps.keys():
            self.steps[scan] = replace(self.steps[scan], associations=associations[scan])

    def show(self, snapshot: Snapshot | None) -> None:
        """From now on the map is this one; how good it is, is not known yet."""
        if snapshot is not self.snapshot:
            self.snapshot, self.covariances, self._map_view = snapshot, {}, None
            self.quality = self.sigmas = self.consistency = None

    def forget(self) -> None:
        """Nothing is known but the log: it will be processed from its beginning."""
        self.steps, self.processed = {}, 0
        self.show(None)

    def take(self, result: Result) -> None:
        """From now on this result is what is known."""
        self.steps, self.processed = dict(result.steps), result.processed
        self.show(result.snapshot)
        self.know(result)

    def know(self, result: Result) -> None:
        """What is known by now of the result shown: quality, covariances and consistency."""
        self.consistency = result.consistency
        if result.covariances is not self.covariances or result.quality is not self.quality:
            self.covariances, self.quality, self._map_view = result.covariances, result.quality, None
            self.sigmas = result.sigmas

    def pose(self, index: int) -> Float[np.ndarray, "3"]:
        """Where scan `index` was taken, by the best that is known: the estimate, else odometry from its end."""
        if self.snapshot is not None and index < len(self.snapshot.poses):
            return self.snapshot.poses[index]
        if index in self.steps:
            return self.steps[index].pose
        last = self.processed - 1
        odometry = self.log.odometry if self.log is not None else None
        if last not in self.steps:
            return dead_reckoned(index, 0, np.zeros(3), odometry)
        return dead_reckoned(index, last, self.steps[last].pose, odometry)

    @property
    def map_view(self) -> MapView | None:
        if self._map_view is None and self.log is not None:
            now = view_map(self.log, self.snapshot, self.covariances, self.quality, self.sigmas)
            self._map_view = self._seen = keeping(self._seen, now)
        return self._map_view

    def scan_view(self, index: int) -> ScanView | None:
        if self.log is None or not len(self.log):
            return None
        pose, step = self.pose(index), self.steps.get(index)
        key = (index, tuple(pose), step)
        if self._scan_view is None or self._scan_view[0] != key:
            self._scan_view = (key, self._drawn_anew(self.log, index, pose, step))
        return self._scan_view[1]

    def _drawn_anew(self, log: ScanLog, index: int, pose: Float[np.ndarray, "3"], step: SlamStep | None) -> ScanView:
        if self._scan_view is not None and self._scan_view[0][::2] == (index, step):
            return replace(self._scan_view[1], pose=pose)
        return view_scan(log[index], pose, step)
