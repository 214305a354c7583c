"""Given the poses, all control points by one linear least-squares problem, banded along each spline."""

from __future__ import annotations

import numpy as np
from jaxtyping import Float
from scipy.linalg import solveh_banded

from bspline_slam.backends.gauss_newton import STEP_INFORMATION, State
from bspline_slam.backends.packing import CurveTerms, EdgeTerms, pack_curves, pack_edges
from bspline_slam.backends.pattern import Blocks, find_pattern, linearise_terms
from bspline_slam.backends.threads import single_thread
from bspline_slam.graph import Graph

STEPS = 2
"""The second takes back what STEP_INFORMATION held of the first."""


def solve_control_points(graph: Graph, poses: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, "N 2"]:
    """The control points that fit the factors best when the poses are taken as given.

    Directions that nothing observes keep the values of `graph.control_points`.
    """
    return fit_control_points(pack_curves(graph), pack_edges(graph), poses, graph.control_points)


def fit_control_points(
    curves: CurveTerms,
    edges: EdgeTerms,
    poses: Float[np.ndarray, "n 3"],
    control_points: Float[np.ndarray, "N 2"],
) -> Float[np.ndarray, "N 2"]:
    """The same of packed terms, from these control points."""
    if len(control_points) == 0:
        return control_points
    pattern = find_pattern(curves, edges, len(control_points))
    for _ in range(STEPS):
        blocks = linearise_terms(curves, edges, pattern, State(poses, control_points))
        with single_thread():
            step = solveh_banded(curve_band(blocks), -blocks.gradient.control_points.ravel(), lower=True)
        control_points = control_points + step.reshape(-1, 2)
    return control_points


def curve_band(blocks: Blocks) -> Float[np.ndarray, "h d"]:
    """The matrix of all control points as the lower band that SciPy reads: [r − c, c] is the entry (r, c)."""
    N, w = blocks.curve.shape[:2]
    band = np.zeros((2 * w, 2 * N))
    for reach in range(w):
        for a in range(2):
            for b in range(2):
                below = 2 * reach + b - a
                if below >= 0:
                    band[below, a : 2 * (N - reach) : 2] = blocks.curve[: N - reach, reach, a, b]
    band[0] += STEP_INFORMATION
    return band
