"""A log whose records are indexed in memory and whose scans are read when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from bspline_slam.scan import LaserScan, Records, index_at, interpolate_poses

Progress = Callable[[float], None]


def unwatched(fraction: float) -> None:
    """Progress of an index pass (0 … 1) that nobody watches."""


@dataclass(frozen=True, eq=False, slots=True)
class IndexedLog:
    """The ScanLog that every reader returns.

    `times`, `odometry` and `truth` have one row per scan. `read_scan` reads scan i (0 ≤ i < len) from the log;
    everything else was found out by the index pass.
    """

    path: Path
    records: Records
    times: Float[np.ndarray, "scans"]
    odometry: Float[np.ndarray, "scans 3"] | None
    truth: Float[np.ndarray, "scans 3"] | None
    notes: tuple[str, ...]
    content_hash: str
    read_scan: Callable[[int], LaserScan]

    @classmethod
    def from_records(
        cls,
        path: Path,
        records: Records,
        truth: Float[np.ndarray, "scans 3"] | None,
        notes: Iterable[str],
        content_hash: str,
        read_scan: Callable[[int], LaserScan],
    ) -> IndexedLog:
        """A log whose scans are those that `records` tells of."""
        held = records.scan_of_record >= 0
        odometry = None if records.odometry is None else records.odometry[held]
        return cls(path, records, records.times[held], odometry, truth, tuple(notes), content_hash, read_scan)

    @property
    def name(self) -> str:
        """The file's name without folders."""
        return self.path.name

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, index: int) -> LaserScan:
        count = len(self)
        if not -count <= index < count:
            raise IndexError(f"{self.name} has {count} scans, there is no scan {index}")
        return self.read_scan(int(index) % count)

    def __iter__(self) -> Iterator[LaserScan]:
        return (self.read_scan(index) for index in range(len(self)))

    def index_at(self, time: float) -> int:
        """The latest scan at or before `time` on the increasing axis; the first scan for earlier times."""
        return index_at(self.times, time)

    def odometry_at(self, time: float) -> Float[np.ndarray, "3"] | None:
        """Pose of the robot by odometry, interpolated between records; None without odometry."""
        if self.records.odometry is None:
            return None
        return interpolate_poses(self.records.times, self.records.odometry, time)
