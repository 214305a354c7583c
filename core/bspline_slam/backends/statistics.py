"""From the end of a descent to an Estimate: χ² and degrees of freedom of the whole graph."""

from __future__ import annotations

from bspline_slam.backends.gauss_newton import Descent, State
from bspline_slam.backends.packing import pack_curves, pack_edges
from bspline_slam.backends.protocol import Estimate
from bspline_slam.graph import Graph


def estimate_of(graph: Graph, descent: Descent) -> Estimate:
    """The estimate that a descent reached, with the statistics of all factors of the graph."""
    state = descent.state
    return Estimate(
        graph,
        state.poses,
        state.control_points,
        descent.records,
        descent.converged,
        chi_square(graph, state),
        degrees_of_freedom(graph),
    )


def chi_square(graph: Graph, state: State) -> float:
    """Σ w‖e‖², w the weight of the robust kernel, and the constants of the spline factors."""
    squares = pack_curves(graph).cost(state.poses, state.control_points) + pack_edges(graph).cost(state.poses)[1]
    return squares + sum(factor.constant for factor in graph.spline_factors)


def degrees_of_freedom(graph: Graph) -> int:
    """Readings behind the spline factors (rows, where a factor counts none) and rows of all others, less unknowns."""
    readings = sum(factor.readings or len(factor.b) for factor in graph.spline_factors)
    rows = 3 * len(graph.pose_factors) + 3 * len(graph.pose_priors) + sum(len(prior.b) for prior in graph.shape_priors)
    return readings + rows - graph.unknowns
