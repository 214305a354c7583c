"""What the pipeline hands out: the step of each scan, and the whole estimate at one moment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.association import Association
from bspline_slam.backends.protocol import Estimate
from bspline_slam.bent_path import bent_through
from bspline_slam.calibration.laser import LaserCalibration
from bspline_slam.front_end.loop_closure import LoopClosure
from bspline_slam.graph import PoseFactor
from bspline_slam.segmentation import ScanSegment
from bspline_slam.sights import KeyObservations
from bspline_slam.spline_map import SplineMap


@dataclass(frozen=True, eq=False, slots=True)
class SlamStep:
    """What was done with one scan.

    `predicted` is the pose before the scan was looked at, `pose` after (world frame). `key` says whether the scan
    entered the map; only key scans carry segments, associations and loop closures. `score` (0…1) is the matcher's
    correlation and `lost` that it was too low to be believed; `unfit` that odometry was not believed, for it did not
    fit what scans show.
    """

    scan: int
    predicted: Float[np.ndarray, "3"]
    pose: Float[np.ndarray, "3"]
    key: bool
    lost: bool
    score: float
    segments: tuple[ScanSegment, ...] = ()
    associations: tuple[Association, ...] = ()
    loop_closures: tuple[LoopClosure, ...] = ()
    unfit: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """The whole estimate at one moment: poses of the scans read so far, the map, and the decisions behind it.

    `poses[i]` is the pose of scan i (world frame); `steps` holds the latest SlamStep of each *key* scan, with poses
    as estimated now, and `observations` the same as the adjustment reads them. `pose_factors` tie key scans by
    odometry, matching and loop closures. `laser` is what the segments of a finished estimate are corrected by.
    """

    poses: Float[np.ndarray, "scans 3"]
    key_scans: Int[np.ndarray, "n"]
    steps: tuple[SlamStep, ...]
    map: SplineMap
    loop_closures: tuple[LoopClosure, ...]
    estimate: Estimate | None = None
    observations: tuple[KeyObservations, ...] = ()
    pose_factors: tuple[PoseFactor, ...] = ()
    laser: LaserCalibration = LaserCalibration()

    def poses_with(self, key_poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "scans 3"]:
        """The poses of all scans when the key scans go to `key_poses`: each goes along with the key scans on both sides
        of it, the difference spread evenly over the scans between them."""
        return bent_through(self.poses, self.key_scans, key_poses)
