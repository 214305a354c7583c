"""Whether a scan can be held against what was seen before, and how much of it agrees."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.scan import LaserScan

SECTORS = 180
"""What is seen is compared in so many sectors of a whole turn."""
MARGIN, PER_METRE = 0.3, 0.1
"""By so much may a beam end before or behind the wall that it was expected at (m; share of the distance)."""


def compared(
    scan: LaserScan, walls: Float[np.ndarray, "m 2"], pose: Float[np.ndarray, "3"], farthest: float
) -> tuple[float, float]:
    """Shares (0…1) of the sectors in which beams of the scan end: those in which a wall was expected, for a robot at
    `pose` among these wall points (world frame), and those in which the beams end there.

    Walls beyond the range of the laser are not expected, whatever stands before them.
    """
    limit = min(farthest, scan.range_max)
    ends = scan.valid & (scan.ranges < limit)
    seen = _nearest(scan.bearings[ends], scan.ranges[ends])
    x, y = se2.transform(se2.inverse(se2.compose(pose, scan.pose_robot_sensor)), walls).T
    wall = _nearest(np.arctan2(y, x), np.hypot(x, y))
    both = np.isfinite(seen) & (wall < limit)
    there = np.abs(seen[both] - wall[both]) <= MARGIN + PER_METRE * wall[both]
    total = max(int(np.count_nonzero(np.isfinite(seen))), 1)
    return int(np.count_nonzero(both)) / total, int(np.count_nonzero(there)) / total


def _nearest(bearings: Float[np.ndarray, "n"], distances: Float[np.ndarray, "n"]) -> Float[np.ndarray, "_"]:
    """The smallest distance in each sector; inf where there is none."""
    sector = np.floor(bearings * (SECTORS / (2.0 * np.pi))).astype(np.int64) % SECTORS
    out = np.full(SECTORS, np.inf)
    np.minimum.at(out, sector, distances)
    return out
