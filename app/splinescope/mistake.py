"""The mistake that the tour makes: a segment given to a wall that runs beside the one that it saw."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.edits.edit import Force
from bspline_slam.slam import SlamStep
from bspline_slam.spline_map import MapSpline, SplineMap
from splinescope.findings import Findings

NEAR, FAR = 0.12, 1.2
"""How far (m) the beams end from the wrong spline: it is not the same wall, but one that could be meant."""
PARALLEL = 0.1
"""The standard deviation (m) of how far they end from it is less than this: it runs alongside."""
FACING = 0.05
"""Least cosine between the normal of a curve and the way back to the robot: walls are not seen from behind."""
LEAST_LENGTH = 1.0  # m: of both splines
LEAST_BEAMS = 15


def mistake_in(findings: Findings) -> Force | None:
    """A segment that clearly saw one wall while another one runs beside it: what a hasty person might mix up.

    All of its beams face the wrong wall, too, and none ends beside it. So they count when they are given to it, no wall
    grows towards them, and the cost rises: beams that cannot have seen a wall would be left out, at no cost.
    """
    snapshot = findings.snapshot
    if snapshot is None:
        return None
    long = SplineMap(tuple(spline for spline in snapshot.map if spline.length > LEAST_LENGTH))
    mixed = [
        (piece.first - piece.last, gap, piece.scan, piece.segment, piece, wrong.id)
        for step in findings.steps.values()
        for piece in _clear(step, long)
        for gap, wrong in _beside(piece, step, snapshot.poses[step.scan], long)
    ]
    if not mixed:
        return None
    *_, piece, wrong = min(mixed, key=lambda each: each[:4])
    return Force(piece.scan, piece.segment, piece.first, piece.last, wrong)


def _clear(step: SlamStep, long: SplineMap) -> Iterator[Association]:
    """The pieces of many beams that matched a long spline."""
    ids = {spline.id for spline in long}
    for piece in step.associations:
        if piece.verdict is Verdict.MATCHED and piece.last - piece.first >= LEAST_BEAMS and piece.spline in ids:
            yield piece


def _beside(
    piece: Association, step: SlamStep, pose: Float[np.ndarray, "3"], long: SplineMap
) -> Iterator[tuple[float, MapSpline]]:
    """The long splines that run alongside the beams of a piece and face them, but are not theirs: how far away (m)."""
    segment = next(segment for segment in step.segments if segment.index == piece.segment)
    inside = (segment.beams >= piece.first) & (segment.beams <= piece.last)
    points = se2.transform(pose, segment.points[inside])
    for spline in long:
        if spline.id != piece.spline and _distance(spline, points.mean(0)) < FAR:
            gap = _gap(spline, points, pose[:2])
            if gap is not None and NEAR < gap < FAR:
                yield gap, spline


def _distance(spline: MapSpline, point: Float[np.ndarray, "2"]) -> float:
    return float(np.linalg.norm(spline.sample(0.1)[1] - point, axis=1).min())


def _gap(spline: MapSpline, points: Float[np.ndarray, "m 2"], robot: Float[np.ndarray, "2"]) -> float | None:
    """How far (m, RMS) beam ends lie from a spline that all of them face and that runs alongside; None for others."""
    t = spline.curve.foot_points(points)
    feet, normals = spline.curve(t), spline.curve.normals(t)
    off, back = ((points - feet) * normals).sum(1), robot - points
    facing = (back * normals).sum(1) > FACING * np.linalg.norm(back, axis=1)
    low, high = spline.span
    if not (facing & (t > low) & (t < high)).all() or off.std() > PARALLEL:
        return None
    return float(np.sqrt(np.mean(np.square(off))))
