"""A log whose records are indexed in memory and whose scans are read when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.scan import LaserScan, Records, interpolate_poses

Progress = Callable[[float], None]


def unwatched(fraction: float) -> None:
    """Progress of an index pass (0 … 1) that nobody watches."""


@dataclass(frozen=True, eq=False)
class IndexedLog:
    """The ScanLog that every reader returns.

    `read_scan` reads scan i (0 ≤ i < len) from the log; everything else was found out by the index pass.
    """

    path: Path
    records: Records
    truth: Float[np.ndarray, "scans 3"] | None
    notes: tuple[str, ...]
    content_hash: str
    read_scan: Callable[[int], LaserScan]

    @property
    def name(self) -> str:
        """The file's name without folders."""
        return self.path.name

    @cached_property
    def record_of_scan(self) -> Int[np.ndarray, "scans"]:
        """The record that holds each scan."""
        return np.flatnonzero(self.records.scan_of_record >= 0)

    @cached_property
    def times(self) -> Float[np.ndarray, "scans"]:
        """Time of each scan on the increasing axis (s)."""
        return self.records.times[self.record_of_scan]

    @cached_property
    def odometry(self) -> Float[np.ndarray, "scans 3"] | None:
        """Pose of the robot by odometry at each scan; None without odometry."""
        return None if self.records.odometry is None else self.records.odometry[self.record_of_scan]

    def __len__(self) -> int:
        return len(self.record_of_scan)

    def __getitem__(self, index: int) -> LaserScan:
        count = len(self)
        if not -count <= index < count:
            raise IndexError(f"{self.name} has {count} scans, there is no scan {index}")
        return self.read_scan(int(index) % count)

    def __iter__(self) -> Iterator[LaserScan]:
        return (self.read_scan(index) for index in range(len(self)))

    def index_at(self, time: float) -> int:
        """The latest scan at or before `time` on the increasing axis; the first scan for earlier times."""
        return max(int(np.searchsorted(self.times, time, side="right")) - 1, 0)

    def odometry_at(self, time: float) -> Float[np.ndarray, "3"] | None:
        """Pose of the robot by odometry, interpolated between records; None without odometry."""
        if self.records.odometry is None:
            return None
        return interpolate_poses(self.records.times, self.records.odometry, time)
