"""Knots that earn nothing are taken out, and degrees too: a straight wall needs two control points, however long it
is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam.bspline import BSpline, basis_rows
from bspline_slam.kernels import knots as kernels

ALONG = 0.1
"""Share of a beam's weight that holds the curve along itself, so that it keeps its length; it earns no knot."""
CELL = 0.02
"""Beams whose feet lie in the same stretch of so much parameter (m) count together."""


@dataclass(frozen=True, eq=False, slots=True)
class Places:
    """Points of a curve where beams saw it: their parameters, and what these beams measure of each (xx, xy, yy, in
    1/m²), across the curve alone and with a little along it."""

    t: Float[np.ndarray, "m"]
    points: Float[np.ndarray, "m 2"]
    across: Float[np.ndarray, "m 3"]
    held: Float[np.ndarray, "m 3"]


def without_idle_knots(
    curve: BSpline,
    t: Float[np.ndarray, "m"],
    normals: Float[np.ndarray, "m 2"],
    weight: Float[np.ndarray, "m"],
    gain: float,
) -> BSpline:
    """The plainest curve that will do: χ² grows by at most `gain` for each control point saved.

    Beams measure across the curve, along `normals` at parameters `t`, with weights 1/σ (1/m); the curve is taken to
    be their best fit. Tries each degree up to that of the curve, from one polynomial on, and puts knots back, one by
    one, that around which most is lost. With `gain` = 1, what noise alone gives for the one coordinate that beams
    measure, the covariances stay honest; larger gains trade shape for fewer control points.
    """
    if len(t) == 0:
        return curve
    at, across, held = kernels.gathered(t, normals, weight, t.min(), CELL, ALONG)
    places = Places(at, curve(at), across, held)
    best = curve
    for degree in range(1, curve.degree + 1):
        best = _plainest(curve, degree, places, gain, best)
    return best


def _plainest(curve: BSpline, degree: int, places: Places, gain: float, best: BSpline) -> BSpline:
    """The curve of this degree with the fewest knots that will do, where it has fewer control points than `best`."""
    count = len(curve.control_points)
    inner = curve.knots[curve.degree + 1 : count]
    kept = np.zeros(len(inner), dtype=bool)
    while degree + 1 + np.count_nonzero(kept) < len(best.control_points):
        plain, lost = _fitted(on_inner_knots(curve, degree, kept), places)
        if lost.sum() <= gain * (count - len(plain.control_points)):
            return _without_more(curve, plain, kept, places, gain)
        missing = np.flatnonzero(~kept)
        if len(missing) == 0:
            return best
        middles = (inner[missing][1:] + inner[missing][:-1]) / 2
        nearest = np.searchsorted(middles, places.t)
        kept[missing[np.bincount(nearest, weights=lost, minlength=len(missing)).argmax()]] = True
    return best


def _without_more(curve: BSpline, plain: BSpline, kept: Bool[np.ndarray, "k"], places: Places, gain: float) -> BSpline:
    """The plainer curve without those knots, tried one by one, that the ones put back after them made needless."""
    for knot in np.flatnonzero(kept).tolist():
        left = kept.copy()
        left[knot] = False
        plainer, lost = _fitted(on_inner_knots(curve, plain.degree, left), places)
        if lost.sum() <= gain * (len(curve.control_points) - len(plainer.control_points)):
            plain, kept = plainer, left
    return plain


def on_inner_knots(curve: BSpline, degree: int, kept: Bool[np.ndarray, "k"]) -> BSpline:
    """A curve of this degree, no higher than that of `curve`, on the same domain and on some of its inner knots;
    control points are still to be found."""
    own, count = curve.degree, len(curve.control_points)
    inner = curve.knots[own + 1 : count][kept]
    knots = np.concatenate([curve.knots[own - degree : own + 1], inner, curve.knots[count : count + degree + 1]])
    return BSpline(degree, knots, np.zeros((len(knots) - degree - 1, 2)))


def _fitted(plain: BSpline, places: Places) -> tuple[BSpline, Float[np.ndarray, "m"]]:
    """The plainer curve nearest to the places as beams weigh their distance, and what is lost at each."""
    first, basis = basis_rows(plain.knots, plain.degree, places.t)
    H, g = kernels.normal_equations(first, basis, places.held, places.points, len(plain.control_points))
    H += 1e-9 * np.trace(H) / len(H) * np.eye(len(H))
    g += 1e-9 * np.trace(H) / len(H) * np.tile(places.points.mean(0), len(plain.control_points))
    control_points = np.linalg.solve(H, g).reshape(-1, 2)
    return plain.with_control_points(control_points), kernels.losses(
        first, basis, places.across, places.points, control_points
    )
