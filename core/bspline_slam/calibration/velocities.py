"""How fast the robot moved and turned at each scan, from the poses of the scans and odometry between them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.bent_path import bent_through
from bspline_slam.calibration.odometry import scan_records
from bspline_slam.calibration.odometry_filter import filtered_odometry
from bspline_slam.scan import Records

BURST = 10
"""Records come in bursts: the time between neighbours is the mean over so many of them on both sides."""
USUAL, JUMP = 95.0, 5.0
"""What is faster than this percentile of all velocities by such a factor is a jump of the estimate, and no motion."""


def velocities(records: Records, scan_poses: Float[np.ndarray, "scans 3"]) -> Float[np.ndarray, "scans 3"]:
    """Velocity (m/s, m/s, rad/s) at each of the first scans, in the frame of its robot: central differences over the
    neighbouring records. Where the estimate jumps, the robot stands still."""
    places, odometry = scan_records(records, len(scan_poses)), filtered_odometry(records, scan_poses)
    if len(places) < 2:
        return np.zeros((len(scan_poses), 3))
    if odometry is None:
        return _central(scan_poses, _periods(records.times[places]))
    path = bent_through(odometry, places, scan_poses)
    return _central(path, _periods(records.times))[places]


def _central(poses: Float[np.ndarray, "n 3"], periods: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n 3"]:
    index = np.arange(len(poses))
    before, after = np.maximum(index - 1, 0), np.minimum(index + 1, len(poses) - 1)
    moved = se2.rotate(-poses, poses[after, :2] - poses[before, :2])
    turned = se2.wrap(poses[after, 2] - poses[before, 2])
    velocity = np.column_stack([moved, turned]) / np.maximum(periods * (after - before), 1e-9)[:, None]
    size = np.column_stack([np.hypot(velocity[:, 0], velocity[:, 1]), np.abs(velocity[:, 2])])
    return np.where((size > JUMP * np.percentile(size, USUAL, axis=0)).any(1, keepdims=True), 0.0, velocity)


def _periods(times: Float[np.ndarray, "n"]) -> Float[np.ndarray, "n"]:
    """Time (s) from record to record around each."""
    index = np.arange(len(times))
    first, last = np.maximum(index - BURST, 0), np.minimum(index + BURST, len(times) - 1)
    return (times[last] - times[first]) / (last - first)
