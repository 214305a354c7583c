"""The pieces that the segments of a scan were cut into by what was decided about them."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam import se2
from bspline_slam.association import Association, Verdict
from bspline_slam.segmentation import ScanSegment
from splinescope.view import Piece, ScanView


def name_of_piece(association: Association) -> Piece:
    """What tells a piece from all others of its scan."""
    return association.segment, association.first, association.last


def pieces_of(segment: ScanSegment, scan: ScanView) -> tuple[Association, ...]:
    """The pieces of a segment in order; a segment that nothing was decided about is one piece."""
    return tuple(a for a in scan.associations if a.segment == segment.index) or (_whole(segment),)


def every_piece(scan: ScanView) -> tuple[Association, ...]:
    """All pieces of a scan."""
    return tuple(piece for fitted in scan.segments for piece in pieces_of(fitted.segment, scan))


def points_of(piece: Piece, scan: ScanView) -> Float[np.ndarray, "m 2"]:
    """Where the beams of a piece end in the world; none where the scan has no such piece."""
    number, first, last = piece
    segment = next((f.segment for f in scan.segments if f.segment.index == number), None)
    if segment is None:
        return np.zeros((0, 2))
    inside = (segment.beams >= first) & (segment.beams <= last)
    return se2.transform(scan.pose, segment.points[inside])


def pieces_in(scan: ScanView, corners: Float[np.ndarray, "4 2"]) -> tuple[Piece, ...]:
    """The pieces that lie in a rectangle, however it is turned, with more than half of their points.

    `corners` go round the rectangle.
    """
    origin, along, across = corners[0], corners[1] - corners[0], corners[3] - corners[0]
    names = map(name_of_piece, every_piece(scan))
    return tuple(name for name in names if _share(points_of(name, scan) - origin, along, across) > 0.5)


def _share(points: Float[np.ndarray, "m 2"], along: Float[np.ndarray, "2"], across: Float[np.ndarray, "2"]) -> float:
    """Which part of some points lies between the origin and both sides."""
    if len(points) == 0 or not along.any() or not across.any():
        return 0.0
    shares = np.stack([points @ side / (side @ side) for side in (along, across)])
    return float(((shares >= 0.0) & (shares <= 1.0)).all(axis=0).mean())


def _whole(segment: ScanSegment) -> Association:
    first, last = int(segment.beams[0]), int(segment.beams[-1])
    return Association(segment.scan, segment.index, first, last, Verdict.GATED, None, float("nan"), float("nan"))
