"""A solve looked at again: some of its iterations are kept, and the map as it was at each is made from the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.backends.protocol import IterationRecord
from bspline_slam.slam import Snapshot
from bspline_slam.spline_map import MapSpline, SplineMap
from splinescope.map_view import carried, with_control_points

MOST_FRAMES = 25
"""Kept of one result, in single precision: 2,000 poses and 9,000 control points are 2.4 MB."""


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """What one iteration reached: its number, the cost, key poses and control points."""

    iteration: int
    cost: float
    poses: Float[np.ndarray, "n 3"]
    control_points: Float[np.ndarray, "N 2"]


def frames_of(records: Sequence[IterationRecord]) -> tuple[Frame, ...]:
    """The first iteration, the last, and so many evenly between them."""
    chosen = np.unique(np.rint(np.linspace(0, len(records) - 1, MOST_FRAMES)).astype(int)) if records else ()
    return tuple(
        Frame(r.index, float(r.cost), r.poses.astype(np.float32), r.control_points.astype(np.float32))
        for r in (records[i] for i in chosen)
    )


def at_frame(result: Snapshot, frame: Frame) -> Snapshot:
    """The map and the path as they were at a frame.

    Scans between key scans go along with the key scan before them. Where the frame is of a round with other control
    points, each curve goes along with the key scan that started it.
    """
    if len(frame.poses) != len(result.key_scans):
        return result
    key_poses = frame.poses.astype(float)
    if len(frame.control_points) == result.map.control_point_count:
        curves = with_control_points(result.map, frame.control_points.astype(float))
    else:
        curves = SplineMap(tuple(_carried_along(spline, result, key_poses) for spline in result.map))
    return replace(result, poses=carried(result.poses, result.key_scans, key_poses), map=curves)


def _carried_along(spline: MapSpline, result: Snapshot, key_poses: Float[np.ndarray, "n 3"]) -> MapSpline:
    key = max(int(np.searchsorted(result.key_scans, spline.born, side="right")) - 1, 0)
    now = result.poses[result.key_scans[key]]
    move = se2.compose(key_poses[key], se2.inverse(now))
    return spline.moved(move)
