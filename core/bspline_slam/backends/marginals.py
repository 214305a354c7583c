"""Marginal covariances of whole splines out of blocks of an inverse."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.graph import Graph


def control_points_of(graph: Graph, spline: int) -> Int[np.ndarray, "m"]:
    """Control points of the spline with this id."""
    k = int(np.flatnonzero(graph.spline_ids == spline)[0])
    return np.arange(graph.spline_first[k], graph.spline_first[k + 1])


def spline_covariance(blocks: Float[np.ndarray, "N w 2 2"], graph: Graph, spline: int) -> Float[np.ndarray, "d d"]:
    """Covariance of (c_1x, c_1y, c_2x, …); blocks[k, d] is that of control points k and k + d, in one spline."""
    points = control_points_of(graph, spline)
    m = len(points)
    covariance = np.zeros((m, 2, m, 2))
    for reach in range(m):
        first = np.arange(m - reach)
        covariance[first, :, first + reach, :] = blocks[points[0] + first, reach]
        covariance[first + reach, :, first, :] = blocks[points[0] + first, reach].swapaxes(1, 2)
    return covariance.reshape(2 * m, 2 * m)
