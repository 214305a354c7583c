"""The laser of a twin: where its beams point and how far they reach."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float

from bspline_slam.scan import LaserScan

FARTHEST = 81.83
"""Reach (m) of a laser that tells no limit of its own."""


@dataclass(frozen=True, eq=False, slots=True)
class TwinLaser:
    """A planar laser by the bearings of its beams (rad, sensor frame); distances in m."""

    bearings: Float[np.ndarray, "beams"]
    range_min: float
    range_max: float
    pose_robot_sensor: Float[np.ndarray, "3"]

    @classmethod
    def from_scan(cls, scan: LaserScan) -> TwinLaser:
        reach = scan.range_max if np.isfinite(scan.range_max) else FARTHEST
        return cls(scan.bearings, scan.range_min, reach, scan.pose_robot_sensor)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> TwinLaser:
        """From what `to_dict` made; raises KeyError, TypeError or ValueError where it is something else."""
        bearings = np.radians(data["first_bearing_deg"] + data["resolution_deg"] * np.arange(data["beams"]))
        x, y, turn = data["pose_robot_sensor"]
        return cls(bearings, float(data["range_min"]), float(data["range_max"]), np.array([x, y, turn], dtype=float))

    def to_dict(self) -> dict[str, Any]:
        """Plain data; beams lie evenly apart."""
        width = np.degrees(self.bearings[-1] - self.bearings[0])
        return {
            "beams": len(self.bearings),
            "first_bearing_deg": round(float(np.degrees(self.bearings[0])), 6),
            "resolution_deg": round(float(width / max(len(self.bearings) - 1, 1)), 6),
            "range_min": self.range_min,
            "range_max": self.range_max,
            "pose_robot_sensor": self.pose_robot_sensor.tolist(),
        }
