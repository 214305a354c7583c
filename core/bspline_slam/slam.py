"""The pipeline: from a log to a map, one scan at a time; what it saw and decided is recorded as frozen steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.association import Association
from bspline_slam.backends.protocol import Estimate
from bspline_slam.loop_closure import LoopClosure
from bspline_slam.segmentation import ScanSegment
from bspline_slam.spline_map import SplineMap


@dataclass(frozen=True, eq=False, slots=True)
class SlamStep:
    """What was done with one scan.

    `predicted` is the pose before the scan was looked at, `pose` after (world frame). `key` says whether the scan
    entered the map; only key scans
    carry segments, associations and loop closures. `score` (0…1) is the matcher's correlation and `lost` that it
    was too low to be believed.
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


@dataclass(frozen=True, eq=False, slots=True)
class Snapshot:
    """The whole estimate at one moment: poses of the scans read so far, the map, and the decisions behind it.

    `poses[i]` is the pose of scan i (world frame); `steps` holds the latest SlamStep of each *key* scan, with
    poses as estimated now.
    """

    poses: Float[np.ndarray, "scans 3"]
    key_scans: Int[np.ndarray, "n"]
    steps: tuple[SlamStep, ...]
    map: SplineMap
    loop_closures: tuple[LoopClosure, ...]
    estimate: Estimate | None = None
