"""The drive of a robot through a world: a smooth path under way points, at speeds that a real robot would keep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bspline import BSpline, clamped_knots

SPACING = 0.01
"""Distance (m) between the samples of the path that its timing is computed on."""


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """Where the robot goes, how fast, and how often it scans.

    The path is the cubic B-spline with `way_points` as control points: it starts at the first, ends at the last, and
    rounds the others. Three or more in a row on a line make it straight there. `speed` (m/s), `turn_rate` (rad/s) and
    `acceleration` (m/s²) are upper limits; a scan is taken every `scan_period` seconds.
    """

    way_points: Float[np.ndarray, "n 2"]
    speed: float
    turn_rate: float
    acceleration: float
    scan_period: float

    @property
    def path(self) -> BSpline:
        return BSpline(3, clamped_knots(len(self.way_points), 3), self.way_points)

    def poses(self, period: float) -> tuple[Float[np.ndarray, "k"], Float[np.ndarray, "k 3"]]:
        """Times from the start (s) and poses of the robot (world frame), one every `period` seconds."""
        parameters, points = self.path.sample(SPACING)
        tangent, bend = self.path(parameters, 1), self.path(parameters, 2)
        heading = np.unwrap(np.arctan2(tangent[:, 1], tangent[:, 0]))
        speed = np.maximum(np.linalg.norm(tangent, axis=1), 1e-9)
        curvature = (tangent[:, 0] * bend[:, 1] - tangent[:, 1] * bend[:, 0]) / speed**3
        reached = self._arrival_times(points, curvature)
        times = period * np.arange(int(reached[-1] / period) + 1)
        columns = [np.interp(times, reached, column) for column in (points[:, 0], points[:, 1], heading)]
        poses = np.stack(columns, -1)
        poses[:, 2] = se2.wrap(poses[:, 2])
        return times, poses

    def _arrival_times(
        self, points: Float[np.ndarray, "s 2"], curvature: Float[np.ndarray, "s"]
    ) -> Float[np.ndarray, "s"]:
        """Time at each sample when going as fast as speed, turn rate and acceleration allow, from rest to rest."""
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        limit = np.minimum(self.speed, self.turn_rate / np.maximum(np.abs(curvature), 1e-9)) ** 2
        limit[[0, -1]] = 0.0
        gain = 2 * self.acceleration * way
        forward = np.minimum.accumulate(limit - gain) + gain
        backward = np.minimum.accumulate((limit + gain)[::-1])[::-1] - gain
        velocity = np.sqrt(np.maximum(np.minimum(forward, backward), 0.0))
        return np.concatenate([[0.0], np.cumsum(2 * steps / (velocity[1:] + velocity[:-1]))])
