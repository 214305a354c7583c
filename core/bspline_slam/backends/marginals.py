"""Marginal covariances of chosen poses and splines: blocks of an inverse, by solves with unit vectors."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from jaxtyping import Float, Int

from bspline_slam.backends.protocol import Marginals
from bspline_slam.graph import Graph

Solve = Callable[[np.ndarray], np.ndarray]


def marginals(solve: Solve, graph: Graph, poses: Sequence[int], splines: Sequence[int]) -> Marginals:
    """Blocks of H⁻¹, where `solve` gives H⁻¹ B and unknowns are all poses, then all control points."""
    return Marginals(
        {pose: inverse_block(solve, graph.unknowns, np.arange(3 * pose, 3 * pose + 3)) for pose in poses},
        {spline: inverse_block(solve, graph.unknowns, spline_unknowns(graph, spline)) for spline in splines},
    )


def spline_unknowns(graph: Graph, spline: int) -> Int[np.ndarray, "d"]:
    """Unknowns (c_1x, c_1y, …) of the spline with this id, behind those of all poses."""
    k = int(np.flatnonzero(graph.spline_ids == spline)[0])
    return 3 * len(graph.poses) + np.arange(2 * graph.spline_first[k], 2 * graph.spline_first[k + 1])


def inverse_block(solve: Solve, unknowns: int, block: Int[np.ndarray, "d"]) -> Float[np.ndarray, "d d"]:
    """Rows and columns `block` of H⁻¹."""
    units = np.zeros((unknowns, len(block)))
    units[block, np.arange(len(block))] = 1.0
    covariance = solve(units)[block]
    return (covariance + covariance.T) / 2
