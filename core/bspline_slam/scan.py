"""What a log is made of: laser scans, odometry, and the log that hands them out in the order of recording."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Bool, Float, Int

from bspline_slam import se2

CLOCK_SET_BACK = 10.0
"""A step backwards by more than this (s) means that the clock was set, not that records came out of order."""


@dataclass(frozen=True, eq=False, slots=True)
class LaserScan:
    """One sweep of a planar laser.

    `ranges` (m; NaN, inf or beyond `range_max` where nothing came back) and `bearings` (rad, increasing,
    counter-clockwise from the sensor's x axis) have one entry per beam. `stamp` is in seconds in the log's own clock.
    """

    index: int
    stamp: float
    ranges: Float[np.ndarray, "beams"]
    bearings: Float[np.ndarray, "beams"]
    range_min: float
    range_max: float
    pose_robot_sensor: Float[np.ndarray, "3"]

    @property
    def valid(self) -> Bool[np.ndarray, "beams"]:
        """Beams that hit something: finite and inside (range_min, range_max)."""
        with np.errstate(invalid="ignore"):
            return np.isfinite(self.ranges) & (self.ranges > self.range_min) & (self.ranges < self.range_max)

    @property
    def no_return(self) -> Bool[np.ndarray, "beams"]:
        """Beams that flew through free space to the limit: +inf or at least range_max."""
        with np.errstate(invalid="ignore"):
            return ~np.isnan(self.ranges) & (self.ranges >= self.range_max)

    @property
    def resolution(self) -> float:
        """Angle between neighbouring beams (rad), on average."""
        count = len(self.bearings)
        return float((self.bearings[-1] - self.bearings[0]) / (count - 1)) if count > 1 else 0.0

    @property
    def directions_robot(self) -> Float[np.ndarray, "beams 2"]:
        """Unit vector of each beam in the robot frame."""
        angle = self.bearings + self.pose_robot_sensor[2]
        return np.stack([np.cos(angle), np.sin(angle)], -1)

    @property
    def points_robot(self) -> Float[np.ndarray, "beams 2"]:
        """Beam ends in the robot frame; NaN for beams that are not `valid`."""
        reach = np.where(self.valid, self.ranges, np.nan)
        return self.pose_robot_sensor[:2] + reach[:, None] * self.directions_robot


@dataclass(frozen=True, eq=False, slots=True)
class Records:
    """Every record of a log, scans and odometry, in the order of recording.

    `stamps` are as written in the file (they may step backwards or repeat); `times` is the strictly increasing axis
    made from them that playback and interpolation use. `odometry` is None for a log without odometry.
    `scan_of_record` is the
    index of the scan that this record holds, −1 for a record of odometry only.
    """

    stamps: Float[np.ndarray, "records"]
    times: Float[np.ndarray, "records"]
    odometry: Float[np.ndarray, "records 3"] | None
    scan_of_record: Int[np.ndarray, "records"]


@runtime_checkable
class ScanLog(Protocol):
    """A log, whatever its format: lazy random access to scans, and the whole of its odometry in memory.

    `odometry` and `truth` hold one pose of the robot per scan, in frames of their own; None where the log has none.
    `notes` are sentences on what was unusual in the file and what was done about it.
    """

    @property
    def name(self) -> str: ...
    @property
    def path(self) -> Path: ...
    @property
    def records(self) -> Records: ...
    @property
    def times(self) -> Float[np.ndarray, "scans"]: ...
    @property
    def odometry(self) -> Float[np.ndarray, "scans 3"] | None: ...
    @property
    def truth(self) -> Float[np.ndarray, "scans 3"] | None: ...
    @property
    def notes(self) -> tuple[str, ...]: ...
    @property
    def content_hash(self) -> str: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: int) -> LaserScan: ...
    def __iter__(self) -> Iterator[LaserScan]: ...
    def index_at(self, time: float) -> int: ...
    def odometry_at(self, time: float) -> Float[np.ndarray, "3"] | None: ...


def index_at(times: Float[np.ndarray, "scans"], time: float) -> int:
    """The latest scan at or before `time` on an increasing axis; the first scan for earlier times."""
    return max(int(np.searchsorted(times, time, side="right")) - 1, 0)


def increasing_times(stamps: Float[np.ndarray, "records"]) -> Float[np.ndarray, "records"]:
    """A strictly increasing axis for stamps in the order of recording (s).

    Where the clock was set back (by more than CLOCK_SET_BACK) the axis goes on by one ordinary step. Smaller steps
    backwards are lifted to the latest time seen, and runs of equal times are spread evenly towards the next later one.
    """
    stamps = np.asarray(stamps, dtype=float)
    if len(stamps) < 2:
        return stamps
    steps = np.diff(stamps)
    forward = steps[steps > 0]
    ordinary = max(float(np.median(forward)), 1e-6) if len(forward) else 1e-3
    set_back = np.where(steps < -CLOCK_SET_BACK, ordinary - steps, 0.0)
    lifted = np.maximum.accumulate(stamps + np.concatenate([[0.0], np.cumsum(set_back)]))
    levels, first, count = np.unique(lifted, return_index=True, return_counts=True)
    gap = np.append(np.diff(levels), ordinary)
    position = np.arange(len(lifted)) - np.repeat(first, count)
    spread = lifted + np.repeat(np.minimum(gap, ordinary) / count, count) * position
    if np.all(np.diff(spread) > 0):
        return spread
    least = 2 * np.spacing(np.abs(spread).max()) * np.arange(len(spread))  # so many repeats that floats run out
    return np.maximum.accumulate(spread - least) + least


def interpolate_poses(
    times: Float[np.ndarray, "records"],
    poses: Float[np.ndarray, "records 3"],
    time: Float[np.ndarray, "*batch"] | float,
) -> Float[np.ndarray, "*batch 3"]:
    """The poses at `time` (one or many) on an increasing axis; held constant beyond its two ends."""
    time = np.asarray(time, dtype=float)
    if len(times) == 1:
        return np.broadcast_to(poses[0], (*time.shape, 3)).copy()
    right = np.clip(np.searchsorted(times, time), 1, len(times) - 1)
    fraction = np.clip((time - times[right - 1]) / (times[right] - times[right - 1]), 0.0, 1.0)
    return se2.interpolate(poses[right - 1], poses[right], fraction)
