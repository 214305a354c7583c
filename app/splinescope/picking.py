"""From a click to the thing under it: only what is switched on can be hit."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from bspline_slam import se2
from bspline_slam.spline_map import MapSpline
from splinescope.pieces import every_piece, name_of_piece, pieces_in, points_of
from splinescope.view import Layer, MapView, Piece, ScanView, Selection, View

Hit = tuple[float, Selection]
"""How far it is from the click (m), and what it is."""


def pick(view: View, world_point: Float[np.ndarray, "2"], tolerance_m: float) -> Selection | None:
    """What lies within `tolerance_m` of a point of the world, None when nothing does.

    A control point or key pose wins over the line through it, where its neighbours stand far enough away to be told
    apart; the current scan, which is drawn on top, wins over a spline that is not clearly nearer.
    """
    found = {
        "control point": _control_point(view, world_point, tolerance_m),
        "key pose": _key_pose(view, world_point, tolerance_m),
        "segment": _segment(view, world_point),
        "spline": _spline(view, world_point, tolerance_m),
    }
    near = {kind: hit for kind, hit in found.items() if hit is not None and hit[0] <= tolerance_m}
    if "segment" in near and "spline" in near and near["spline"][0] + 0.5 * tolerance_m < near["segment"][0]:
        del near["segment"]
    return next((hit[1] for hit in near.values()), None)


def pick_piece(view: View, point: Float[np.ndarray, "2"], tolerance: float) -> Piece | None:
    """The piece of the key scan under a point."""
    scan = view.scan
    if scan is None or not scan.key or not _shows_segments(view):
        return None
    hits = [
        (_distance_to_polyline(points, point), name)
        for name in map(name_of_piece, every_piece(scan))
        if len(points := points_of(name, scan))
    ]
    distance, found = min(hits, default=(np.inf, None))
    return found if distance <= tolerance else None


def pick_box(view: View, corners: Float[np.ndarray, "4 2"]) -> tuple[Piece, ...]:
    """The pieces of the key scan that lie in a rectangle."""
    scan = view.scan
    return pieces_in(scan, corners) if scan is not None and scan.key and _shows_segments(view) else ()


def _shows_segments(view: View) -> bool:
    return bool(view.layers & {Layer.SEGMENTS, Layer.FITS, Layer.ASSOCIATIONS})


def nearest_spline(view: View, point: Float[np.ndarray, "2"], tolerance: float) -> int | None:
    """The spline under a point, whatever lies over it."""
    hit = _spline(view, point, tolerance)
    return hit[1].id if hit is not None and hit[0] <= tolerance else None


def nearest_key_pose(view: View, point: Float[np.ndarray, "2"]) -> int | None:
    """The scan of the key pose nearest to a point."""
    if view.map is None or not len(view.map.key_poses):
        return None
    return view.map.key_scans[_nearest(view.map.key_poses[:, :2], point)[0]]


def _control_point(view: View, point: Float[np.ndarray, "2"], tolerance: float) -> Hit | None:
    if view.map is None or Layer.CONTROL_POINTS not in view.layers or not len(view.map.map):
        return None
    counts, points = _control_points(view.map)
    best, distance = _nearest(points, point)
    spline = int(np.searchsorted(np.cumsum(counts), best, side="right"))
    sub = best - int(counts[:spline].sum())
    own = view.map.map.splines[spline].curve.control_points
    if _crowded(own, sub, tolerance):
        return None
    return distance, Selection("control point", view.map.map.splines[spline].id, sub)


def _key_pose(view: View, point: Float[np.ndarray, "2"], tolerance: float) -> Hit | None:
    if view.map is None or Layer.ESTIMATE not in view.layers or not len(view.map.key_poses):
        return None
    positions = view.map.key_poses[:, :2]
    best, distance = _nearest(positions, point)
    if _crowded(positions, best, tolerance):
        return None
    return distance, Selection("key pose", view.map.key_scans[best])


def _segment(view: View, point: Float[np.ndarray, "2"]) -> Hit | None:
    if view.scan is None or not _shows_segments(view):
        return None
    hits = [
        (_distance_to_polyline(_points_world(view.scan, i), point), Selection("segment", fitted.segment.index))
        for i, fitted in enumerate(view.scan.segments)
    ]
    return min(hits, key=lambda hit: hit[0], default=None)


def _spline(view: View, point: Float[np.ndarray, "2"], tolerance: float) -> Hit | None:
    if view.map is None or Layer.SPLINES not in view.layers or not len(view.map.map):
        return None
    counts, points = _control_points(view.map)
    starts = np.cumsum(counts) - counts
    low = np.minimum.reduceat(points, starts, axis=0) - tolerance
    high = np.maximum.reduceat(points, starts, axis=0) + tolerance
    around = np.flatnonzero(((point >= low) & (point <= high)).all(axis=1))
    hits = [
        (_distance_to_spline(s, point), Selection("spline", s.id)) for s in (view.map.map.splines[i] for i in around)
    ]
    return min(hits, key=lambda hit: hit[0], default=None)


def _control_points(view: MapView) -> tuple[Int[np.ndarray, "s"], Float[np.ndarray, "n 2"]]:
    arrays = [spline.curve.control_points for spline in view.map]
    return np.array([len(array) for array in arrays]), np.concatenate(arrays)


def _points_world(scan: ScanView, index: int) -> Float[np.ndarray, "m 2"]:
    return se2.transform(scan.pose, scan.segments[index].segment.points)


def _nearest(points: Float[np.ndarray, "n 2"], point: Float[np.ndarray, "2"]) -> tuple[int, float]:
    distance = np.hypot(points[:, 0] - point[0], points[:, 1] - point[1])
    best = int(np.argmin(distance))
    return best, float(distance[best])


def _crowded(points: Float[np.ndarray, "n 2"], index: int, tolerance: float) -> bool:
    """Whether a neighbour in the row stands so near that a click could as well mean it."""
    neighbours = [i for i in (index - 1, index + 1) if 0 <= i < len(points)]
    gaps = [float(np.linalg.norm(points[i] - points[index])) for i in neighbours]
    return min(gaps, default=np.inf) < 2.0 * tolerance


def _distance_to_polyline(points: Float[np.ndarray, "m 2"], point: Float[np.ndarray, "2"]) -> float:
    start, step = points[:-1], np.diff(points, axis=0)
    if len(step) == 0:
        return float(np.linalg.norm(points[0] - point))
    square = np.maximum((step**2).sum(axis=1), 1e-18)
    share = np.clip(((point - start) * step).sum(axis=1) / square, 0.0, 1.0)
    return float(np.linalg.norm(start + share[:, None] * step - point, axis=1).min())


def _distance_to_spline(spline: MapSpline, point: Float[np.ndarray, "2"]) -> float:
    foot = np.clip(spline.curve.foot_points(point[None]), *spline.span)
    return float(np.linalg.norm(spline.curve(foot)[0] - point))
