"""A finished run: the folder that `run` wrote, read back, and the log that it was made from."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.calibration.odometry import scan_records
from bspline_slam.config import config_from_dict
from bspline_slam.errors import LogError
from bspline_slam.export.map_json import map_from_json
from bspline_slam.export.trajectory import Trajectory
from bspline_slam.logs import open_log
from bspline_slam.scan import ScanLog
from bspline_slam.slam_config import SlamConfig
from bspline_slam.spline_map import SplineMap

TRAJECTORY, MAP, REPORT = "trajectory.tum", "map.json", "report.json"


@dataclass(frozen=True, eq=False, slots=True)
class FinishedRun:
    """The results of a run: its map, a pose for every record of its log, and its report (empty where it is missing)."""

    folder: Path
    splines: SplineMap
    trajectory: Trajectory
    report: dict[str, Any]

    @classmethod
    def from_folder(cls, folder: Path) -> FinishedRun:
        """Read it; raises LogError where the map or the trajectory is missing or cannot be read."""
        if not folder.is_dir():
            raise LogError(folder, "is not a folder with the results of a run")
        splines, _ = map_from_json(folder / MAP)
        return cls(folder, splines, Trajectory.from_tum(folder / TRAJECTORY), read_report(folder))

    def config(self, *sections: str) -> SlamConfig:
        """The configuration of the run in these sections, defaults in the others."""
        saved = self.report.get("configuration", {})
        return config_from_dict(SlamConfig, {name: saved[name] for name in sections if name in saved})

    @property
    def laser(self) -> LaserCalibration:
        """What the beams of the run were corrected by; nothing where the report does not tell."""
        return LaserCalibration.from_dict(self.report.get("laser_calibration", {}))

    def scan_poses(self, log: ScanLog) -> Float[np.ndarray, "scans 3"]:
        """The pose of each scan of its log (world frame)."""
        return self.trajectory.poses[scan_records(log.records, len(log))]

    def open_log(self, path: Path) -> ScanLog:
        """The log that the run was made from; raises LogError where `path` is another one."""
        if not path.exists():
            raise LogError(path, "there is no such log")
        log = open_log(path)
        wanted = self.report.get("log", {}).get("content_hash", log.content_hash)
        stamps = self.trajectory.stamps
        same = len(log.records.stamps) == len(stamps) and np.allclose(log.records.stamps, stamps, atol=1e-5, rtol=0)
        if log.content_hash != wanted or not same:
            raise LogError(path, f"is not the log that {self.folder.name} was made from: its contents differ")
        return log


def read_report(folder: Path) -> dict[str, Any]:
    """The report of a run, empty where there is none; raises LogError where it cannot be read."""
    path = folder / REPORT
    if not path.is_file():
        return {}
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LogError(path, f"is not a readable report ({error})") from None
    if not isinstance(report, dict) or report.get("format") != "splinescope-report":
        raise LogError(path, "is not the report of a run")
    return report
