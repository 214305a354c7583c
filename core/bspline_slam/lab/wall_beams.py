"""The beams of a log that saw walls, from scans a little way apart: what a finished map is held against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2
from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.calibration.laser_correction import LaserCorrection
from bspline_slam.calibration.velocities import velocities
from bspline_slam.front_end.tracking_config import TrackingConfig
from bspline_slam.scan import ScanLog
from bspline_slam.segmentation import SegmentationConfig, segment_scan
from bspline_slam.sights import KeyObservations


@dataclass(frozen=True, eq=False, slots=True)
class WallBeams:
    """Beams on segments, of the scans `scans`.

    `pose` is a position among `poses` (world frame), `beam` the number of the beam in its scan. Points and unit
    directions are in the robot frame; `ranges` are distances from the sensor (m).
    """

    scans: Int[np.ndarray, "n"]
    poses: Float[np.ndarray, "n 3"]
    pose: Int[np.ndarray, "m"]
    beam: Int[np.ndarray, "m"]
    points: Float[np.ndarray, "m 2"]
    directions: Float[np.ndarray, "m 2"]
    ranges: Float[np.ndarray, "m"]

    @classmethod
    def from_log(
        cls,
        log: ScanLog,
        scan_poses: Float[np.ndarray, "scans 3"],
        tracking: TrackingConfig,
        segmentation: SegmentationConfig,
        laser: LaserCalibration,
    ) -> WallBeams:
        """The scans that lie as far apart as key scans do, and what segmentation makes of them, corrected by the
        calibration of the laser."""
        chosen = scans_apart(scan_poses, tracking)
        correction = LaserCorrection(laser, velocities(log.records, scan_poses), len(log[0].ranges))
        keys = []
        for scan in (log[index] for index in chosen.tolist()):
            sensor = scan.pose_robot_sensor[:2]
            segments = correction.segments(segment_scan(scan, segmentation), sensor)
            keys.append(KeyObservations(scan.index, segments, (), int(np.count_nonzero(scan.valid)), sensor))
        return cls.from_key_scans(keys, scan_poses[chosen])

    @classmethod
    def from_key_scans(cls, keys: Sequence[KeyObservations], poses: Float[np.ndarray, "n 3"]) -> WallBeams:
        """Those of all segments of key scans, at these poses."""
        pose, beam, points, rays = [np.zeros(0, int)], [np.zeros(0, int)], [np.zeros((0, 2))], [np.zeros((0, 2))]
        for place, key in enumerate(keys):
            for segment in key.segments:
                pose.append(np.full(len(segment.beams), place))
                beam.append(segment.beams)
                points.append(segment.points)
                rays.append(segment.points - key.sensor)
        ray = np.concatenate(rays)
        ranges = np.linalg.norm(ray, axis=1)
        scans = np.array([key.scan for key in keys], dtype=np.int64)
        ends = np.concatenate(points)
        directions = ray / np.maximum(ranges, 1e-9)[:, None]
        return cls(scans, poses, np.concatenate(pose), np.concatenate(beam), ends, directions, ranges)

    def __len__(self) -> int:
        return len(self.pose)

    @property
    def ends(self) -> Float[np.ndarray, "m 2"]:
        """Where the beams end (world frame)."""
        return se2.transform(self.poses[self.pose], self.points)

    @property
    def towards(self) -> Float[np.ndarray, "m 2"]:
        """Unit vectors back to the sensor (world frame)."""
        return se2.rotate(self.poses[self.pose], -self.directions)

    def part(self, kept: Bool[np.ndarray, "m"]) -> WallBeams:
        """Only these beams."""
        columns = (self.pose, self.beam, self.points, self.directions, self.ranges)
        return WallBeams(self.scans, self.poses, *(column[kept] for column in columns))


def scans_apart(poses: Float[np.ndarray, "scans 3"], tracking: TrackingConfig) -> Int[np.ndarray, "n"]:
    """The first scan, and each that lies as far from the one before as key scans do."""
    chosen = [0]
    for index in range(1, len(poses)):
        step = se2.between(poses[chosen[-1]], poses[index])
        if np.hypot(step[0], step[1]) > tracking.distance or abs(step[2]) > tracking.turn:
            chosen.append(index)
    return np.array(chosen)
