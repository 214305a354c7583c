"""How a map curve grows: where a run of beams is one smooth curve, and how a curve is lengthened through it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.association import AssociationConfig
from bspline_slam.bspline import BSpline
from bspline_slam.fitting import FittingConfig, cumulated_chords
from bspline_slam.kernels import fitting as kernels
from bspline_slam.kernels import surfaces
from bspline_slam.kernels.basis import basis_rows
from bspline_slam.spline_map import MapSpline

GROWN_STIFFNESS = 0.05
"""Weight of second differences of control points where a curve is lengthened."""


def largest_distance(curve: BSpline, span: tuple[float, float], points: Float[np.ndarray, "m 2"]) -> float:
    """Largest distance of points to a stretch of curve, to the nearest centimetre of arc (m)."""
    _, samples = curve.sample(0.01, span)
    return float(kernels.largest_distance(points, samples))


def sparse_cuts(points: Float[np.ndarray, "m 2"], config: AssociationConfig) -> list[int]:
    """Where to cut a run (robot frame) because the surface between two beam ends is anybody's guess: they lie farther
    apart than `sparse_gap` and than `sparse_ratio` times what a wall facing the robot would give."""
    wide = kernels.sparse_gaps(points, config.sparse_gap, config.sparse_ratio)
    return [0, *(wide + 1).tolist(), len(points)]


def smooth_cuts(
    points: Float[np.ndarray, "m 2"], through: Callable[[Float[np.ndarray, "_ 2"]], BSpline], tolerance: float
) -> list[int]:
    """Where to cut a run so that the curve `through` each piece stays within `tolerance` of every point (m)."""
    m, t = len(points), cumulated_chords(points)
    if m < 4 or t[-1] < 1e-6:
        return [0, m]
    off = np.linalg.norm(through(points)(t) - points, axis=1)
    worst = int(np.argmax(off))
    if off[worst] <= tolerance:
        return [0, m]
    cut = min(max(worst, 2), m - 2)
    left = smooth_cuts(points[:cut], through, tolerance)
    right = smooth_cuts(points[cut:], through, tolerance)
    return [*left, *(cut + k for k in right[1:])]


def left_normals(
    points: Float[np.ndarray, "m 2"], sizes: Int[np.ndarray, "k"], reach: int = 3
) -> Float[np.ndarray, "m 2"]:
    """Unit normals of polygons stacked, of `sizes` points: the chord over ±`reach` points turned left (towards the
    robot, for a segment)."""
    return surfaces.chord_normals(points, sizes, reach)


def lengthened(
    spline: MapSpline, points: Float[np.ndarray, "m 2"], fitting: FittingConfig, *, forward: bool
) -> tuple[BSpline, tuple[float, float]]:
    """The curve grown through `points` beyond its end (or before its start): control points are appended, and only
    those that shape the old end or the new stretch are solved for again."""
    if not forward:
        turned = replace(spline, curve=spline.curve.reversed(), span=_mirrored(spline.curve, spline.span))
        grown, span = lengthened(turned, points[::-1], fitting, forward=True)
        back, span = grown.reversed(), _mirrored(grown, span)
        shift = back.domain[1] - spline.curve.domain[1]
        return BSpline(back.degree, back.knots - shift, back.control_points), (span[0] - shift, span[1] - shift)
    curve, (low, high) = spline.curve, spline.span
    spacing = float(curve.knots[curve.degree + 1] - curve.knots[curve.degree])
    end = curve(np.array([high]))[0]
    ahead = ((points - end) * curve(np.array([high]), 1)[0]).sum(1) > 0
    points = points[ahead]
    if len(points) == 0:
        return curve, spline.span
    t_new = high + cumulated_chords(np.concatenate([end[None], points]))[1:]
    reach = float(t_new[-1])
    grown = curve.extended(after=max(int(np.ceil((reach - curve.domain[1]) / spacing - 1e-9)), 0))
    fixed = int(np.searchsorted(grown.knots[grown.degree + 1 :], high - 1e-9, side="right"))
    t_old = np.linspace(max(low, high - 3 * spacing), high, 16)
    first, basis = basis_rows(grown.knots, grown.degree, np.concatenate([t_old, t_new]), 0)
    shape = np.concatenate([curve(t_old), points])
    c = kernels.control_points(first, basis, shape, grown.control_points, fixed, GROWN_STIFFNESS)
    return grown.with_control_points(c), (low, reach)


def _mirrored(curve: BSpline, span: tuple[float, float]) -> tuple[float, float]:
    total = float(curve.knots[0] + curve.knots[-1])
    return total - span[1], total - span[0]
