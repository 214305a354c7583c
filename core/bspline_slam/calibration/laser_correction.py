"""Scans as a robot at rest would have seen them with a laser without bias: what a laser calibration is good for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.kernels import resting as kernels
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import ScanSegment


@dataclass(frozen=True, eq=False, slots=True)
class LaserCorrection:
    """A calibration with the velocity (m/s, m/s, rad/s) of the robot at each scan, in its own frame, and the number of
    beams of a scan."""

    calibration: LaserCalibration
    velocities: Float[np.ndarray, "scans 3"]
    beams: int

    def scan(self, scan: LaserScan) -> LaserScan:
        """A scan with ranges and bearings corrected; bearings increase, so beams may have changed places."""
        if not self.calibration.tells:
            return scan
        x, y, heading = scan.pose_robot_sensor.tolist()
        ranges, bearings = kernels.scan_at_rest(
            scan.ranges, scan.bearings, scan.range_min, scan.range_max, x, y, heading,
            self.calibration.figures, self.velocities[scan.index],
        )  # fmt: skip
        return replace(scan, ranges=ranges, bearings=bearings)

    def segments(self, segments: Iterable[ScanSegment], sensor: Float[np.ndarray, "2"]) -> tuple[ScanSegment, ...]:
        """Segments with their points corrected; `sensor` is where in the robot frame it sits."""
        if not self.calibration.tells:
            return tuple(segments)
        return tuple(replace(segment, points=self._points(segment, sensor)) for segment in segments)

    def _points(self, segment: ScanSegment, sensor: Float[np.ndarray, "2"]) -> Float[np.ndarray, "m 2"]:
        x, y = sensor.tolist()
        return kernels.points_at_rest(
            segment.points, segment.beams, self.beams, x, y, self.calibration.figures,
            self.velocities[segment.scan],
        )  # fmt: skip
