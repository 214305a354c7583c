"""How surely curves lie where the map has them: the standard deviation across each, stretch by stretch."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from jaxtyping import Float

from bspline_slam.bspline import BSpline, basis_rows
from bspline_slam.lab.stretches import LENGTH, Stretches
from bspline_slam.spline_map import SplineMap


def sigma_across(
    curve: BSpline, covariance: Float[np.ndarray, "d d"], t: Float[np.ndarray, "m"], left_out: float = 0.0
) -> Float[np.ndarray, "m"]:
    """Standard deviation (m) of a wall along the normal of its curve at each t, by the covariance of (c_1x, c_1y,
    c_2x, …) and the variance (m²) of what the curve leaves out."""
    first, weights = basis_rows(curve.knots, curve.degree, t)
    active = first[:, None] + np.arange(curve.degree + 1)
    blocks = covariance.reshape(len(curve.control_points), 2, len(curve.control_points), 2)
    among = blocks[active[:, :, None], :, active[:, None, :], :]
    direction = weights[:, :, None] * curve.normals(t)[:, None, :]
    variance = np.einsum("mki,mklij,mlj->m", direction, among, direction)
    return np.sqrt(np.maximum(variance, 0.0) + left_out)


def sigmas_along(splines: SplineMap, covariances: Mapping[int, Float[np.ndarray, "d d"]]) -> Stretches:
    """1σ across each curve (m) in the middle of its stretches; NaN where the covariance of a spline is not known."""
    spline, start, end, value = [np.zeros(0, dtype=np.int64)], [np.zeros(0)], [np.zeros(0)], [np.zeros(0)]
    for one in splines:
        edges, _ = one.sample(LENGTH)
        middle, covariance = 0.5 * (edges[:-1] + edges[1:]), covariances.get(one.id)
        spline.append(np.full(len(middle), one.id))
        start.append(edges[:-1])
        end.append(edges[1:])
        if covariance is None:
            value.append(np.full(len(middle), np.nan))
        else:
            value.append(sigma_across(one.curve, covariance, middle, one.left_out))
    return Stretches(*(np.concatenate(column) for column in (spline, start, end, value)))
