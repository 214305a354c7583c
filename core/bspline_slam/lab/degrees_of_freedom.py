"""χ² of what was measured and its degrees of freedom, priors and gauges left out of both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from jaxtyping import Float

from bspline_slam.backends.gauss_newton import STEP_INFORMATION
from bspline_slam.backends.protocol import Estimate
from bspline_slam.graph import Beams, Graph, SplineFactor

Matrices = list[Float[np.ndarray, "_ _"]]


def measures(factor: SplineFactor) -> bool:
    """Whether a spline factor holds beams; without any it only fixes where control points lie along their curve."""
    return factor.readings > 0


def data_chi_square(estimate: Estimate) -> float:
    """Σ‖e‖² of all observations and relative poses, with the constants of the observations."""
    total = 0.0
    for factor in filter(measures, estimate.graph.spline_factors):
        seen = estimate.control_points[factor.first : factor.first + factor.A.shape[1] // 2]
        total += float(np.sum(factor.residual(estimate.poses[factor.pose], seen) ** 2)) + factor.constant
    for edge in estimate.graph.pose_factors:
        total += float(np.sum(edge.residual(estimate.poses[edge.i], estimate.poses[edge.j]) ** 2))
    return total


def data_degrees_of_freedom(estimate: Estimate) -> float:
    """Measured numbers less the parameters that they, and not the priors, determine.

    All poses but the first count fully. A spline counts tr((D + Q)⁻¹ D) parameters, D being the information that
    beams give its control points and Q that of gauge and shape prior: less than two for each control point.
    """
    graph = estimate.graph
    rows = sum(_rows(factor) for factor in filter(measures, graph.spline_factors)) + 3 * len(graph.pose_factors)
    held = len({prior.pose for prior in graph.pose_priors})
    return rows - 3 * (len(graph.poses) - held) - sum(_determined(estimate))


def _rows(factor: SplineFactor) -> int:
    """A distance for each beam; where the factor sums nothing up beyond its rows, those."""
    return factor.readings if factor.constant > 0 else len(factor.b)


def _determined(estimate: Estimate) -> list[float]:
    """For each spline the number of its parameters that beams determine."""
    shares = []
    for data, prior in zip(*spline_information(estimate), strict=True):
        held = data + prior + STEP_INFORMATION * np.eye(len(data))
        shares.append(float(np.trace(np.linalg.solve(held, data))))
    return shares


def spline_information(estimate: Estimate) -> tuple[Matrices, Matrices]:
    """For each spline of the graph the information of its control points: from beams, and from gauge and priors."""
    graph, sizes = estimate.graph, 2 * np.diff(estimate.graph.spline_first)
    data, prior = [np.zeros((n, n)) for n in sizes], [np.zeros((n, n)) for n in sizes]
    for factor in graph.spline_factors:
        seen = estimate.control_points[factor.first : factor.first + factor.A.shape[1] // 2]
        _, jacobian = factor.jacobians(estimate.poses[factor.pose], seen)
        _add(data if measures(factor) else prior, graph, factor.first, jacobian)
    for shape in graph.shape_priors:
        _add(prior, graph, shape.first, shape.A)
    return data, prior


def _add(sums: Matrices, graph: Graph, first: int, jacobian: Float[np.ndarray, "r d"]) -> None:
    """Add the information of rows on consecutive control points to that of their spline."""
    spline = int(np.searchsorted(graph.spline_first, first, side="right")) - 1
    a = 2 * (first - int(graph.spline_first[spline]))
    b = a + jacobian.shape[1]
    sums[spline][a:b, a:b] += jacobian.T @ jacobian


def without_last_pose(estimate: Estimate) -> Graph:
    """The graph at the estimate without its last pose and all that hangs on it."""
    graph, last = estimate.graph, len(estimate.poses) - 1
    return replace(
        graph,
        key_scans=graph.key_scans[:-1],
        poses=estimate.poses[:-1],
        control_points=estimate.control_points,
        spline_factors=tuple(factor for factor in graph.spline_factors if factor.pose != last),
        pose_factors=tuple(edge for edge in graph.pose_factors if last not in (edge.i, edge.j)),
        pose_priors=tuple(prior for prior in graph.pose_priors if prior.pose != last),
        beams=None if graph.beams is None else _beams_of_others(graph.beams, last),
    )


def _beams_of_others(beams: Beams, pose: int) -> Beams:
    kept = beams.pose != pose
    return Beams(
        beams.pose[kept],
        beams.spline[kept],
        beams.origins[kept],
        beams.directions[kept],
        beams.ranges[kept],
        beams.parameters[kept],
        beams.sigma[kept],
        beams.curves,
    )
