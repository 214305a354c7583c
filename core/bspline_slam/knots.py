"""Knots that earn nothing are taken out, and degrees too: a straight wall needs two control points, however long it
is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam.bspline import BSpline, basis_rows
from bspline_slam.kernels import knots as kernels

ALONG = 0.1
"""Share of a beam's weight that holds the curve along itself, so that it keeps its length; it earns no knot."""


def without_idle_knots(
    curve: BSpline,
    t: Float[np.ndarray, "m"],
    normals: Float[np.ndarray, "m 2"],
    weight: Float[np.ndarray, "m"],
    gain: float,
) -> BSpline:
    """The plainest curve that will do: χ² grows by at most `gain` for each control point saved.

    Beams measure across the curve, along `normals` at parameters `t`, with weights 1/σ (1/m); the curve is taken to
    be their best fit. Tries a straight line first, then one polynomial of each degree up to that of the curve; then
    puts knots back, one by one, that around which most is lost. With `gain` = 1, what noise alone gives for the one
    coordinate that beams measure, the covariances stay honest; larger gains trade shape for fewer control points.
    """
    if len(t) == 0:
        return curve
    first, basis = basis_rows(curve.knots, curve.degree, t)
    rows = (first, basis, normals * weight[:, None])
    information = kernels.information(*rows, ALONG, len(curve.control_points))
    information += 1e-9 * np.trace(information) / len(information) * np.eye(len(information))
    for plain in polynomials(curve):
        coarse, lost = _fitted(curve, plain, information, rows)
        if lost.sum() <= gain * (len(curve.control_points) - len(plain.control_points)):
            return coarse
    kept = np.zeros(len(curve.control_points) - curve.degree - 1, dtype=bool)  # inner knots
    inner = curve.knots[curve.degree + 1 : len(curve.control_points)]
    while not kept.all():
        coarse, lost = _fitted(curve, _on_inner_knots(curve, kept), information, rows)
        if lost.sum() <= gain * np.count_nonzero(~kept):
            return coarse
        missing = np.flatnonzero(~kept)
        middles = (inner[missing][1:] + inner[missing][:-1]) / 2
        nearest = np.searchsorted(middles, t)
        kept[missing[np.bincount(nearest, weights=lost, minlength=len(missing)).argmax()]] = True
    return curve


def polynomials(curve: BSpline) -> Iterator[BSpline]:
    """Curves of lower degrees without inner knots, on the same domain; control points are still to be found."""
    count = len(curve.control_points)
    for degree in range(1, curve.degree):
        left, right = curve.knots[curve.degree - degree : curve.degree + 1], curve.knots[count:][: degree + 1]
        yield BSpline(degree, np.concatenate([left, right]), np.zeros((degree + 1, 2)))


def _on_inner_knots(curve: BSpline, kept: Bool[np.ndarray, "k"]) -> BSpline:
    degree, count = curve.degree, len(curve.control_points)
    knots = np.concatenate([curve.knots[: degree + 1], curve.knots[degree + 1 : count][kept], curve.knots[count:]])
    return BSpline(degree, knots, np.zeros((len(knots) - degree - 1, 2)))


def _fitted(
    curve: BSpline,
    plain: BSpline,
    information: Float[np.ndarray, "d d"],
    rows: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> tuple[BSpline, Float[np.ndarray, "m"]]:
    """The plainer curve nearest to the finer one as beams weigh their difference, and what each beam loses."""
    refine = refinement(curve, plain)
    both = np.kron(refine, np.eye(2))
    wanted = both.T @ information
    control_points = np.linalg.solve(wanted @ both, wanted @ curve.control_points.ravel()).reshape(-1, 2)
    return plain.with_control_points(control_points), kernels.losses(
        *rows, refine @ control_points - curve.control_points
    )


def refinement(curve: BSpline, plain: BSpline) -> Float[np.ndarray, "n m"]:
    """The matrix that turns control points of a plainer curve (some of the knots, or a polynomial of lower degree) into
    those of `curve`."""
    places = greville(curve)
    return np.linalg.solve(curve.basis(places), plain.basis(places))


def greville(curve: BSpline) -> Float[np.ndarray, "n"]:
    """Greville abscissae: where each control point has most of its say."""
    index = np.arange(len(curve.control_points))[:, None] + np.arange(1, curve.degree + 1)
    return curve.knots[index].mean(1)
