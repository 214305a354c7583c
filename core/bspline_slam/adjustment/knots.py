"""Knots that earn nothing are taken out, and degrees too: a straight wall needs two control points, however long it
is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

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


@dataclass(frozen=True, eq=False, slots=True)
class PlainerCurve:
    """A curve that stands for a richer one, and the variance (m²) of the wall about it by what that one had more."""

    curve: BSpline
    left_out: float = 0.0


def without_idle_knots(
    curve: BSpline,
    t: Float[np.ndarray, "m"],
    normals: Float[np.ndarray, "m 2"],
    weight: Float[np.ndarray, "m"],
    gain: float,
) -> PlainerCurve:
    """The curve with the least χ² + `gain` · control points: each of these is there because it lowers χ² by more.

    Beams measure across the curve, along `normals` at parameters `t`, with weights 1/σ (1/m); the curve is taken to
    be their best fit. Tries each degree up to that of the curve, from one polynomial on; puts knots back, one by one,
    that around which most is lost, and takes out again those that others made needless.
    """
    if len(t) == 0:
        return PlainerCurve(curve)
    at, across, held = kernels.gathered(t, normals, weight, t.min(), CELL, ALONG)
    places = Places(at, curve(at), across, held)
    best = Trial(curve, np.zeros(len(at)), gain)
    for degree in range(1, curve.degree + 1):
        best = _cheapest(curve, degree, places, best)
    return PlainerCurve(best.curve, left_out(curve, best.curve, places))


@dataclass(frozen=True, eq=False, slots=True)
class Trial:
    """A plainer curve, and by how much χ² is larger for it, place by place."""

    curve: BSpline
    lost: Float[np.ndarray, "m"]
    gain: float

    @property
    def cost(self) -> float:
        return float(self.lost.sum()) + self.gain * len(self.curve.control_points)


def _cheapest(curve: BSpline, degree: int, places: Places, best: Trial) -> Trial:
    """The curve of this degree that costs least, where it costs less than `best`."""
    inner = curve.knots[curve.degree + 1 : len(curve.control_points)]
    kept, chosen = np.zeros(len(inner), dtype=bool), None
    while best.gain * (degree + 1 + np.count_nonzero(kept)) < best.cost:
        trial = _fitted(curve, degree, kept, places, best.gain)
        if trial.cost < best.cost:
            best, chosen = trial, kept.copy()
        missing = np.flatnonzero(~kept)
        if len(missing) == 0:
            break
        middles = (inner[missing][1:] + inner[missing][:-1]) / 2
        nearest = np.searchsorted(middles, places.t)
        kept[missing[np.bincount(nearest, weights=trial.lost, minlength=len(missing)).argmax()]] = True
    return best if chosen is None else _without_more(curve, degree, chosen, places, best)


def _without_more(curve: BSpline, degree: int, kept: Bool[np.ndarray, "k"], places: Places, best: Trial) -> Trial:
    """The plainer curve without the knots that others, put back after them, made needless: tried one by one, round and
    round, until each that is left is worth its while."""
    kept, left, tried = kept.copy(), np.flatnonzero(kept).tolist(), 0
    while tried < len(left):
        knot = left.pop(0)
        kept[knot] = False
        trial = _fitted(curve, degree, kept, places, best.gain)
        if trial.cost < best.cost:
            best, tried = trial, 0
        else:
            kept[knot] = True
            left.append(knot)
            tried += 1
    return best


def left_out(rich: BSpline, plain: BSpline, places: Places) -> float:
    """How far a wall strays from the plainer of two curves, squared and on the average along it (m²).

    Let x be the coordinates of a wall across the straight line nearest to it, each whitened by what the richer curve
    knows of it: that found them as d = x + noise of variance 1. Where x ~ N(0, τ²), it is known afterwards with the
    mean ρ d and the variance ρ = τ²/(1 + τ²). Of τ² tells d itself: |d|², by how much χ² is larger for the line, is
    k (1 + τ²) in the mean, k being by how many control points the line has less, each of which has one coordinate
    across it. So ρ = 1 − k/|d|², or 0 (James and Stein 1961); told by all of d, it does not hang on which of the
    coordinates were chosen to be left out. Where the two curves lie d(s) apart and the richer one has by s²(s) the
    larger variance, the wall strays from the plainer one by ρ² d(s)² + ρ s²(s).
    """
    if rich is plain:
        return 0.0
    line = _fitted(rich, 1, np.zeros(len(rich.control_points) - rich.degree - 1, dtype=bool), places, 0.0)
    share = 1.0 - (len(rich.control_points) - 2) / max(line.cost, 1e-12)
    if share <= 0.0:
        return 0.0
    normals = rich.normals(places.t)
    apart = ((plain(places.t) - places.points) * normals).sum(1)
    surer = np.maximum(_variances(rich, places, normals) - _variances(plain, places, normals), 0.0)
    return float(np.mean(share**2 * apart**2 + share * surer))


def _variances(curve: BSpline, places: Places, normals: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m"]:
    """Variance (m²) of a curve along these normals at the places, the poses that saw it taken as known."""
    first, basis = basis_rows(curve.knots, curve.degree, places.t)
    H, _ = _normal_equations(first, basis, places, len(curve.control_points))
    rows = (curve.basis(places.t)[:, :, None] * normals[:, None, :]).reshape(len(normals), -1)
    return (rows * np.linalg.solve(H, rows.T).T).sum(1)


def on_inner_knots(curve: BSpline, degree: int, kept: Bool[np.ndarray, "k"]) -> BSpline:
    """A curve of this degree, no higher than that of `curve`, on the same domain and on some of its inner knots;
    control points are still to be found."""
    own, count = curve.degree, len(curve.control_points)
    inner = curve.knots[own + 1 : count][kept]
    knots = np.concatenate([curve.knots[own - degree : own + 1], inner, curve.knots[count : count + degree + 1]])
    return BSpline(degree, knots, np.zeros((len(knots) - degree - 1, 2)))


def _fitted(curve: BSpline, degree: int, kept: Bool[np.ndarray, "k"], places: Places, gain: float) -> Trial:
    """The curve of this degree on these inner knots that is nearest to the places as beams weigh their distance."""
    plain = on_inner_knots(curve, degree, kept)
    first, basis = basis_rows(plain.knots, degree, places.t)
    control_points = np.linalg.solve(*_normal_equations(first, basis, places, len(plain.control_points))).reshape(-1, 2)
    lost = kernels.losses(first, basis, places.across, places.points, control_points)
    return Trial(plain.with_control_points(control_points), lost, gain)


def _normal_equations(
    first: Int[np.ndarray, "m"], basis: Float[np.ndarray, "m k"], places: Places, count: int
) -> tuple[Float[np.ndarray, "c c"], Float[np.ndarray, "c"]]:
    """H and g of H c = g for `count` control points (x, y of each in turn); what no beam tells of lies in the middle
    of all places."""
    H, g = kernels.normal_equations(first, basis, places.held, places.points, count)
    little = 1e-9 * np.trace(H) / len(H)
    return H + little * np.eye(len(H)), g + little * np.tile(places.points.mean(0), count)
