"""From the end of a descent to an Estimate: χ² of what was measured and its degrees of freedom.

Priors and gauges are left out of both: they say what data leave open, and a control point that only they hold is no
parameter that data were spent on.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float

from bspline_slam.backends.gauss_newton import STEP_INFORMATION, Descent, State
from bspline_slam.backends.packing import CurveTerms, EdgeTerms, pack_curves
from bspline_slam.backends.protocol import Estimate
from bspline_slam.flat_factors import FlatFactors
from bspline_slam.graph import Graph, SplineFactor
from bspline_slam.kernels import determined as kernels
from bspline_slam.kernels import linearise

Matrices = list[Float[np.ndarray, "_ _"]]


def estimate_of(graph: Graph, curves: CurveTerms, edges: EdgeTerms, descent: Descent) -> Estimate:
    """The estimate that a descent reached, with its statistics; the terms are those of the graph."""
    state = descent.state
    return Estimate(
        graph,
        state.poses,
        state.control_points,
        descent.records,
        descent.converged,
        chi_square(graph, curves, edges, state),
        degrees_of_freedom(graph, curves, state),
    )


def chi_square(graph: Graph, curves: CurveTerms, edges: EdgeTerms, state: State) -> float:
    """Σ w‖e‖² of observations and relative poses, w the weight of the robust kernel, with the constants of the
    observations."""
    observed = curves.only(measured(graph)).cost(state.poses, state.control_points)
    relative = edges.first(len(graph.pose_factors)).cost(state.poses)[1]
    return observed + relative + float(FlatFactors.of(graph.spline_factors).constant.sum())


def degrees_of_freedom(graph: Graph, curves: CurveTerms, state: State) -> float:
    """Measured numbers less the parameters that they, and not the priors, determine.

    All poses without a prior count fully. A spline counts tr((D + Q)⁻¹ D) parameters, D being the information that
    observations give its control points and Q that of gauge and shape prior: less than two for each control point.
    """
    rows = int(FlatFactors.of(graph.spline_factors).measured.sum()) + 3 * len(graph.pose_factors)
    held = len({prior.pose for prior in graph.pose_priors})
    data = measured(graph)
    told, held_by_priors = _band(curves.only(data), state), _band(curves.only(~data), state)
    determined = kernels.determined(told, held_by_priors, graph.spline_first, STEP_INFORMATION)
    return rows - 3 * (len(graph.poses) - held) - determined


def measures(factor: SplineFactor) -> bool:
    """Whether a spline factor holds beams; without any it only fixes where control points lie along their curve."""
    return factor.readings > 0


def measured(graph: Graph) -> Bool[np.ndarray, "f"]:
    """Which curve terms hold beams: not the gauges among spline factors, and no shape prior."""
    factors = FlatFactors.of(graph.spline_factors).readings > 0
    return np.append(factors, np.zeros(len(graph.shape_priors), dtype=bool))


def spline_information(graph: Graph, curves: CurveTerms, state: State) -> tuple[Matrices, Matrices]:
    """For each spline the information of its control points at a state: from observations, and from gauge and
    priors."""
    data = measured(graph)
    return _by_spline(graph, curves.only(data), state), _by_spline(graph, curves.only(~data), state)


def information_of(estimate: Estimate) -> tuple[Matrices, Matrices]:
    """`spline_information` at an estimate."""
    state = State(estimate.poses, estimate.control_points)
    return spline_information(estimate.graph, pack_curves(estimate.graph), state)


def _by_spline(graph: Graph, curves: CurveTerms, state: State) -> Matrices:
    """The information of curve terms as one matrix per spline."""
    band = _band(curves, state)
    return [_dense(band[a:b]) for a, b in pairwise(graph.spline_first.tolist())]


def _band(curves: CurveTerms, state: State) -> Float[np.ndarray, "n w 2 2"]:
    """The information of curve terms: the block of control points k and k + d at [k, d]."""
    widest = int(curves.size[:, 1].max(initial=1))
    band = np.zeros((len(state.control_points), widest, 2, 2))
    linearise.curve_information(
        state.poses, curves.observer, curves.first, curves.size, curves.start, curves.gram, band
    )
    return band


def _dense(band: Float[np.ndarray, "n w 2 2"]) -> Float[np.ndarray, "m m"]:
    """The symmetric matrix of blocks [k, d] in row k and column k + d."""
    n, widest = band.shape[:2]
    full = np.zeros((n, 2, n, 2))
    for d in range(min(widest, n)):
        k = np.arange(n - d)
        full[k, :, k + d, :] = band[: n - d, d]
        full[k + d, :, k, :] = band[: n - d, d].transpose(0, 2, 1)
    return full.reshape(2 * n, 2 * n)
