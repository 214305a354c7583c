"""From the end of a descent to an Estimate: χ² and degrees of freedom of the whole graph."""

from __future__ import annotations

from bspline_slam.backends.gauss_newton import Descent, State
from bspline_slam.backends.packing import CurveTerms, EdgeTerms
from bspline_slam.backends.protocol import Estimate
from bspline_slam.graph import Graph


def estimate_of(graph: Graph, curves: CurveTerms, edges: EdgeTerms, descent: Descent) -> Estimate:
    """The estimate that a descent reached, with the statistics of all factors; the terms are those of the graph."""
    state = descent.state
    return Estimate(
        graph,
        state.poses,
        state.control_points,
        descent.records,
        descent.converged,
        chi_square(graph, curves, edges, state),
        degrees_of_freedom(graph),
    )


def chi_square(graph: Graph, curves: CurveTerms, edges: EdgeTerms, state: State) -> float:
    """Σ w‖e‖², w the weight of the robust kernel, and the constants of the spline factors."""
    squares = curves.cost(state.poses, state.control_points) + edges.cost(state.poses)[1]
    return squares + sum(factor.constant for factor in graph.spline_factors)


def degrees_of_freedom(graph: Graph) -> int:
    """Readings behind the spline factors (rows, where a factor counts none) and rows of all others, less unknowns."""
    readings = sum(factor.readings or len(factor.b) for factor in graph.spline_factors)
    rows = 3 * len(graph.pose_factors) + 3 * len(graph.pose_priors) + sum(len(prior.b) for prior in graph.shape_priors)
    return readings + rows - graph.unknowns
