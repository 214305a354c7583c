"""Small logs in memory and on disk, for tests of what handles logs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from app import views
from bspline_slam.scan import LaserScan, Records, ScanLog, index_at
from splinescope.computing.messages import LogFile


@dataclass(frozen=True, eq=False)
class MemoryLog:
    """A ScanLog of ready-made scans."""

    name: str
    path: Path
    scans: tuple[LaserScan, ...]
    odometry: Float[np.ndarray, "scans 3"] | None
    truth: Float[np.ndarray, "scans 3"] | None = None
    notes: tuple[str, ...] = ()
    content_hash: str = "0"

    @property
    def times(self) -> Float[np.ndarray, "scans"]:
        return np.array([scan.stamp for scan in self.scans])

    @property
    def records(self) -> Records:
        return Records(self.times, self.times, self.odometry, np.arange(len(self.scans)))

    def __len__(self) -> int:
        return len(self.scans)

    def __getitem__(self, index: int) -> LaserScan:
        return self.scans[index]

    def __iter__(self) -> Iterator[LaserScan]:
        return iter(self.scans)

    def index_at(self, time: float) -> int:
        return index_at(self.times, time)

    def odometry_at(self, time: float) -> Float[np.ndarray, "3"] | None:
        return None if self.odometry is None else self.odometry[self.index_at(time)]


def file_of(log: ScanLog) -> LogFile:
    """The log as the estimator is told of it."""
    return LogFile(log.path, log.content_hash)


def corridor_log(rng: np.random.Generator, count: int = 40, notes: tuple[str, ...] = ()) -> MemoryLog:
    """A drive past two rooms, ten scans a second; odometry that drifts, the truth beside it."""
    world = views.floor_map()
    path = views.path_through(2, 1, count, rng)
    scans = tuple(views.scan_of(world, pose, index, rng) for index, pose in enumerate(path))
    return MemoryLog("corridor.log", Path("corridor.log"), scans, views.drifted(path, 0.002), path, notes)


def write_carmen(log: MemoryLog, path: Path) -> Path:
    """The log as CARMEN text (181 beams over 180°, readings without return as 81.83)."""
    lines = []
    for scan, (x, y, heading) in zip(log.scans, log.odometry if log.odometry is not None else (), strict=True):
        ranges = " ".join(f"{r:.3f}" if np.isfinite(r) else "81.830" for r in scan.ranges)
        pose = f"{x:.4f} {y:.4f} {heading:.5f}"
        lines.append(f"FLASER {len(scan.ranges)} {ranges} {pose} {pose} {scan.stamp:.3f} robot {scan.stamp:.3f}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
