"""Knots that earn nothing are taken out: a straight wall needs four control points, however long it is."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline

ALONG = 0.1
"""Share of a beam's weight that holds the curve along itself, so that it keeps its length; it earns no knot."""


def without_idle_knots(
    curve: BSpline,
    t: Float[np.ndarray, "m"],
    normals: Float[np.ndarray, "m 2"],
    weight: Float[np.ndarray, "m"],
    gain: float,
) -> BSpline:
    """The curve on as few of its knots as will do: χ² grows by at most `gain` for each control point saved.

    Beams measure across the curve, along `normals` at parameters `t`, with weights 1/σ (1/m); the curve is taken to
    be their best fit. Starts with no inner knot and puts back, one by one, that around which most is lost. With
    `gain` = 1, what noise alone gives for the one coordinate that beams measure, the covariances stay honest; larger
    gains trade shape for fewer control points.
    """
    degree, count = curve.degree, len(curve.control_points)
    if len(t) == 0:
        return curve
    across = _rows(curve, t, normals * weight[:, None])
    along = _rows(curve, t, normals[:, ::-1] * (ALONG * weight[:, None] * (1.0, -1.0)))
    information = across.T @ across + along.T @ along
    information += 1e-9 * np.trace(information) / len(information) * np.eye(len(information))
    kept = np.zeros(count - degree - 1, dtype=bool)  # inner knots
    inner = curve.knots[degree + 1 : count]
    while not kept.all():
        knots = np.concatenate([curve.knots[: degree + 1], inner[kept], curve.knots[count:]])
        refine = np.kron(refinement(curve, knots), np.eye(2))
        wanted = refine.T @ information
        coarse = np.linalg.solve(wanted @ refine, wanted @ curve.control_points.ravel())
        lost = np.square(across @ (refine @ coarse - curve.control_points.ravel()))
        if lost.sum() <= gain * np.count_nonzero(~kept):
            return BSpline(degree, knots, coarse.reshape(-1, 2))
        missing = np.flatnonzero(~kept)
        nearest = np.abs(t[:, None] - inner[missing]).argmin(1)
        kept[missing[np.bincount(nearest, weights=lost, minlength=len(missing)).argmax()]] = True
    return curve


def _rows(curve: BSpline, t: Float[np.ndarray, "m"], directions: Float[np.ndarray, "m 2"]) -> Float[np.ndarray, "m d"]:
    """What moves of the control points (c_1x, c_1y, c_2x, …) do to the curve at t, seen along `directions`."""
    return (curve.basis(t)[:, :, None] * directions[:, None, :]).reshape(len(t), 2 * len(curve.control_points))


def refinement(curve: BSpline, knots: Float[np.ndarray, "fewer"]) -> Float[np.ndarray, "n m"]:
    """The matrix that turns control points on `knots`, a part of those of `curve`, into those on all of them."""
    places = greville(curve)
    coarse = BSpline(curve.degree, knots, np.zeros((len(knots) - curve.degree - 1, 2)))
    return np.linalg.solve(curve.basis(places), coarse.basis(places))


def greville(curve: BSpline) -> Float[np.ndarray, "n"]:
    """Greville abscissae: where each control point has most of its say."""
    index = np.arange(len(curve.control_points))[:, None] + np.arange(1, curve.degree + 1)
    return curve.knots[index].mean(1)
