"""The scan under the cursor as the page draws it: cut, fitted, and with the decisions made about it."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import fitting, se2
from bspline_slam.errors import GeometryError
from bspline_slam.scan import LaserScan
from bspline_slam.segmentation import ScanSegment, segment_scan
from bspline_slam.slam import SlamStep
from splinescope.view import FittedSegment, ScanView


def view_scan(scan: LaserScan, pose: Float[np.ndarray, "3"], step: SlamStep | None) -> ScanView:
    """One scan placed at `pose` (world frame).

    A key scan shows the segments and decisions recorded in its `step`; any other scan is cut here and has none.
    """
    recorded = step is not None and step.key
    segments = step.segments if step is not None and step.key else segment_scan(scan)
    return ScanView(
        scan=scan,
        pose=pose,
        key=recorded,
        lost=step is not None and step.lost,
        segments=tuple(fitted(segment, scan.pose_robot_sensor) for segment in segments),
        associations=step.associations if step is not None else (),
    )


def fitted(segment: ScanSegment, pose_robot_sensor: Float[np.ndarray, "3"]) -> FittedSegment:
    """The segment with its curve (robot frame); without one when it has too few beams for a fit."""
    try:
        fit = fitting.fit_chord_length(se2.transform(se2.inverse(pose_robot_sensor), segment.points))
    except GeometryError:
        return FittedSegment(segment, None, None)
    curve = fit.curve.moved(pose_robot_sensor)
    return FittedSegment(segment, curve, turned(fit.covariance, float(pose_robot_sensor[2])))


def turned(covariance: Float[np.ndarray, "d d"], angle: float) -> Float[np.ndarray, "d d"]:
    """Covariance of stacked points after all of them were turned by `angle`."""
    turn = np.kron(np.eye(len(covariance) // 2), se2.rotation(angle))
    return turn @ covariance @ turn.T
