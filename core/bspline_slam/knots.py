"""Knots that earn nothing are taken out: a straight wall needs four control points, however long it is."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline, basis_rows


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
    `gain` = 9.2 a knot stays where χ² of its two coordinates rejects its absence at 99 %.
    """
    degree, count = curve.degree, len(curve.control_points)
    first, basis = basis_rows(curve.knots, degree, t)
    rows = np.zeros((len(t), count, 2))
    rows[np.arange(len(t))[:, None], first[:, None] + np.arange(degree + 1)] = (
        basis[:, :, None] * (normals * weight[:, None])[:, None, :]
    )
    rows = rows.reshape(len(t), 2 * count)
    information = rows.T @ rows
    information += 1e-6 * np.trace(information) / len(information) * np.eye(len(information))
    kept = np.zeros(count - degree - 1, dtype=bool)
    inner = curve.knots[degree + 1 : count]
    while not kept.all():
        knots = np.concatenate([curve.knots[: degree + 1], inner[kept], curve.knots[count:]])
        refine = np.kron(refinement(curve, knots), np.eye(2))
        wanted = refine.T @ information
        coarse = np.linalg.solve(wanted @ refine, wanted @ curve.control_points.ravel())
        lost = np.square(rows @ (refine @ coarse - curve.control_points.ravel()))
        if lost.sum() <= gain * np.count_nonzero(~kept):
            return BSpline(degree, knots, coarse.reshape(-1, 2))
        missing = np.flatnonzero(~kept)
        nearest = np.abs(t[:, None] - inner[missing]).argmin(1)
        kept[missing[np.bincount(nearest, weights=lost, minlength=len(missing)).argmax()]] = True
    return curve


def refinement(curve: BSpline, knots: Float[np.ndarray, "fewer"]) -> Float[np.ndarray, "n m"]:
    """The matrix that turns control points on `knots`, a part of those of `curve`, into those on all of them."""
    places = greville(curve)
    coarse = BSpline(curve.degree, knots, np.zeros((len(knots) - curve.degree - 1, 2)))
    return np.linalg.solve(curve.basis(places), coarse.basis(places))


def greville(curve: BSpline) -> Float[np.ndarray, "n"]:
    """Greville abscissae: where each control point has most of its say."""
    index = np.arange(len(curve.control_points))[:, None] + np.arange(1, curve.degree + 1)
    return curve.knots[index].mean(1)
